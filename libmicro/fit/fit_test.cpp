#include "fit/fit.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/error.h"
#include "core/random.h"
#include "distribution/beckmann.h"
#include "distribution/ellipsoid.h"
#include "distribution/tabulate.h"
#include "testing/lobe_zoo.h"
#include "testing/step_between.h"

namespace micro {
namespace {

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

constexpr double kRecovered = 1e-5;  // relative L2 of the table, and widths in slope space

void expect_recovered(const Fit& found, const SlopeFrame& frame, std::uint64_t k) {
  EXPECT_LE(found.rel_rms, kRecovered) << "case " << k << " " << name_of(found.status);
  EXPECT_LE(step_between(frame, found.frame).cwiseAbs().maxCoeff(), kRecovered) << "case " << k;
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

// Sizes whose nodes fall on the horizon, extents that put them within rounding of it, and nodes there that
// another program filled with what it had.
TEST(Fit, NodesAtTheHorizonDecideNothing) {
  for (const int size : {51, 69, 71, 79, 99, 101, 201, 251, 401, 999})
    for (const double below : {0., 1e-13, 1e-11, 1e-8, 1e-5})
      for (const EllipsoidParameters& p :
           {EllipsoidParameters{0.4, 0.2, 0.6, -0.5, 0.4}, {0.5, 0.3, 0, 1.2, 1}}) {
        const DiskGrid grid{size, 1 - below};
        const SlopeFrame frame = slope_frame(p);
        DiskTable table = tabulate(Ellipsoid(frame), grid);
        for (Eigen::Index k = 0; k < table.density.size(); ++k)
          if (grid.mz2(k / size, k % size) < 1e-12) table.density.data()[k] = k % 3 == 0 ? 1e3 : 0;
        const Fit found = fit(table, FitModel::EllipsoidNdf);
        EXPECT_EQ(found.status, FitStatus::Converged) << size << " " << below;
        EXPECT_LE(found.rel_rms, kRecovered) << size << " " << below;
        EXPECT_LE(step_between(frame, found.frame).cwiseAbs().maxCoeff(), kRecovered) << size << " " << below;
      }
}

/// A random lobe on a random table, resolved or not: widths from a tenth of a node to twenty nodes, α_x/α_y
/// to 1e5, tilts to the horizon.
Case wild_case(std::uint64_t k, int size) {
  const auto [a, b] = random_uniform(77, 0, k);
  const auto [c, d] = random_uniform(77, 1, k);
  const auto [e, f] = random_uniform(77, 2, k);
  const bool zoomed = k % 3 != 0;
  Case made;
  made.grid = {size, zoomed ? std::pow(10, -3 * d) : 1};
  EllipsoidParameters& p = made.parameters;
  p.alpha_y = made.grid.spacing() * std::pow(10, -1 + 2.3 * a);
  p.alpha_x = std::min(p.alpha_y * std::pow(10, 5 * b), k % 5 == 0 ? 1e3 : 3.);
  const double tilt = (zoomed ? 0.8 * std::asin(made.grid.extent) : 1.55) * std::sqrt(c), turn = 2 * kPi * e;
  p.theta_x = tilt * std::cos(turn);
  p.theta_y = tilt * std::sin(turn);
  p.theta_z = kPi * (f - 0.5);
  return made;
}

// Whatever a table holds, what is called a success is the lobe it was made of; unless that lobe falls between
// the nodes, when no fit can know it, and the table is taken for what its nodes show.
TEST(Fit, NoLocalMinimumIsCalledSuccess) {
  constexpr int kSize = 97;
  int converged = 0;
  for (std::uint64_t k = 0; k < 1000; ++k) {
    const Case made = wild_case(k, kSize);
    const SlopeFrame frame = slope_frame(made.parameters);
    const Fit found = fit(tabulate(Ellipsoid(frame), made.grid), FitModel::EllipsoidNdf);
    if (found.status != FitStatus::Converged) continue;
    ++converged;
    const bool between_nodes = made.parameters.alpha_y * 1.28 < made.grid.spacing();
    if (between_nodes)
      EXPECT_LT(found.rel_rms, 1) << "case " << k;
    else
      expect_recovered(found, frame, k);
  }
  EXPECT_GE(converged, 300);
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

// Of a needle a hundred times as long as its table hardly anything tells how it is turned: errors are large,
// far from linear, and said to be so. What is across it is known as well
// as ever.
TEST(Fit, SaysWhenANeedleIsLongerThanItsTableTells) {
  const SlopeFrame frame = slope_frame({1, 0.0005, 0, 0, 0.6});
  for (const auto& [noise, told] : {std::pair(0.0, false), {0.02, true}}) {
    DiskTable table = tabulate(Ellipsoid(frame), {97, 0.005});
    const double peak = table.density.maxCoeff();
    for (Eigen::Index k = 0; k < table.density.size(); ++k)
      table.density.data()[k] += noise * peak * random_normal(43, 0, static_cast<std::uint64_t>(k))[0];
    const Fit found = fit(table, FitModel::EllipsoidNdf);
    EXPECT_EQ(found.undetermined.find("first order") != std::string::npos, told) << found.undetermined;
    EXPECT_NEAR(found.nodes_across, 6.2, 0.2);
  }
}

TEST(Fit, WhatIsKnownToNoBetterThanAWidthIsNoSuccess) {
  const SlopeFrame frame = slope_frame({1, 0.0005, 0, 0, 0.6});
  int beyond = 0;
  for (std::uint32_t seed = 0; seed < 4; ++seed)
    for (const double noise : {0.05, 0.15}) {
      DiskTable table = tabulate(Ellipsoid(frame), {97, 0.005});
      const double peak = table.density.maxCoeff();
      for (Eigen::Index k = 0; k < table.density.size(); ++k)
        table.density.data()[k] += noise * peak * random_normal(44, seed, static_cast<std::uint64_t>(k))[0];
      const Fit found = fit(table, FitModel::EllipsoidNdf);
      const Eigen::SelfAdjointEigenSolver<Matrix5> solver(found.step_covariance, Eigen::EigenvaluesOnly);
      if (solver.eigenvalues()[4] <= 1) continue;
      ++beyond;
      EXPECT_NE(found.status, FitStatus::Converged) << found.undetermined;
    }
  EXPECT_GE(beyond, 1);
}

// Extreme parameters: what is called a success is the lobe, and everything is a number where the table holds
// anything.
TEST(Fit, ZooOfLobesIsRecoveredOrSaidNotToBe) {
  int converged = 0;
  for (const testing::ZooLobe& row : testing::zoo_lobes()) {
    const SlopeFrame frame = slope_frame(row.parameters);
    for (const FitModel model : {FitModel::EllipsoidNdf, FitModel::BeckmannNdf}) {
      const bool ellipsoid = model == FitModel::EllipsoidNdf;
      const DiskGrid grid = {std::min(row.grid.size, 257), row.grid.extent};
      const Fit found =
          fit(ellipsoid ? tabulate(Ellipsoid(frame), grid) : tabulate(Beckmann(frame), grid), model);
      if (found.status == FitStatus::Empty) continue;
      EXPECT_GT(found.parameters.alpha_y, 0) << row.name;
      EXPECT_LT(found.parameters.alpha_x, 1e12) << row.name;
      EXPECT_LE(std::abs(found.parameters.theta_x), kPi) << row.name;
      if (found.status != FitStatus::Converged) continue;
      ++converged;
      expect_recovered(found, frame, 0);
    }
  }
  EXPECT_GE(converged, 16);
}

TEST(Fit, SaysWhenTheTableIsNoDistribution) {
  DiskTable counts = tabulate(ggx(0.2), {65, 1});
  counts.density *= 10;
  for (const FitModel model : {FitModel::EllipsoidNdf, FitModel::BeckmannNdf}) {
    const Fit found = fit(counts, model);
    EXPECT_NE(found.status, FitStatus::Converged);
    EXPECT_NE(found.misfit.find("per steradian"), std::string::npos);
  }
  for (const double scale : {1e-300, 1e300}) {  // whose squares a double does not hold
    counts.density = tabulate(ggx(0.2), {65, 1}).density * scale;
    EXPECT_NE(fit(counts, FitModel::EllipsoidNdf).status, FitStatus::Converged);
  }
}

// Beckmann's lobe far beyond the table's extent: densities whose squares are zero.
TEST(Fit, TheFarTailOfALobeElsewhereIsNothing) {
  DiskTable table = tabulate(Beckmann(slope_frame({0.02, 0.015, 0.9, 0, 0})), {129, 0.23});
  table.density = table.density.min(1e-141);
  ASSERT_GT(table.density.maxCoeff(), 0);
  for (const Weighting weighting : {Weighting::SolidAngle, Weighting::Log})
    EXPECT_EQ(fit(table, FitModel::BeckmannNdf, weighting).status, FitStatus::Empty);
}

TEST(Fit, SaysWhenNothingIsOnTheDisk) {
  DiskTable table = make_disk_table({65, 1});
  table.density(0, 0) = 3;
  EXPECT_EQ(fit(table, FitModel::EllipsoidNdf).status, FitStatus::Empty);
}

// A few nodes at the horizon, which no lobe comes near to.
TEST(Fit, AMinimumWorseThanNothingIsNoSuccess) {
  DiskTable rim = make_disk_table({65, 1}), one = rim;
  rim.density(32, 63) = 5;
  rim.density(32, 62) = 3;
  rim.density(31, 63) = 2;
  one.density(30, 20) = 5;
  for (const DiskTable& table : {rim, one})
    for (const FitModel model : {FitModel::EllipsoidNdf, FitModel::BeckmannNdf}) {
      const Fit found = fit(table, model);
      EXPECT_NE(found.status, FitStatus::Converged) << found.rel_rms;
    }
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

TEST(Fit, SaysWhenTheLobeIsNotResolved) {
  const DiskGrid grid{101, 1};
  const Fit narrow = fit(tabulate(ggx(0.4 * grid.spacing()), grid), FitModel::EllipsoidNdf);
  EXPECT_EQ(narrow.status, FitStatus::Unresolved);
  EXPECT_LT(narrow.nodes_across, 2);
  DiskTable one = make_disk_table(grid);
  one.density(50, 50) = 1 / (grid.spacing() * grid.spacing());
  for (const FitModel model : {FitModel::EllipsoidNdf, FitModel::BeckmannNdf}) {
    const Fit found = fit(one, model);
    EXPECT_TRUE(found.status == FitStatus::Unresolved || found.status == FitStatus::Undetermined)
        << name_of(found.status);
  }
}

// D_K of a smooth patch is such a table: steps wander between the nodes, which is no failure to converge.
TEST(Fit, AMirrorsPeakIsNotResolvedWhereverItsStepsEnd) {
  const DiskGrid grid{301, 0.25};
  const auto sinc2 = [](double x) { return x == 0 ? 1 : std::pow(std::sin(x) / x, 2); };
  for (const double width : {0.3, 0.6, 0.9}) {
    DiskTable table = make_disk_table(grid);
    for (Eigen::Index j = 0; j < grid.size; ++j)
      for (Eigen::Index i = 0; i < grid.size; ++i) {
        const double x = static_cast<double>(i - 150), y = static_cast<double>(j - 150);
        table.density(j, i) = sinc2(kPi * x / width) * sinc2(kPi * y / (1.3 * width)) +
                              1e-5 * random_uniform(3, 0, static_cast<std::uint64_t>(301 * j + i))[0];
      }
    table.density *= 0.9 / (table.density.sum() * grid.spacing() * grid.spacing());
    for (const FitModel model : {FitModel::EllipsoidNdf, FitModel::BeckmannNdf}) {
      const Fit found = fit(table, model);
      EXPECT_TRUE(found.status == FitStatus::Unresolved || found.status == FitStatus::Undetermined)
          << width << ' ' << name_of(found.status) << ' ' << found.rel_rms;
    }
  }
}

// Ridges across the whole disk, far longer than it: by scatter alone they ended beside the ridge.
TEST(Fit, NeedlesFarLongerThanTheDiskAreRecovered) {
  for (const int size : {129, 257})
    for (const double across : {2.5, 4., 10.})
      for (const double length : {1., 10., 100., 1000.})
        for (const double turn : {0., 0.3, 0.7, 2.}) {
          const DiskGrid grid{size, 1};
          const EllipsoidParameters parameters = {length, across * grid.spacing() / 1.28, 0, 0, turn};
          const DiskTable table = tabulate(Ellipsoid(slope_frame(parameters)), grid);
          const Fit found = fit(table, FitModel::EllipsoidNdf);
          EXPECT_LE(found.rel_rms, kRecovered) << size << ' ' << across << ' ' << length << ' ' << turn;
          // How long a ridge is, and where along it its middle, a table that ends before it may not tell.
          EXPECT_TRUE(found.status == FitStatus::Converged || found.status == FitStatus::Undetermined)
              << name_of(found.status);
          EXPECT_NEAR(found.parameters.alpha_y, parameters.alpha_y, 1e-4 * parameters.alpha_y);
        }
}

TEST(Fit, SaysThatThereIsNothing) {
  const Fit empty = fit(make_disk_table({101, 1}), FitModel::EllipsoidNdf);
  EXPECT_EQ(empty.status, FitStatus::Empty);
  EXPECT_TRUE(std::isnan(empty.parameters.alpha_x));
  EXPECT_FALSE(empty.undetermined.empty());
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

TEST(Fit, TwoLobesEndInTheBetterOne) {
  const SlopeFrame left = slope_frame({0.1, 0.1, 0.4, 0, 0}), right = slope_frame({0.05, 0.05, -0.4, 0, 0});
  DiskTable table = tabulate(Ellipsoid(left), {129, 1});
  table.density = 0.8 * table.density + 0.2 * tabulate(Ellipsoid(right), {129, 1}).density;
  const Fit found = fit(table, FitModel::EllipsoidNdf);
  EXPECT_EQ(found.status, FitStatus::Converged);
  EXPECT_LE(left.whiten(found.frame.centre).norm(), 0.5);
}

TEST(Fit, RefusesWhatIsNotFinite) {
  DiskTable table = tabulate(ggx(0.2), {33, 1});
  table.density(3, 20) = NAN;
  EXPECT_THROW(fit(table, FitModel::EllipsoidNdf), InputError);
  table.density(3, 20) = INFINITY;
  EXPECT_THROW(fit(table, FitModel::EllipsoidNdf), InputError);
}

}  // namespace
}  // namespace micro
