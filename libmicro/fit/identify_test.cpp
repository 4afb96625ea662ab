#include "fit/identify.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/random.h"
#include "testing/step_between.h"

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
  EXPECT_EQ(canonical.meaningless, "");
  EXPECT_NEAR(std::sqrt(canonical.covariance(0, 0)), 0.2 * 0.03, 1e-6);
  EXPECT_NEAR(std::sqrt(canonical.covariance(1, 1)), 0.1 * 0.04, 1e-6);
  // A tilt θ_y moves the peak by θ_y·(1 − α_x²) along x, to first order.
  EXPECT_NEAR(std::sqrt(canonical.covariance(3, 3)), 0.2 * 0.01 / (1 - 0.04), 1e-6);
  EXPECT_NEAR(std::sqrt(canonical.covariance(2, 2)), 0.1 * 0.02 / (1 - 0.01), 1e-6);
}

TEST(Identify, NamesWhatIsBarelyKnown) {
  Matrix5 steps = 1e-4 * Matrix5::Identity();
  EXPECT_TRUE(barely_known(steps).words.empty());
  steps(3, 3) = 0.09;
  EXPECT_NE(barely_known(steps).words.find("1 L_21 only to 0.3 widths"), std::string::npos)
      << barely_known(steps).words;
}

TEST(Identify, RoundWithinTheErrorHasNoThirdAngle) {
  const SlopeFrame frame = slope_frame({0.21, 0.2, 0, 0, 0.3});
  const Canonical uncertain = canonical_with_covariance(frame, 1e-2 * Matrix5::Identity()),
                  certain = canonical_with_covariance(frame, 1e-8 * Matrix5::Identity());
  EXPECT_NE(uncertain.meaningless.find("theta_z"), std::string::npos);
  EXPECT_EQ(uncertain.parameters.theta_z, 0);
  EXPECT_DOUBLE_EQ(uncertain.parameters.alpha_x, uncertain.parameters.alpha_y);
  EXPECT_TRUE(std::isnan(uncertain.covariance(4, 4)));
  EXPECT_GT(uncertain.covariance(0, 0), 0);
  EXPECT_EQ(certain.meaningless, "");
  EXPECT_NEAR(certain.parameters.theta_z, 0.3, 1e-9);
}

/// The smooth map from a frame to the place of an ellipsoid of revolution's own axis, by the eigenvectors of
/// B alone, and to its width: (α, θ_x, θ_y) of a lobe with θ_z = 0, whose third axis is (−c_x s_y, s_x, c_x
/// c_y).
Vec3 round_lobe(const SlopeFrame& frame) {
  Eigen::Matrix3d b = Eigen::Matrix3d::Identity();
  b.topLeftCorner<2, 2>() = frame.scale() + frame.centre * frame.centre.transpose();
  b.topRightCorner<2, 1>() = -frame.centre;
  b.bottomLeftCorner<1, 2>() = -frame.centre.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(b);
  const Vec3 axis = solver.eigenvectors().col(2) * std::copysign(1., solver.eigenvectors()(2, 2));
  const Vec3 values = solver.eigenvalues();
  return {std::pow(values[0] * values[1], 0.25) / std::sqrt(values[2]), std::asin(axis.y()),
          std::atan2(-axis.x(), axis.z())};
}

// Of a tilted round lobe the widths and the tilt are known as well as of any other, and only θ_z is not: the
// spread of lobes drawn from the covariance of steps, each brought back by an eigendecomposition.
TEST(Identify, CovarianceOfTiltedRoundLobes) {
  constexpr int kDraws = 20000;
  constexpr double kStatistics = 0.05, kOfTheLargest = 0.03;
  for (const EllipsoidParameters& p :
       {EllipsoidParameters{0.2, 0.2, 0.4, 0.1, 0}, {0.2, 0.2, 0, 0, 0}, {0.01, 0.01, -0.7, 0.5, 0}}) {
    const SlopeFrame frame = slope_frame(p);
    Matrix5 root = 1e-3 * Matrix5::Identity();
    root(3, 0) = 5e-4;
    root(1, 2) = -7e-4;
    const Matrix5 steps = root * root.transpose();
    const Canonical canonical = canonical_with_covariance(frame, steps);
    EXPECT_NE(canonical.meaningless.find("theta_z"), std::string::npos);
    EXPECT_EQ(canonical.parameters.theta_z, 0);
    EXPECT_TRUE(std::isnan(canonical.covariance(4, 4)));
    EXPECT_TRUE(std::isnan(canonical.covariance(0, 4)));
    const Vec3 centre = round_lobe(frame);
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (std::uint64_t k = 0; k < kDraws; ++k) {
      Vector5 normal;
      for (std::uint32_t n = 0; n < 5; ++n)
        normal[n] = random_normal(3, n, k)[0];
      const Vec3 away = round_lobe(moved(frame, root * normal)) - centre;
      spread += away * away.transpose() / kDraws;
    }
    constexpr int kRows[] = {0, 2, 3};  // α, θ_x, θ_y
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) {
        const double unit = std::sqrt(spread(a, a) * spread(b, b));
        EXPECT_NEAR(canonical.covariance(kRows[a], kRows[b]) / unit, spread(a, b) / unit,
                    a == b ? kStatistics : kOfTheLargest)
            << p.theta_x << " " << a << b;
      }
    EXPECT_DOUBLE_EQ(canonical.covariance(1, 1), canonical.covariance(0, 0));
  }
}

