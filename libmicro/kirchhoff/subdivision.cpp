#include "kirchhoff/subdivision.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "kirchhoff/quadrature_lattice.h"

namespace micro {
namespace {

/// The relief at some 50,000 cells: slope s = |∇z|, and its change κ from cell to cell (the root of the sum
/// of the squared second differences, per pitch). A facet shines where q_z = |q|·cosθ, cosθ = 1/√(1 + s²):
/// phases go with s·cosθ = sinθ and κ·cosθ.
struct Relief {
  std::vector<double> slope, sine, kink;  ///< s, sinθ, κ·cosθ of each sampled cell
  double typical_sine = 0;  ///< per axis: the median of sinθ over that of a Rayleigh distribution of σ = 1

  double fraction_above(double limit) const {
    const auto above = std::count_if(slope.begin(), slope.end(), [&](double s) { return s > limit; });
    return slope.empty() ? 0 : static_cast<double>(above) / static_cast<double>(slope.size());
  }
  /// √⟨min(sinθ, limit)⁴ (κ·cosθ)²⟩
  double kinks(double limit) const {
    double sum = 0;
    for (std::size_t n = 0; n < sine.size(); ++n) {
      const double squared = std::pow(std::min(sine[n], limit), 2);
      sum += squared * squared * kink[n] * kink[n];
    }
    return sine.empty() ? 0 : std::sqrt(sum / static_cast<double>(sine.size()));
  }
};

/// z(j−dj, i−di) − 2z(j, i) + z(j+dj, i+di), µm; 0 beyond the border or beside a hole: that edge is the
/// rim's.
double second_difference(const HeightField& surface, Eigen::Index j, Eigen::Index i, Eigen::Index dj,
                         Eigen::Index di) {
  if (j < dj || i < di || j + dj >= surface.rows() || i + di >= surface.cols()) return 0;
  const double before = surface.z(j - dj, i - di), after = surface.z(j + dj, i + di);
  const double value = before - 2. * surface.z(j, i) + after;
  return std::isfinite(value) ? value : 0;
}

Relief sample_relief(const HeightField& surface) {
  constexpr Eigen::Index kSamples = 50000;
  const Eigen::Index step = std::max<Eigen::Index>(1, 2 * surface.rows() * surface.cols() / kSamples);
  Relief relief;
  Eigen::Index start = 0;
  for (Eigen::Index j = 0; j + 1 < surface.rows(); ++j)
    for (Eigen::Index i = start++ % step; i + 1 < surface.cols(); i += step) {
      const double z00 = surface.z(j, i), z01 = surface.z(j, i + 1), z10 = surface.z(j + 1, i),
                   z11 = surface.z(j + 1, i + 1);
      const double slope = std::hypot((z01 - z00) / surface.dx, (z11 - z01) / surface.dy);
      if (!std::isfinite(slope)) continue;
      const double twist = z11 - z10 - z01 + z00;
      const double xy = std::isfinite(twist) ? twist / std::sqrt(surface.dx * surface.dy) : 0;
      const double xx = second_difference(surface, j, i, 0, 1) / surface.dx;
      const double yy = second_difference(surface, j, i, 1, 0) / surface.dy;
      const double cosine = 1 / std::sqrt(1 + slope * slope);
      relief.slope.push_back(slope);
      relief.sine.push_back(slope * cosine);
      relief.kink.push_back(cosine * std::sqrt(xx * xx + yy * yy + 2 * xy * xy));
    }
  if (relief.slope.empty()) return relief;
  std::vector<double> sorted = relief.sine;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  relief.typical_sine = *middle / std::sqrt(2 * std::numbers::ln2);
  return relief;
}

/// The slope s whose phase turns by `turns`·|q| per length in its worst direction on the table:
/// max sinθ + s·cosθ over θ up to the outermost, which is √(1 + s²) where tanθ = 1/s is on the table.
double steepest_slope(double turns, double sin_theta) {
  if (turns * sin_theta >= 1) return std::sqrt(turns * turns - 1);
  return (turns - sin_theta) / std::sqrt(1 - sin_theta * sin_theta);
}

}  // namespace

int choose_subdivision(const HeightField& surface, const SubdivisionDemands& demands) {
  const Relief relief = sample_relief(surface);
  const double phase = demands.phase, sin_theta = demands.sin_theta, tol = demands.tolerance;

  const double rim = rim_fraction(surface);
  const double dense = 1.7e-2 * rim * rim, far = 2e-3 * (1 + 3 * std::min(1.0, rim / 0.024));
  const double in_plane = std::max(2 * dense / tol, far / (25 * tol));
  const double finest = phase / 2.5 * sin_theta * std::pow(in_plane, 0.25);
  int subdivision = std::clamp(static_cast<int>(std::ceil(finest)), 1, kMostSubdivision);

  const auto kinked = [&](int n) {
    constexpr double kKink = 4e-3;
    const double across = phase / n;
    return kKink * std::pow(across, 4) * relief.typical_sine * relief.kinks(std::numbers::pi / across);
  };
  while (subdivision < kMostSubdivision && kinked(subdivision) > tol / 3)
    ++subdivision;

  const auto aliased = [&](int n) {
    const double turns = 2 * std::numbers::pi * n / phase;
    // In-plane phases alone must stay within half a period.
    if (turns < 2 * sin_theta) return 1.0;
    return relief.fraction_above(steepest_slope(turns, sin_theta));
  };
  // Cliffs are few and their light goes everywhere: beyond 4 the measured error decides.
  constexpr int kMost = 4096;
  while (subdivision < kMost && aliased(subdivision) > (subdivision < 4 ? 2 * tol : 0.1))
    ++subdivision;
  return subdivision;
}

}  // namespace micro
