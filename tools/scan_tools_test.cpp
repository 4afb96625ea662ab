// `microbrdf synth` and `microbrdf info` as people and programs call them.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <tuple>

#include "io/scan.h"
#include "testing/run_program.h"
#include "testing/temporary_folder.h"

namespace micro::tools {
namespace {

using testing::run_program;

class ScanTools : public ::testing::Test {
 protected:
  struct Outcome {
    int code;
    std::string out;  ///< stdout
    std::string err;  ///< stderr
  };
  Outcome run(const std::string& arguments) const {
    const auto [code, out] = run_program(testing::microbrdf(arguments + " 2>" + file("err")));
    return {code, out, content("err")};
  }
  std::string file(const std::string& name) const { return (folder.path() / name).string(); }
  std::string content(const std::string& name) const {
    std::ifstream in(file(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  TemporaryFolder folder;
};

constexpr const char* kSmall = " --rows 30 --cols 40 ";

TEST_F(ScanTools, SynthMakesEveryKindInEveryFormat) {
  for (const char* kind : {"gaussian", "multiscale", "brushed", "sinusoid", "blazed", "two-level", "plane",
                           "step", "facet --side 1um"})
    for (const char* name : {"a.dat", "a.h5", "a.npy"}) {
      const Outcome made = run(std::string("synth ") + kind + kSmall + "-o " + file(name));
      ASSERT_EQ(made.code, 0) << kind << made.err;
      const Scan scan = read_scan(file(name), {.pitch_x = 0.11, .pitch_y = {}});
      EXPECT_EQ(scan.surface.rows(), 30);
      EXPECT_EQ(scan.surface.cols(), 40);
      EXPECT_NEAR(scan.surface.dx, 0.11, 1e-8);  // .dat keeps it as float
    }
}

TEST_F(ScanTools, StudiesNameTheScansThatFail) {
  std::filesystem::create_directory(file("scans"));
  const std::string whole = file("scans/a.dat"), torn = file("scans/torn.dat");
  ASSERT_EQ(run("synth gaussian --tau 1" + std::string(kSmall) + "-o " + whole).code, 0);
  std::filesystem::copy_file(whole, torn);
  std::filesystem::resize_file(torn, 1000);
  for (const char* study : {"sigma --sigma 1", "filters"}) {
    const std::string arguments = std::string("study ") + study + " -o " + file("study") + " ";
    const Outcome some = run(arguments + "--json " + file("scans"));
    EXPECT_EQ(some.code, 1) << some.err;
    EXPECT_NE(some.err.find("torn.dat"), std::string::npos) << some.err;
    const auto summary = nlohmann::json::parse(some.out);
    EXPECT_EQ(summary["failed"].at(0)["source"], "torn.dat");
    EXPECT_FALSE(summary["rows"].empty());
    const Outcome none = run(arguments + file("nowhere.dat"));
    EXPECT_EQ(none.code, 3) << none.err;
    EXPECT_NE(none.err.find("nowhere.dat: does not exist"), std::string::npos) << none.err;
  }
}

TEST_F(ScanTools, SynthTakesOnlyWhatAppliesToItsKind) {
  for (const char* wrong :
       {"gaussian --depth 1um", "plane --periodic", "step --rms 1um", "sinusoid --tau 1um",
        "gaussian --tau 1 --tau-x 2 --tau-y 3", "gaussian --tau-x 2", "gaussian --tau 2 --orientation 1deg",
        "blazed --depth 1 --blaze 3deg", "wavy", ""}) {
    const Outcome outcome = run(std::string("synth ") + wrong + kSmall + "-o " + file("a.dat"));
    EXPECT_EQ(outcome.code, 2) << wrong << outcome.err;
    EXPECT_FALSE(std::filesystem::exists(file("a.dat")));
  }
  for (const char* wrong : {"gaussian --pitch 0", "gaussian --pitch -1um", "gaussian -o a.xyz"})
    EXPECT_EQ(run(std::string("synth ") + wrong +
                  (std::string(wrong).ends_with("xyz") ? "" : " -o " + file("a.dat")))
                  .code,
              2)
        << wrong;
  for (const char* wrong : {"gaussian --rows 0", "gaussian --tau 0", "gaussian --holes 1.5",
                            "brushed --width 0", "facet --side 1nm", "sinusoid --period 0.7um --periodic",
                            "plane --tilt-x 90deg", "facet --tilt-y 100deg", "blazed --blaze 91deg"}) {
    const Outcome outcome = run(std::string("synth ") + wrong + " -o " + file("a.dat"));
    EXPECT_EQ(outcome.code, 2) << wrong << outcome.err;
    EXPECT_FALSE(outcome.err.empty());
  }
}

TEST_F(ScanTools, SynthDependsOnTheSeedAlone) {
  const std::string common = std::string("synth brushed --holes 0.05 --hole-radius 0.3um") + kSmall;
  ASSERT_EQ(run(common + "--seed 7 --threads 1 -o " + file("a.dat")).code, 0);
  ASSERT_EQ(run(common + "--seed 7 --threads 3 -o " + file("b.dat")).code, 0);
  ASSERT_EQ(run(common + "--seed 8 -o " + file("c.dat")).code, 0);
  EXPECT_EQ(content("a.dat"), content("b.dat"));
  EXPECT_NE(content("a.dat"), content("c.dat"));
}

TEST_F(ScanTools, TheFixturesAreWhatTheirRecipeMakes) {
  const std::string testdata = MICRO_SOURCE_DIR "/testdata";
  ASSERT_EQ(
      std::system(
          (testdata + "/make.sh " MICROBRDF_PROGRAM " " + folder.path().string() + " >/dev/null").c_str()),
      0);
  int fixtures = 0;
  for (const auto& entry : std::filesystem::directory_iterator(testdata)) {
    if (entry.path().extension() != ".dat") continue;
    ++fixtures;
    std::ifstream in(entry.path(), std::ios::binary);
    EXPECT_EQ(content(entry.path().filename().string()), std::string(std::istreambuf_iterator<char>(in), {}))
        << entry.path();
  }
  EXPECT_EQ(fixtures, 4);
}

TEST_F(ScanTools, InfoSaysWhatItMeasures) {
  ASSERT_EQ(run("synth plane --tilt-x 10deg --pitch 0.2um,0.1um --holes 0.1" + std::string(kSmall) + "-o " +
                file("a.h5"))
                .code,
            0);
  const Outcome outcome = run("info --json --level none " + file("a.h5"));
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto scan = nlohmann::json::parse(outcome.out)["scans"][0];
  EXPECT_EQ(scan["source"], file("a.h5"));
  EXPECT_EQ(scan["format"], "microbrdf-hdf5");
  EXPECT_EQ(scan["rows"], 30);
  EXPECT_EQ(scan["cols"], 40);
  EXPECT_NEAR(scan["dx_um"], 0.2, 1e-12);
  EXPECT_NEAR(scan["dy_um"], 0.1, 1e-12);
  EXPECT_GT(scan["missing"], 50);
  EXPECT_LT(scan["missing"], 200);
  const double slope = std::tan(10 * 3.14159265358979 / 180);
  constexpr double kFloat = 1e-5;
  EXPECT_NEAR(scan["Sdq"], slope, kFloat);
  EXPECT_NEAR(scan["Sdr"], std::sqrt(1 + slope * slope) - 1, kFloat);
  EXPECT_NEAR(scan["max_um"].get<double>() - scan["min_um"].get<double>(), slope * 39 * 0.2, kFloat);
  EXPECT_NEAR(scan["Sz_um"], slope * 39 * 0.2, kFloat);
  EXPECT_TRUE(scan["direction_rad"].is_null());
  for (const char* key : {"mean_um", "rms_um", "Sq_um", "Sa_um", "Ssk", "Sku", "Sal_um", "Str",
                          "tau_along_um", "tau_across_um"})
    EXPECT_TRUE(scan.contains(key)) << key;
  EXPECT_FALSE(scan.contains("filled"));
}

TEST_F(ScanTools, InfoLevelsAPlaneByDefaultAndReportsRepairs) {
  ASSERT_EQ(run("synth plane --tilt-x 10deg --holes 0.1" + std::string(kSmall) + "-o " + file("a.h5")).code,
            0);
  const auto scan = nlohmann::json::parse(
      run("info --json --fill-holes --reject-outliers " + file("a.h5")).out)["scans"][0];
  EXPECT_LE(scan["Sq_um"].get<double>(), 1e-6);
  EXPECT_EQ(scan["filled"], scan["missing"]);
  EXPECT_EQ(scan["rejected"], 0);
  EXPECT_GT(scan["rms_um"], 0.1);  // as in the file
}

TEST_F(ScanTools, InfoGoesOnAfterABadFile) {
  ASSERT_EQ(run("synth step" + std::string(kSmall) + "-o " + file("good.dat")).code, 0);
  std::ofstream(file("bad.dat")) << "this is no scan";
  Outcome outcome = run("info " + file("bad.dat") + " " + file("good.dat") + " " + file("none.dat"));
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.err.find("bad.dat"), std::string::npos);
  EXPECT_NE(outcome.err.find("none.dat"), std::string::npos);
  EXPECT_NE(outcome.out.find("good.dat"), std::string::npos);
  outcome = run("info --json " + file("bad.dat") + " " + file("good.dat"));
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(json["scans"].size(), 1u);
  EXPECT_EQ(json["failed"][0]["source"], file("bad.dat"));
  EXPECT_EQ(run("info " + file("bad.dat")).code, 3);
  EXPECT_EQ(run("info").code, 2);
}

TEST_F(ScanTools, WhatIsSaidOfAFileIsOneLineWhateverItsName) {
  const std::string name = "a\n\033[31mb\xFF.dat";
  std::ofstream(file(name)) << "\x88\x1B\x03\x6F";
  const std::string argument = "\"$(printf '" + folder.path().string() + "/a\\n\\033[31mb\\377.dat')\"";
  for (const std::string& command : {"info " + argument, "info " + folder.path().string(),
                                     "convert " + argument + " -o " + file("b.npy")}) {
    const Outcome outcome = run(command);
    EXPECT_EQ(outcome.code, 3) << command;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_NE(outcome.err.find("a??[31mb\xFF.dat: is shorter"), std::string::npos) << outcome.err;
  }
}

TEST_F(ScanTools, InfoTakesFolders) {
  std::filesystem::create_directories(folder.path() / "deep" / "deeper");
  EXPECT_EQ(run("info " + file("deep")).code, 3);
  ASSERT_EQ(run("synth step" + std::string(kSmall) + "-o " + file("deep/deeper/good.dat")).code, 0);
  std::ofstream(file("deep/readme.txt")) << "no scan";
  const auto json = nlohmann::json::parse(run("info --json " + file("deep")).out);
  ASSERT_EQ(json["scans"].size(), 1u);
  EXPECT_EQ(json["scans"][0]["source"], file("deep/deeper/good.dat"));
  EXPECT_EQ(json["skipped"][0]["source"], "readme.txt");
}

TEST_F(ScanTools, JsonIsThereHoweverARunEnds) {
  ASSERT_EQ(run("synth step" + std::string(kSmall) + "-o " + file("a.dat")).code, 0);
  ASSERT_EQ(run("synth step --pitch 1um" + std::string(kSmall) + "-o " + file("b.dat")).code, 0);
  const std::string both = file("a.dat") + " " + file("b.dat");
  for (const auto& [arguments, code, failed] :
       {std::tuple{"ndf " + both + " -o " + file("x.h5"), 3, 2},
        std::tuple{"ndf " + file("none.dat") + " -o " + file("x.h5"), 3, 1},
        std::tuple{"convert " + file("none.dat") + " -o " + file("x.h5"), 3, 1},
        std::tuple{"ndf " + file("a.dat") + " -o " + file("nowhere/x.h5"), 3, 1},
        std::tuple{"ndf --tol 0.1 " + file("a.dat") + " -o " + file("x.h5"), 2, 0},
        std::tuple{std::string("ndf"), 2, 0}, std::tuple{std::string("nfd"), 2, 0}}) {
    const Outcome outcome = run(arguments + " --json");
    EXPECT_EQ(outcome.code, code) << arguments << outcome.err;
    const auto json = nlohmann::json::parse(outcome.out, nullptr, false);
    ASSERT_FALSE(json.is_discarded()) << arguments << outcome.out;
    EXPECT_EQ(json["failed"].size(), static_cast<std::size_t>(failed)) << arguments << outcome.out;
    EXPECT_FALSE(std::filesystem::exists(file("x.h5")));
  }
}

TEST_F(ScanTools, AnOptionThatNothingUsesIsRefused) {
  ASSERT_EQ(run("synth step" + std::string(kSmall) + "-o " + file("scans.dat")).code, 0);
  for (const char* idle :
       {"ndf --method naive --sigma 2um", "ndf --tol 0.1", "ndf --lambda-q 500nm", "ndf --coherence 50",
        "run --without kirchhoff --lambda 500nm", "run --without filtered --sigma 1um"}) {
    const Outcome outcome = run(std::string(idle) + " " + file("scans.dat") + " -o " + file("x"));
    EXPECT_EQ(outcome.code, 2) << idle << outcome.err;
    EXPECT_NE(outcome.err.find("not computed here"), std::string::npos) << outcome.err;
  }
}

TEST_F(ScanTools, OptionsTakeNoScanForTheirValue) {
  ASSERT_EQ(run("synth step" + std::string(kSmall) + "-o " + file("a.npy")).code, 0);
  const std::string scans = " " + file("a.npy") + " " + file("a.npy");
  EXPECT_EQ(run("info --pitch 0.1" + scans).code, 0);
  EXPECT_EQ(run("info --pitch 0.1,0.2" + scans).code, 0);
  EXPECT_EQ(run("info --pitch 0.1,0.2,0.3" + scans).code, 2);
  const Outcome outcome =
      run("run --pitch 0.1 --without naive,kirchhoff,pictures " + file("a.npy") + " -o " + file("out"));
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(run("ndf --pitch 0.1 --method naive" + scans + " -o " + file("x.h5")).code, 0);
}

TEST_F(ScanTools, AnUnknownSubcommandIsToldWhichThereAre) {
  EXPECT_NE(run("nfd").err.find("'nfd' is no subcommand of microbrdf; there are run, info"),
            std::string::npos);
  EXPECT_NE(run("synth wavy").err.find("'wavy' is no subcommand of synth; there are gaussian"),
            std::string::npos);
}

TEST_F(ScanTools, InfoOfNothingButHolesIsNull) {
  ASSERT_EQ(run("synth plane --holes 1" + std::string(kSmall) + "-o " + file("a.h5")).code, 0);
  const auto json = nlohmann::json::parse(run("info --json " + file("a.h5")).out);
  EXPECT_TRUE(json["scans"][0]["Sq_um"].is_null());
  EXPECT_TRUE(json["scans"][0]["min_um"].is_null());
  EXPECT_EQ(run("info --fill-holes " + file("a.h5")).code, 3);
}

}  // namespace
}  // namespace micro::tools
