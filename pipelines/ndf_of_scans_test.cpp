#include "pipelines/ndf_of_scans.h"

#include <gtest/gtest.h>

#include <fstream>

#include "core/error.h"
#include "core/parallel.h"
#include "height/gaussian_surface.h"
#include "height/make_holes.h"
#include "height/triangles.h"
#include "io/hdf5_reader.h"
#include "io/microbrdf_hdf5.h"
#include "io/npy.h"
#include "io/zygo_dat.h"
#include "kirchhoff/exact.h"
#include "ndf/normal_counts.h"
#include "pipelines/output_lock.h"
#include "pipelines/pitch_groups.h"
#include "pipelines/result_file.h"
#include "testing/temporary_folder.h"

namespace micro {
namespace {

namespace fs = std::filesystem;

constexpr double kFloat = 1e-6;  // tables are stored as float32

/// Rough scans in Zygo .dat, the second with holes.
class Scans : public testing::Test {
 protected:
  void SetUp() override {
    for (std::uint64_t k = 0; k < 3; ++k) {
      HeightField surface = gaussian_surface({40, 50 + static_cast<Eigen::Index>(10 * k), 0.2, 0.2},
                                             {.rms = 0.2, .tau_x = 1.5, .tau_y = 1.5}, k);
      if (k == 1) surface = make_holes(surface, {.fraction = 0.05}, 7);
      write_zygo_dat(scans() / ("scan" + std::to_string(k) + ".dat"), surface);
    }
  }
  fs::path scans() {
    fs::create_directories(folder_.path() / "scans" / "deeper");
    return folder_.path() / "scans";
  }
  void write_text(const fs::path& name, const std::string& text) { std::ofstream(scans() / name) << text; }

  NdfRequest request() {
    NdfRequest request;
    request.methods = {{"naive", Naive{}}, {"filtered", Filtered{0.5}}};
    request.size = 65;
    return request;
  }
  NdfResult run(const NdfRequest& what) {
    return ndf_of_scans(list_scans({scans()}), what, [](const Progress&) {});
  }

