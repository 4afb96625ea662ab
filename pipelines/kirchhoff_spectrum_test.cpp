#include "pipelines/kirchhoff_spectrum.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "core/error.h"
#include "height/triangles.h"
#include "io/hdf5_reader.h"
#include "io/zygo_dat.h"
#include "kirchhoff/spectral.h"
#include "pipelines/ndf_of_scans.h"
#include "pipelines/result_file.h"
#include "testing/cosine_surface.h"
#include "testing/temporary_folder.h"

namespace micro {
namespace {

namespace fs = std::filesystem;

/// Three rough scans of different area.
class SpectrumOfFolder : public ::testing::Test {
 protected:
  void SetUp() override {
    for (std::uint64_t k = 0; k < 3; ++k)
      write_zygo_dat(folder_.path() / ("scan" + std::to_string(k) + ".dat"),
                     testing::make_gaussian_surface({.cols = 48 + 16 * static_cast<Eigen::Index>(k)}, k));
    request_.spectrum = SpectrumRequest{std::vector<double>{0.5, 0.6, 0.7}, 1e-3, WholePatch{}, {}};
    request_.size = 33;
  }
  ScanListing listing() { return list_scans({folder_.path()}); }
  NdfResult run() {
    return ndf_of_scans(listing(), request_, [](const Progress&) {});
  }

