#include "distribution/signature.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "core/error.h"
#include "core/parallel.h"
#include "distribution/ring_convolution.h"
#include "distribution/signature_kernel.h"

namespace micro {
namespace {

/// m_z at the nodes; zero off the disk.
Grid<double> heights_of_hemisphere(const DiskGrid& grid) {
  Grid<double> mz(grid.size, grid.size);
  for (Eigen::Index j = 0; j < grid.size; ++j)
    for (Eigen::Index i = 0; i < grid.size; ++i)
      mz(j, i) = std::sqrt(std::max(0., grid.mz2(j, i)));
  return mz;
}

/// Columns [begin, end) of a row that are not zero.
struct Span {
  Eigen::Index begin, end;
};

std::vector<Span> spans(const Grid<double>& values) {
  std::vector<Span> rows;
  for (Eigen::Index j = 0; j < values.rows(); ++j) {
    Span span{0, values.cols()};
    while (span.begin < span.end && values(j, span.begin) == 0)
      ++span.begin;
    while (span.end > span.begin && values(j, span.end - 1) == 0)
      --span.end;
    rows.push_back(span);
  }
  return rows;
}

/// Σ response(∠)·weight over the nodes that are in reach of a node's direction and within the weights' spans.
class Gather {
 public:
  Gather(const DiskGrid& grid, const Grid<double>& mz, const SignatureKernel& response,
         const Grid<double>& weights)
      : grid_(grid),
        mz_(mz),
        response_(response),
        weights_(weights),
        spans_(spans(weights)),
        // |h_xy − m_xy| ≤ |h − m| = √(2c): half the box that holds the reach.
        reach_(static_cast<Eigen::Index>(std::ceil(std::sqrt(2 * response.reach()) / grid.spacing()))) {}

  double operator()(Eigen::Index row, Eigen::Index col) const {
    const double x = grid_.coordinate(col), y = grid_.coordinate(row), z = mz_(row, col);
    double sum = 0;
    for (Eigen::Index j = std::max<Eigen::Index>(0, row - reach_);
         j <= std::min<Eigen::Index>(grid_.size - 1, row + reach_); ++j) {
      const Span span = spans_[static_cast<std::size_t>(j)];
      const double dy = grid_.coordinate(j) - y;
      for (Eigen::Index i = std::max(span.begin, col - reach_); i < std::min(span.end, col + reach_ + 1);
           ++i) {
        const double dx = grid_.coordinate(i) - x, dz = mz_(j, i) - z;
        const double c = (dx * dx + dy * dy + dz * dz) / 2;
        if (c <= response_.reach()) sum += response_(c) * weights_(j, i);
      }
    }
    return sum;
  }

