#include "brdf/free_travel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace micro {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kTolerance = 1e-10;

/// ½ erfc(w/√2) with [Sun02 Eq. 3.4.8] as it is printed, in 64 bits of mantissa: it cancels near t = 0.
double literal_q(double eta, double nu, double t) {
  const long double x = t, c = std::exp(-x * x);
  return static_cast<double>(std::erfc((eta * (1 - c) + nu * x) / std::sqrt(1 - c * c) / std::sqrt(2.L)) / 2);
}

double literal_length(double eta, double nu) {
  using Rule = boost::math::quadrature::gauss_kronrod<double, 61>;
  const auto q = [&](double t) { return literal_q(eta, nu, t); };
  double sum = 0;
  const double end = std::max(1., (39 - eta) / nu);
  std::vector<double> borders = {1e-5, 0.5, 1, 2, 4, end / 8, end / 4, end / 2, end};
  std::sort(borders.begin(), borders.end());
  for (std::size_t k = 1; k < borders.size(); ++k)
    if (borders[k] <= end) sum += Rule::integrate(q, borders[k - 1], borders[k], 12, 1e-12);
  return sum + 1e-5 * literal_q(eta, nu, 1e-5);
}

TEST(FreeTravel, CoveredLengthIsTheLiteralIntegral) {
  // The literal form loses 1e-9 of w to cancellation at t = 1e-5.
  constexpr double kLiteral = 1e-7;
  for (const double eta : {-3., -1., 0., 0.5, 2.5})
    for (const double nu : {0.03, 0.3, 1., 3., 6.}) {
      const Estimate<double> length = mean_covered_length(eta, nu, kTolerance);
      EXPECT_NEAR(length.value / literal_length(eta, nu), 1, kLiteral) << eta << ' ' << nu;
      EXPECT_LE(length.error, kTolerance * length.value);
      EXPECT_GT(length.cost.evaluations, 0);
    }
}

TEST(FreeTravel, ToleranceIsKept) {
  for (const double eta : {-2., 0., 2.})
    for (const double nu : {0.01, 0.7, 5.}) {
      const double exact = mean_covered_length(eta, nu, 1e-13).value;
      for (const double tol : {1e-2, 1e-4, 1e-6, 1e-8})
        EXPECT_LE(std::abs(mean_covered_length(eta, nu, tol).value / exact - 1), tol) << eta << ' ' << nu;
    }
}

TEST(FreeTravel, NearTheHorizonTheSurfaceIsAPlaneOfHeights) {
  // νL → E(z − η)₊, what a normal height stands above η on average; the surface's own correlation is O(ν).
  const boost::math::normal normal;
  for (const double eta : {-2., 0., 1.}) {
    const double above = pdf(normal, eta) - eta * cdf(complement(normal, eta));
    EXPECT_NEAR(1e-6 * mean_covered_length(eta, 1e-6, kTolerance).value, above, 2e-6);
  }
  // And so does Γ₀ [3.4.24].
  EXPECT_NEAR(-std::log(free_travel_probability(0.01)) * 0.01 * std::sqrt(2 * std::numbers::pi), 1, 3e-5);
}

TEST(FreeTravel, SteepRaysFollowTheAsymptoticForm) {
  // w ≈ ν/√2·(1 + t²/2): L → e^{−ν²/4}/ν² with corrections of 1/ν².
  for (const double nu : {10., 20., 40.})
    EXPECT_NEAR(mean_covered_length(0, nu, kTolerance).value * nu * nu * std::exp(nu * nu / 4), 1,
                8 / (nu * nu));
}

TEST(FreeTravel, MeanIsThatOfTheHeights) {
  using Rule = boost::math::quadrature::gauss_kronrod<double, 61>;
  const boost::math::normal normal;
  for (const auto& [nu1, nu2] : {std::pair{0.5, 2.}, std::pair{1., 1.}, std::pair{0.1, kInfinity}}) {
    const auto product = [&, a = nu1, b = nu2](double eta) {
      return pdf(normal, eta) * std::exp(-literal_length(eta, a)) *
             (std::isinf(b) ? 1 : std::exp(-literal_length(eta, b)));
    };
    const Estimate<double> mean = mean_free_travel_product(nu1, nu2, 1e-8);
    EXPECT_NEAR(mean.value, Rule::integrate(product, -8., 8., 4, 1e-9), 1e-7);
    EXPECT_LE(mean.error, 2e-8);
    EXPECT_EQ(mean.value, mean_free_travel_product(nu2, nu1, 1e-8).value);
  }
}

TEST(FreeTravel, ExtremesStayProbabilities) {
  // θ from 0 to 89.999°, s from 0.1 to 1e6.
  EXPECT_EQ(free_travel_probability(0.), 0);
  EXPECT_EQ(free_travel_probability(-1.), 0);
  EXPECT_EQ(free_travel_probability(kInfinity), 1);
  EXPECT_EQ(free_travel_probability(0., kInfinity, 1e-9).value, 1);
  EXPECT_NEAR(mean_free_travel_product(kInfinity, kInfinity, 1e-9).value, 1, 1e-9);
  double last = 0;
  for (const double nu : {1.7e-6, 1e-3, 0.1, 1., 10., 17.45, 1e3, 1e9}) {
    for (const double eta : {-6., 0., 6.}) {
      const double gamma = free_travel_probability(eta, nu, 1e-9).value;
      EXPECT_TRUE(gamma >= 0 && gamma <= 1) << eta << ' ' << nu << ' ' << gamma;
    }
    const Estimate<double> mean = mean_free_travel_product(nu, kInfinity, 1e-6);
    EXPECT_TRUE(mean.value >= last && mean.value <= 1 + 1e-6) << nu << ' ' << mean.value;
    EXPECT_LE(mean.error, 1e-5);
    last = mean.value;
  }
}

}  // namespace
}  // namespace micro
