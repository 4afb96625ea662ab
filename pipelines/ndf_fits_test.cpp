#include "pipelines/ndf_fits.h"

#include <gtest/gtest.h>
#include <hdf5.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "distribution/beckmann.h"
#include "distribution/ellipsoid.h"
#include "distribution/tabulate.h"
#include "io/hdf5_reader.h"
#include "pipelines/fit_figure.h"
#include "testing/temporary_folder.h"

namespace micro {
namespace {

namespace fs = std::filesystem;

const EllipsoidParameters kParameters = {0.3, 0.1, 0.05, -0.1, 0.4};

class FitFile : public testing::Test {
 protected:
  fs::path path(const std::string& name = "a.h5") const { return folder_.path() / name; }

  /// Any program's file: tables under /ndf with their extents, and no word of ours.
  void write_tables(const fs::path& file, const std::vector<NdfTable>& tables) const {
    Hdf5Writer writer(file);
    for (const auto& [method, table, lambda_q] : tables) {
      writer.write("/ndf/" + method + "/density", table.density);
      writer.set_attribute("/ndf/" + method, "extent", table.grid.extent);
    }
    writer.write_text("/plan",
                      R"([{"stage":"fit","ran":false,"reason":"--without"},{"stage":"read","ran":true}])");
    writer.set_attribute("/", "other", "kept");
    writer.finish();
    remove_attribute(file, "complete");
  }
  static void remove_attribute(const fs::path& file, const char* name) {
    const hid_t id = H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    H5Adelete(id, name);
    H5Fclose(id);
  }