 private:
  const DiskGrid& grid_;
  const Grid<double>& mz_;
  const SignatureKernel& response_;
  const Grid<double>& weights_;
  std::vector<Span> spans_;
  Eigen::Index reach_;
};

/// Σ response over the nodes of the whole hemisphere, those beyond the table too, in reach of node (row,
/// col).
double taken_by_hemisphere(const DiskGrid& grid, const SignatureKernel& response, Eigen::Index row,
                           Eigen::Index col) {
  const auto reach = static_cast<Eigen::Index>(std::ceil(std::sqrt(2 * response.reach()) / grid.spacing()));
  const double x = grid.coordinate(col), y = grid.coordinate(row), z = std::sqrt(grid.mz2(row, col));
  double sum = 0;
  for (Eigen::Index j = row - reach; j <= row + reach; ++j) {
    const double hy = grid.coordinate(j), rest = 1 - hy * hy;
    for (Eigen::Index i = col - reach; i <= col + reach; ++i) {
      const double hx = grid.coordinate(i), hz2 = rest - hx * hx;
      if (!(hz2 > 0)) continue;
      const double dz = std::sqrt(hz2) - z;
      const double c = ((hx - x) * (hx - x) + (hy - y) * (hy - y) + dz * dz) / 2;
      if (c <= response.reach()) sum += response(c);
    }
  }
  return sum;
}

/// What the hemisphere takes of each node's mass. The disk's eight symmetries leave it unchanged, so one
/// octant is computed, and of that the nodes that hold something.
Grid<double> taken(const DiskTable& table, const Grid<double>& mz, const SignatureKernel& response) {
  const DiskGrid& grid = table.grid;
  const Eigen::Index c = (grid.size - 1) / 2;
  Grid<double> octant = Grid<double>::Zero(c + 1, c + 1);
  const auto fold = [c](Eigen::Index j, Eigen::Index i) {
    const Eigen::Index a = std::abs(j - c), b = std::abs(i - c);
    return std::pair(std::max(a, b), std::min(a, b));
  };
  for (Eigen::Index j = 0; j < grid.size; ++j)
    for (Eigen::Index i = 0; i < grid.size; ++i)
      if (table.density(j, i) != 0 && mz(j, i) > 0) {
        const auto [a, b] = fold(j, i);
        octant(a, b) = 1;
      }
  parallel_for(c + 1, [&](std::int64_t a) {
    for (Eigen::Index b = 0; b <= a; ++b)
      if (octant(a, b) != 0) octant(a, b) = taken_by_hemisphere(grid, response, c + a, c + b);
  });
  Grid<double> sums = Grid<double>::Zero(grid.size, grid.size);
  for (Eigen::Index j = 0; j < grid.size; ++j)
    for (Eigen::Index i = 0; i < grid.size; ++i) {
      const auto [a, b] = fold(j, i);
      sums(j, i) = octant(a, b);
    }
  return sums;
}

/// Elementary operations of the literal sum, about a nanosecond each: so many for a pair of nodes (zeros
/// between the first and the last node of a row count), and for finding none.
double cost_on_nodes(const DiskTable& table, const SignatureKernel& kernel) {
  constexpr double kPair = 15, kNode = 100;
  double sources = 0;
  for (const Span& span : spans(table.density))
    sources += static_cast<double>(span.end - span.begin);
  const double in_reach = std::numbers::pi * std::pow(kernel.reach_angle() / table.grid.spacing(), 2);
  return kPair * sources * in_reach + kNode * static_cast<double>(table.density.size());
}

/// The literal sum over pairs of nodes.
DiskTable convolve_on_nodes(const DiskTable& table, const SignatureKernel& kernel) {
  const DiskGrid& grid = table.grid;
  const Grid<double> mz = heights_of_hemisphere(grid);
  const Grid<double> sums = taken(table, mz, kernel);
  const Grid<double> share = (mz > 0 && table.density != 0).select(table.density / sums, 0.);
  const Gather gather(grid, mz, kernel, share);
  DiskTable seen = make_disk_table(grid);
  parallel_for(grid.size, [&](std::int64_t j) {
    for (Eigen::Index i = 0; i < grid.size; ++i)
      if (mz(j, i) > 0) seen.density(j, i) = gather(j, i);
  });
  return seen;
}

}  // namespace

Signature gaussian_signature(double fwhm) {
  if (!(fwhm > 0 && fwhm <= std::numbers::pi / 2))
    throw InputError("the signature's full width must lie in (0°, 90°], not " +
                     std::to_string(fwhm * 180 / std::numbers::pi) + "°");
  constexpr double kCut = 1e-6;
  const double sigma = fwhm / (2 * std::sqrt(2 * std::numbers::ln2));
  const double reach = std::min(sigma * std::sqrt(-2 * std::log(kCut)), std::numbers::pi);
  constexpr int kSamples = 2000;
  Signature signature;
  for (int k = 0; k <= kSamples; ++k) {
    signature.angle.push_back(reach * k / kSamples);
    signature.response.push_back(std::exp(-std::pow(signature.angle.back() / sigma, 2) / 2));
  }
  return signature;
}

void require_valid(const Signature& signature) {
  const auto& [angle, response] = signature;
  if (angle.size() < 2 || angle.size() != response.size())
    throw InputError("an instrument signature needs at least two pairs of angle and response");
  if (angle.front() != 0) throw InputError("an instrument signature starts at angle 0");
  if (!(response.front() > 0)) throw InputError("an instrument signature that is blind at angle 0 is none");
  for (std::size_t k = 0; k < angle.size(); ++k) {
    if (!(std::isfinite(angle[k]) && angle[k] <= std::numbers::pi) || (k > 0 && !(angle[k] > angle[k - 1])))
      throw InputError("an instrument signature's angles must ascend and stay below 180°");
    if (!(std::isfinite(response[k]) && response[k] >= 0))
      throw InputError("an instrument signature's responses must be finite and not negative");
  }
}

DiskTable convolve(const DiskTable& table, const Signature& signature) {
  require_valid(signature);
  const SignatureKernel kernel(signature);
  if (const auto spacing = ring_spacing(signature))
    if (cost_on_rings(table, kernel, *spacing) < cost_on_nodes(table, kernel))
      return convolve_on_rings(table, kernel, *spacing);
  return convolve_on_nodes(table, kernel);
}

}  // namespace micro
