#include "distribution/table_mean.h"

#include "core/error.h"

namespace micro {

TableMean::TableMean(const DiskGrid& grid) : grid_(grid), mean_(make_disk_table(grid).grid.size, grid.size) {}

void TableMean::require_same(const DiskGrid& grid) const {
  if (!(grid == grid_)) throw InputError("tables of different size or extent have no common mean");
}

void TableMean::add(const DiskTable& table, double weight) {
  require_same(table.grid);
  mean_.add(table.density, weight);
}

void TableMean::add(const SparseTable& table, double weight) {
  require_same(table.grid);
  mean_.add(table.nodes, table.density, weight);
}

void TableMean::merge(const TableMean& other) {
  require_same(other.grid_);
  mean_.merge(other.mean_);
}

}  // namespace micro
