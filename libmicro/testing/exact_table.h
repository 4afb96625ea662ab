#pragma once

#include "distribution/disk_table.h"
#include "height/height_field.h"

namespace micro::testing {

/// D_K on every node above the horizon by the closed form per triangle: O(nodes · triangles).
DiskTable exact_table(const HeightField& surface, const DiskGrid& grid, double lambda_q);

/// What is promised of a D_K table, measured on every node.
struct TableError {
  double relative_l2;  ///< of D over the table
  double core_free;    ///< the same where |h_xy| > core, 0 if nothing is there
  double median;       ///< relative error among D ≥ 1e-8 of the peak
};

TableError table_error(const Grid<double>& got, const DiskTable& want, double core);

}  // namespace micro::testing
