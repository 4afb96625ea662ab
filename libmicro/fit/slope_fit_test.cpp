#include "fit/slope_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/random.h"
#include "distribution/beckmann.h"
#include "distribution/ellipsoid.h"
#include "distribution/tabulate.h"
#include "testing/step_between.h"

namespace micro {
namespace {

using testing::step_between;

struct Slopes {
  Grid<double> x, y;
};

/// Independent slopes drawn from a lobe.
template <typename Lobe>
Slopes drawn(const Lobe& lobe, Eigen::Index rows, Eigen::Index cols, std::uint64_t seed) {
  Slopes slopes = {Grid<double>(rows, cols), Grid<double>(rows, cols)};
  for (Eigen::Index k = 0; k < rows * cols; ++k) {
    const auto [a, b] = random_uniform(seed, 0, static_cast<std::uint64_t>(k));
    const Vec2 slope = slope_of(lobe.sample({a, b}));
    slopes.x.data()[k] = slope.x();
    slopes.y.data()[k] = slope.y();
  }
  return slopes;
}

const EllipsoidParameters kLobes[] = {{0.2, 0.2, 0, 0, 0},        // round
                                      {0.3, 0.003, 0, 0, 0.4},    // a needle that no table of the disk holds
                                      {0.02, 0.01, 0.5, 0.3, 1},  // narrow and tilted
                                      {0.2, 0.1, 0.6, 0.3, 0.5}};

TEST(SlopeFit, FindsTheLobeThatSlopesWereDrawnFrom) {
  // 160,000 independent normals leave about 1/√n·2 in each number; the bins widen the lobe by 1/(6·8.3²).
  constexpr double kSampling = 0.02;
  for (const EllipsoidParameters& p : kLobes) {
    const SlopeFrame frame = slope_frame(p);
    const Slopes slopes = drawn(Ellipsoid(frame), 400, 400, 3);
    const Fit found = fit_slopes(slopes.x, slopes.y);
    EXPECT_EQ(found.status, FitStatus::Converged) << name_of(found.status);
    EXPECT_LE(step_between(frame, found.frame).cwiseAbs().maxCoeff(), kSampling);
  }
}

TEST(SlopeFit, AgreesWithTheFitOfTheTable) {
  // On slopes that are no ellipsoid's, both minimise the squared difference of densities: the table's by
  // solid angle, the texel's in the lobe's frame.
  constexpr double kFrames = 0.03;
  const Beckmann lobe(slope_frame({0.15, 0.1, 0.05, 0, 0.3}));
  const Slopes slopes = drawn(lobe, 400, 400, 5);
  const Fit texel = fit_slopes(slopes.x, slopes.y);
  const Fit table = fit(tabulate(lobe, {513, 0.9}), FitModel::EllipsoidNdf);
  EXPECT_LE(step_between(table.frame, texel.frame).cwiseAbs().maxCoeff(), kFrames);
}

TEST(SlopeFit, PredictsItsOwnSpread) {
  // z of 300 texels' errors; a ratio of variances from 16 clusters scatters, so its mean is tested.
  const SlopeFrame frame = slope_frame({0.2, 0.1, 0.1, 0, 0.3});
  Vector5 squares = Vector5::Zero(), predicted = Vector5::Zero();
  constexpr int kTexels = 300;
  for (std::uint64_t k = 0; k < kTexels; ++k) {
    const Slopes slopes = drawn(Ellipsoid(frame), 40, 40, 100 + k);
    const Fit found = fit_slopes(slopes.x, slopes.y);
    squares += step_between(frame, found.frame).cwiseAbs2();
    predicted += found.step_covariance.diagonal();
  }
  // Sample variances of 300 scatter by √(2/300) = 8 %: four of them, and the sandwich's own bias of 1/16.
  for (int n = 0; n < 5; ++n)
    EXPECT_NEAR(predicted[n] / squares[n], 1, 0.4) << n;
}

TEST(SlopeFit, TakesExtremeTexels) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  const auto valid = [](const Fit& found) {
    const EllipsoidParameters& p = found.parameters;
    return p.alpha_x > 0 && p.alpha_y > 0 && std::isfinite(p.alpha_x) && std::isfinite(p.theta_x) &&
           std::isfinite(p.theta_y) && std::isfinite(p.theta_z);
  };
  const Grid<double> none = Grid<double>::Constant(10, 10, kNaN), flat = Grid<double>::Constant(10, 10, 0.3);
  EXPECT_EQ(fit_slopes(none, none).status, FitStatus::Empty);
  const Fit facet = fit_slopes(flat, flat);
  EXPECT_TRUE(valid(facet));
  EXPECT_NE(facet.status, FitStatus::Converged);
  EXPECT_NEAR(facet.frame.centre.x(), 0.3, 1e-5);
  Grid<double> ramp(10, 10);
  for (Eigen::Index k = 0; k < 100; ++k)
    ramp.data()[k] = static_cast<double>(k) / 100;
  EXPECT_TRUE(valid(fit_slopes(ramp, flat)));  // on a line
  EXPECT_TRUE(valid(fit_slopes(ramp, ramp)));
  EXPECT_TRUE(valid(fit_slopes(ramp * 1e8, ramp * -1e-8)));
  Grid<double> one = none;
  one(3, 3) = 0.1;
  EXPECT_TRUE(valid(fit_slopes(one, one)));
  const Slopes row = drawn(ggx(0.2), 1, 3, 1);
  EXPECT_TRUE(valid(fit_slopes(row.x, row.y)));
}

}  // namespace
}  // namespace micro
