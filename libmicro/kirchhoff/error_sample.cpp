#include "kirchhoff/error_sample.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/parallel.h"
#include "core/random.h"
#include "kirchhoff/exact.h"

namespace micro {
namespace {

constexpr double kSignificant = 1e-8;
constexpr double kSignificantTolerance = 30;
constexpr std::uint32_t kStream = 0x6b65;

struct Node {
  Eigen::Index j, i;
};

/// The measures that nodes are drawn by, in turn: D², D² without the coherent core, D, and evenly.
enum Measure { kWhole, kCoreFree, kLinear, kEven, kMeasures };

/// What one node weighs in each measure.
template <typename Real>
struct NodeWeights {
  const DiskGrid& grid;
  const Grid<Real>& table;
  double core, threshold;

  std::array<double, kMeasures> operator()(Eigen::Index j, Eigen::Index i) const {
    const auto density = static_cast<double>(table(j, i));
    if (!(grid.mz2(j, i) > 0) || !(density > 0)) return {};
    const double x = grid.coordinate(i), y = grid.coordinate(j), squared = density * density;
    return {squared, x * x + y * y > core * core ? squared : 0, density, density >= threshold ? 1.0 : 0.0};
  }
};

/// Cumulative sums over rows; a node is found in its row by adding up again.
struct RowSums {
  std::array<std::vector<double>, kMeasures> cumulative;
  double total(int measure) const { return cumulative[measure].back(); }
};

template <typename Real>
RowSums sum_rows(const NodeWeights<Real>& weights) {
  const Eigen::Index rows = weights.table.rows();
  RowSums sums;
  for (auto& row : sums.cumulative)
    row.resize(static_cast<std::size_t>(rows));
  parallel_blocks(rows, 16, [&](std::int64_t begin, std::int64_t end) {
    for (Eigen::Index j = begin; j < end; ++j) {
      std::array<double, kMeasures> sum{};
      for (Eigen::Index i = 0; i < rows; ++i) {
        const auto w = weights(j, i);
        for (int m = 0; m < kMeasures; ++m)
          sum[m] += w[m];
      }
      for (int m = 0; m < kMeasures; ++m)
        sums.cumulative[m][j] = sum[m];
    }
  });
  for (auto& row : sums.cumulative)
    for (std::size_t j = 1; j < row.size(); ++j)
      row[j] += row[j - 1];
  return sums;
}

/// The node at fraction u of a measure's total.
template <typename Real>
Node find_node(const NodeWeights<Real>& weights, const RowSums& sums, int measure, double u) {
  const auto& rows = sums.cumulative[measure];
  const double target = u * rows.back();
  const auto row = std::min<std::ptrdiff_t>(std::upper_bound(rows.begin(), rows.end(), target) - rows.begin(),
                                            static_cast<std::ptrdiff_t>(rows.size()) - 1);
  double sum = row > 0 ? rows[static_cast<std::size_t>(row - 1)] : 0;
  Node last{row, 0};
  for (Eigen::Index i = 0; i < weights.table.cols(); ++i) {
    const double w = weights(row, i)[measure];
    if (w == 0) continue;
    last.i = i;
    sum += w;
    if (sum > target) break;
  }
  return last;
}

/// A node to look at, the probability of it among all draws together, and whether it speaks for the
/// significant directions.
struct Draw {
  Node node;
  double probability;
  bool even;
};

/// `count` nodes by importance: each measure's in strata of equal weight, which scatter less than drawn
/// freely.
template <typename Real>
std::vector<Draw> draw_nodes(const NodeWeights<Real>& weights, const RowSums& sums, int count,
                             std::uint64_t seed) {
  // A table that lies in the core altogether lacks one measure.
  std::vector<int> turn;
  for (int measure = 0; static_cast<int>(turn.size()) < count; measure = (measure + 1) % kMeasures)
    if (sums.total(measure) > 0) turn.push_back(measure);
  std::array<int, kMeasures> strata{}, stratum{};
  for (const int measure : turn)
    ++strata[measure];
  std::vector<Draw> draws;
  for (int n = 0; n < count; ++n) {
    const double within = random_uniform(seed, kStream, static_cast<std::uint64_t>(n))[0];
    const double u = (stratum[turn[n]]++ + within) / strata[turn[n]];
    const Node node = find_node(weights, sums, turn[n], u);
    const auto w = weights(node.j, node.i);
    double probability = 0;
    for (const int measure : turn)
      probability += w[measure] / sums.total(measure) / count;
    draws.push_back({node, probability, turn[n] == kEven});
  }
  return draws;
}

/// Every node once, if there are no more than `most`; else nothing.
template <typename Real>
std::vector<Draw> all_nodes(const NodeWeights<Real>& weights, int most) {
  const Eigen::Index size = weights.grid.size;
  std::vector<Draw> draws;
  if (size * size > 2 * most) return draws;  // the disk is three quarters of the square
  for (Eigen::Index j = 0; j < size; ++j)
    for (Eigen::Index i = 0; i < size; ++i) {
      const auto w = weights(j, i);
      if (w[kWhole] > 0) draws.push_back({{j, i}, 0, w[kEven] > 0});
    }
  if (static_cast<int>(draws.size()) > most) draws.clear();
  for (Draw& draw : draws)
    draw.probability = 1. / static_cast<double>(draws.size());
  return draws;
}

}  // namespace

double ErrorSample::error() const {
  return nodes > 0 ? std::sqrt(squared / static_cast<double>(nodes)) : 0;
}

double ErrorSample::error_core_free() const {
  return nodes > 0 ? std::sqrt(squared_core_free / static_cast<double>(nodes)) : 0;
}

bool ErrorSample::within(double tol) const {
  return error() <= tol && error_core_free() <= tol && 2 * significant_bad <= significant + 1;
}

ErrorSample& ErrorSample::operator+=(const ErrorSample& other) {
  nodes += other.nodes;
  squared += other.squared;
  squared_core_free += other.squared_core_free;
  significant += other.significant;
  significant_bad += other.significant_bad;
  return *this;
}

double coherent_core(const HeightField& surface, double lambda_q) {
  const double shorter = std::min(static_cast<double>(surface.cols() - 1) * surface.dx,
                                  static_cast<double>(surface.rows() - 1) * surface.dy);
  return 2 * lambda_q / (2 * shorter);
}

template <typename Real>
ErrorSample sample_error(const Window& window, const DiskGrid& grid, const Grid<Real>& density,
                         double lambda_q, double tol, int nodes, std::uint64_t seed) {
  const NodeWeights<Real> weights{grid, density, coherent_core(window.surface, lambda_q),
                                  kSignificant * static_cast<double>(density.maxCoeff())};
  const RowSums sums = sum_rows(weights);
  ErrorSample sample;
  if (!(sums.total(kWhole) > 0)) return sample;
  std::vector<Draw> draws = all_nodes(weights, nodes);
  if (draws.empty()) draws = draw_nodes(weights, sums, nodes, seed);
  std::vector<Vec3> q;
  for (const auto& [node, probability, even] : draws) {
    const double x = grid.coordinate(node.i), y = grid.coordinate(node.j);
    q.push_back(wave_vector(Vec3(x, y, std::sqrt(grid.mz2(node.j, node.i))), lambda_q));
  }
  const auto fields = exact_field(window, q);
  const double area = effective_area(window);
  for (std::size_t n = 0; n < draws.size(); ++n) {
    const auto& [node, probability, even] = draws[n];
    const double exact = kirchhoff_density(fields[n], area);
    const double difference = static_cast<double>(density(node.j, node.i)) - exact,
                 squared = difference * difference;
    sample.squared += squared / (probability * sums.total(kWhole));
    if (weights(node.j, node.i)[kCoreFree] > 0)
      sample.squared_core_free += squared / (probability * sums.total(kCoreFree));
    if (even) {
      ++sample.significant;
      if (!(std::abs(difference) <= kSignificantTolerance * tol * exact)) ++sample.significant_bad;
    }
  }
  sample.nodes = static_cast<std::int64_t>(draws.size());
  return sample;
}

template ErrorSample sample_error(const Window&, const DiskGrid&, const Grid<float>&, double, double, int,
                                  std::uint64_t);
template ErrorSample sample_error(const Window&, const DiskGrid&, const Grid<double>&, double, double, int,
                                  std::uint64_t);

}  // namespace micro
