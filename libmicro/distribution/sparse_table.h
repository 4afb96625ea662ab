#pragma once

#include <cstdint>
#include <vector>

#include "distribution/disk_table.h"

namespace micro {

/// A table that is zero but at a few nodes: what a small scan's histogram is, at a cost that follows the
/// scan.
struct SparseTable {
  DiskGrid grid;
  std::vector<std::int32_t> nodes;  ///< row-major places, ascending
  std::vector<double> density;      ///< 1/sr, at these
};

/// The same table with its zeros.
DiskTable dense(const SparseTable& table);

}  // namespace micro
