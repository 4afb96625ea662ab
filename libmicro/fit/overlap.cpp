#include "fit/overlap.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "distribution/beckmann.h"
#include "distribution/ellipsoid.h"

namespace micro {
namespace {

constexpr std::size_t kRings = 4, kParts = 2 * 4 * kRings;

/// |v|² within which lie a quarter, a half and three quarters of a lobe.
using Radii = std::array<double, kRings - 1>;
constexpr Radii kEllipsoidRadii = {1. / 3, 1, 3};
constexpr Radii kBeckmannRadii = {0.28768207245178096 /* ln 4/3 */, std::numbers::ln2, 2 * std::numbers::ln2};

std::size_t part_of(const Vec3& m, const SlopeFrame& frame, const Radii& radii) {
  const Vec2 v = frame.whiten(slope_of(m));
  const double vv = v.squaredNorm();
  std::size_t part = (v.x() > 0 ? 1 : 0) + (v.y() > 0 ? 2 : 0) + (m.z() < 0.5 ? 4 * kRings : 0);
  for (const double radius : radii)
    part += vv > radius ? 4 : 0;
  return part;
}

/// Sums over blocks of `side`² nodes, each block's energy taken at its middle.
template <typename Lobe>
double overlap_with(const Lobe& lobe, const Radii& radii, const DiskTable& table, Eigen::Index side) {
  const DiskGrid& grid = table.grid;
  const Eigen::Index n = grid.size;
  const double area = grid.spacing() * grid.spacing();
  std::array<double, kParts> of_table{}, of_lobe{};
  for (Eigen::Index j = 0; j < n; j += side)
    for (Eigen::Index i = 0; i < n; i += side) {
      const Eigen::Index rows = std::min(side, n - j), cols = std::min(side, n - i);
      const double y = (grid.coordinate(j) + grid.coordinate(j + rows - 1)) / 2,
                   x = (grid.coordinate(i) + grid.coordinate(i + cols - 1)) / 2, z2 = 1 - x * x - y * y;
      if (!(z2 > 0)) continue;
      const Vec3 m(x, y, std::sqrt(z2));
      const std::size_t part = part_of(m, lobe.frame(), radii);
      of_table[part] += table.density.block(j, i, rows, cols).sum() * area;
      of_lobe[part] += lobe.D(m) * static_cast<double>(rows * cols) * area;
    }
  double shared = 0, whole_table = 0, whole_lobe = 0;
  for (std::size_t k = 0; k < kParts; ++k) {
    shared += std::min(std::max(of_table[k], 0.), of_lobe[k]);
    whole_table += of_table[k];
    whole_lobe += of_lobe[k];
  }
  return shared / std::max(whole_table, whole_lobe);
}

}  // namespace

double overlap(const DiskTable& table, const SlopeFrame& frame, FitModel model, double across) {
  const Eigen::Index side = across >= 16 ? 4 : across >= 8 ? 2 : 1;
  return model == FitModel::EllipsoidNdf ? overlap_with(Ellipsoid(frame), kEllipsoidRadii, table, side)
                                         : overlap_with(Beckmann(frame), kBeckmannRadii, table, side);
}

}  // namespace micro
