#pragma once

#include <functional>
#include <vector>

#include "core/grid.h"

namespace micro::testing {

/// Pearson's χ² of counts against expected counts: the probability of a larger value. Bins that expect fewer
/// than ten are put together; the expectations' sum must be that of the counts.
double chi_square_p(const std::vector<double>& counts, const std::vector<double>& expected);

/// Bins of the whole plane of slopes by polar angle and radius about the origin, `radial` equal steps in
/// τ ∈ [0, 1], |v| = √(1 − τ²)/τ, and `angular` in angle: enough room for tails that fall as slowly as |v|⁻³.
struct PlaneBins {
  int radial, angular;
  std::size_t size() const { return static_cast<std::size_t>(radial) * static_cast<std::size_t>(angular); }
  std::size_t bin_of(const Vec2& v) const;
  /// ∫ density d²v over each bin, by the midpoint rule on `steps` × `steps` points a bin.
  std::vector<double> integrate(const std::function<double(const Vec2&)>& density, int steps) const;
};

}  // namespace micro::testing
