#include "distribution/compare.h"

#include <limits>

#include "core/error.h"

namespace micro {
namespace {

/// Position, in nodes, below which the fraction p of the marginal's mass lies; linear inside a node's bin.
double quantile(const Eigen::ArrayXd& marginal, double p) {
  const double target = p * marginal.sum();
  double below = 0;
  for (Eigen::Index i = 0; i < marginal.size(); ++i) {
    if (below + marginal[i] >= target && marginal[i] > 0)
      return static_cast<double>(i) - 0.5 + (target - below) / marginal[i];
    below += marginal[i];
  }
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

LobeWidth lobe_width(const DiskTable& table) {
  const Eigen::ArrayXd along_x = table.density.colwise().sum().transpose(),
                       along_y = table.density.rowwise().sum();
  const auto half_range = [&](const Eigen::ArrayXd& marginal) {
    return (quantile(marginal, 0.75) - quantile(marginal, 0.25)) / 2 * table.grid.spacing();
  };
  return {half_range(along_x), half_range(along_y)};
}

double total_variation(const DiskTable& a, const DiskTable& b) {
  if (!(a.grid == b.grid))
    throw InputError("tables of different size or extent cannot be compared node by node");
  return (a.density - b.density).abs().sum() / 2 * a.grid.spacing() * a.grid.spacing();
}

}  // namespace micro