  TemporaryFolder folder_;
  NdfRequest request_;
};

TEST_F(SpectrumOfFolder, IsTheWeightedMeanOfSeparateRuns) {
  const NdfResult result = run();
  ASSERT_TRUE(result.spectrum);
  EXPECT_TRUE(result.ndfs.empty());
  EXPECT_EQ(result.spectrum->mean.count(), 3);
  for (std::size_t k = 0; k < 3; ++k) {
    const double lambda_q = result.spectrum->lambda_q[k];
    Grid<double> sum = Grid<double>::Zero(33, 33);
    double area = 0;
    for (const ListedScan& scan : listing().scans) {
      const HeightField surface = prepare_scan(scan.path, request_.prepare).surface;
      const double weight = projected_area(surface);
      sum += weight * spectral_table(surface, {33, 1}, lambda_q, 1e-4).table.density;
      area += weight;
    }
    sum /= area;
    const Grid<double> got = result.spectrum->mean.mean(k).density;
    EXPECT_LE(std::sqrt((got - sum).square().sum() / sum.square().sum()), 2e-3);
    EXPECT_LE(result.spectrum->rel_error(k), 1e-3);
    EXPECT_GT(result.spectrum->errors[k].nodes, 0);
    EXPECT_EQ(result.spectrum->unreached[k], 0);
    EXPECT_DOUBLE_EQ(result.spectrum->valid_sin_theta(k), 1);
  }
}

TEST_F(SpectrumOfFolder, IsWrittenAsTheLayoutSays) {
  const NdfResult result = run();
  const fs::path file = folder_.path() / "result.h5";
  write_result(file, result, "test");
  const Hdf5Reader reader(file);
  const std::string group = "/ndf/kirchhoff_spectrum";
  EXPECT_FALSE(reader.contains("/ndf/kirchhoff"));
  const std::vector<float> density = reader.read<float>(group + "/density");
  ASSERT_EQ(reader.shape(group + "/density"), (Shape{3, 33, 33}));
  const Grid<double> mean = result.spectrum->mean.mean(1).density;
  EXPECT_FLOAT_EQ(density[33 * 33 + 16 * 33 + 20], static_cast<float>(mean(16, 20)));
  ASSERT_EQ(reader.shape(group + "/standard_error"), (Shape{3, 33, 33}));
  EXPECT_EQ(reader.read<double>(group + "/lambda_q_um"), (std::vector<double>{0.5, 0.6, 0.7}));
  for (const char* name : {"normalization", "rel_error", "valid_sin_theta"})
    EXPECT_EQ(reader.numbers_attribute(group, name).size(), 3u) << name;
  EXPECT_EQ(reader.integer_attribute(group, "scans"), 3);
  EXPECT_EQ(reader.text_attribute(group, "estimator"), "spectral");
  EXPECT_DOUBLE_EQ(reader.number_attribute(group, "extent"), 1);
}

TEST_F(SpectrumOfFolder, SourceGivesEachWavelengthItsCoherenceArea) {
  request_.spectrum->source = 0.1;
  const NdfResult result = run();
  ASSERT_TRUE(result.spectrum);
  ASSERT_EQ(result.spectrum->coherence_area.size(), 3u);
  EXPECT_DOUBLE_EQ(result.spectrum->coherence_area[2], coherence_area(0.7, 0.1));
  EXPECT_EQ(result.spectrum->mean.count(), 3);
}

TEST_F(SpectrumOfFolder, WindowsAreAveragedInIntensity) {
  request_.spectrum->coherence = SubWindows{8};
  const NdfResult result = run();
  ASSERT_TRUE(result.spectrum);
  EXPECT_GT(result.spectrum->windows, 6);
  EXPECT_NEAR(normalization(result.spectrum->mean.mean(0)), 1, 0.2);
}

TEST_F(SpectrumOfFolder, RefusalsAreNamed) {
  request_.spectrum->coherence = SubWindows{1e-9};  // smaller than a cell
  request_.unfit = NdfRequest::Unfit::Fail;
  const NdfResult result = run();
  EXPECT_FALSE(result.spectrum);
  EXPECT_TRUE(result.empty());
  for (const ScanRecord& scan : result.scans)
    EXPECT_TRUE(scan.failure);
}

TEST_F(SpectrumOfFolder, AutoTakesNoMoreThanItNeeds) {
  request_.spectrum->lambda_q = AsManyAsNeeded{};
  const NdfResult result = run();
  ASSERT_TRUE(result.spectrum);
  EXPECT_GE(result.spectrum->lambda_q.size(), 1u);
  EXPECT_LE(result.spectrum->lambda_q.size(), 65u);
}

TEST_F(SpectrumOfFolder, AutoTakesMoreWhereTheMirrorFades) {
  // rms 0.04 µm: e^{−g} goes from 0.17 to 0.66 over the visible.
  for (const ListedScan& scan : listing().scans)
    write_zygo_dat(scan.path, testing::make_gaussian_surface({.rms = 0.04}, 5));
  request_.spectrum->lambda_q = AsManyAsNeeded{};
  const NdfResult result = run();
  ASSERT_TRUE(result.spectrum);
  EXPECT_GE(result.spectrum->lambda_q.size(), 5u);
  EXPECT_DOUBLE_EQ(result.spectrum->lambda_q.front(), 0.38);
  EXPECT_DOUBLE_EQ(result.spectrum->lambda_q.back(), 0.78);
  for (const Stage& stage : result.plan)
    EXPECT_TRUE(stage.name != "kirchhoff spectrum" || stage.outcome == Stage::Outcome::Ran);
}

/// Two scans whose tables are Gaussians that widen as λ^power, without scatter.
WavelengthDependence widening(const std::vector<double>& lambda_q, double power) {
  const DiskGrid grid = {513, 1};
  WavelengthDependence dependence(grid, lambda_q, 1e-3);
  std::vector<Grid<float>> tables;
  for (const double lambda : lambda_q) {
    const double width = 0.3 * std::pow(lambda, power);
    tables.push_back(Grid<float>::NullaryExpr(513, 513, [&](auto j, auto i) {
      const double r = std::hypot(grid.coordinate(i), grid.coordinate(j)) / width;
      return static_cast<float>(std::exp(-r * r) / (width * width));
    }));
  }
  dependence.add(tables, 1);
  dependence.add(tables, 2);
  return dependence;
}

TEST(WavelengthDependence, MeasuresARelativeDistance) {
  // ‖a − b‖²/‖(a + b)/2‖² of Gaussians e^{−r²/w²}/w²: ∫a² = π/2w², ∫ab = π/(w₁² + w₂²).
  const auto distance = widening({0.5, 0.6}, 1).between(0, 1);
  const double a = 1 / (2 * 0.5 * 0.5), b = 1 / (2 * 0.6 * 0.6), ab = 1 / (0.5 * 0.5 + 0.6 * 0.6);
  EXPECT_NEAR(distance.measured, std::sqrt((a + b - 2 * ab) / ((a + b + 2 * ab) / 4)), 4e-3);
  EXPECT_LE(distance.scatter, 1e-6);
  EXPECT_NEAR(distance.beyond(), distance.measured, 1e-6);
}

TEST(WavelengthDependence, ScatterIsTakenAway) {
  const DiskGrid grid = {129, 1};
  WavelengthDependence dependence(grid, {0.4, 0.5}, 1e-3);
  for (int scan = 0; scan < 20; ++scan) {
    std::vector<Grid<float>> tables;
    for (int k = 0; k < 2; ++k)  // speckle of the same mean, independent at the two wavelengths
      tables.push_back(
          testing::make_gaussian_surface({.rows = 129, .cols = 129, .dx = 1, .dy = 1, .waves = 60},
                                         static_cast<std::uint64_t>(2 * scan + k))
              .z +
          1);
    dependence.add(tables, 1);
  }
  const auto distance = dependence.between(0, 1);
  EXPECT_GT(distance.measured, 0.03);
  EXPECT_NEAR(distance.measured / distance.scatter, 1, 0.15);
  EXPECT_LE(distance.beyond(), 0.6 * distance.measured);
}

TEST(ChooseWavelengths, OneDoesWhereNothingChanges) {
  const ChosenWavelengths chosen =
      choose_wavelengths({0.4, 0.8}, [](const auto& lambda_q) { return widening(lambda_q, 0); });
  ASSERT_EQ(chosen.lambda_q.size(), 1u);
  EXPECT_DOUBLE_EQ(chosen.lambda_q[0], 2 / (1 / 0.4 + 1 / 0.8));
  EXPECT_LE(chosen.farthest, 1e-6);
}

TEST(ChooseWavelengths, HalvesUntilNeighboursAreTheSame) {
  const ChosenWavelengths chosen =
      choose_wavelengths({0.4, 0.8}, [](const auto& lambda_q) { return widening(lambda_q, 0.5); });
  ASSERT_GE(chosen.lambda_q.size(), 5u);
  EXPECT_DOUBLE_EQ(chosen.lambda_q.front(), 0.4);
  EXPECT_DOUBLE_EQ(chosen.lambda_q.back(), 0.8);
  EXPECT_LE(chosen.farthest, kSameTables);
  const WavelengthDependence dependence = widening(chosen.lambda_q, 0.5);
  for (std::size_t k = 1; k < chosen.lambda_q.size(); ++k)
    EXPECT_LE(dependence.between(k - 1, k).beyond(), kSameTables);
  // No more than that: a wider pair would have been too far apart.
  EXPECT_GT(dependence.between(0, 2).beyond(), 0.6 * kSameTables);
}

}  // namespace
}  // namespace micro
