#pragma once

#include "distribution/disk_table.h"

namespace micro {

/// Half the interquartile range of m_x and of m_y: a width that exists for every distribution (GGX has no
/// second moment) and that a few stray normals don't move. For a Gaussian it is 0.6745 standard deviations.
struct LobeWidth {
  double x, y;  ///< in m_xy; NaN for an empty table
};
LobeWidth lobe_width(const DiskTable& table);

/// Total variation ½∫|D_a − D_b| m_z dω between two normalised tables: the part of the mass that lies
/// elsewhere, 0 to 1. Throws InputError if they stand on different grids.
double total_variation(const DiskTable& a, const DiskTable& b);

}  // namespace micro
