#include "brdf/free_travel.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

namespace micro {
namespace {

constexpr double kInvSqrt2Pi = std::numbers::inv_sqrtpi / std::numbers::sqrt2;
/// ½ erfc(w/√2) underflows beyond.
constexpr double kFarthest = 39;

/// P(surface above the ray) at distance t.
double covered(double eta, double nu, double t) {
  const double from_height = std::sqrt(std::tanh(t * t / 2));
  const double from_ray = t > 0 ? t / std::sqrt(-std::expm1(-2 * t * t)) : 1 / std::numbers::sqrt2;
  return std::erfc((eta * from_height + nu * from_ray) / std::numbers::sqrt2) / 2;
}

/// The trapezoidal rule of a function that vanishes at both ends, halving its step until it changes by no
/// more than `tolerance(sum)`: exponential convergence for analytic functions.
template <typename F, typename Tolerance>
Estimate<double> trapezoid(F&& f, double low, double high, Tolerance&& tolerance) {
  constexpr int kFirst = 16, kMostHalvings = 8;
  std::int64_t intervals = kFirst, evaluations = 0;
  double step = (high - low) / kFirst, sum = 0;
  for (std::int64_t k = 1; k < intervals; ++k, ++evaluations)
    sum += f(low + static_cast<double>(k) * step);
  double value = sum * step, change = std::numeric_limits<double>::infinity();
  for (int halving = 0; halving < kMostHalvings && !(change <= tolerance(value)); ++halving) {
    for (std::int64_t k = 0; k < intervals; ++k, ++evaluations)
      sum += f(low + (static_cast<double>(k) + 0.5) * step);
    intervals *= 2;
    step /= 2;
    change = std::abs(sum * step - value);
    value = sum * step;
  }
  return {value, change, {0, evaluations}};
}

}  // namespace

double free_travel_probability(double nu) {
  if (!(nu > 0)) return 0;
  return std::exp(-std::exp(-nu * nu / 4) * kInvSqrt2Pi / nu);
}

Estimate<double> mean_covered_length(double eta, double nu, double tol) {
  assert(nu > 0 && std::isfinite(eta));
  if (nu > 2 * kFarthest + 2 * std::abs(eta)) return {0, 0, {}};
  const Stopwatch watch;
  // t = exp(x − e^{−x}) [Takahasi74] from where it underflows to where w does.
  const double last = std::log((kFarthest + std::abs(eta)) / nu);
  const auto integrand = [&](double x) {
    const double t = std::exp(x - std::exp(-x));
    return covered(eta, nu, t) * t * (1 + std::exp(-x));
  };
  Estimate<double> length =
      trapezoid(integrand, -4, std::max(1., last + 1), [&](double value) { return tol * value; });
  length.cost.seconds = watch.seconds();
  return length;
}

Estimate<double> free_travel_probability(double eta, double nu, double tol) {
  // e^{−L}·L ≤ 1/e: a relative tolerance of the length is more than enough.
  Estimate<double> length = mean_covered_length(eta, nu, tol);
  const double value = std::exp(-length.value);
  return {value, value * length.error, length.cost};
}

Estimate<double> mean_free_travel_product(double nu1, double nu2, double tol) {
  const Stopwatch watch;
  constexpr double kHighest = 9;  // beyond lie 1e-19 of the heights
  Cost cost;
  const auto integrand = [&](double eta) {
    const double heights = kInvSqrt2Pi * std::exp(-eta * eta / 2);
    const Estimate<double> one = free_travel_probability(eta, nu1, tol / 10);
    const Estimate<double> other = nu1 == nu2 ? one : free_travel_probability(eta, nu2, tol / 10);
    cost.evaluations += one.cost.evaluations + other.cost.evaluations;
    return heights * one.value * other.value;
  };
  Estimate<double> mean = trapezoid(integrand, -kHighest, kHighest, [&](double) { return tol; });
  mean.error += tol / 5;
  mean.cost = {watch.seconds(), cost.evaluations};
  return mean;
}

}  // namespace micro
