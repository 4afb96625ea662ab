#pragma once

#include <vector>

#include "core/grid.h"

namespace micro {

/// Draws cells of a grid with probabilities in proportion to given weights.
class CellSampling {
 public:
  /// Weights ≥ 0, not all zero.
  explicit CellSampling(const Grid<double>& weights);

  double total() const { return total_; }

  /// A cell and what is left of the two uniform numbers, uniform again.
  struct Cell {
    Eigen::Index row, col;
    Vec2 xi;
  };
  /// xi.y chooses the row, xi.x the column in it.
  Cell operator()(const Vec2& xi) const;

 private:
  Eigen::Index cols_ = 0;
  double total_ = 0;
  std::vector<double> rows_;   // running sums of the rows' weights
  std::vector<double> cells_;  // [row, col] running sums within each row
};

}  // namespace micro
