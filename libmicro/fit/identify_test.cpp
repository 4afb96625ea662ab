#include "fit/identify.h"

#include <gtest/gtest.h>

#include <cmath>

namespace micro {
namespace {

// Three equations leave two combinations free, and those are named.
TEST(Identify, NamesWhatIsFree) {
  Matrix5 gram = Matrix5::Zero();
  const Vector5 seen = (Vector5() << 1, 1, 0, 0, 0).finished();  // t_1 + t_2 is known, t_1 − t_2 is not
  gram += seen * seen.transpose();
  gram(2, 2) = 2;
  gram(4, 4) = 3;
  const std::string free = identify(gram).free;
  EXPECT_NE(free.find("0.71 t_1 - 0.71 t_2"), std::string::npos) << free;
  EXPECT_NE(free.find("L_21"), std::string::npos) << free;
  EXPECT_EQ(free.find("log"), std::string::npos) << free;
  EXPECT_FALSE(identify(Matrix5::Zero()).free.empty());
}

TEST(Identify, InvertsWhatIsKnown) {
  Matrix5 gram = Matrix5::Identity();
  gram(0, 3) = gram(3, 0) = 0.4;
  gram(1, 1) = 1e-6;
  const Identified identified = identify(gram);
  EXPECT_TRUE(identified.free.empty());
  EXPECT_LE((identified.inverse * gram - Matrix5::Identity()).norm(), 1e-9);
}

// Against the derivative of untilted lobes: α_x = l_11 and α_y = l_22 there, θ ≈ the peak's slope.
TEST(Identify, CovarianceOfUntiltedLobes) {
  const SlopeFrame frame = slope_frame({0.2, 0.1, 0, 0, 0});
  Matrix5 steps = Matrix5::Zero();
  steps.diagonal() << 1e-4, 4e-4, 9e-4, 1e-6, 16e-4;
  const Canonical canonical = canonical_with_covariance(frame, steps);
  EXPECT_FALSE(canonical.round);
  EXPECT_NEAR(std::sqrt(canonical.covariance(0, 0)), 0.2 * 0.03, 1e-6);
  EXPECT_NEAR(std::sqrt(canonical.covariance(1, 1)), 0.1 * 0.04, 1e-6);
  // A tilt θ_y moves the peak by θ_y·(1 − α_x²) along x, to first order.
  EXPECT_NEAR(std::sqrt(canonical.covariance(3, 3)), 0.2 * 0.01 / (1 - 0.04), 1e-6);
  EXPECT_NEAR(std::sqrt(canonical.covariance(2, 2)), 0.1 * 0.02 / (1 - 0.01), 1e-6);
}

TEST(Identify, NamesWhatIsBarelyKnown) {
  Matrix5 steps = 1e-4 * Matrix5::Identity();
  EXPECT_TRUE(barely_known(steps).empty());
  steps(3, 3) = 0.09;
  EXPECT_NE(barely_known(steps).find("1 L_21 only to 0.3 widths"), std::string::npos) << barely_known(steps);
}

TEST(Identify, RoundWithinTheErrorHasNoThirdAngle) {
  const SlopeFrame frame = slope_frame({0.21, 0.2, 0, 0, 0.3});
  const Canonical uncertain = canonical_with_covariance(frame, 1e-2 * Matrix5::Identity()),
                  certain = canonical_with_covariance(frame, 1e-8 * Matrix5::Identity());
  EXPECT_TRUE(uncertain.round);
  EXPECT_EQ(uncertain.parameters.theta_z, 0);
  EXPECT_DOUBLE_EQ(uncertain.parameters.alpha_x, uncertain.parameters.alpha_y);
  EXPECT_TRUE(std::isnan(uncertain.covariance(4, 4)));
  EXPECT_GT(uncertain.covariance(0, 0), 0);
  EXPECT_FALSE(certain.round);
  EXPECT_NEAR(certain.parameters.theta_z, 0.3, 1e-9);
}

}  // namespace
}  // namespace micro