  TemporaryFolder folder_;
  const DiskTable ellipsoid_ = tabulate(Ellipsoid(slope_frame(kParameters)), {129, 0.9});
  const DiskTable beckmann_ = tabulate(Beckmann(slope_frame(kParameters)), {65, 0.8});
};

TEST_F(FitFile, FitsAnyFileAndWritesIntoIt) {
  write_tables(path(), {{"measured", ellipsoid_}, {"other", beckmann_}});
  const NdfTables tables = read_ndf_tables(path());
  ASSERT_EQ(tables.tables.size(), 2u);
  const NdfFits fits = fit_ndfs(tables.tables, Weighting::SolidAngle);
  add_fits(path(), path(), fits, "microbrdf fit a.h5");
  add_fits(path(), path(), fits, "microbrdf fit a.h5 again");
  const Hdf5Reader file(path());
  EXPECT_EQ(file.integer_attribute("/", "complete"), 1);
  EXPECT_EQ(file.text_attribute("/", "other"), "kept");
  EXPECT_EQ(file.children("/fit"), (std::vector<std::string>{"measured", "other"}));
  EXPECT_EQ(file.children("/fit/measured"), (std::vector<std::string>{"beckmann", "ellipsoid"}));
  constexpr double kSame = 1e-6;
  EXPECT_NEAR(file.number_attribute("/fit/measured/ellipsoid", "alpha_x"), 0.3, kSame);
  EXPECT_NEAR(file.number_attribute("/fit/measured/ellipsoid", "theta_y"), -0.1, kSame);
  EXPECT_NEAR(file.number_attribute("/fit/other/beckmann", "theta_z"), 0.4, kSame);
  EXPECT_EQ(file.text_attribute("/fit/measured/ellipsoid", "status"), "converged");
  EXPECT_EQ(file.numbers_attribute("/fit/measured/ellipsoid", "covariance").size(), 25u);
  EXPECT_LE(file.number_attribute("/fit/measured/ellipsoid", "rel_rms"), 1e-5);
  EXPECT_GT(file.number_attribute("/fit/measured/beckmann", "rel_rms"), 1e-2);
  EXPECT_GT(file.integer_attribute("/fit/measured/beckmann", "iterations"), 0);
  // The plan says of the fit what is now so, once, and nothing else has changed.
  const nlohmann::json plan = nlohmann::json::parse(file.read_text("/plan"));
  ASSERT_EQ(plan.size(), 2u);
  EXPECT_EQ(plan[0].at("stage"), "read");
  EXPECT_EQ(plan[1].at("stage"), "fit");
  EXPECT_EQ(plan[1].at("ran"), true);
  EXPECT_EQ(file.read_grid<double>("/ndf/measured/density").rows(), 129);
}

TEST_F(FitFile, WritesBesideWhenAskedTo) {
  write_tables(path(), {{"measured", ellipsoid_}});
  add_fits(path(), path("b.h5"), fit_ndfs(read_ndf_tables(path()).tables, Weighting::Log), "");
  EXPECT_FALSE(Hdf5Reader(path()).contains("/fit"));
  EXPECT_EQ(Hdf5Reader(path("b.h5")).text_attribute("/fit/measured/ellipsoid", "weighting"), "log");
}

TEST_F(FitFile, RefusesWhatIsNotWhole) {
  write_tables(path(), {{"measured", ellipsoid_}});
  {
    Hdf5Writer writer = Hdf5Writer::amend(path(), path());
    writer.set_attribute("/", "format", "microbrdf");
    writer.finish();
  }
  EXPECT_NO_THROW(read_ndf_tables(path()));
  remove_attribute(path(), "complete");
  EXPECT_THROW(read_ndf_tables(path()), FileError);
}

TEST_F(FitFile, LeavesOutWhatIsNoTableAndSaysWhy) {
  {
    Hdf5Writer writer(path());
    writer.write("/ndf/good/density", ellipsoid_.density);
    writer.set_attribute("/ndf/good", "extent", 0.9);
    writer.write("/ndf/no_extent/density", ellipsoid_.density);
    writer.write("/ndf/even/density", Grid<double>::Ones(64, 64).eval());
    writer.set_attribute("/ndf/even", "extent", 1.);
    writer.write("/ndf/oblong/density", Grid<double>::Ones(65, 64).eval());
    writer.set_attribute("/ndf/oblong", "extent", 1.);
    const std::vector<double> cube(27, 1);
    writer.write<double>("/ndf/spectrum/density", cube, {3, 3, 3});
    writer.set_attribute("/ndf/spectrum", "extent", 1.);
    writer.create_group("/ndf/nothing");
    Grid<double> holed = ellipsoid_.density;
    holed(3, 64) = NAN;
    writer.write("/ndf/holed/density", holed);
    writer.set_attribute("/ndf/holed", "extent", 0.9);
    writer.write("/ndf/zero/density", Grid<double>::Zero(65, 65).eval());
    writer.set_attribute("/ndf/zero", "extent", 1.);
    writer.finish();
  }
  const NdfTables tables = read_ndf_tables(path());
  EXPECT_EQ(tables.tables.size(), 3u);
  EXPECT_EQ(tables.left_out.size(), 4u);
  const NdfFits fits = fit_ndfs(tables.tables, Weighting::SolidAngle);
  ASSERT_EQ(fits.left_out.size(), 1u);
  EXPECT_EQ(fits.left_out[0].method, "holed");
  EXPECT_EQ(fits.fits.size(), 4u);
  EXPECT_EQ(fits.fits[2].fit.status, FitStatus::Empty);
  add_fits(path(), path("b.h5"), fits, "");
  EXPECT_TRUE(std::isnan(Hdf5Reader(path("b.h5")).number_attribute("/fit/zero/ellipsoid", "alpha_x")));
  EXPECT_NE(stage_of(fits).reason.find("empty"), std::string::npos);
}

// Off the disk there are no directions: what another program left there, NaN for one, does not count.
TEST_F(FitFile, OnlyTheDiskCounts) {
  DiskTable table = tabulate(Ellipsoid(slope_frame(kParameters)), {51, 1});  // (7, 24)/25: on the horizon
  for (Eigen::Index j = 0; j < 51; ++j)
    for (Eigen::Index i = 0; i < 51; ++i)
      if (std::hypot(static_cast<double>(j - 25), static_cast<double>(i - 25)) > 24.999)
        table.density(j, i) = (i + j) % 2 == 0 ? NAN : 1e9;
  write_tables(path(), {{"theirs", table}});
  const NdfFits fits = fit_ndfs(read_ndf_tables(path()).tables, Weighting::SolidAngle);
  EXPECT_TRUE(fits.left_out.empty());
  ASSERT_EQ(fits.fits.size(), 2u);
  EXPECT_EQ(fits.fits[0].fit.status, FitStatus::Converged);
  EXPECT_NEAR(fits.fits[0].fit.parameters.alpha_x, kParameters.alpha_x, 1e-5);
}

// What cannot be fitted leaves the fits that are there as they are.
TEST_F(FitFile, FailuresKeepEarlierFits) {
  write_tables(path(), {{"measured", ellipsoid_}, {"other", beckmann_}});
  add_fits(path(), path(), fit_ndfs(read_ndf_tables(path()).tables, Weighting::SolidAngle), "first");
  NdfFits other;
  other.left_out.push_back({"measured", "the table holds a density that is not finite"});
  add_fits(path(), path(), other, "second");
  EXPECT_EQ(Hdf5Reader(path()).text_attribute("/fit", "command"), "first");
  other.add(fit_ndf({"other", beckmann_}, Weighting::Log));
  add_fits(path(), path(), other, "third");
  const Hdf5Reader file(path());
  EXPECT_EQ(file.text_attribute("/fit", "command"), "third");
  EXPECT_EQ(file.text_attribute("/fit/other/ellipsoid", "weighting"), "log");
  ASSERT_TRUE(file.is_group("/fit/measured/ellipsoid"));
  EXPECT_NEAR(file.number_attribute("/fit/measured/ellipsoid", "alpha_x"), kParameters.alpha_x, 1e-5);
  EXPECT_NE(file.read_text("/plan").find("measured: the table holds"), std::string::npos);
}

TEST_F(FitFile, FitsEveryWavelengthOfASpectrum) {
  {
    Hdf5Writer writer(path());
    std::vector<double> both(ellipsoid_.density.data(),
                             ellipsoid_.density.data() + ellipsoid_.density.size());
    const DiskTable other = tabulate(Ellipsoid(slope_frame({0.2, 0.2, 0, 0, 0})), ellipsoid_.grid);
    both.insert(both.end(), other.density.data(), other.density.data() + other.density.size());
    writer.write<double>("/ndf/kirchhoff_spectrum/density", both, {2, 129, 129});
    const std::vector<double> lambda_q = {0.45, 0.6};
    writer.write<double>("/ndf/kirchhoff_spectrum/lambda_q_um", lambda_q, {2});
    writer.set_attribute("/ndf/kirchhoff_spectrum", "extent", 0.9);
    writer.finish();
  }
  const NdfTables tables = read_ndf_tables(path());
  ASSERT_EQ(tables.tables.size(), 2u);
  add_fits(path(), path(), fit_ndfs(tables.tables, Weighting::SolidAngle), "");
  constexpr double kFloat = 1e-5;
  const Hdf5Reader file(path());
  EXPECT_NEAR(file.number_attribute("/fit/kirchhoff_spectrum_0.45um/ellipsoid", "alpha_x"), 0.3, kFloat);
  EXPECT_NEAR(file.number_attribute("/fit/kirchhoff_spectrum_0.6um/ellipsoid", "alpha_x"), 0.2, kFloat);
}

TEST(SliceNames, AreAllDifferent) {
  using Names = std::vector<std::string>;
  EXPECT_EQ(slice_names("k", {0.45, 0.6}), (Names{"k_0.45um", "k_0.6um"}));
  EXPECT_EQ(slice_names("k", {0.45, 0.6, 0.45, 0.45}),
            (Names{"k_0.45um", "k_0.6um", "k_0.45um_2", "k_0.45um_3"}));
  const Names close = slice_names("k", {0.45, std::nextafter(0.45, 1)});
  EXPECT_NE(close[0], close[1]);
  for (const double bad : {double{NAN}, double{INFINITY}, 0., -0.5})
    EXPECT_THROW(slice_names("k", {0.45, bad}), InputError) << bad;
}

TEST_F(FitFile, LeavesOutASpectrumOfNoWavelengths) {
  {
    Hdf5Writer writer(path());
    writer.write("/ndf/good/density", ellipsoid_.density);
    writer.set_attribute("/ndf/good", "extent", 0.9);
    const std::vector<double> cube(27, 1), lambda_q = {0.45, NAN, 0.6};
    writer.write<double>("/ndf/spectrum/density", cube, {3, 3, 3});
    writer.write<double>("/ndf/spectrum/lambda_q_um", lambda_q, {3});
    writer.set_attribute("/ndf/spectrum", "extent", 1.);
    writer.finish();
  }
  const NdfTables tables = read_ndf_tables(path());
  EXPECT_EQ(tables.tables.size(), 1u);
  ASSERT_EQ(tables.left_out.size(), 1u);
  EXPECT_NE(tables.left_out[0].reason.find("nan"), std::string::npos);
}

TEST_F(FitFile, RefusesAFileWithoutTables) {
  {
    Hdf5Writer writer(path());
    writer.create_group("/scans");
    writer.finish();
  }
  EXPECT_THROW(read_ndf_tables(path()), FileError);
  EXPECT_THROW(read_ndf_tables(path("missing.h5")), FileError);
}

TEST_F(FitFile, DrawsTheFigure) {
  const NdfTable table = {"measured", ellipsoid_};
  const NdfFits fits = fit_ndfs({table}, Weighting::SolidAngle);
  EXPECT_TRUE(write_fit_figure(path("a.png"), table, fits));
  EXPECT_GT(fs::file_size(path("a.png")), 10000u);
  EXPECT_FALSE(write_fit_figure(path("b.png"), {"another", ellipsoid_}, fits));
  EXPECT_FALSE(fs::exists(path("b.png")));
  // Lobes of one node, skewed to the rim, zoomed in: a picture all the same.
  for (const DiskGrid& grid : {DiskGrid{33, 1}, DiskGrid{3, 0.01}, DiskGrid{257, 0.001}}) {
    DiskTable odd = make_disk_table(grid);
    odd.density(grid.size / 2, grid.size / 2 + grid.size / 3) = 1e5;
    odd.density(grid.size / 2, grid.size / 2) = 2;
    const NdfTable odd_table = {"odd", odd};
    const NdfFits odd_fits = fit_ndfs({odd_table}, Weighting::SolidAngle);
    EXPECT_TRUE(write_fit_figure(path("odd.png"), odd_table, odd_fits));
  }
}

}  // namespace
}  // namespace micro