// An ellipsoid of which hardly anything is known is no sphere for that.
TEST(Identify, LargeErrorsCallNothingEqual) {
  const SlopeFrame frame = slope_frame({1, 0.01, 0.1, 0, 0.4});
  const Canonical canonical = canonical_with_covariance(frame, 100 * Matrix5::Identity());
  EXPECT_NEAR(canonical.parameters.alpha_y, 0.01, 1e-9);
  EXPECT_GT(canonical.covariance(1, 1), 0);
}

// Beyond θ_z = π/2 axes point the other way and angles change their sign, which is no error of theirs.
TEST(Identify, CovarianceDoesNotJumpWhereTheThirdAngleDoes) {
  const Matrix5 steps = 1e-6 * Matrix5::Identity();
  const double right = std::numbers::pi / 2;
  const Matrix5 near =
      canonical_with_covariance(slope_frame({0.3, 0.1, 0.2, -0.4, right - 1e-4}), steps).covariance;
  for (const double turn : {right, -right, right - 1e-9, right + 1e-9}) {
    const Canonical there = canonical_with_covariance(slope_frame({0.3, 0.1, 0.2, -0.4, turn}), steps);
    const double sign = there.parameters.theta_y < 0 ? 1 : -1;
    const Vector5 signs = (Vector5() << 1, 1, sign, sign, 1).finished();
    const Matrix5 turned = signs.asDiagonal() * there.covariance * signs.asDiagonal();
    EXPECT_LE((turned - near).norm(), 1e-3 * near.norm()) << turn;
  }
}

// A width as long as the third axis: turning these two into one another is nothing. A sphere has no angle.
TEST(Identify, SaysWhichAnglesOfSpheroidsAreMeaningless) {
  const Matrix5 steps = 1e-8 * Matrix5::Identity();
  struct Case {
    EllipsoidParameters p;
    std::vector<int> lost;
  };
  for (const auto& [p, lost] : {Case{{2, 1, 0.3, 0.2, 0.7}, {2}},
                                {{1, 0.3, 0.3, 0.2, 0.7}, {3}},
                                {{1, 1, 0.3, 0.2, 0.7}, {2, 3, 4}},
                                {{0.3, 0.3, 0.3, 0.2, 0}, {4}},
                                {{4, 4, 0.3, 0.2, 0}, {4}}}) {
    const SlopeFrame frame = slope_frame(p);
    const Canonical canonical = canonical_with_covariance(frame, steps);
    const EllipsoidParameters& q = canonical.parameters;
    EXPECT_LE(testing::step_between(frame, slope_frame(q)).cwiseAbs().maxCoeff(), 1e-9)
        << canonical.meaningless;
    EXPECT_NE(canonical.meaningless, "");
    const double angles[] = {0, 0, q.theta_x, q.theta_y, q.theta_z};
    for (int k = 0; k < 5; ++k) {
      const bool is_lost = std::find(lost.begin(), lost.end(), k) != lost.end();
      EXPECT_EQ(std::isnan(canonical.covariance(k, k)), is_lost) << canonical.meaningless << " " << k;
      // Errors of 1e-4 of a width; the width itself is up to 4, and a turn moves it by one over its
      // difference.
      if (is_lost) {
        EXPECT_EQ(angles[k], 0) << canonical.meaningless << " " << k;
      } else {
        EXPECT_LE(canonical.covariance(k, k), 1e-8 * 100) << canonical.meaningless << " " << k;
        EXPECT_GE(canonical.covariance(k, k), 1e-8 / 100) << canonical.meaningless << " " << k;
      }
    }
  }
}

}  // namespace
}  // namespace micro
