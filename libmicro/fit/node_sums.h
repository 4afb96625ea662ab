#pragma once

#include <array>

#include "fit/normal_equations.h"

namespace micro {

/// 15 of a symmetric matrix row by row, 5 of the gradient, the cost, the data and the number of nodes.
using NodeSums = std::array<double, 23>;

/// What the sums need; det L = l11·l22. `inverse`, row by row, is for sum_residuals alone.
struct NodeSumInput {
  NodeSpan nodes;
  SlopeFrame frame;
  double determinant;
  std::array<double, 25> inverse;
};

/// The sums of NormalEquations, and that of TableEquations::residual_gram; vectorised for the machine it runs
/// on.
NodeSums sum_equations(const NodeSumInput& input, FitModel model, Weighting weighting);
NodeSums sum_residuals(const NodeSumInput& input, FitModel model, Weighting weighting);

}  // namespace micro
