#include "testing/chi_square.h"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <numbers>

namespace micro::testing {

double chi_square_p(const std::vector<double>& counts, const std::vector<double>& expected) {
  constexpr double kFewest = 10;
  double statistic = 0, small_count = 0, small_expected = 0;
  int bins = 0;
  const auto add = [&](double count, double expect) {
    statistic += (count - expect) * (count - expect) / expect;
    ++bins;
  };
  for (std::size_t k = 0; k < counts.size(); ++k)
    if (expected[k] < kFewest) {
      small_count += counts[k];
      small_expected += expected[k];
    } else {
      add(counts[k], expected[k]);
    }
  if (small_expected >= kFewest) {
    add(small_count, small_expected);
  } else if (small_count > small_expected + 5 * std::sqrt(small_expected + 1) + 5) {
    return 0;  // samples where there should be none
  }
  if (bins < 2 || !std::isfinite(statistic)) return 0;
  return cdf(complement(boost::math::chi_squared(bins - 1), statistic));
}

std::size_t PlaneBins::bin_of(const Vec2& v) const {
  const double tau = 1 / std::hypot(1., v.norm()),
               turn = std::atan2(v.y(), v.x()) / (2 * std::numbers::pi) + 0.5;
  const int i = std::clamp(static_cast<int>(tau * radial), 0, radial - 1);
  const int j = std::clamp(static_cast<int>(turn * angular), 0, angular - 1);
  return static_cast<std::size_t>(i * angular + j);
}

std::vector<double> PlaneBins::integrate(const std::function<double(const Vec2&)>& density, int steps) const {
  // d²v = |v|d|v|dφ = τ⁻³dτdφ.
  std::vector<double> result(size(), 0.);
  const double step_tau = 1. / radial / steps, step_phi = 2 * std::numbers::pi / angular / steps;
  for (int i = 0; i < radial * steps; ++i)
    for (int j = 0; j < angular * steps; ++j) {
      const double tau = (i + 0.5) * step_tau, phi = (j + 0.5) * step_phi - std::numbers::pi;
      const double r = std::sqrt((1 - tau) * (1 + tau)) / tau;
      result[static_cast<std::size_t>(i / steps * angular + j / steps)] +=
          density({r * std::cos(phi), r * std::sin(phi)}) / (tau * tau * tau) * step_tau * step_phi;
    }
  return result;
}

}  // namespace micro::testing
