#include "distribution/cell_sampling.h"

#include <algorithm>
#include <cassert>
#include <span>

namespace micro {
namespace {

/// The first entry whose running sum exceeds ξ·(last sum), and ξ's place inside it.
struct Choice {
  std::size_t index;
  double xi;
};
Choice choose(std::span<const double> sums, double xi) {
  const double target = xi * sums.back();
  auto found = std::upper_bound(sums.begin(), sums.end(), target);
  // Rounding may put the target on the last sum: then the last entry that has any weight.
  if (found == sums.end()) found = std::lower_bound(sums.begin(), sums.end(), sums.back());
  const double below = found == sums.begin() ? 0 : *(found - 1);
  return {static_cast<std::size_t>(found - sums.begin()),
          std::clamp((target - below) / (*found - below), 0., 1 - 0x1p-53)};
}

}  // namespace

CellSampling::CellSampling(const Grid<double>& weights) : cols_(weights.cols()) {
  rows_.reserve(static_cast<std::size_t>(weights.rows()));
  cells_.reserve(static_cast<std::size_t>(weights.size()));
  for (Eigen::Index j = 0; j < weights.rows(); ++j) {
    double sum = 0;
    for (Eigen::Index i = 0; i < cols_; ++i)
      cells_.push_back(sum += weights(j, i));
    rows_.push_back(total_ += sum);
  }
  assert(total_ > 0);
}

CellSampling::Cell CellSampling::operator()(const Vec2& xi) const {
  const Choice row = choose(rows_, xi.y());
  const auto n = static_cast<std::size_t>(cols_);
  const Choice col = choose(std::span(cells_).subspan(row.index * n, n), xi.x());
  return {static_cast<Eigen::Index>(row.index), static_cast<Eigen::Index>(col.index), {col.xi, row.xi}};
}

}  // namespace micro
