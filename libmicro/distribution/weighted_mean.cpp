#include "distribution/weighted_mean.h"

#include <cassert>
#include <cmath>
#include <limits>

#include "core/error.h"

namespace micro {

WeightedMean::WeightedMean(Eigen::Index rows, Eigen::Index cols) {
  sum_ = sum_weight_ = sum_square_ = Grid<double>::Zero(rows, cols);
}

void WeightedMean::add(const Grid<double>& values, double weight) {
  assert(values.rows() == sum_.rows() && values.cols() == sum_.cols());
  if (!(weight > 0)) return;
  add_weight(weight);
  // Most of a narrow lobe's table is zero, and zero adds nothing to any sum.
  for (Eigen::Index k = 0; k < values.size(); ++k)
    if (const double value = values.data()[k]; value != 0) add_at(k, value, weight);
}

void WeightedMean::add(std::span<const std::int32_t> places, std::span<const double> values, double weight) {
  assert(places.size() == values.size());
  if (!(weight > 0)) return;
  add_weight(weight);
  for (std::size_t n = 0; n < places.size(); ++n)
    add_at(places[n], values[n], weight);
}

void WeightedMean::add_weight(double weight) {
  ++count_;
  weight_ += weight;
  weight2_ += weight * weight;
}

void WeightedMean::add_at(Eigen::Index place, double value, double weight) {
  const double area_d = weight * value;
  sum_.data()[place] += area_d;
  sum_weight_.data()[place] += weight * area_d;
  sum_square_.data()[place] += area_d * area_d;
}

void WeightedMean::merge(const WeightedMean& other) {
  if (sum_.rows() != other.sum_.rows() || sum_.cols() != other.sum_.cols())
    throw InputError("sums of arrays of different shape do not add up");
  count_ += other.count_;
  weight_ += other.weight_;
  weight2_ += other.weight2_;
  sum_ += other.sum_;
  sum_weight_ += other.sum_weight_;
  sum_square_ += other.sum_square_;
}

Grid<double> WeightedMean::mean() const {
  return weight_ > 0 ? Grid<double>(sum_ / weight_) : sum_;
}

std::optional<Grid<double>> WeightedMean::standard_error() const {
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
