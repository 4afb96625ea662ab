#include "distribution/table_mean.h"

#include "core/error.h"

namespace micro {

TableMean::TableMean(const DiskGrid& grid) : grid_(grid), mean_(make_disk_table(grid).grid.size, grid.size) {}

void TableMean::add(const DiskTable& table, double weight) {
  if (!(table.grid == grid_)) throw InputError("tables of different size or extent have no common mean");
  mean_.add(table.density, weight);
}

void TableMean::merge(const TableMean& other) {
  if (!(other.grid_ == grid_)) throw InputError("tables of different size or extent have no common mean");
  mean_.merge(other.mean_);
}

}  // namespace micro
