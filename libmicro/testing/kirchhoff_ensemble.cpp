#include "testing/kirchhoff_ensemble.h"

#include <algorithm>
#include <boost/math/quadrature/gauss.hpp>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

namespace micro::testing {
namespace {

constexpr double kPi = std::numbers::pi;

double sinc(double x) {
  return x == 0 ? 1 : std::sin(x) / x;
}

struct Node {
  double x, weight;
};

/// Gauss–Legendre nodes on [−length, length] with a panel border at 0, panels no longer than `panel`.
std::vector<Node> panels(double length, double panel) {
  using Rule = boost::math::quadrature::gauss<double, 10>;
  const auto n = static_cast<int>(std::ceil(length / panel));
  const double half = length / n / 2;
  std::vector<Node> nodes;
  for (int p = -n; p < n; ++p)
    for (std::size_t k = 0; k < Rule::abscissa().size(); ++k)
      for (const double side : {-1.0, 1.0})
        nodes.push_back({(2 * p + 1 + side * Rule::abscissa()[k]) * half, Rule::weights()[k] * half});
  return nodes;
}

}  // namespace

double gaussian_mean_density(const Vec3& q, const GaussianStatistics& s) {
  const double g = q.z() * q.z() * s.sigma * s.sigma;
  const double b = (std::pow(q.x() * s.tau_x, 2) + std::pow(q.y() * s.tau_y, 2)) / 4;
  if (g == 0) return 0;
  const auto log_term = [g, b](double m) {
    return m * std::log(g) - g - std::lgamma(m + 1) - std::log(m) - b / m;
  };
  // The terms have one maximum, at ln(g/m) + b/m² − 1.5/m = 0 by Stirling; bisection finds it well enough.
  double low = 1, high = std::max({2.0, 2 * g, g + std::sqrt(b)}) + 10;
  for (int k = 0; k < 200; ++k) {
    const double m = (low + high) / 2;
    (std::log(g / m) + b / (m * m) - 1.5 / m > 0 ? low : high) = m;
  }
  const double peak = std::max(1.0, std::floor(low)), top = log_term(peak);
  constexpr double kNegligible = -45;  // e^−45 = 3e-20
  double sum = 0;
  for (double m = peak; m >= 1 && log_term(m) - top > kNegligible; --m)
    sum += std::exp(log_term(m) - top);
  for (double m = peak + 1; log_term(m) - top > kNegligible; ++m)
    sum += std::exp(log_term(m) - top);
  return std::pow(q.squaredNorm() / q.z(), 2) * s.tau_x * s.tau_y / (4 * kPi) * sum * std::exp(top);
}

double gaussian_coherent_density(const Vec3& q, const GaussianStatistics& s, double length_x,
                                 double length_y) {
  const double g = q.z() * q.z() * s.sigma * s.sigma;
  const double plate = q.z() * sinc(q.x() * length_x / 2) * sinc(q.y() * length_y / 2);
  return plate * plate * length_x * length_y * std::exp(-g) / (4 * kPi * kPi);
}

double gaussian_patch_density(const Vec3& q, const GaussianStatistics& s, double length_x, double length_y) {
  const double g = q.z() * q.z() * s.sigma * s.sigma, variance = s.sigma * s.sigma;
  // Ten nodes to a panel of a few radians, or of one width of e^{gC} (about τ/√(1+g)).
  const auto nodes = [g](double length, double wave, double tau) {
    return panels(length, 1 / (std::abs(wave) / 5 + std::sqrt(1 + g) / (1.5 * tau)));
  };
  const auto across = nodes(length_x, q.x(), s.tau_x), along = nodes(length_y, q.y(), s.tau_y);
  const double ax = 2 / (s.tau_x * s.tau_x), ay = 2 / (s.tau_y * s.tau_y);
  double sum = 0;
  for (const Node& y : along)
    for (const Node& x : across) {
      const double correlation = std::exp(-(ax * x.x * x.x + ay * y.x * y.x) / 2);
      // q·∇C = −u C and (q·∇)²C = (u² − w) C
      const double u = q.x() * ax * x.x + q.y() * ay * y.x;
      const double w = q.x() * q.x() * ax + q.y() * q.y() * ay;
      const std::complex<double> tilt(1, variance * u * correlation);
      const std::complex<double> mean = q.z() * q.z() * tilt * tilt - variance * (u * u - w) * correlation;
      const double window = (1 - std::abs(x.x) / length_x) * (1 - std::abs(y.x) / length_y);
      const std::complex<double> wave = std::polar(1.0, -(q.x() * x.x + q.y() * y.x));
      sum += x.weight * y.weight * window * std::exp(-g * (1 - correlation)) * (mean * wave).real();
    }
  return sum / (4 * kPi * kPi);
}

double gaussian_tapered_density(const Vec3& q, const GaussianStatistics& stats, double s) {
  const double g = q.z() * q.z() * stats.sigma * stats.sigma, window = 1 / (4 * s * s);
  double sum = 0;
  const int last = static_cast<int>(g + 12 * std::sqrt(g) + 60);
  for (int m = 0; m <= last; ++m) {
    const double poisson = std::exp((m == 0 ? 0 : m * std::log(g)) - g - std::lgamma(m + 1.0));
    const double x = m / (stats.tau_x * stats.tau_x) + window, y = m / (stats.tau_y * stats.tau_y) + window;
    const double obliquity = m == 0 ? q.z() : q.squaredNorm() / q.z();
    sum += obliquity * obliquity * poisson * std::exp(-q.x() * q.x() / (4 * x) - q.y() * q.y() / (4 * y)) /
           std::sqrt(x * y);
  }
  return sum / (4 * kPi);
}

double beckmann_density(const Vec3& m, double alpha_x, double alpha_y) {
  const double x = m.x() / (m.z() * alpha_x), y = m.y() / (m.z() * alpha_y);
  return std::exp(-x * x - y * y) / (kPi * alpha_x * alpha_y * std::pow(m.z(), 4));
}

Vec2 slope_alpha(const GaussianStatistics& s) {
  return {2 * s.sigma / s.tau_x, 2 * s.sigma / s.tau_y};
}

Vec2 filtered_slope_alpha(const GaussianStatistics& s, double width) {
  const double x2 = s.tau_x * s.tau_x + 4 * width * width, y2 = s.tau_y * s.tau_y + 4 * width * width;
  const double sigma = s.sigma * std::sqrt(s.tau_x * s.tau_y / std::sqrt(x2 * y2));
  return {2 * sigma / std::sqrt(x2), 2 * sigma / std::sqrt(y2)};
}

}  // namespace micro::testing
