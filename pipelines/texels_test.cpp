#include "pipelines/texels.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fstream>

#include "core/error.h"
#include "core/parallel.h"
#include "fit/slope_fit.h"
#include "height/gaussian_surface.h"
#include "io/hdf5_reader.h"
#include "io/zygo_dat.h"
#include "ndf/local_planes.h"
#include "testing/temporary_folder.h"

namespace micro {
namespace {

constexpr GaussianField kRough = {.rms = 0.3, .tau_x = 3, .tau_y = 3};

HeightField rough(Eigen::Index rows, Eigen::Index cols, std::uint64_t seed) {
  return gaussian_surface({rows, cols, 0.25, 0.25}, kRough, seed);
}

ScanListing listing_of(const std::vector<std::string>& names) {
  ScanListing listing;
  for (const std::string& name : names)
    listing.scans.push_back({name, name});
  return listing;
}

TEST(TexelLayout, ReadsNamesAndManifests) {
  const TexelLayout named = lay_out(listing_of({"a/r02_c10.dat", "a/r03_c09.dat"}), ByName{"r{row}_c{col}"});
  EXPECT_EQ(named.rows, 2);
  EXPECT_EQ(named.cols, 2);
  EXPECT_EQ(named.places[0]->row, 0);
  EXPECT_EQ(named.places[0]->col, 1);
  EXPECT_EQ(named.places[1]->row, 1);
  EXPECT_EQ(named.places[1]->col, 0);
  const TexelLayout strip = lay_out(listing_of({"x 7.dat", "x 5.dat"}), ByName{"x {col}."});
  EXPECT_EQ(strip.cols, 3);
  EXPECT_EQ(strip.rows, 1);
  const TemporaryFolder folder;
  const auto path = folder.path() / "places.csv";
  std::ofstream(path) << "# source,row,col\n\na,b.dat,4,1\r\nc.dat,4,3\nunused.dat,0,0\n";
  const TexelLayout listed = lay_out(listing_of({"c.dat", "a,b.dat"}), Manifest{path});
  EXPECT_EQ(listed.cols, 3);
  EXPECT_EQ(listed.places[0]->col, 2);
  EXPECT_EQ(listed.how, "by the manifest, of which 1 line is of no scan here: unused.dat");
  EXPECT_THROW(lay_out(listing_of({"z.dat"}), Manifest{path}), FileError);
  // As spreadsheets and shells write it.
  std::ofstream(path) << "\xef\xbb\xbfsource, row, col\r\n./c.dat , 1, -1\r\n\"sub/a,b.dat\",0,4";
  const TexelLayout typed = lay_out(listing_of({"c.dat", "sub/a,b.dat"}), Manifest{path});
  EXPECT_EQ(typed.rows, 2);
  EXPECT_EQ(typed.cols, 6);
  EXPECT_EQ(typed.places[0]->row, 1);
  EXPECT_EQ(typed.places[1]->col, 5);
}

TEST(TexelLayout, CountsNumbersInNames) {
  // As listings have them: by letters.
  const std::vector<std::string> names = {"s10.dat", "s10b1.dat", "s2.dat",
                                          "s2a.dat", "sub/1.dat", "t007.dat",
                                          "t07.dat", "t1e30.dat", "t99999999999999999999999.dat"};
  const std::vector<Eigen::Index> places = {2, 3, 0, 1, 4, 6, 7, 5, 8};
  const TexelLayout layout = lay_out(listing_of(names), InOrder{});
  EXPECT_EQ(layout.rows, 1);
  ASSERT_EQ(layout.cols, 9);
  for (std::size_t k = 0; k < names.size(); ++k)
    EXPECT_EQ(layout.places[k]->col, places[k]) << names[k];
}

/// A scan with stage coordinates, µm; nothing is said of it if `x` is NaN.
void write_at(const std::filesystem::path& path, double x, double y) {
  std::string header =
      "Gwyddion Simple Field 1.0\nXRes = 2\nYRes = 1\nXReal = 2e-5\nYReal = 1e-5\nXYUnits = m\nZUnits = m\n";
  if (!std::isnan(x))
    header += "XOffset = " + std::to_string(x) + "e-6\nYOffset = " + std::to_string(y) + "e-6\n";
  header.resize(header.size() / 4 * 4 + 4);
  std::ofstream(path, std::ios::binary) << header << std::string(8, '\0');
}

TEST(TexelLayout, ReadsStageCoordinates) {
  const TemporaryFolder folder;
  ScanListing listing;
  const auto add = [&](const char* name, double x, double y) {
    const auto path = folder.path() / name;
    write_at(path, x, y);
    listing.scans.push_back({path, name});
  };
  // Steps of 18 and 12 µm, a gap of two columns, the stage's own errors, coordinates below 0.
  add("a", 54.9, -12.1);
  add("b", 0, 0.2);
  add("c", 18.4, 0);
  add("d", 0.5, -12);
  TexelLayout layout = lay_out(listing, ByStage{});
  EXPECT_EQ(layout.rows, 2);
  EXPECT_EQ(layout.cols, 4);
  const auto place = [&](std::size_t k) { return std::pair{layout.places[k]->row, layout.places[k]->col}; };
  EXPECT_EQ(place(0), std::pair(Eigen::Index{0}, Eigen::Index{3}));
  EXPECT_EQ(place(1), std::pair(Eigen::Index{1}, Eigen::Index{0}));
  EXPECT_EQ(place(2), std::pair(Eigen::Index{1}, Eigen::Index{1}));
  EXPECT_EQ(place(3), std::pair(Eigen::Index{0}, Eigen::Index{0}));
  add("silent", std::nan(""), 0);
  layout = lay_out(listing, ByStage{});
  EXPECT_FALSE(layout.places[4]);
  EXPECT_NE(layout.unplaced.at(4).find("stage"), std::string::npos);
  EXPECT_TRUE(layout.places[3]);
  add("off the grid", 28, 0);
  EXPECT_THROW(lay_out(listing, ByStage{}), InputError);
  listing.scans = {listing.scans[4]};
  EXPECT_THROW(lay_out(listing, ByStage{}), FileError);
}

TEST(TexelLayout, RefusesWhatMakesNoSense) {
  EXPECT_THROW(lay_out(listing_of({"a.dat"}), ByName{"r{row}"}), InputError);
  EXPECT_THROW(lay_out(listing_of({"r1.dat"}), ByName{"r1"}), InputError);
  EXPECT_THROW(lay_out(listing_of({"r1.dat"}), ByName{"{row}{row}"}), InputError);
  EXPECT_THROW(lay_out(listing_of({"r1.dat", "r01.dat"}), ByName{"r{row}"}), InputError);
  EXPECT_THROW(lay_out(listing_of({"r1.dat", "r999999999.dat"}), ByName{"r{row}"}), InputError);
  EXPECT_THROW(lay_out(listing_of({"r99999999999999999999.dat"}), ByName{"r{row}"}), InputError);
  EXPECT_THROW(lay_out(listing_of({"a.dat"}), Manifest{"/nowhere/at/all"}), FileError);
  const TemporaryFolder folder;
  const auto path = folder.path() / "places.csv";
  EXPECT_THROW(lay_out(listing_of({"a.dat"}), Manifest{folder.path()}), FileError);
  for (const char* text : {"", "a.dat", "a.dat,1", "a.dat,1,", "a.dat,1,0.5", "a.dat,1,1\na.dat,2,2",
                           "a.dat,1,9999999999999999999999", "b.dat,0,0\nsource,row,col\na.dat,0,1"}) {
    std::ofstream(path) << text;
    EXPECT_THROW(lay_out(listing_of({"a.dat"}), Manifest{path}), FileError) << text;
  }
  // Beyond what differences of places can hold, and what memory could.
  for (const char* text : {"a,-9223372036854775808,0\nb,9223372036854775807,0", "a,0,0\nb,0,1000000000",
                           "a,0,-1000000001\nb,0,0", "a,0,0\nb,9999,9999"}) {
    std::ofstream(path) << text;
    EXPECT_THROW(lay_out(listing_of({"a", "b"}), Manifest{path}), InputError) << text;
  }
}

TEST(TexelsOfSurface, AreTheBlocksOfTheWholeSurfacesNormals) {
  const HeightField surface = rough(130, 200, 1);
  const SlopeField slopes = local_planes(surface, 1);
  const SurfaceTexels texels = texels_of_surface(surface, {40, 60, 1, 9});
  ASSERT_EQ(texels.rows, 3);
  ASSERT_EQ(texels.cols, 3);
  for (Eigen::Index k = 0; k < 9; ++k) {
    const Fit whole = fit_slopes(slopes.zx.block(k / 3 * 40, k % 3 * 60, 40, 60),
                                 slopes.zy.block(k / 3 * 40, k % 3 * 60, 40, 60));
    const Texel& texel = texels.texels[static_cast<std::size_t>(k)];
    EXPECT_EQ(texel.fit.frame.l11, whole.frame.l11);
    EXPECT_NEAR(texel.independent, 40 * 60 * 0.0625 / (4 * 3.14159265), 1e-6);
    double mass = 0;
    for (const float density : texel.slopes)
      mass += density;
    EXPECT_GT(mass, 0.8);  // a node is one width: nearly all of a light-tailed lobe
    EXPECT_LE(mass, 1.0001);
  }
  EXPECT_THROW(texels_of_surface(surface, {131, 10, 1, 0}), InputError);
  EXPECT_THROW(texels_of_surface(surface, {40, 60, 33, 0}), InputError);  // of 32.5 µm
}

TEST(TexelsOfSurface, DoNotDependOnTheBands) {
  // 2²² points a band: this surface takes two. Whole blocks of it alone take one.
  const HeightField surface = rough(2200, 2200, 2);
  const SurfaceTexels banded = texels_of_surface(surface, {550, 1100, 1, 0});
  const SlopeField slopes = local_planes(surface, 1);
  for (Eigen::Index k = 0; k < 8; ++k) {
    const Fit whole = fit_slopes(slopes.zx.block(k / 2 * 550, k % 2 * 1100, 550, 1100),
                                 slopes.zy.block(k / 2 * 550, k % 2 * 1100, 550, 1100));
    EXPECT_NEAR(banded.texels[static_cast<std::size_t>(k)].fit.frame.l11, whole.frame.l11, 1e-9);
  }
}

/// Scans in a folder, as texels.
class TexelsOfScans : public ::testing::Test {
 protected:
  void scan(const std::string& name, const HeightField& surface) {
    write_zygo_dat(folder_.path() / name, surface);
  }
  Texels texels(const TexelRequest& request, const LayoutRule& rule = InOrder{}) const {
    const ScanListing listing = list_scans({folder_.path()});
    return texels_of_scans(listing, lay_out(listing, rule), request, [](const Progress&) {});
  }
  TemporaryFolder folder_;
};

TEST_F(TexelsOfScans, LeaveGapsAndNameWhatFails) {
  scan("r0_c0.dat", rough(80, 60, 1));
  scan("r2_c1.dat", rough(80, 60, 2));
  scan("r1_c1.dat", rough(80, 60, 3));
  std::filesystem::resize_file(folder_.path() / "r1_c1.dat", 3000);
  const Texels found = texels({}, ByName{"r{row}_c{col}"});
  EXPECT_EQ(found.rows, 3);
  EXPECT_EQ(found.cols, 2);
  EXPECT_EQ(found.count(), 2);
  EXPECT_NEAR(found.width, 15, 1e-6);
  EXPECT_NEAR(found.height, 20, 1e-6);
  EXPECT_EQ(found.places, (std::vector<std::int64_t>{0, 5}));  // of r0_c0 and r2_c1; gaps are nowhere
  EXPECT_EQ(std::count_if(found.scans.begin(), found.scans.end(),
                          [](const auto& s) { return s.failure.has_value(); }),
            1);
  const auto path = folder_.path() / "out.h5";
  Hdf5Writer file(path);
  write_texels(file, found);
  file.finish();
  const std::vector<float> parameters = Hdf5Reader(path).read<float>("/texels/parameters");
  EXPECT_EQ(Hdf5Reader(path).read<std::int32_t>("/texels/scan"),
            (std::vector<std::int32_t>{0, -1, -1, -1, -1, 2}));
  const std::vector<float> slopes = Hdf5Reader(path).read<float>("/texels/slope_density");
  ASSERT_EQ(slopes.size(), 6U * 33 * 33);
  EXPECT_EQ(slopes[5 * 33 * 33 + 16 * 33 + 16], found.texels[1].slopes[16 * 33 + 16]);
  EXPECT_TRUE(std::isnan(slopes[4 * 33 * 33]));
  ASSERT_EQ(parameters.size(), 3U * 2 * 5);
  EXPECT_FLOAT_EQ(parameters[0], static_cast<float>(found.texels[0].fit.parameters.alpha_x));
  EXPECT_TRUE(std::isnan(parameters[5]));
}

/// Most memory that was ever taken, bytes.
double peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024. * static_cast<double>(usage.ru_maxrss);
}

TEST_F(TexelsOfScans, TakeMemoryForTexelsThatAreThere) {
  // Two scans at the far ends of a million places, whose tables of slopes would take 4.4 GB.
  constexpr double kMost = 4e8;  // bytes; five numbers and states of each place, and what stood before
  scan("r0_c0.dat", rough(40, 40, 1));
  scan("r999_c999.dat", rough(40, 40, 2));
  const double before = peak_memory();
  const Texels found = texels({}, ByName{"r{row}_c{col}"});
  ASSERT_EQ(found.rows * found.cols, 1'000'000);
  EXPECT_EQ(found.texels.size(), 2U);
  const auto path = folder_.path() / "out.h5";
  Hdf5Writer file(path);
  write_texels(file, found);
  file.finish();
  EXPECT_LT(peak_memory() - before, kMost);
}

TEST_F(TexelsOfScans, SayWhereTheyAreOfUnequalSize) {
  scan("a.dat", rough(80, 60, 1));
  scan("b.dat", rough(80, 59, 2));
  const auto stage = [](const Texels& texels, const std::string& name) {
    const auto found =
        std::find_if(texels.plan.begin(), texels.plan.end(), [&](const Stage& s) { return s.name == name; });
    return found == texels.plan.end() ? "" : found->reason;
  };
  EXPECT_EQ(stage(texels({}), "texels").find("unequal"), std::string::npos);
  scan("c.dat", rough(40, 60, 3));
  EXPECT_NE(stage(texels({}), "texels").find("of unequal size, 150 to 300 square µm"), std::string::npos)
      << stage(texels({}), "texels");
}

TEST_F(TexelsOfScans, FailWhereATexelHoldsNoPoint) {
  scan("a.dat", rough(40, 40, 1));
  TexelRequest request;
  request.block = Vec2(10, 0.1);
  const Texels found = texels(request);
  ASSERT_TRUE(found.scans[0].failure);
  EXPECT_NE(found.scans[0].failure->find("too far apart"), std::string::npos);
}

TEST_F(TexelsOfScans, FormACrossOfStrips) {
  scan("r0_c0.dat", rough(80, 240, 1));  // 2 × 6 blocks across
  scan("r1_c0.dat", rough(240, 80, 2));  // 6 × 2 along
  scan("r1_c1.dat", rough(120, 40, 3));  // 3 × 1 beside it
  TexelRequest request;
  request.enough = 0;
  request.block = Vec2(10, 10);
  const Texels found = texels(request, ByName{"r{row}_c{col}"});
  ASSERT_EQ(found.rows, 8);
  ASSERT_EQ(found.cols, 7);
  EXPECT_EQ(found.count(), 12 + 12 + 3);
  const auto index_at = [&](Eigen::Index j, Eigen::Index i) -> std::int64_t {
    const auto at = std::find(found.places.begin(), found.places.end(), j * found.cols + i);
    return at == found.places.end() ? -1 : at - found.places.begin();
  };
  const auto scan_at = [&](Eigen::Index j, Eigen::Index i) {
    const std::int64_t k = index_at(j, i);
    return k < 0 ? -1 : found.scan[static_cast<std::size_t>(k)];
  };
  EXPECT_EQ(scan_at(1, 5), 0);
  EXPECT_EQ(scan_at(0, 6), -1);
  EXPECT_EQ(scan_at(2, 0), 1);
  EXPECT_EQ(scan_at(7, 1), 1);
  EXPECT_EQ(scan_at(2, 2), -1);
  EXPECT_EQ(scan_at(4, 6), 2);
  EXPECT_EQ(scan_at(5, 6), -1);
  const SurfaceTexels alone = texels_of_surface(rough(120, 40, 3), {40, 40, 1, 0});
  EXPECT_NEAR(found.texels[static_cast<std::size_t>(index_at(3, 6))].fit.frame.l11,
              alone.texels[1].fit.frame.l11, 1e-3 * alone.texels[1].fit.frame.l11);
}

TEST_F(TexelsOfScans, LoseACommonPlaneAndNothingElse) {
  // A stage that tilts every scan alike moves no lobe against another.
  constexpr double kTilt = 0.05, kFloatHeights = 2e-4;
  const std::vector<std::string> names = {"0.dat", "1.dat"};
  for (std::uint64_t k = 0; k < 2; ++k)
    scan(names[k], rough(100, 100, k));
  const Texels plain = texels({});
  for (std::uint64_t k = 0; k < 2; ++k) {
    HeightField tilted = rough(100, 100, k);
    for (Eigen::Index j = 0; j < 100; ++j)
      for (Eigen::Index i = 0; i < 100; ++i)
        tilted.z(j, i) += static_cast<float>(kTilt * 0.25 * static_cast<double>(i));
    scan(names[k], tilted);
  }
  const Texels tilted = texels({});
  EXPECT_NEAR(tilted.tilt.x() - plain.tilt.x(), kTilt, kFloatHeights);
  for (std::size_t k = 0; k < 2; ++k) {
    const SlopeFrame &a = plain.texels[k].fit.frame, &b = tilted.texels[k].fit.frame;
    EXPECT_NEAR(a.centre.x(), b.centre.x(), kFloatHeights);
    EXPECT_NEAR(a.l11, b.l11, kFloatHeights);
  }
  EXPECT_GT(std::abs(plain.texels[0].fit.frame.centre.x() - plain.texels[1].fit.frame.centre.x()), 1e-3);
}

TEST_F(TexelsOfScans, ShrinkWhereNormalsAreFew) {
  scan("a.dat", rough(400, 400, 5));
  TexelRequest request;
  request.block = Vec2(10, 10);
  request.enough = 0;
  const Texels plain = texels(request);
  request.enough = 50;
  const Texels shrunk = texels(request);
  double before = 0, after = 0, mean = 0;
  for (const Texel& texel : plain.texels)
    mean += std::log(texel.fit.frame.l11) / static_cast<double>(plain.texels.size());
  for (std::size_t k = 0; k < plain.texels.size(); ++k) {
    EXPECT_EQ(plain.states[k], TexelState::Fitted);
    EXPECT_EQ(shrunk.states[k], TexelState::Shrunk);
    before += std::pow(std::log(plain.texels[k].fit.frame.l11) - mean, 2);
    after += std::pow(std::log(shrunk.texels[k].fit.frame.l11) - mean, 2);
  }
  EXPECT_LT(after, before);
  request.block = Vec2(33, 33);  // nine texels tell nothing of what is usual
  request.enough = 1e4;
  EXPECT_EQ(texels(request).states[0], TexelState::Few);
}

TEST(StoredScale, IsPositiveDefiniteForAnyNeedle) {
  constexpr double kFloat = 3e-7;  // of the wider axis
  for (const double narrow : {1e-2, 1e-4, 1e-6, 1e-8})
    for (int k = 0; k < 50; ++k) {
      const SlopeFrame frame = frame_of({0.1, 0, std::log(0.3), 0, std::log(0.3 * narrow)});
      const Eigen::Matrix2d turn = Eigen::Rotation2Dd(0.13 * k).toRotationMatrix(),
                            scale = turn * frame.scale() * turn.transpose();
      SlopeFrame turned;
      turned.l11 = std::sqrt(scale(0, 0));
      turned.l21 = scale(0, 1) / turned.l11;
      turned.l22 = 0.3 * 0.3 * narrow / turned.l11;
      const std::array<float, 3> stored = stored_scale(turned);
      EXPECT_GT(static_cast<double>(stored[0]) * stored[2] - static_cast<double>(stored[1]) * stored[1], 0)
          << narrow << " " << k;
      EXPECT_NEAR(stored[0], scale(0, 0), kFloat * 0.09);
      EXPECT_NEAR(stored[1], scale(0, 1), kFloat * 0.09);
      EXPECT_NEAR(stored[2], scale(1, 1), kFloat * 0.09);
    }
}

/// A texel of 20 independent normals with a round lobe; each step's error is so many widths.
Texel made_texel(double width, double error, FitStatus status) {
  Texel texel;
  texel.normals = 1000;
  texel.independent = 20;
  texel.fit.frame = {{0, 0}, width, 0, width};
  texel.fit.status = status;
  texel.fit.step_covariance = error * error * Matrix5::Identity();
  return texel;
}

TEST(ShrinkFew, LeavesWideLobesWideBesideFlatTexels) {
  // Half of a sheet is flat: lobes narrower than what resolves them, whose errors, in widths, tell nothing of
  // the others'. What varies between texels is then far more than their error.
  constexpr double kOfItself = 0.05;
  Texels texels;
  for (int k = 0; k < 20; ++k)
    texels.texels.push_back(k % 2 == 0 ? made_texel(0.3 + 0.01 * k, 0.1, FitStatus::Converged)
                                       : made_texel(1e-7, k % 4 == 1 ? 300 : 1e-4, FitStatus::Unresolved));
  texels.states.assign(20, TexelState::Fitted);
  shrink_few(texels, 50);
  for (std::size_t k = 0; k < 20; k += 2) {
    EXPECT_EQ(texels.states[k], TexelState::Shrunk);
    EXPECT_NEAR(texels.texels[k].fit.frame.l11, 0.3 + 0.01 * static_cast<double>(k), kOfItself);
    EXPECT_NEAR(std::log(texels.texels[k + 1].fit.frame.l11), std::log(1e-7), 0.5);
  }
}

TEST(ShrinkFew, CountsNoGaps) {
  // Equal texels stay where they are, whatever stands in the gaps between them.
  Texels texels;
  for (int k = 0; k < 40; ++k)
    texels.texels.push_back(k % 2 == 0 ? made_texel(0.1, 0.1, FitStatus::Converged) : Texel{});
  for (int k = 0; k < 40; ++k)
    texels.states.push_back(k % 2 == 0 ? TexelState::Fitted : TexelState::Gap);
  shrink_few(texels, 50);
  for (std::size_t k = 0; k < 40; k += 2)
    EXPECT_NEAR(texels.texels[k].fit.frame.l11, 0.1, 1e-9);
}

TEST(ShrinkFew, DrawsByWhatVariesOverThatPlusTheError) {
  // Both widths' logarithms go together, with variance v about their mean, and each is known to e. Along that
  // direction texels vary by 2v, of which e² is error: drawn to 1 − e²/2v of their distance.
  constexpr double kError = 0.2;
  Texels texels;
  double variance = 0;
  const auto away = [](int k) { return 0.06 * (k - 9.5); };
  for (int k = 0; k < 20; ++k) {
    texels.texels.push_back(made_texel(0.1 * std::exp(away(k)), kError, FitStatus::Converged));
    variance += away(k) * away(k) / 19;
  }
  texels.states.assign(20, TexelState::Fitted);
  shrink_few(texels, 50);
  for (int k = 0; k < 20; ++k)
    EXPECT_NEAR(std::log(texels.texels[static_cast<std::size_t>(k)].fit.frame.l11 / 0.1),
                away(k) * (1 - kError * kError / (2 * variance)), 1e-6)
        << k;
}

TEST_F(TexelsOfScans, AreTheSameForAnyNumberOfThreads) {
  for (const char* name : {"0.dat", "1.dat", "2.dat"})
    scan(name, rough(90, 90, static_cast<std::uint64_t>(name[0])));
  TexelRequest request;
  request.block = Vec2(11, 11);
  const int threads = thread_count();
  set_thread_count(1);
  const Texels one = texels(request);
  set_thread_count(3);
  const Texels three = texels(request);
  set_thread_count(threads);
  ASSERT_EQ(one.texels.size(), three.texels.size());
  for (std::size_t k = 0; k < one.texels.size(); ++k)
    EXPECT_EQ(one.texels[k].fit.parameters.alpha_x, three.texels[k].fit.parameters.alpha_x);
}

}  // namespace
}  // namespace micro
