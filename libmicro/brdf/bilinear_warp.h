#pragma once

#include <span>
#include <vector>

#include "core/grid.h"

namespace micro {

/// Sampling of a bilinear density on the unit square, as the readers of tensor files do it [Dupuy18 §4.2]: y
/// (rows) by the marginal, then x (columns) within the row between two rows of nodes.
class BilinearWarp {
 public:
  /// values[row·cols + col] ≥ 0 at nodes (x, y) = (col/(cols−1), row/(rows−1)), at least 2 × 2, not all 0.
  BilinearWarp(std::span<const float> values, std::size_t rows, std::size_t cols);

  /// The point of the unit square that (x, y) uniform numbers give.
  Vec2 sample(const Vec2& xi) const;

  /// The density at a point; its integral over the square is 1.
  double density(const Vec2& at) const;

 private:
  double value(std::size_t row, std::size_t col) const { return values_[row * cols_ + col]; }

  std::size_t rows_, cols_;
  std::vector<double> values_;       // of integral 1
  std::vector<double> conditional_;  // [rows, cols] integrals along each row of nodes, in columns
  std::vector<double> marginal_;     // [rows] integrals of those, in rows
};

}  // namespace micro
