#include "pipelines/wavelength_dependence.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/error.h"
#include "core/parallel.h"

namespace micro {
namespace {

/// Wide enough to hold many speckles, and nodes of a coarse table, which samples speckle rather than resolves
/// it.
double cell_width(const DiskGrid& grid, double longer_speckle) {
  constexpr double kMostCells = 100, kSpecklesWide = 3, kNodesWide = 6;
  const double width = 2 * grid.extent;
  return std::min(
      width, std::max({width / kMostCells, kSpecklesWide * longer_speckle, kNodesWide * grid.spacing()}));
}

}  // namespace

WavelengthDependence::WavelengthDependence(const DiskGrid& grid, std::vector<double> lambda_q,
                                           double longer_speckle)
    : grid_(grid),
      lambda_q_(std::move(lambda_q)),
      cell_(cell_width(grid, longer_speckle)),
      cells_(static_cast<int>(std::ceil(2 * grid.extent / cell_ * (1 - 1e-12)))) {
  for (int i = 0; i < grid.size; ++i)
    cell_of_.push_back(
        std::clamp(static_cast<int>((grid.coordinate(i) + grid.extent) / cell_), 0, cells_ - 1));
  const auto wavelengths = static_cast<Eigen::Index>(lambda_q_.size());
  sum_ = sum2_ = Eigen::MatrixXd::Zero(Eigen::Index{cells_} * cells_, wavelengths);
  gram2_ = Eigen::MatrixXd::Zero(wavelengths, wavelengths);
}

void WavelengthDependence::add(const std::vector<Grid<float>>& tables, double weight) {
  assert(tables.size() == lambda_q_.size());
  if (!(weight > 0)) return;
  Eigen::MatrixXd cells = Eigen::MatrixXd::Zero(sum_.rows(), sum_.cols());
  parallel_for(static_cast<std::int64_t>(tables.size()), [&](std::int64_t k) {
    const Grid<float>& table = tables[static_cast<std::size_t>(k)];
    for (Eigen::Index j = 0; j < table.rows(); ++j)
      for (Eigen::Index i = 0; i < table.cols(); ++i)
        cells(Eigen::Index{cell_of_[static_cast<std::size_t>(j)]} * cells_ +
                  cell_of_[static_cast<std::size_t>(i)],
              k) += static_cast<double>(table(j, i));
  });
  ++scans_;
  weight_ += weight;
  weight2_ += weight * weight;
  sum_ += weight * cells;
  sum2_ += weight * weight * cells;
  gram2_ += weight * weight * (cells.transpose() * cells);
}

void WavelengthDependence::merge(const WavelengthDependence& other) {
  if (!(other.grid_ == grid_) || other.lambda_q_ != lambda_q_ || other.cell_ != cell_)
    throw InputError("spectra of different tables, wavelengths or cells do not add up");
  scans_ += other.scans_;
  weight_ += other.weight_;
  weight2_ += other.weight2_;
  sum_ += other.sum_;
  sum2_ += other.sum2_;
  gram2_ += other.gram2_;
}

double WavelengthDependence::Distance::beyond() const {
  return std::sqrt(std::max(0.0, measured * measured - scatter * scatter));
}

WavelengthDependence::Distance WavelengthDependence::between(std::size_t first, std::size_t second) const {
  const auto a = static_cast<Eigen::Index>(first), b = static_cast<Eigen::Index>(second);
  const Eigen::VectorXd difference = (sum_.col(a) - sum_.col(b)) / weight_;
  const double size = ((sum_.col(a) + sum_.col(b)) / (2 * weight_)).squaredNorm();
  if (!(size > 0)) return {0, 0};
  double scatter = 0;
  if (scans_ > 1) {
    const double squares = gram2_(a, a) + gram2_(b, b) - 2 * gram2_(a, b);
    const double about =
        squares - 2 * (sum2_.col(a) - sum2_.col(b)).dot(difference) + weight2_ * difference.squaredNorm();
    const double n = static_cast<double>(scans_);
    scatter = n / (n - 1) * std::max(0.0, about) / (weight_ * weight_) / size;
  }
  return {std::sqrt(difference.squaredNorm() / size), std::sqrt(scatter)};
}

WavelengthDependence::Distance WavelengthDependence::largest() const {
  Distance worst{0, 0};
  for (std::size_t a = 0; a < lambda_q_.size(); ++a)
    for (std::size_t b = a + 1; b < lambda_q_.size(); ++b) {
      const Distance distance = between(a, b);
      if (std::pair(distance.beyond(), distance.measured) > std::pair(worst.beyond(), worst.measured))
        worst = distance;
    }
  return worst;
}

std::pair<std::size_t, WavelengthDependence::Distance> WavelengthDependence::most_typical() const {
  std::pair<std::size_t, Distance> best{0, {0, 0}};
  for (std::size_t a = 0; a < lambda_q_.size(); ++a) {
    Distance farthest{0, 0};
    for (std::size_t b = 0; b < lambda_q_.size(); ++b) {
      const Distance distance = between(a, b);
      if (b != a &&
          std::pair(distance.beyond(), distance.measured) > std::pair(farthest.beyond(), farthest.measured))
        farthest = distance;
    }
    const auto rank = [](const Distance& d) { return std::pair(d.beyond(), d.measured); };
    if (a == 0 || rank(farthest) < rank(best.second)) best = {a, farthest};
  }
  return best;
}

}  // namespace micro
