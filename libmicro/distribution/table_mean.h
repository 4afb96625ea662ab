#pragma once

#include <cstdint>
#include <optional>

#include "distribution/disk_table.h"
#include "distribution/sparse_table.h"
#include "distribution/weighted_mean.h"

namespace micro {

/// The mean of tables over scans, weighted by each scan's projected area A_perp, and its standard error
/// (weighted_mean.h).
class TableMean {
 public:
  explicit TableMean(const DiskGrid& grid);

  /// Adds one scan's table with its weight, A_perp in µm². A weight of zero (no surface) is counted nowhere.
  /// Throws InputError if the table stands on another grid.
  void add(const DiskTable& table, double weight);
  void add(const SparseTable& table, double weight);

  std::int64_t count() const { return mean_.count(); }
  double weight() const { return mean_.weight(); }                                       ///< ΣA_perp, µm²
  DiskTable mean() const { return {grid_, mean_.mean()}; }                               ///< 1/sr
  std::optional<Grid<double>> standard_error() const { return mean_.standard_error(); }  ///< 1/sr

  /// Adds what another sum holds. Throws InputError if it stands on another grid.
  void merge(const TableMean& other);

  template <typename Archive>
  void persist(Archive& archive) {
    archive(grid_, mean_);
  }

 private:
  void require_same(const DiskGrid& grid) const;

  DiskGrid grid_;
  WeightedMean mean_;
};

}  // namespace micro
