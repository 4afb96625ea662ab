#include "error_vs_time/kirchhoff_curves.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/random.h"
#include "kirchhoff/exact.h"
#include "kirchhoff/monte_carlo.h"
#include "kirchhoff/spectral.h"

namespace micro::bench {
namespace {

constexpr double kLambdaQ = 0.555;  // µm
constexpr int kTableSize = 1025;

DiskGrid grid_of(const HeightField& surface) {
  return {kTableSize, std::min(1.0, kLambdaQ / (2 * std::max(surface.dx, surface.dy)))};
}

double nodes_on_disk(const DiskGrid& grid) {
  double nodes = 0;
  for (Eigen::Index j = 0; j < grid.size; ++j)
    for (Eigen::Index i = 0; i < grid.size; ++i)
      nodes += grid.mz2(j, i) > 0;
  return nodes;
}

/// Directions that judge every estimator of a surface alike: nodes drawn from a mixture of D², D² without the
/// coherent core, and evenly, with their exact D.
class Judges {
 public:
  Judges(const HeightField& surface, const DiskTable& proposal) : grid_(proposal.grid) {
    constexpr int kNodes = 96;
    const double core = coherent_core(surface, kLambdaQ);
    const Eigen::Index size = grid_.size;
    const auto outside_core = [&](Eigen::Index j, Eigen::Index i) {
      return std::hypot(grid_.coordinate(i), grid_.coordinate(j)) > core;
    };
    Grid<double> squared = proposal.density.square(), tail = squared, even = Grid<double>::Zero(size, size);
    for (Eigen::Index j = 0; j < size; ++j)
      for (Eigen::Index i = 0; i < size; ++i) {
        if (!outside_core(j, i)) tail(j, i) = 0;
        even(j, i) = grid_.mz2(j, i) > 0 ? 1 : 0;
      }
    Grid<double> probability = squared / squared.sum() / 3 + even / even.sum() / 3;
    probability += tail.sum() > 0 ? tail / tail.sum() / 3 : squared / squared.sum() / 3;
    std::vector<double> cumulative(static_cast<std::size_t>(probability.size()));
    double sum = 0;
    for (Eigen::Index n = 0; n < probability.size(); ++n)
      cumulative[static_cast<std::size_t>(n)] = sum += probability.data()[n];
    for (int k = 0; k < kNodes; ++k) {
      const double u = random_uniform(7, 7, static_cast<std::uint64_t>(k))[0] * sum;
      const auto n = std::upper_bound(cumulative.begin(), cumulative.end() - 1, u) - cumulative.begin();
      const Eigen::Index j = n / size, i = n % size;
      const double mz2 = std::max(grid_.mz2(j, i), 0.0);
      nodes_.push_back({j, i, 1 / probability(j, i), outside_core(j, i)});
      q_.push_back(wave_vector(Vec3(grid_.coordinate(i), grid_.coordinate(j), std::sqrt(mz2)), kLambdaQ));
    }
    const double area = kirchhoff_area(surface);
    const Stopwatch watch;
    for (const std::complex<double>& field : exact_field(surface, q_))
      exact_.push_back(kirchhoff_density(field, area));
    seconds_ = watch.seconds() / static_cast<double>(q_.size());
  }

  const std::vector<Vec3>& q() const { return q_; }
  double exact_seconds() const { return seconds_; }  ///< of one direction

  /// The table's values at the judges' nodes.
  std::vector<double> pick(const DiskTable& table) const {
    std::vector<double> density;
    for (const Node& node : nodes_)
      density.push_back(table.density(node.j, node.i));
    return density;
  }

  /// Estimates of (Σ(D − D*)²/ΣD*²)^½ over the table, and over the table without its core.
  void judge(const std::vector<double>& density, CurvePoint& point) const {
    double off = 0, all = 0, tail_off = 0, tail_all = 0;
    for (std::size_t n = 0; n < nodes_.size(); ++n) {
      const double difference = density[n] - exact_[n];
      off += nodes_[n].weight * difference * difference;
      all += nodes_[n].weight * exact_[n] * exact_[n];
      if (!nodes_[n].outside_core) continue;
      tail_off += nodes_[n].weight * difference * difference;
      tail_all += nodes_[n].weight * exact_[n] * exact_[n];
    }
    point.error = std::sqrt(off / all);
    point.error_core_free = tail_all > 0 ? std::sqrt(tail_off / tail_all) : point.error;
  }

