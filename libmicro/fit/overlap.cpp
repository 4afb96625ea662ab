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

/// Some nodes of a table side by side, from (j, i).
struct Block {
  Eigen::Index j, i, rows, cols;
};

/// Energies of table and lobe in each part.
struct Energies {
  std::array<double, kParts> table{}, lobe{};
};

/// Adds a block's energies, taken at its middle.
template <typename Shape>
void add_block(const Block& block, const SlopeFrame& frame, const Radii& radii, const DiskTable& table,
               Energies& energies) {
  const auto& [j, i, rows, cols] = block;
  const double y = (table.grid.coordinate(j) + table.grid.coordinate(j + rows - 1)) / 2,
               x = (table.grid.coordinate(i) + table.grid.coordinate(i + cols - 1)) / 2,
               z2 = 1 - x * x - y * y;
  if (!(z2 > kHorizonMz2)) return;
  const double z = std::sqrt(z2), v1 = (x + frame.centre.x() * z) / frame.l11,
               v2 = (y + frame.centre.y() * z - frame.l21 * v1) / frame.l22;
  const std::size_t part = part_of(v1, v2, z, radii);
  energies.table[part] += table.density.block(j, i, rows, cols).sum();
  energies.lobe[part] += Shape::density(v1 * v1 + v2 * v2, z) * static_cast<double>(rows * cols);
}

template <typename Shape>
double overlap_with(const SlopeFrame& frame, const Radii& radii, const DiskTable& table, Eigen::Index side) {
  const DiskGrid& grid = table.grid;
  const Eigen::Index n = grid.size;
  // Nearer to the horizon a lobe wider than the hemisphere changes from node to node, however wide it is.
  const double steep = 16 * grid.spacing() * static_cast<double>(side);
  Energies energies;
  for (Eigen::Index j = 0; j < n; j += side)
    for (Eigen::Index i = 0; i < n; i += side) {
      const Block block = {j, i, std::min(side, n - j), std::min(side, n - i)};
      if (side == 1 || grid.mz2(j, i) > steep) {
        add_block<Shape>(block, frame, radii, table, energies);
        continue;
      }
      for (Eigen::Index row = 0; row < block.rows; ++row)
        for (Eigen::Index col = 0; col < block.cols; ++col)
          add_block<Shape>({j + row, i + col, 1, 1}, frame, radii, table, energies);
    }
  const double area = grid.spacing() * grid.spacing(), determinant = frame.l11 * frame.l22;
  for (std::size_t k = 0; k < kParts; ++k) {
    energies.table[k] *= area;
    energies.lobe[k] *= area / determinant;
  }
  const auto& [of_table, of_lobe] = energies;
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
