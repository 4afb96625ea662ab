#include "distribution/table_mean.h"

#include <cmath>
#include <limits>

#include "core/error.h"

namespace micro {

TableMean::TableMean(const DiskGrid& grid) : grid_(grid) {
  sum_ = sum_weight_ = sum_square_ = make_disk_table(grid).density;
}

void TableMean::add(const DiskTable& table, double weight) {
  if (!(table.grid == grid_)) throw InputError("tables of different size or extent have no common mean");
  if (!(weight > 0)) return;
  ++count_;
  weight_ += weight;
  weight2_ += weight * weight;
  // Most of a narrow lobe's table is zero, and zero adds nothing to any sum.
  for (Eigen::Index k = 0; k < table.density.size(); ++k) {
    const double d = table.density.data()[k];
    if (d == 0) continue;
    const double area_d = weight * d;
    sum_.data()[k] += area_d;
    sum_weight_.data()[k] += weight * area_d;
    sum_square_.data()[k] += area_d * area_d;
  }
}

DiskTable TableMean::mean() const {
  DiskTable table{grid_, sum_};
  if (weight_ > 0) table.density /= weight_;
  return table;
}

std::optional<Grid<double>> TableMean::standard_error() const {
  if (count_ < 2) return std::nullopt;
  const double n = static_cast<double>(count_);
  Grid<double> error(sum_.rows(), sum_.cols());
  for (Eigen::Index k = 0; k < error.size(); ++k) {
    const double mean = sum_.data()[k] / weight_;
    const double square = sum_square_.data()[k], spread = mean * mean * weight2_;
    const double variance = square - 2 * mean * sum_weight_.data()[k] + spread;
    // Below the rounding of the sums the scans agree.
    const double rounding = 4 * n * std::numeric_limits<double>::epsilon() * (square + spread);
    error.data()[k] = variance > rounding ? std::sqrt(n / (n - 1) * variance) / weight_ : 0;
  }
  return error;
}

}  // namespace micro
