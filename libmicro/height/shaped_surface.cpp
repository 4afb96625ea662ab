#include "height/shaped_surface.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "core/error.h"

namespace micro {
namespace {

/// A period that misses the patch by less than this fraction of a cycle fits it.
constexpr double kFit = 1e-6;
/// Positions within this fraction of a period of an edge count as on it, so that rounding cannot move edges
/// that coincide with grid points.
constexpr double kEdge = 1e-9;

void check_finite(std::initializer_list<double> values) {
  for (const double value : values)
    if (!std::isfinite(value)) throw InputError("slopes, heights and angles must be finite");
}

/// Cycles per µm along x and y.
Vec2 frequency(const Grating& grating) {
  if (!(grating.period > 0) || !std::isfinite(grating.period))
    throw InputError("a grating's period must be positive and finite");
  check_finite({grating.depth, grating.orientation});
  Vec2 f = Vec2(std::cos(grating.orientation), std::sin(grating.orientation)) / grating.period;
  // cos(π/2) is 6e-17: an axis-parallel grating has no component along its grooves.
  for (double& component : f)
    if (std::abs(component) * grating.period < 1e-15) component = 0;
  return f;
}

void check_fit(const SyntheticGrid& grid, const Vec2& f) {
  const Vec2 cycles(f.x() * grid.width(), f.y() * grid.height());
  const Vec2 whole(std::round(cycles.x()), std::round(cycles.y()));
  if ((cycles - whole).cwiseAbs().maxCoeff() <= kFit) return;
  const double nearest = 1 / std::hypot(whole.x() / grid.width(), whole.y() / grid.height());
  const double angle = std::atan2(whole.y() / grid.height(), whole.x() / grid.width());
  throw InputError("the grating does not fit the patch a whole number of times, so it cannot be periodic" +
                   (std::isfinite(nearest)
                        ? "; the nearest that does has a period of " + std::to_string(nearest) + " µm at " +
                              std::to_string(angle * 180 / std::numbers::pi) + " degrees"
                        : std::string()));
}

/// A surface of height(t), t in [0, 1) the phase in cycles.
template <typename Height>
HeightField grating_surface(const SyntheticGrid& grid, const Grating& grating, Border border,
                            Height&& height) {
  check(grid);
  const Vec2 f = frequency(grating);
  if (border == Border::Periodic) check_fit(grid, f);
  return sample_heights(grid, [&](Eigen::Index j, Eigen::Index i) {
    const double t = f.x() * grid.dx * static_cast<double>(i) + f.y() * grid.dy * static_cast<double>(j);
    const double phase = t - std::floor(t + kEdge);
    return height(std::max(phase, 0.));
  });
}

}  // namespace

HeightField sinusoid_surface(const SyntheticGrid& grid, const Grating& grating, Border border) {
  return grating_surface(grid, grating, border, [&](double phase) {
    return grating.depth / 2 * std::sin(2 * std::numbers::pi * phase);
  });
}

HeightField blazed_surface(const SyntheticGrid& grid, const Grating& grating, Border border) {
  return grating_surface(grid, grating, border, [&](double phase) { return grating.depth * phase; });
}

HeightField two_level_surface(const SyntheticGrid& grid, const Grating& grating, double duty, Border border) {
  if (!(duty >= 0 && duty <= 1)) throw InputError("the duty must lie between 0 and 1");
  return grating_surface(grid, grating, border,
                         [&](double phase) { return phase + kEdge < duty ? grating.depth : 0.; });
}

HeightField plane_surface(const SyntheticGrid& grid, double slope_x, double slope_y) {
  check_finite({slope_x, slope_y});
  return sample_heights(grid, [&](Eigen::Index j, Eigen::Index i) {
    return slope_x * grid.dx * static_cast<double>(i) + slope_y * grid.dy * static_cast<double>(j);
  });
}

HeightField step_surface(const SyntheticGrid& grid, double height, double orientation) {
  check_finite({height, orientation});
  const double c = std::cos(orientation), s = std::sin(orientation);
  return sample_heights(grid, [&](Eigen::Index j, Eigen::Index i) {
    const double x = (static_cast<double>(i) - 0.5 * static_cast<double>(grid.cols - 1)) * grid.dx;
    const double y = (static_cast<double>(j) - 0.5 * static_cast<double>(grid.rows - 1)) * grid.dy;
    return x * c + y * s > kEdge * (grid.dx + grid.dy) ? height : 0;
  });
}

HeightField facet_surface(const SyntheticGrid& grid, double side, double slope_x, double slope_y) {
  check_finite({side, slope_x, slope_y});
  const HeightField facet = sample_heights(grid, [&](Eigen::Index j, Eigen::Index i) {
    const double x = (static_cast<double>(i) - 0.5 * static_cast<double>(grid.cols - 1)) * grid.dx;
    const double y = (static_cast<double>(j) - 0.5 * static_cast<double>(grid.rows - 1)) * grid.dy;
    const double half = 0.5 * side * (1 + kEdge);
    const bool inside = std::abs(x) <= half && std::abs(y) <= half;
    return inside ? slope_x * x + slope_y * y : std::numeric_limits<double>::quiet_NaN();
  });
  const auto there = !facet.z.isNaN();
  if (there.colwise().any().count() < 2 || there.rowwise().any().count() < 2)
    throw InputError("no whole cell of the grid fits into a facet of " + std::to_string(side) + " µm");
  return facet;
}

}  // namespace micro
