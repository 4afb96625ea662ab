#pragma once

#include <cstdint>
#include <optional>

#include "distribution/disk_table.h"

namespace micro {

/// The mean of tables over scans, weighted by each scan's projected area A_perp, and its standard error.
/// Running sums are double; memory does not grow with the number of tables.
class TableMean {
 public:
  explicit TableMean(const DiskGrid& grid);

  /// Adds one scan's table with its weight, A_perp in µm². A weight of zero (no surface) is counted nowhere.
  /// Throws InputError if the table stands on another grid.
  void add(const DiskTable& table, double weight);

  std::int64_t count() const { return count_; }
  double weight() const { return weight_; }  ///< ΣA_perp, µm²

  /// D̄ = Σ A·D / Σ A, 1/sr.
  DiskTable mean() const;

  /// Standard error of D̄ over n scans, 1/sr: √(n/(n−1)·Σ A²(D − D̄)²) / ΣA. Nothing if there are fewer than
  /// two.
  std::optional<Grid<double>> standard_error() const;

 private:
  DiskGrid grid_;
  std::int64_t count_ = 0;
  double weight_ = 0, weight2_ = 0;             // Σ A, Σ A²
  Grid<double> sum_, sum_weight_, sum_square_;  // Σ A·D, Σ A²·D, Σ A²·D²
};

}  // namespace micro
