#include "fit/fit.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/random.h"
#include "distribution/beckmann.h"
#include "distribution/ellipsoid.h"
#include "distribution/tabulate.h"
#include "testing/expect_recovered.h"

namespace micro {
namespace {

using testing::expect_recovered;
using testing::step_between;

constexpr double kPi = std::numbers::pi;

/// A random lobe and a grid that resolves it: the narrowest full width is 2…12 nodes, needles to 1:100, tilts
/// to 80° from the mean normal.
struct Case {
  EllipsoidParameters parameters;
  DiskGrid grid;
};
Case random_case(std::uint64_t k, int size) {
  const auto [a, b] = random_uniform(21, 0, k);
  const auto [c, d] = random_uniform(21, 1, k);
  const auto [e, f] = random_uniform(21, 2, k);
  const bool skewed = k % 2 == 1;
  Case made;
  made.grid = {size, 1};
  const double tilt = skewed ? 1.4 * c : 0.05 * c;
  // A tilted lobe reaches out to sin(tilt), or the tilt is small and the table zooms in.
  const double extent = skewed ? 1 : std::pow(10, -3 * d) * 0.5;
  made.grid.extent = extent;
  const double spacing = made.grid.spacing();
  const double foreshortened = skewed ? std::cos(tilt) : 1;
  const double narrow = spacing * (2 + 10 * a) / foreshortened / 1.28;
  const double ratio = std::pow(10, 2 * b);
  made.parameters.alpha_y = narrow;
  made.parameters.alpha_x = std::min({narrow * ratio, 2., 0.7 * extent + narrow});
  const double turn = 2 * kPi * e;
  made.parameters.theta_x = (skewed ? tilt : 0.3 * extent * c) * std::cos(turn);
  made.parameters.theta_y = (skewed ? tilt : 0.3 * extent * c) * std::sin(turn);
  made.parameters.theta_z = kPi * (f - 0.5);
  return made;
}

TEST(Fit, RecoversRandomEllipsoids) {
  constexpr int kSize = 97;
  int converged = 0, unresolved = 0, most_iterations = 0;
  for (std::uint64_t k = 0; k < 1000; ++k) {
    const Case made = random_case(k, kSize);
    const SlopeFrame frame = slope_frame(made.parameters);
    const Fit found = fit(tabulate(Ellipsoid(frame), made.grid), FitModel::EllipsoidNdf);
    most_iterations = std::max(most_iterations, found.iterations);
    if (found.status == FitStatus::Unresolved) {
      ++unresolved;
      continue;
    }
    converged += found.status == FitStatus::Converged ? 1 : 0;
    expect_recovered(found, frame, k);
  }
  EXPECT_EQ(converged + unresolved, 1000);
  EXPECT_LE(unresolved, 100);
  RecordProperty("iterations", most_iterations);
}

TEST(Fit, RecoversRandomBeckmanns) {
  for (std::uint64_t k = 0; k < 200; ++k) {
    const Case made = random_case(k, 97);
    const SlopeFrame frame = slope_frame(made.parameters);
    const Fit found = fit(tabulate(Beckmann(frame), made.grid), FitModel::BeckmannNdf);
    if (found.status == FitStatus::Unresolved) continue;
    EXPECT_EQ(found.status, FitStatus::Converged) << k;
    expect_recovered(found, frame, k);
  }
}

TEST(Fit, RecoversByLogarithms) {
  for (std::uint64_t k = 0; k < 60; ++k) {
    const Case made = random_case(k, 97);
    const SlopeFrame frame = slope_frame(made.parameters);
    expect_recovered(fit(tabulate(Ellipsoid(frame), made.grid), FitModel::EllipsoidNdf, Weighting::Log),
                     frame, k);
    if (k % 2 == 0)  // a Gaussian's far tails are zero in a table: nothing to take the logarithm of
      expect_recovered(fit(tabulate(Beckmann(frame), made.grid), FitModel::BeckmannNdf, Weighting::Log),
                       frame, k);
  }
}

TEST(Fit, GivesCanonicalParameters) {
  const EllipsoidParameters p = {0.3, 0.1, 0.12, -0.2, 0.7};
  const Fit found = fit(tabulate(Ellipsoid(slope_frame(p)), {257, 1}), FitModel::EllipsoidNdf);
  constexpr double kSame = 1e-8;
  EXPECT_NEAR(found.parameters.alpha_x, p.alpha_x, kSame);
  EXPECT_NEAR(found.parameters.alpha_y, p.alpha_y, kSame);
  EXPECT_NEAR(found.parameters.theta_x, p.theta_x, kSame);
  EXPECT_NEAR(found.parameters.theta_y, p.theta_y, kSame);
  EXPECT_NEAR(found.parameters.theta_z, p.theta_z, kSame);
  EXPECT_TRUE(found.undetermined.empty());
}

TEST(Fit, RoundLobesHaveNoThirdAngle) {
  for (const EllipsoidParameters& p : {EllipsoidParameters{0.2, 0.2, 0, 0, 0}, {0.2, 0.2, 0.4, 0.1, 0}}) {
    const Fit found = fit(tabulate(Ellipsoid(slope_frame(p)), {129, 1}), FitModel::EllipsoidNdf);
    EXPECT_EQ(found.status, FitStatus::Converged);
    EXPECT_EQ(found.parameters.theta_z, 0);
    EXPECT_NE(found.undetermined.find("theta_z"), std::string::npos);
    EXPECT_TRUE(std::isnan(found.covariance(4, 4)));
    EXPECT_TRUE(std::isfinite(found.covariance(0, 0)));
    EXPECT_NEAR(found.parameters.alpha_x, 0.2, 1e-6);
    EXPECT_NEAR(found.parameters.theta_x, p.theta_x, 1e-6);
  }
}

// Noise of known truth: dᵀC⁻¹d of the frame's error d is χ² with five degrees of freedom each. Additive noise
// of one variance, and counts of a histogram with as many normals (variance as the mean), whose bins the
// model fills by its values at the nodes.
TEST(Fit, NoisyTablesAreRecoveredWithinTheirCovariance) {
  constexpr int kTables = 60;
  const SlopeFrame frame = slope_frame({0.2, 0.08, 0.1, -0.05, 0.6});
  const DiskTable exact = tabulate(Ellipsoid(frame), {65, 0.8});
  const double peak = exact.density.maxCoeff();
  const auto expect_calibrated = [&](auto&& noise) {
    double chi2 = 0, angles2 = 0;
    const EllipsoidParameters p = {0.2, 0.08, 0.1, -0.05, 0.6};
    for (std::uint64_t k = 0; k < kTables; ++k) {
      DiskTable noisy = exact;
      for (Eigen::Index i = 0; i < noisy.density.size(); ++i)
        noisy.density.data()[i] =
            noise(exact.density.data()[i],
                  random_normal(31, static_cast<std::uint32_t>(k), static_cast<std::uint64_t>(i))[0]);
      const Fit found = fit(noisy, FitModel::EllipsoidNdf);
      ASSERT_EQ(found.status, FitStatus::Converged);
      const Vector5 d = step_between(found.frame, frame);
      chi2 += d.dot(found.step_covariance.inverse() * d);
      const Vector5 e = (Vector5() << found.parameters.alpha_x - p.alpha_x,
                         found.parameters.alpha_y - p.alpha_y, found.parameters.theta_x - p.theta_x,
                         found.parameters.theta_y - p.theta_y, found.parameters.theta_z - p.theta_z)
                            .finished();
      angles2 += e.dot(found.covariance.inverse() * e);
    }
    const boost::math::chi_squared distribution(5 * kTables);
    for (const double statistic : {chi2, angles2}) {
      EXPECT_GT(cdf(distribution, statistic), 1e-4) << statistic / (5 * kTables);
      EXPECT_GT(cdf(complement(distribution, statistic)), 1e-4) << statistic / (5 * kTables);
    }
  };
  expect_calibrated([&](double d, double n) { return d + 0.01 * peak * n; });
  expect_calibrated([&](double d, double n) { return std::max(0., d + 0.03 * std::sqrt(d * peak) * n); });
}

// The same over many lobes, needles and skewed ones included, each on a table that resolves it. Of lobes few
// nodes wide the noise of a few nodes decides, so χ² is compared with its law through its quantiles.
TEST(Fit, NoisyRandomEllipsoidsAreRecoveredWithinTheirCovariance) {
  constexpr std::uint64_t kLobes = MICRO_NOISY_LOBES;
  constexpr double kNoise = 0.003;  // of the peak
  const boost::math::chi_squared law(5);
  int tried = 0, beyond_median = 0, beyond_99 = 0;
  for (std::uint64_t k = 0; k < kLobes; ++k) {
    const Case made = random_case(k, 97);
    const SlopeFrame frame = slope_frame(made.parameters);
    DiskTable noisy = tabulate(Ellipsoid(frame), made.grid);
    const double peak = noisy.density.maxCoeff();
    for (Eigen::Index i = 0; i < noisy.density.size(); ++i)
      noisy.density.data()[i] +=
          kNoise * peak * random_normal(33, static_cast<std::uint32_t>(k), static_cast<std::uint64_t>(i))[0];
    const Fit found = fit(noisy, FitModel::EllipsoidNdf);
    if (found.status == FitStatus::Unresolved) continue;
    EXPECT_EQ(found.status, FitStatus::Converged) << k;
    const Vector5 d = step_between(found.frame, frame);
    const double chi2 = d.dot(found.step_covariance.inverse() * d);
    ++tried;
    beyond_median += chi2 <= quantile(law, 0.5) ? 0 : 1;
    beyond_99 += chi2 <= quantile(law, 0.99) ? 0 : 1;
  }
  RecordProperty("beyond_median", beyond_median);
  RecordProperty("beyond_99", beyond_99);
  constexpr double kSigmas = 4, kFewNodes = 0.01;  // HC2 on lobes of a few nodes
  EXPECT_NEAR(beyond_median, 0.5 * tried, kSigmas * std::sqrt(0.25 * tried) + kFewNodes * tried);
  EXPECT_LE(beyond_99, 0.01 * tried + kSigmas * std::sqrt(0.01 * tried) + kFewNodes * tried);
}

// The far tails that logarithms weigh are not those of the other model: no lobe of it is near.
TEST(Fit, LogarithmsOfTheOtherModelAreAMisfit) {
  const SlopeFrame frame = slope_frame({0.3, 0.1, 0.1, -0.05, 0.5});
  for (const DiskGrid& grid : {DiskGrid{129, 1}, {257, 0.95}}) {
    const Fit wide = fit(tabulate(Ellipsoid(frame), grid), FitModel::BeckmannNdf, Weighting::Log),
              thin = fit(tabulate(Beckmann(frame), grid), FitModel::EllipsoidNdf, Weighting::Log);
    for (const Fit& found : {wide, thin}) {
      EXPECT_NE(found.status, FitStatus::Converged) << found.rel_rms;
      EXPECT_LE(found.overlap, 0.3);
      EXPECT_FALSE(found.misfit.empty());
    }
  }
}

// What is far from the model node by node and true to it on the whole: the speckle of one patch, and the
// counts of a thousand normals in 50,000 nodes. The lobe is found to what they allow.
TEST(Fit, NoiseIsNoMisfit) {
  const SlopeFrame frame = slope_frame({0.3, 0.1, 0.1, -0.05, 0.5});
  const DiskTable exact = tabulate(Ellipsoid(frame), {257, 1});
  DiskTable speckle = exact, counts = make_disk_table(exact.grid);
  for (Eigen::Index k = 0; k < speckle.density.size(); ++k)
    speckle.density.data()[k] *= -std::log1p(-random_uniform(41, 0, static_cast<std::uint64_t>(k))[0]);
  const Ellipsoid lobe(frame);
  constexpr int kNormals = 1000;
  const double spacing = counts.grid.spacing();
  for (std::uint64_t k = 0; k < kNormals; ++k) {
    const auto [a, b] = random_uniform(42, 0, k);
    const Vec3 m = lobe.sample({a, b});
    const auto node = [&](double x) { return std::lround(x / spacing + counts.grid.centre()); };
    counts.density(node(m.y()), node(m.x())) += 1 / (kNormals * spacing * spacing);
  }
  for (const auto& [table, error] : {std::pair(&speckle, 0.1), {&counts, 0.5}}) {
    const Fit found = fit(*table, FitModel::EllipsoidNdf);
    EXPECT_EQ(found.status, FitStatus::Converged) << found.misfit;
    EXPECT_GE(found.rel_rms, 0.69);
    EXPECT_GE(found.overlap, 0.85);
    EXPECT_LE(step_between(found.frame, frame).cwiseAbs().maxCoeff(), error);
  }
}

// A part of the energy, and a lobe beside half of it: nearer to nothing than to a lobe.
TEST(Fit, SaysWhenHalfOfTheEnergyIsElsewhere) {
  DiskTable table = tabulate(ggx(0.2), {129, 1});
  table.density *= 0.3;
  for (const FitModel model : {FitModel::EllipsoidNdf, FitModel::BeckmannNdf})
    for (const Weighting weighting : {Weighting::SolidAngle, Weighting::Log}) {
      const Fit found = fit(table, model, weighting);
      EXPECT_EQ(found.status, FitStatus::Misfit);
      EXPECT_LE(found.overlap, 0.31);
    }
}

TEST(Fit, TheRightModelFitsBetter) {
  const SlopeFrame frame = slope_frame({0.3, 0.1, 0.1, 0, 0.3});
  const DiskTable ellipsoid = tabulate(Ellipsoid(frame), {129, 1}),
                  beckmann = tabulate(Beckmann(frame), {129, 1});
  const Fit wrong = fit(ellipsoid, FitModel::BeckmannNdf), other = fit(beckmann, FitModel::EllipsoidNdf);
  EXPECT_EQ(wrong.status, FitStatus::Converged);
  EXPECT_EQ(other.status, FitStatus::Converged);
  EXPECT_GT(wrong.rel_rms, 0.02);
  EXPECT_GT(other.rel_rms, 0.02);
  EXPECT_LT(wrong.rel_rms, 0.5);
  EXPECT_LE(frame.whiten(wrong.frame.centre).norm(), 0.1);
}

// Real tables look so by logarithms: two lobes, tails of another kind, speckle. Gauss–Newton alone creeps
// there (the large residuals' curvature is as large as the Gram matrix); a part of the nodes tells that
// curvature.
TEST(Fit, TablesThatFitBadlyEndInFewSteps) {
  constexpr int kMostSteps = 55;  // of both models; 57 without that curvature
  int steps = 0;
  const DiskGrid grid{513, 1};
  const SlopeFrame lobe = slope_frame({0.2, 0.08, 0.3, 0, 0.4}), base = slope_frame({0.3, 0.2, -0.2, 0.3, 0});
  DiskTable table = tabulate(Beckmann(lobe), grid);
  table.density = 0.7 * table.density + 0.3 * tabulate(Beckmann(base), grid).density;
  const double faint = 1e-4 * table.density.maxCoeff();  // a histogram holds nothing there
  for (Eigen::Index k = 0; k < table.density.size(); ++k) {
    double& density = table.density.data()[k];
    density *= -std::log1p(-random_uniform(45, 0, static_cast<std::uint64_t>(k))[0]);
    if (density < faint) density = 0;
  }
  for (const FitModel model : {FitModel::EllipsoidNdf, FitModel::BeckmannNdf}) {
    const Fit found = fit(table, model, Weighting::Log);
    steps += found.iterations;
    EXPECT_NE(found.status, FitStatus::NotConverged);
    const Fit minimum = fit_from(found.frame, 1e-9, table, model, Weighting::Log);
    EXPECT_LE(step_between(found.frame, minimum.frame).cwiseAbs().maxCoeff(), 1e-3);
  }
  EXPECT_LE(steps, kMostSteps);
}

TEST(Fit, TwoLobesEndInTheBetterOne) {
  const SlopeFrame left = slope_frame({0.1, 0.1, 0.4, 0, 0}), right = slope_frame({0.05, 0.05, -0.4, 0, 0});
  DiskTable table = tabulate(Ellipsoid(left), {129, 1});
  table.density = 0.8 * table.density + 0.2 * tabulate(Ellipsoid(right), {129, 1}).density;
  const Fit found = fit(table, FitModel::EllipsoidNdf);
  EXPECT_EQ(found.status, FitStatus::Converged);
  EXPECT_LE(left.whiten(found.frame.centre).norm(), 0.5);
}

}  // namespace
}  // namespace micro
