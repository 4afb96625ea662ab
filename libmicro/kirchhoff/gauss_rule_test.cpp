#include "kirchhoff/gauss_rule.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>

namespace micro {
namespace {

TEST(GaussRule, IntegratesWavesToItsTolerance) {
  GaussRules rules;
  std::vector<GaussNode> nodes;
  for (const double tolerance : {1e-5, 1e-7, 1e-9})
    for (const double phase : {0.01, 0.4, 3.0, 17.0, 60.0, 199.0, 201.0, 5000.0}) {
      rules.fill(gauss_cut(phase, tolerance), nodes);
      double worst = 0;
      for (double part = 0; part <= 1; part += 0.125) {
        const double u = phase * part;
        std::complex<double> sum = 0;
        for (const GaussNode& node : nodes)
          sum += std::polar(node.weight, u * node.t);
        const std::complex<double> wanted =
            u == 0 ? 1 : (std::polar(1.0, u) - 1.0) / std::complex<double>(0, u);
        worst = std::max(worst, std::abs(sum - wanted));
      }
      EXPECT_LE(worst, tolerance) << phase;
    }
}

TEST(GaussRule, OrdersGrowWithThePhase) {
  constexpr double kTolerance = 1e-5;
  EXPECT_EQ(gauss_points(0, kTolerance), 2);
  EXPECT_LE(gauss_points(2.5, kTolerance), 5);
  EXPECT_LE(gauss_points(226, kTolerance), 70);
  EXPECT_GE(gauss_points(226, kTolerance), 57);  // half the phase is the least that resolves it
  EXPECT_GT(gauss_points(1e300, kTolerance), 1'000'000);
}

}  // namespace
}  // namespace micro
