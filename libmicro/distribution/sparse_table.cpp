#include "distribution/sparse_table.h"

namespace micro {

DiskTable dense(const SparseTable& table) {
  DiskTable full = make_disk_table(table.grid);
  for (std::size_t n = 0; n < table.nodes.size(); ++n)
    full.density.data()[table.nodes[n]] = table.density[n];
  return full;
}

}  // namespace micro
