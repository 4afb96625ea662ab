#include "brdf/bilinear_warp.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace micro {
namespace {

/// Where the integral of the density (1−t)·a + t·b from 0 reaches `mass`, t in [0, 1].
double invert_linear(double a, double b, double mass) {
  if (!(a + b > 0)) return 0;
  // (a + √(a² + 2·mass·(b − a))) in the denominator: no cancellation where a and b are nearly equal.
  const double root = std::sqrt(std::max(0., a * a + 2 * mass * (b - a)));
  return a + root > 0 ? std::clamp(2 * mass / (a + root), 0., 1.) : 0;
}

/// The last index below `size` − 1 whose sum is at most `mass`.
template <typename Sum>
std::size_t interval(std::size_t size, double mass, Sum&& sum) {
  std::size_t low = 0, high = size - 1;
  while (high - low > 1) {
    const std::size_t middle = (low + high) / 2;
    (sum(middle) <= mass ? low : high) = middle;
  }
  return low;
}

}  // namespace

BilinearWarp::BilinearWarp(std::span<const float> values, std::size_t rows, std::size_t cols)
    : rows_(rows), cols_(cols), values_(values.begin(), values.end()) {
  assert(values.size() == rows * cols && rows > 1 && cols > 1);
  conditional_.resize(values_.size());
  marginal_.resize(rows);
  for (std::size_t row = 0; row < rows; ++row)
    for (std::size_t col = 1; col < cols; ++col)
      conditional_[row * cols + col] =
          conditional_[row * cols + col - 1] + (value(row, col - 1) + value(row, col)) / 2;
  const auto whole = [&](std::size_t row) { return conditional_[row * cols + cols - 1]; };
  for (std::size_t row = 1; row < rows; ++row)
    marginal_[row] = marginal_[row - 1] + (whole(row - 1) + whole(row)) / 2;
  const double scale = static_cast<double>((rows - 1) * (cols - 1)) / marginal_.back();
  for (std::vector<double>* table : {&values_, &conditional_, &marginal_})
    for (double& entry : *table)
      entry *= scale;
}

Vec2 BilinearWarp::sample(const Vec2& xi) const {
  double mass = xi.y() * marginal_.back();
  const std::size_t row = interval(rows_, mass, [&](std::size_t k) { return marginal_[k]; });
  const double below = conditional_[row * cols_ + cols_ - 1], above = conditional_[(row + 2) * cols_ - 1];
  const double y = invert_linear(below, above, mass - marginal_[row]);
  const auto between = [&](const std::vector<double>& table, std::size_t col) {
    return (1 - y) * table[row * cols_ + col] + y * table[(row + 1) * cols_ + col];
  };
  mass = xi.x() * between(conditional_, cols_ - 1);
  const std::size_t col = interval(cols_, mass, [&](std::size_t k) { return between(conditional_, k); });
  const double x =
      invert_linear(between(values_, col), between(values_, col + 1), mass - between(conditional_, col));
  return {(static_cast<double>(col) + x) / static_cast<double>(cols_ - 1),
          (static_cast<double>(row) + y) / static_cast<double>(rows_ - 1)};
}

double BilinearWarp::density(const Vec2& at) const {
  const double x = at.x() * static_cast<double>(cols_ - 1), y = at.y() * static_cast<double>(rows_ - 1);
  const auto cell = [](double t, std::size_t nodes) {
    return static_cast<std::size_t>(std::clamp(t, 0., static_cast<double>(nodes - 2)));
  };
  const std::size_t col = cell(x, cols_), row = cell(y, rows_);
  const double u = x - static_cast<double>(col), v = y - static_cast<double>(row);
  return (1 - v) * ((1 - u) * value(row, col) + u * value(row, col + 1)) +
         v * ((1 - u) * value(row + 1, col) + u * value(row + 1, col + 1));
}

}  // namespace micro
