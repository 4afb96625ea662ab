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

/// v·m_z, by its components, tells the part as v would.
std::size_t part_of(double v1, double v2, double z, const Radii& radii) {
  const double vv = v1 * v1 + v2 * v2;
  std::size_t part = (v1 > 0 ? 1 : 0) + (v2 > 0 ? 2 : 0) + (z < 0.5 ? 4 * kRings : 0);
  for (const double radius : radii)
    part += vv > radius * z * z ? 4 : 0;
  return part;
}

/// Sums over blocks of `side`² nodes, each block's energy taken at its middle.
template <typename Shape>
double overlap_with(const SlopeFrame& frame, const Radii& radii, const DiskTable& table, Eigen::Index side) {
  const DiskGrid& grid = table.grid;
  const Eigen::Index n = grid.size;
  const double area = grid.spacing() * grid.spacing(), inverse11 = 1 / frame.l11, inverse22 = 1 / frame.l22;
  std::array<double, kParts> of_table{}, of_lobe{};
  for (Eigen::Index j = 0; j < n; j += side)
    for (Eigen::Index i = 0; i < n; i += side) {
      const Eigen::Index rows = std::min(side, n - j), cols = std::min(side, n - i);
      const double y = (grid.coordinate(j) + grid.coordinate(j + rows - 1)) / 2,
                   x = (grid.coordinate(i) + grid.coordinate(i + cols - 1)) / 2, z2 = 1 - x * x - y * y;
      if (!(z2 > 0)) continue;
      const double z = std::sqrt(z2), v1 = (x + frame.centre.x() * z) * inverse11,
                   v2 = (y + frame.centre.y() * z - frame.l21 * v1) * inverse22;
      const std::size_t part = part_of(v1, v2, z, radii);
      of_table[part] += table.density.block(j, i, rows, cols).sum() * area;
      of_lobe[part] += Shape::density(v1 * v1 + v2 * v2, z) * static_cast<double>(rows * cols);
    }
  for (double& energy : of_lobe)
    energy *= area * inverse11 * inverse22;
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
  return model == FitModel::EllipsoidNdf ? overlap_with<HemisphereShape>(frame, kEllipsoidRadii, table, side)
                                         : overlap_with<GaussianShape>(frame, kBeckmannRadii, table, side);
}

}  // namespace micro
