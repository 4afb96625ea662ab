#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "core/grid.h"

namespace micro {

/// Directions nearer to the horizon than this m_z² are on it.
inline constexpr double kHorizonMz2 = 1e-12;

/// The square grid that holds the hemisphere projected onto the unit disk: size × size nodes, node (j, i) at
/// m_xy = ((i−c)/c, (j−c)/c)·extent, c = (size−1)/2, m_z = √(1−|m_xy|²). extent ≤ 1 zooms in on narrow lobes.
struct DiskGrid {
  int size = 1025;
  double extent = 1;

  double centre() const { return (size - 1) / 2.0; }
  /// Distance between nodes, in units of m_xy.
  double spacing() const { return extent / centre(); }
  /// m_x of column i, or m_y of row i.
  double coordinate(Eigen::Index i) const { return (static_cast<double>(i) - centre()) * spacing(); }
  /// m_z² of node (j, i); the disk is where it is positive. Of a node on the horizon, as many sizes have by
  /// Pythagoras' triples, rounding alone would say on which side it lies: it is off the disk.
  double mz2(Eigen::Index j, Eigen::Index i) const {
    const double x = coordinate(i), y = coordinate(j), z2 = 1 - x * x - y * y;
    return z2 > kHorizonMz2 ? z2 : 0;
  }
  /// A node stands for dω = spacing²/m_z, but for no more than the cell that touches the horizon from within
  /// has, ∫dm_x dm_y/m_z ≈ spacing·√(2·spacing): m_z counts as this at least.
  double least_mz() const { return std::sqrt(spacing() / 2); }
  /// sinθ of the outermost direction, in the table's corners.
  double outermost_sine() const { return std::min(1.0, extent * std::numbers::sqrt2); }
  template <typename Archive>
  void persist(Archive& archive) {
    archive(size, extent);
  }
  bool operator==(const DiskGrid&) const = default;
};

/// A normal distribution tabulated on a DiskGrid, in 1/sr; zero outside the disk.
struct DiskTable {
  DiskGrid grid;
  Grid<double> density;  ///< [size, size] 1/sr, row j along m_y, column i along m_x
};

/// An empty (all zero) table. Throws InputError unless size is odd and ≥ 3 and 0 < extent ≤ 1.
DiskTable make_disk_table(const DiskGrid& grid);

/// How many nodes of a grid lie on the disk.
std::int64_t disk_nodes(const DiskGrid& grid);

/// ∫ D m_z dω over the table: since m_z dω = dm_x dm_y it is ΣD·spacing².
double normalization(const DiskTable& table);

/// Half width in m_xy of the smallest centred square that holds this fraction of the table's mass.
double extent_holding(const DiskTable& table, double fraction);

}  // namespace micro
