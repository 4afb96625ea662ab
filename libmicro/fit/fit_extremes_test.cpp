#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/error.h"
#include "core/random.h"
#include "distribution/beckmann.h"
#include "distribution/ellipsoid.h"
#include "distribution/tabulate.h"
#include "fit/fit.h"
#include "testing/expect_recovered.h"
#include "testing/lobe_zoo.h"

// Extremes: needles, the horizon, lobes between the nodes or beyond the table, tables of next to nothing.
namespace micro {
namespace {

using testing::expect_recovered;
using testing::kRecovered;
using testing::step_between;

constexpr double kPi = std::numbers::pi;

// Sizes whose nodes fall on the horizon, extents that put them within rounding of it, and nodes there that
// another program filled with what it had.
TEST(FitExtremes, NodesAtTheHorizonDecideNothing) {
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

/// A lobe, and the grid of its table.
struct WildCase {
  EllipsoidParameters parameters;
  DiskGrid grid;
};

/// A random lobe on a random table, resolved or not: widths from a tenth of a node to twenty nodes, α_x/α_y
/// to 1e5, tilts to the horizon.
WildCase wild_case(std::uint64_t k, int size) {
  const auto [a, b] = random_uniform(77, 0, k);
  const auto [c, d] = random_uniform(77, 1, k);
  const auto [e, f] = random_uniform(77, 2, k);
  const bool zoomed = k % 3 != 0;
  WildCase made;
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
TEST(FitExtremes, NoLocalMinimumIsCalledSuccess) {
  constexpr int kSize = 97;
  int converged = 0;
  for (std::uint64_t k = 0; k < 1000; ++k) {
    const WildCase made = wild_case(k, kSize);
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

// Of a needle a hundred times as long as its table hardly anything tells how it is turned: errors are large,
// far from linear, and said to be so. What is across it is known as well
// as ever.
TEST(FitExtremes, SaysWhenANeedleIsLongerThanItsTableTells) {
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

TEST(FitExtremes, WhatIsKnownToNoBetterThanAWidthIsNoSuccess) {
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
TEST(FitExtremes, ZooOfLobesIsRecoveredOrSaidNotToBe) {
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

TEST(FitExtremes, SaysWhenTheTableIsNoDistribution) {
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
TEST(FitExtremes, TheFarTailOfALobeElsewhereIsNothing) {
  DiskTable table = tabulate(Beckmann(slope_frame({0.02, 0.015, 0.9, 0, 0})), {129, 0.23});
  table.density = table.density.min(1e-141);
  ASSERT_GT(table.density.maxCoeff(), 0);
  for (const Weighting weighting : {Weighting::SolidAngle, Weighting::Log})
    EXPECT_EQ(fit(table, FitModel::BeckmannNdf, weighting).status, FitStatus::Empty);
}

TEST(FitExtremes, SaysWhenNothingIsOnTheDisk) {
  DiskTable table = make_disk_table({65, 1});
  table.density(0, 0) = 3;
  EXPECT_EQ(fit(table, FitModel::EllipsoidNdf).status, FitStatus::Empty);
}

// A few nodes at the horizon, which no lobe comes near to.
TEST(FitExtremes, AMinimumWorseThanNothingIsNoSuccess) {
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

TEST(FitExtremes, SaysWhenTheLobeIsNotResolved) {
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
TEST(FitExtremes, AMirrorsPeakIsNotResolvedWhereverItsStepsEnd) {
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
TEST(FitExtremes, NeedlesFarLongerThanTheDiskAreRecovered) {
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

TEST(FitExtremes, SaysThatThereIsNothing) {
  const Fit empty = fit(make_disk_table({101, 1}), FitModel::EllipsoidNdf);
  EXPECT_EQ(empty.status, FitStatus::Empty);
  EXPECT_TRUE(std::isnan(empty.parameters.alpha_x));
  EXPECT_FALSE(empty.undetermined.empty());
}

TEST(FitExtremes, RefusesWhatIsNotFinite) {
  DiskTable table = tabulate(ggx(0.2), {33, 1});
  table.density(3, 20) = NAN;
  EXPECT_THROW(fit(table, FitModel::EllipsoidNdf), InputError);
  table.density(3, 20) = INFINITY;
  EXPECT_THROW(fit(table, FitModel::EllipsoidNdf), InputError);
}

}  // namespace
}  // namespace micro
