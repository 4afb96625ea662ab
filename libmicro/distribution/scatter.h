#pragma once

#include <vector>

#include "distribution/disk_table.h"
#include "distribution/slope_space.h"

namespace micro {

/// Some nodes of a table: m_x, m_y and density, 1/sr; for the last see DiskGrid.
struct TableNodes {
  std::vector<double> x, y, density;
  double least_mz = 0;
  std::size_t size() const { return x.size(); }
};

/// The nodes that carry the lobe: those of at least 1e-3 of the peak, or all with mass if these hold less
/// than 9/10 of it; when they are more than `most`, every k-th of them.
TableNodes core_nodes(const DiskTable& table, std::size_t most);

/// Every `stride`-th node of every `stride`-th row, all that lie within the disk.
TableNodes strided_nodes(const DiskTable& table, Eigen::Index stride);

/// Slopes, and how much each counts.
struct WeightedSlopes {
  std::vector<double> x, y, weight;
  std::size_t size() const { return x.size(); }
};

/// One step of the Student-t estimate of location and scatter [Lange89] with the scale taken as in [Kent94],
/// which ends at the same frame in fewer steps. With two degrees of freedom that is the most likely
/// ellipsoid: Σw(v) = 0 and Σw·(2v·vᵀ − 1) = 0, w = 1/(1 + |v|²). There is one such frame unless half of the
/// slopes lie on a line; no width becomes less than `least`.
SlopeFrame scatter_step(const SlopeFrame& frame, const WeightedSlopes& slopes, double least);

/// Where a lobe is and how wide, in slope space: starts from the medians and quartiles of m_x and m_y, then a
/// few steps of the Student-t estimate of location and scatter [Lange89], which a lobe without second moments
/// has and which follows every affine map of the slopes. For an ellipsoid it tends to its frame. The nodes
/// are `core`'s; densities below zero count as zero.
SlopeFrame slope_scatter(const TableNodes& core, const DiskGrid& grid);

}  // namespace micro
