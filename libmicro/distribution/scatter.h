#pragma once

#include <vector>

#include "distribution/disk_table.h"
#include "distribution/slope_space.h"

namespace micro {

/// Some nodes of a table: m_x, m_y and density, 1/sr.
struct TableNodes {
  std::vector<double> x, y, density;
  std::size_t size() const { return x.size(); }
};

/// The nodes that carry the lobe: those of at least 1e-3 of the peak, or all with mass if these hold less
/// than 9/10 of it; when they are more than `most`, every k-th of them.
TableNodes core_nodes(const DiskTable& table, std::size_t most);

/// Where a lobe is and how wide, in slope space: starts from the medians and quartiles of m_x and m_y, then a
/// few steps of the Student-t estimate of location and scatter [Lange89], which a lobe without second moments
/// has and which follows every affine map of the slopes. For an ellipsoid it tends to its frame. The nodes
/// are `core`'s; densities below zero count as zero.
SlopeFrame slope_scatter(const TableNodes& core, const DiskGrid& grid);

}  // namespace micro