 private:
  struct Node {
    Eigen::Index j, i;
    double weight;  // 1/probability
    bool outside_core;
  };
  DiskGrid grid_;
  std::vector<Node> nodes_;
  std::vector<Vec3> q_;
  std::vector<double> exact_;
  double seconds_ = 0;
};

CurvePoint::Reached reached(bool yes) {
  return yes ? CurvePoint::Reached::Yes : CurvePoint::Reached::No;
}

/// The surface turned by half a turn: the same triangles, summed in the opposite order from other
/// coordinates.
HeightField turned(const HeightField& surface) {
  HeightField result = surface;
  result.z = surface.z.reverse().eval();
  return result;
}

}  // namespace

void kirchhoff_curves(const NamedSurface& named, double most_seconds,
                      const std::function<void(const CurvePoint&)>& report) {
  const HeightField& surface = named.surface;
  const DiskGrid grid = grid_of(surface);
  const double nodes = nodes_on_disk(grid), area = kirchhoff_area(surface);
  const Judges judges(surface, spectral_table(surface, grid, kLambdaQ, 1e-2).table);
  const CurvePoint blank{.part = "kirchhoff", .surface = named.name};

  {  // exact: what rounding leaves shows when the same sum is taken in another order
    CurvePoint point = blank;
    point.estimator = "exact";
    std::vector<Vec3> q = judges.q();
    for (Vec3& wave : q)
      wave.head<2>() *= -1;
    std::vector<double> density;
    for (const std::complex<double>& field : exact_field(turned(surface), q))
      density.push_back(kirchhoff_density(field, area));
    judges.judge(density, point);
    point.seconds = judges.exact_seconds() * nodes;
    point.note = "scaled";
    report(point);
  }

  const double directions = static_cast<double>(judges.q().size());
  {  // the paper's: one random point in every triangle, |F|² as it comes
    CurvePoint point = blank;
    point.estimator = "monte-carlo";
    const Window window{surface, {}};
    const Stopwatch watch;
    const auto halves =
        monte_carlo_field(window, judges.q(), {.subdivision = 1, .seed = 1, .draws = Draws::Single});
    point.seconds = watch.seconds() / 2 / directions * nodes;  // of the two halves, the paper has one
    std::vector<double> density;
    for (const FieldHalves& field : halves)
      density.push_back(kirchhoff_density(field.first, area));
    judges.judge(density, point);
    point.note = "paper";
    report(point);
  }
  for (const double tolerance : {0.3, 0.1, 0.03, 0.01, 0.003, 0.001}) {
    CurvePoint point = blank;
    point.estimator = "monte-carlo";
    point.asked = tolerance;
    const auto estimate =
        monte_carlo_density(surface, judges.q(), {.tolerance = tolerance, .max_points = 2e10, .seed = 2});
    std::vector<double> density;
    bool all = true;
    for (const DirectionEstimate& direction : estimate.value) {
      density.push_back(direction.density);
      all = all && direction.reached;
    }
    judges.judge(density, point);
    point.seconds = estimate.cost.seconds / directions * nodes;
    point.reached = reached(all);
    point.note = "scaled";
    report(point);
    if (estimate.cost.seconds > most_seconds) break;
  }

  for (const double tolerance : {1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 1e-5, 1e-6}) {
    CurvePoint point = blank;
    point.estimator = "spectral";
    point.asked = tolerance;
    SpectralSolver solver(grid, kLambdaQ, tolerance);
    KirchhoffTable table = solver(surface);  // touches the memory, as in a directory of scans
    point.seconds = table.cost.seconds;
    constexpr int kRepeats = 3;
    for (int repeat = 0; repeat < kRepeats && point.seconds < 2; ++repeat) {
      table = solver(surface);
      point.seconds = std::min(point.seconds, table.cost.seconds);
    }
    judges.judge(judges.pick(table.table), point);
    point.reached = reached(table.reached);
    report(point);
    if (point.seconds > most_seconds) break;
  }
}

}  // namespace micro::bench
