#pragma once

#include <cstdint>
#include <vector>

#include "distribution/disk_table.h"
#include "distribution/sparse_table.h"
#include "ndf/local_planes.h"

namespace micro {

/// A histogram of surface normals over the nodes of a disk grid. Every sample stands for the same projected
/// area, so the distribution it estimates [Dong15 Eq. 2] is D = count / (total · spacing²): no cosine
/// appears. Counts are integers: the sum of any number of scans is the same in any order.
struct NormalCounts {
  DiskGrid grid;
  std::vector<std::int32_t> nodes;    ///< those that hold any, row-major places, ascending
  std::vector<std::uint32_t> counts;  ///< at these
  std::int64_t total = 0;             ///< samples with a normal, inside the extent or not
  std::int64_t outside = 0;           ///< of these, beyond the extent
};

/// The naive NDF: normals of the surface's triangles, each of projected area dx·dy/2.
NormalCounts naive_counts(const HeightField& surface, const DiskGrid& grid);

/// The filtered NDF [Dong15 §5.1]: normals (−b, −c, 1)/norm of locally fitted planes; every point that has
/// one counts the same.
NormalCounts filtered_counts(const SlopeField& slopes, const DiskGrid& grid);

/// D at the nodes that hold any, 1/sr.
SparseTable sparse_density(const NormalCounts& counts);

/// D at all nodes, 1/sr. All zero if there is no sample.
DiskTable density(const NormalCounts& counts);

}  // namespace micro
