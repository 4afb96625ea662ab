#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "core/grid.h"

namespace micro {

/// The weighted mean of arrays of one shape over scans, and its standard error. Running sums are double;
/// memory does not grow with the number of arrays.
class WeightedMean {
 public:
  WeightedMean(Eigen::Index rows, Eigen::Index cols);

  /// Adds one scan's array with its weight, A_perp in µm². A weight of zero (no surface) is counted nowhere.
  void add(const Grid<double>& values, double weight);
  /// The same for an array that is zero but at these row-major places.
  void add(std::span<const std::int32_t> places, std::span<const double> values, double weight);

  /// Adds what another sum holds, as if its arrays had been added here. Throws InputError if they have
  /// another shape.
  void merge(const WeightedMean& other);

  std::int64_t count() const { return count_; }
  double weight() const { return weight_; }  ///< ΣA_perp, µm²

  /// D̄ = Σ A·D / Σ A.
  Grid<double> mean() const;

  /// Standard error of D̄ over n scans: √(n/(n−1)·Σ A²(D − D̄)²) / ΣA. Nothing if there are fewer than two.
  std::optional<Grid<double>> standard_error() const;

  template <typename Archive>
  void persist(Archive& archive) {
    archive(count_, weight_, weight2_, sum_, sum_weight_, sum_square_);
  }

 private:
  void add_weight(double weight);
  void add_at(Eigen::Index place, double value, double weight);

  std::int64_t count_ = 0;
  double weight_ = 0, weight2_ = 0;             // Σ A, Σ A²
  Grid<double> sum_, sum_weight_, sum_square_;  // Σ A·D, Σ A²·D, Σ A²·D²
};

}  // namespace micro