  TemporaryFolder folder_;
};

const NdfOfScans& named(const NdfResult& result, const std::string& name) {
  for (const NdfOfScans& ndf : result.ndfs)
    if (ndf.method.name == name) return ndf;
  throw std::runtime_error("no " + name);
}

TEST_F(Scans, AverageIsWeightedByArea) {
  const NdfResult result = run(request());
  ASSERT_EQ(result.scans.size(), 3u);
  EXPECT_EQ(result.scans[1].missing, missing_count(read_scan(scans() / "scan1.dat").surface));
  double area = 0;
  Grid<double> sum = Grid<double>::Zero(65, 65);
  for (int k = 0; k < 3; ++k) {
    const HeightField surface =
        level(read_scan(scans() / ("scan" + std::to_string(k) + ".dat")).surface, Level::Plane);
    const NormalCounts counts = naive_counts(surface, {65, 1});
    const double scan_area = static_cast<double>(counts.total) * 0.2 * 0.2 / 2;
    area += scan_area;
    sum += scan_area * density(counts).density;
  }
  const NdfOfScans& naive = named(result, "naive");
  constexpr double kPitch = 1e-6;  // .dat keeps its pitch as float32
  EXPECT_NEAR(naive.area / area, 1, kPitch);
  EXPECT_LE((naive.density.density - sum / area).abs().maxCoeff(), 1e-5 * naive.density.density.maxCoeff());
  EXPECT_NEAR(normalization(naive.density), 1, 1e-12);
  EXPECT_EQ(naive.scans, 3);
  EXPECT_TRUE(naive.standard_error.has_value());
}

TEST_F(Scans, TheSameForAnyNumberOfThreads) {
  const int threads = thread_count();
  set_thread_count(1);
  const NdfResult one = run(request());
  set_thread_count(4);
  const NdfResult four = run(request());
  set_thread_count(threads);
  for (const char* name : {"naive", "filtered"}) {
    EXPECT_TRUE((named(one, name).density.density == named(four, name).density.density).all());
    EXPECT_TRUE((*named(one, name).standard_error == *named(four, name).standard_error).all());
  }
}

TEST_F(Scans, ABrokenScanNeverStopsTheRest) {
  write_text("broken.dat", std::string("\x88\x1b\x03\x6f", 4) + std::string(100, '\0'));
  write_text("deeper/readme.txt", "not a scan");
  write_text("table.csv", "1 2 3\n4 5 6\n");
  const ScanListing listing = list_scans({scans()});
  ASSERT_EQ(listing.scans.size(), 4u);
  EXPECT_EQ(listing.skipped.size(), 2u);
  const NdfResult result = run(request());
  EXPECT_EQ(named(result, "naive").scans, 3);
  ASSERT_TRUE(result.scans[0].failure.has_value());
  EXPECT_EQ(result.scans[0].source, "broken.dat");
  EXPECT_EQ(result.scans[0].failure->find("broken.dat"), std::string::npos) << "the name is said once";
}

TEST_F(Scans, DifferentPitchesAreRefusedTogether) {
  write_zygo_dat(scans() / "other.dat", gaussian_surface({20, 20, 0.3, 0.3}, {}, 1));
  write_text("broken.dat", std::string("\x88\x1b\x03\x6f", 4) + std::string(100, '\0'));
  try {
    run(request());
    FAIL();
  } catch (const MixedPitches& error) {
    for (const char* fact : {"0.2 × 0.2 µm: scan0.dat, scan1.dat, scan2.dat", "0.3 × 0.3 µm: other.dat"})
      EXPECT_NE(std::string(error.what()).find(fact), std::string::npos) << error.what();
    ASSERT_EQ(error.failed().size(), 5u);
    EXPECT_EQ(error.failed()[0].source, "broken.dat");
    EXPECT_NE(error.failed()[1].message.find("0.3 × 0.3 µm"), std::string::npos);
  }
  const ScanListing listing = list_scans({scans()});
  int looked_at = 0;
  EXPECT_THROW(ndf_of_scans(listing, request(), [&](const Progress&) { ++looked_at; }), MixedPitches);
  EXPECT_EQ(looked_at, 0) << "the odd one is refused before anything is computed";
  fs::remove(scans() / "broken.dat");
  NdfRequest mixed = request();
  mixed.pitches = NdfRequest::Pitches::MayDiffer;
  EXPECT_EQ(named(run(mixed), "naive").scans, 4);
}

TEST_F(Scans, AnUnresolvedSigmaIsLeftOutWithTheReason) {
  NdfRequest narrow = request();
  narrow.methods[1].kind = Filtered{0.05};
  const NdfResult result = run(narrow);
  EXPECT_EQ(result.ndfs.size(), 1u);
  bool said = false;
  for (const Stage& stage : result.plan)
    said |= stage.outcome == Stage::Outcome::LeftOut &&
            stage.reason.find("below half the pitch") != std::string::npos;
  EXPECT_TRUE(said);
}

TEST_F(Scans, AnUnresolvedSigmaFailsWhereTheMethodIsAskedForByName) {
  NdfRequest narrow = request();
  narrow.methods[1].kind = Filtered{0.05};
  narrow.unfit = NdfRequest::Unfit::Fail;
  const NdfResult result = run(narrow);
  EXPECT_TRUE(result.ndfs.empty());
  for (const ScanRecord& scan : result.scans) {
    ASSERT_TRUE(scan.failure.has_value());
    EXPECT_NE(scan.failure->find("below half the pitch"), std::string::npos);
    EXPECT_EQ(scan.sha256.size(), 64u);
  }
}

TEST_F(Scans, FilledHolesNeedNoMaskedMoments) {
  const auto outcome = [](const NdfResult& result) {
    for (const Stage& stage : result.plan)
      if (stage.name == "masked moments") return stage.outcome;
    throw std::runtime_error("no masked moments in the plan");
  };
  NdfRequest filling = request();
  EXPECT_EQ(outcome(run(filling)), Stage::Outcome::Ran);
  filling.prepare.holes = Preparation::Holes::Fill;
  EXPECT_EQ(outcome(run(filling)), Stage::Outcome::LeftOut);
}

TEST_F(Scans, AutomaticExtentHoldsTheEnergy) {
  NdfRequest automatic = request();
  automatic.extent = HoldsEnergy{};
  const NdfResult result = run(automatic);
  const NdfOfScans& filtered = named(result, "filtered");
  EXPECT_LT(filtered.density.grid.extent, 0.9);
  EXPECT_GE(normalization(filtered.density), 0.999);
  EXPECT_NEAR(normalization(filtered.density), 1 - filtered.outside, 1e-9);
}

TEST_F(Scans, KirchhoffIsTheMeanOverPatchesOfTheExactDensity) {
  NdfRequest waves = request();
  waves.methods = {{"kirchhoff", Kirchhoff{.lambda_q = 0.555, .tolerance = 1e-3}}};
  const NdfResult result = run(waves);
  const NdfOfScans& kirchhoff = named(result, "kirchhoff");
  EXPECT_EQ(kirchhoff.density.grid.extent, 1);  // λ_q/(2·pitch) = 1.39
  EXPECT_NEAR(kirchhoff.valid_sin_theta, 0.555 / 0.8, 1e-6);
  EXPECT_LE(kirchhoff.rel_error, 1e-3);
  EXPECT_EQ(kirchhoff.unreached, 0);
  double squares = 0, differences = 0;
  for (const auto& [j, i] : {std::pair{32, 32}, std::pair{30, 36}, std::pair{40, 28}, std::pair{20, 32}}) {
    const double x = kirchhoff.density.grid.coordinate(i), y = kirchhoff.density.grid.coordinate(j);
    double sum = 0, area = 0;
    for (int k = 0; k < 3; ++k) {
      const HeightField surface =
          level(read_scan(scans() / ("scan" + std::to_string(k) + ".dat")).surface, Level::Plane);
      const double a = projected_area(surface);
      sum += a * exact_density(surface, wave_vector(Vec3(x, y, std::sqrt(1 - x * x - y * y)), 0.555));
      area += a;
    }
    squares += std::pow(sum / area, 2);
    differences += std::pow(sum / area - kirchhoff.density.density(j, i), 2);
  }
  EXPECT_LE(std::sqrt(differences / squares), 1e-2);  // four nodes of a table whose L2 error is 1e-3
}

TEST_F(Scans, KirchhoffOfACoarseGridEndsAtItsFirstFalseOrder) {
  NdfRequest waves = request();
  waves.methods = {{"kirchhoff", Kirchhoff{.lambda_q = 0.2, .tolerance = 1e-2}}};
  EXPECT_NEAR(named(run(waves), "kirchhoff").density.grid.extent, 0.5, 1e-6);
}

TEST_F(Scans, SignatureKeepsTheMassAndWidens) {
  NdfRequest blurred = request();
  blurred.signature = NamedSignature{"10deg", gaussian_signature(0.17)};
  const NdfResult result = run(blurred);
  ASSERT_EQ(result.ndfs.size(), 4u);
  const NdfOfScans& seen = named(result, "filtered_signature10deg");
  EXPECT_NEAR(normalization(seen.density), 1, 1e-9);
  EXPECT_LT(seen.density.density.maxCoeff(), named(result, "filtered").density.density.maxCoeff());
}

TEST_F(Scans, TheResultFileHoldsWhatTheLayoutSays) {
  const NdfResult result = run(request());
  const fs::path path = folder_.path() / "result.h5";
  write_result(path, result, "microbrdf run scans");
  const Hdf5Reader file(path);
  file.require_complete();
  EXPECT_EQ(file.integer_attribute("/", "format_version"), 1);
  EXPECT_EQ(file.children("/scans").size(), 3u);
  EXPECT_EQ(file.text_attribute("/scans/00001", "source"), "scan1.dat");
  EXPECT_EQ(file.text_attribute("/scans/00001", "status"), "done");
  EXPECT_EQ(file.text_attribute("/scans/00001", "sha256").size(), 64u);
  EXPECT_EQ(file.integer_attribute("/scans/00002", "cols"), 70);
  const Grid<double> stored = file.read_grid<double>("/ndf/filtered/density");
  const NdfOfScans& filtered = named(result, "filtered");
  EXPECT_LE((stored - filtered.density.density).abs().maxCoeff(),
            kFloat * filtered.density.density.maxCoeff());
  EXPECT_EQ(file.number_attribute("/ndf/filtered", "sigma_um"), 0.5);
  EXPECT_EQ(file.text_attribute("/ndf/filtered", "unit"), "1/sr");
  EXPECT_TRUE(file.contains("/ndf/filtered/standard_error"));
  EXPECT_NE(file.read_text("/plan").find("masked moments"), std::string::npos);
}

TEST_F(Scans, TheOutputInsideTheDirectoryIsNoInput) {
  const fs::path output = scans() / "out";
  const OutputLock lock(output);
  write_zygo_dat(output / "copy.dat", read_scan(scans() / "scan0.dat").surface);
  EXPECT_EQ(list_scans({scans()}, output).scans.size(), 3u);
  EXPECT_EQ(list_scans({scans()}).scans.size(), 4u);
}

TEST_F(Scans, OneOutputServesOneRun) {
  const fs::path output = folder_.path() / "out";
  {
    const OutputLock lock(output);
    EXPECT_THROW(OutputLock second(output), FileError);
  }
  EXPECT_FALSE(fs::exists(output));  // nothing came of it
  EXPECT_NO_THROW(OutputLock third(output));
}

TEST_F(Scans, OneFileServesOneRunAndItsNeighboursOthers) {
  const fs::path out = folder_.path() / "out", output = out / "a.h5";
  fs::create_directories(out);
  {
    const OutputLock lock = OutputLock::of_file(output);
    EXPECT_THROW(OutputLock::of_file(out / "." / "a.h5"), FileError);
    EXPECT_NO_THROW(OutputLock::of_file(out / "b.h5"));
    EXPECT_THROW(OutputLock whole(out), FileError);
  }
  EXPECT_TRUE(fs::is_empty(out)) << "nothing came of it";
  EXPECT_NO_THROW(OutputLock::of_file(output));
  const OutputLock whole(out);
  EXPECT_THROW(OutputLock::of_file(output), FileError);
  EXPECT_THROW(OutputLock::of_file(out / "nowhere" / "a.h5"), FileError);
}

TEST_F(Scans, ANamedFileIsTakenAndADirectorysFilesKeepItsNameBesideOthers) {
  const ScanListing one = list_scans({scans()});
  EXPECT_EQ(one.scans[0].source, "scan0.dat");
  const ScanListing listing = list_scans({scans(), folder_.path() / "nowhere.dat"});
  ASSERT_EQ(listing.scans.size(), 4u);
  EXPECT_EQ(listing.scans[0].source, (scans() / "scan0.dat").generic_string());
  EXPECT_NO_THROW(ndf_of_scans(listing, request(), [](const Progress&) {}));
}

TEST_F(Scans, WhatAStoppedRunLeftIsClearedAway) {
  const fs::path output = folder_.path() / "out";
  fs::create_directories(output);
  std::ofstream(output / ".microbrdf-1-0.part") << "half a file";
  const OutputLock lock(output);
  EXPECT_FALSE(fs::exists(output / ".microbrdf-1-0.part"));
}

TEST_F(Scans, ACutHeightFileOfOursIsSkipped) {
  const fs::path whole = scans() / "whole.h5", cut = scans() / "cut.h5";
  write_microbrdf_hdf5(whole, read_scan(scans() / "scan0.dat").surface,
                       {.version = "1", .created = "now", .command = "test"});
  fs::copy_file(whole, cut);
  fs::resize_file(cut, fs::file_size(whole) - 1);
  const ScanListing listing = list_scans({scans()});
  EXPECT_EQ(listing.scans.size(), 4u);
  ASSERT_EQ(listing.skipped.size(), 1u);
  EXPECT_EQ(listing.skipped[0].source, "cut.h5");
  EXPECT_NE(listing.skipped[0].reason.find("cut"), std::string::npos);
}

TEST_F(Scans, FormatsWithoutAPitchAreReadOnlyWhenNamed) {
  write_npy(scans() / "extra.npy", read_scan(scans() / "scan0.dat").surface);
  EXPECT_EQ(list_scans({scans()}).scans.size(), 3u);
  EXPECT_EQ(list_scans({scans() / "extra.npy"}).scans.size(), 1u);
}

}  // namespace
}  // namespace micro
