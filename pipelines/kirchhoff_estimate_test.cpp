#include "pipelines/kirchhoff_estimate.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "distribution/directions.h"
#include "height/gaussian_surface.h"
#include "height/make_holes.h"
#include "height/triangles.h"
#include "io/hdf5_reader.h"
#include "io/zygo_dat.h"
#include "kirchhoff/exact.h"
#include "pipelines/ndf_of_scans.h"
#include "pipelines/result_file.h"
#include "testing/temporary_folder.h"

namespace micro {
namespace {

namespace fs = std::filesystem;

constexpr double kLambda = 0.555;
constexpr DiskGrid kGrid = {17, 0.7};

HeightField surface(std::uint64_t seed, Eigen::Index cols = 50) {
  const HeightField whole =
      gaussian_surface({40, cols, 0.2, 0.2}, {.rms = 0.1, .tau_x = 1.5, .tau_y = 1.5}, seed);
  return seed % 2 == 1 ? make_holes(whole, {.fraction = 0.05}, 7) : whole;
}

Vec3 half_vector(const DiskGrid& grid, Eigen::Index j, Eigen::Index i) {
  return {grid.coordinate(i), grid.coordinate(j), std::sqrt(grid.mz2(j, i))};
}

/// Mean over windows of |F|²/(4π²A), window by window and node by node.
Grid<double> literal_table(const HeightField& s, const Coherence& coherence, const DiskGrid& grid) {
  Grid<double> table = make_disk_table(grid).density;
  double area = 0;
  for (const Window& window : coherent_windows(s, coherence)) {
    area += effective_area(window);
    for (Eigen::Index j = 0; j < grid.size; ++j)
      for (Eigen::Index i = 0; i < grid.size; ++i) {
        if (!(grid.mz2(j, i) > 0)) continue;
        const Vec3 q = wave_vector(half_vector(grid, j, i), kLambda);
        table(j, i) += std::norm(exact_field(window, {&q, 1}).front());
      }
  }
  return table * kirchhoff_density(1, area);
}

double difference(const Grid<double>& a, const Grid<double>& b) {
  return std::sqrt((a - b).square().sum() / b.square().sum());
}

TEST(KirchhoffScans, EveryEstimatorGivesTheTableOfEveryCoherence) {
  const HeightField s = surface(1);
  for (const Coherence& coherence :
       {Coherence(WholePatch{}), Coherence(SubWindows{12}), Coherence(GaussianTaper{6})}) {
    const Grid<double> literal = literal_table(s, coherence, kGrid);
    const auto estimate = [&](KirchhoffBy by, double tol) {
      return KirchhoffScans({kLambda, tol, coherence, by}, kGrid, {})(s);
    };
    const KirchhoffEstimate exact = estimate(KirchhoffBy::Exact, 1e-3);
    EXPECT_EQ(exact.estimator, "exact");
    EXPECT_LE(difference(exact.density, literal), 1e-12);
    EXPECT_EQ(exact.variance.size(), 0);
    const KirchhoffEstimate spectral = estimate(KirchhoffBy::Spectral, 1e-3);
    EXPECT_EQ(spectral.estimator, "spectral");
    constexpr double kSlack = 2;  // a small table samples few speckles
    EXPECT_LE(difference(spectral.density, literal), kSlack * 1e-3);
    EXPECT_EQ(spectral.asked, spectral.windows);
    const KirchhoffEstimate monte_carlo = estimate(KirchhoffBy::MonteCarlo, 3e-2);
    EXPECT_EQ(monte_carlo.estimator, "monte-carlo");
    EXPECT_EQ(monte_carlo.asked, disk_nodes(kGrid));
    double worst = 0;
    for (Eigen::Index j = 0; j < kGrid.size; ++j)
      for (Eigen::Index i = 0; i < kGrid.size; ++i)
        if (kGrid.mz2(j, i) > 0)
          worst = std::max(worst, std::abs(monte_carlo.density(j, i) - literal(j, i)) /
                                      std::sqrt(monte_carlo.variance(j, i)));
    // 225 directions, whose errors are correlated and, near zeros of D, not normal.
    EXPECT_LE(worst, 6) << coherence.index();
    EXPECT_EQ(monte_carlo.unreached, 0);
  }
}

TEST(KirchhoffScans, DirectionsAreThoseOfTheTable) {
  const HeightField s = surface(1);
  const std::vector<Vec3> h = {half_vector(kGrid, 8, 8), half_vector(kGrid, 3, 11)};
  const Grid<double> table = literal_table(s, WholePatch{}, kGrid);
  for (const KirchhoffBy by : {KirchhoffBy::Exact, KirchhoffBy::Fastest}) {
    const KirchhoffEstimate d = KirchhoffScans({kLambda, 1e-6, WholePatch{}, by}, h, {})(s);
    ASSERT_EQ(d.density.rows(), 2);
    EXPECT_NEAR(d.density(0, 0) / table(8, 8), 1, 1e-5);
    EXPECT_NEAR(d.density(1, 0) / table(3, 11), 1, 1e-5);
    EXPECT_TRUE(std::isinf(d.predicted.spectral));
  }
  EXPECT_THROW(KirchhoffScans({kLambda, 1e-6, WholePatch{}, KirchhoffBy::Spectral}, h, {}), InputError);
}

// Two scans of variance v and areas 1, 3: the mean's variance is (1 + 9)v/16.
TEST(KirchhoffTally, PoolsErrorsByArea) {
  KirchhoffEstimate scan;
  scan.density = Grid<double>::Constant(2, 1, 5.);
  scan.variance = Grid<double>::Constant(2, 1, 0.16);
  scan.estimator = "monte-carlo";
  scan.asked = 2;
  scan.unreached = 1;
  KirchhoffTally tally;
  tally.add(scan, 1);
  scan.unreached = 0;
  tally.add(scan, 3);
  EXPECT_NEAR(tally.standard_error()(1, 0), std::sqrt(0.1), 1e-12);
  EXPECT_NEAR(tally.rel_error(scan.density), std::sqrt(0.1) / 5, 1e-12);
  EXPECT_NE(tally.sentence(KirchhoffBy::MonteCarlo).find("3 of 4 directions reached"), std::string::npos);
  scan.variance.resize(0, 0);
  scan.estimator = "exact";
  tally.add(scan, 1);
  EXPECT_EQ(tally.estimator(), "exact and monte-carlo");
}

class KirchhoffOfScans : public testing::Test {
 protected:
  void SetUp() override {
    for (std::uint64_t k = 0; k < 3; ++k)
      write_zygo_dat(folder_.path() / ("scan" + std::to_string(k) + ".dat"),
                     surface(k, 50 + 10 * static_cast<Eigen::Index>(k)));
  }
  NdfResult run(NdfRequest request) {
    return ndf_of_scans(list_scans({folder_.path()}), request, [](const Progress&) {});
  }
  TemporaryFolder folder_;
};

TEST_F(KirchhoffOfScans, MeanAndErrorsOverScansGoIntoTheFile) {
  const std::vector<Vec3> h = {Vec3(0, 0, 1), Vec3(0.28, 0, 0.96), Vec3(0, -0.6, 0.8)};
  NdfRequest request;
  request.directions = DirectionsRequest{h, {kLambda, 1e-3, WholePatch{}, KirchhoffBy::Exact}};
  const NdfResult result = run(request);
  ASSERT_TRUE(result.directions);
  EXPECT_TRUE(result.ndfs.empty());
  EXPECT_FALSE(result.empty());
  for (std::size_t k = 0; k < h.size(); ++k) {
    double area = 0, mean = 0, square = 0;
    std::vector<std::pair<double, double>> scans;
    for (int n = 0; n < 3; ++n) {
      const HeightField s =
          level(read_scan(folder_.path() / ("scan" + std::to_string(n) + ".dat")).surface, Level::Plane);
      scans.emplace_back(projected_area(s), exact_density(s, wave_vector(h[k], kLambda)));
      area += scans.back().first;
      mean += scans.back().first * scans.back().second;
    }
    mean /= area;
    for (const auto& [a, d] : scans)
      square += a * a * (d - mean) * (d - mean);
    EXPECT_NEAR(result.directions->density[k] / mean, 1, 1e-9);
    EXPECT_NEAR((*result.directions->standard_error)[k] / (std::sqrt(1.5 * square) / area), 1, 1e-6);
    EXPECT_EQ(result.directions->estimator_error[k], 0);
  }
  EXPECT_EQ(result.directions->rel_error, 0);

  const fs::path path = folder_.path() / "result.h5";
  write_result(path, result, "microbrdf ndf");
  const Hdf5Reader file(path);
  const std::string group = "/ndf/kirchhoff_directions";
  const Grid<double> direction = file.read_grid<double>(group + "/direction");
  ASSERT_EQ(direction.rows(), 3);
  ASSERT_EQ(direction.cols(), 3);
  EXPECT_EQ(direction(2, 1), -0.6);
  for (const char* name : {"/density", "/standard_error", "/estimator_error"})
    EXPECT_TRUE(file.contains(group + name)) << name;
  EXPECT_EQ(file.text_attribute(group, "estimator"), "exact");
  EXPECT_EQ(file.number_attribute(group, "lambda_q_um"), kLambda);
}

TEST_F(KirchhoffOfScans, MonteCarloSaysHowFarItIs) {
  NdfRequest request;
  request.directions = DirectionsRequest{20, {kLambda, 1e-2, WholePatch{}, KirchhoffBy::MonteCarlo}};
  const DirectionsOfScans got = *run(request).directions;
  const std::vector<Vec3> h = spread_directions(20);
  request.directions = DirectionsRequest{h, {kLambda, 1e-2, WholePatch{}, KirchhoffBy::Exact}};
  const DirectionsOfScans exact = *run(request).directions;
  for (std::size_t k = 0; k < h.size(); ++k) {
    EXPECT_EQ(got.h[k], h[k]);  // λ_q/(2·pitch) > 1: the whole disk
    EXPECT_LE(std::abs(got.density[k] - exact.density[k]), 5 * got.estimator_error[k]);
    EXPECT_GT(got.estimator_error[k], 0);
  }
  EXPECT_LE(got.rel_error, 1e-2);
  EXPECT_GT(got.rel_error, 0);
}

TEST_F(KirchhoffOfScans, TheCoarsestOfMixedPitchesSaysHowFarTheTableGoes) {
  HeightField coarse = surface(2);
  coarse.dx = coarse.dy = 0.4;
  write_zygo_dat(folder_.path() / "z.dat", coarse);
  NdfRequest request;
  request.methods = {{"kirchhoff", Kirchhoff{.lambda_q = 0.2, .tolerance = 1e-2}}};
  request.size = 33;
  request.pitches = NdfRequest::Pitches::MayDiffer;
  EXPECT_NEAR(run(request).ndfs.front().density.grid.extent, 0.2 / 0.8, 1e-6);
}

TEST_F(KirchhoffOfScans, ThePlanSaysWhatAPartOfTheDiskSpares) {
  NdfRequest request;
  request.methods = {{"kirchhoff", Kirchhoff{}}};
  request.size = 65;
  request.extent = 0.25;
  const std::string plan = to_text(run(request).plan);
  const std::int64_t part = disk_nodes({65, 0.25}), whole = disk_nodes({257, 1});
  EXPECT_NE(plan.find(std::to_string(part) + " of the " + std::to_string(whole) + " nodes"),
            std::string::npos)
      << plan;
  EXPECT_NE(plan.find("predicted to be the fastest"), std::string::npos) << plan;
}

}  // namespace
}  // namespace micro
