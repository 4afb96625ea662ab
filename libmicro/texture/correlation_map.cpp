#include "texture/correlation_map.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace micro {

HermiteSeries hermite_series(std::span<const float> values, double reach) {
  HermiteSeries series{};
  if (values.size() < 2 || values.front() == values.back()) return series;
  const double step = 2 * reach / static_cast<double>(values.size() - 1);
  for (std::size_t node = 0; node < values.size(); ++node) {
    const double z = static_cast<double>(node) * step - reach;
    const double weight = step * std::exp(-z * z / 2) / std::sqrt(2 * std::numbers::pi);
    double before = 1, here = z;
    for (int k = 1; k <= kHermiteTerms; ++k) {
      series[static_cast<std::size_t>(k - 1)] += weight * here * static_cast<double>(values[node]);
      const double next = (z * here - std::sqrt(static_cast<double>(k)) * before) / std::sqrt(k + 1.);
      before = std::exchange(here, next);
    }
  }
  return series;
}

CorrelationMap::CorrelationMap(const HermiteSeries& a, const HermiteSeries& b) {
  constexpr int kNodes = 1025;
  double aa = 0, bb = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    aa += a[k] * a[k];
    bb += b[k] * b[k];
  }
  if (!(aa > 0 && bb > 0)) return;
  for (int node = 0; node < kNodes; ++node) {
    const double rho = 2. * node / (kNodes - 1) - 1;
    double sum = 0;
    for (std::size_t k = a.size(); k-- > 0;)
      sum = (sum + a[k] * b[k]) * rho;
    // Rounding aside it rises.
    after_.push_back(std::max(sum / std::sqrt(aa * bb), after_.empty() ? -1. : after_.back()));
  }
}

double CorrelationMap::operator()(double wanted) const {
  if (!changes()) return wanted;
  if (wanted <= after_.front()) return -1;
  if (wanted >= after_.back()) return 1;
  const auto above = std::upper_bound(after_.begin(), after_.end(), wanted);
  const auto node = static_cast<double>(above - after_.begin() - 1);
  const double low = *(above - 1), part = (wanted - low) / (*above - low);
  return 2 * (node + part) / static_cast<double>(after_.size() - 1) - 1;
}

}  // namespace micro
