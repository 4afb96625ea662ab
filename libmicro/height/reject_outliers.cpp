#include <algorithm>
#include <limits>
#include <vector>

#include "core/parallel.h"
#include "height/repair.h"

namespace micro {
namespace {

/// Standard deviation of a normal distribution over its median absolute deviation, 1/Φ⁻¹(3/4), and over its
/// mean absolute deviation, √(π/2).
constexpr double kMedianToSigma = 1.482602218505602, kMeanToSigma = 1.2533141373155003;
constexpr std::size_t kFewestPoints = 5;

/// The lower median; reorders its argument.
float median(std::vector<float>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void gather_window(const HeightField& surface, Eigen::Index j, Eigen::Index i, Eigen::Index radius,
                   std::vector<float>& window) {
  window.clear();
  for (Eigen::Index jj = std::max<Eigen::Index>(j - radius, 0);
       jj <= std::min(j + radius, surface.rows() - 1); ++jj)
    for (Eigen::Index ii = std::max<Eigen::Index>(i - radius, 0);
         ii <= std::min(i + radius, surface.cols() - 1); ++ii)
      if (!is_missing(surface.z(jj, ii))) window.push_back(surface.z(jj, ii));
}

/// Distance of each point from the median of its window, µm; NaN where it cannot be judged.
Grid<float> distances_from_median(const HeightField& surface, Eigen::Index radius) {
  Grid<float> distance(surface.rows(), surface.cols());
  parallel_for(surface.rows(), [&](Eigen::Index j) {
    std::vector<float> window;
    for (Eigen::Index i = 0; i < surface.cols(); ++i) {
      distance(j, i) = kMissing;
      if (is_missing(surface.z(j, i))) continue;
      gather_window(surface, j, i, radius, window);
      if (window.size() >= kFewestPoints) distance(j, i) = std::abs(surface.z(j, i) - median(window));
    }
  });
  return distance;
}

double sigma_of(const Grid<float>& distance) {
  std::vector<float> values;
  values.reserve(static_cast<std::size_t>(distance.size()));
  for (const float d : distance.reshaped<Eigen::RowMajor>())
    if (!is_missing(d)) values.push_back(d);
  if (values.empty()) return 0;
  if (const double middle = median(values); middle > 0) return kMedianToSigma * middle;
  double sum = 0;
  for (const float d : values)
    sum += d;
  return kMeanToSigma * sum / static_cast<double>(values.size());
}

double window_sigma(const HeightField& surface, Eigen::Index j, Eigen::Index i, Eigen::Index radius) {
  std::vector<float> window;
  gather_window(surface, j, i, radius, window);
  const float middle = median(window);
  for (float& z : window)
    z = std::abs(z - middle);
  return kMedianToSigma * median(window);
}

}  // namespace

Repair reject_outliers(const HeightField& surface, const OutlierRule& rule) {
  Repair repair{surface};
  const Grid<float> distance = distances_from_median(surface, rule.radius);
  const double sigma = sigma_of(distance);
  for (Eigen::Index j = 0; j < surface.rows(); ++j)
    for (Eigen::Index i = 0; i < surface.cols(); ++i) {
      const double d = distance(j, i);
      if (!(d > rule.threshold * sigma) || !(d > rule.threshold * window_sigma(surface, j, i, rule.radius)))
        continue;
      repair.surface.z(j, i) = kMissing;
      ++repair.changed;
      repair.largest_change = std::max(repair.largest_change, d);
    }
  return repair;
}

}  // namespace micro
