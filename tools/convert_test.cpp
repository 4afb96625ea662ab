#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "io/scan.h"
#include "testing/run_program.h"
#include "testing/temporary_folder.h"

namespace micro::tools {
namespace {

using testing::run_program;
using Outcome = testing::ProgramOutcome;

class Convert : public ::testing::Test {
 protected:
  /// Its stdout and stderr together.
  Outcome convert(const std::string& arguments) const {
    return run_program(testing::microbrdf("convert " + arguments + " 2>&1"));
  }
  std::string file(const std::string& name) const { return (folder.path() / name).string(); }
  std::string text_scan() const {
    std::ofstream(file("scan.txt")) << "1 2 3\n4 nan 6\n";
    return file("scan.txt");
  }
  TemporaryFolder folder;
};

TEST_F(Convert, GoesRoundThroughEveryFormat) {
  std::string from = text_scan() + " --pitch 250nm";
  for (const char* name : {"a.h5", "a.dat", "a.x3p", "b.h5", "a.npy"}) {
    const Outcome outcome = convert(from + " -o " + file(name));
    EXPECT_EQ(outcome.code, 0) << outcome.out;
    from = file(name);
  }
  const Scan scan = read_scan(file("a.npy"), {.pitch_x = 0.25, .pitch_y = {}});
  ASSERT_EQ(scan.surface.rows(), 2);
  ASSERT_EQ(scan.surface.cols(), 3);
  constexpr float tolerance = 1e-6F;
  EXPECT_NEAR(scan.surface.z(1, 2) - scan.surface.z(0, 0), 5, tolerance);
  EXPECT_TRUE(is_missing(scan.surface.z(1, 1)));
  EXPECT_NEAR(read_scan(file("a.dat")).surface.dx, 0.25, tolerance);
}

TEST_F(Convert, JsonSaysWhatWasDone) {
  const Outcome outcome = convert(text_scan() + " --pitch 250nm,1um --json -o " + file("a.h5"));
  ASSERT_EQ(outcome.code, 0) << outcome.out;
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(json["format"], "text");
  EXPECT_EQ(json["output_format"], "microbrdf-hdf5");
  EXPECT_EQ(json["rows"], 2);
  EXPECT_EQ(json["cols"], 3);
  EXPECT_EQ(json["dx_um"], 0.25);
  EXPECT_EQ(json["dy_um"], 1);
  EXPECT_EQ(json["missing"], 1);
}

TEST_F(Convert, SaysThatNpyDropsThePitch) {
  EXPECT_NE(convert(text_scan() + " --pitch 0.25 -o " + file("a.npy")).out.find("--pitch 0.25um,0.25um"),
            std::string::npos);
}

TEST_F(Convert, RefusesWithTheRightCode) {
  const std::string scan = text_scan();
  EXPECT_EQ(convert(scan + " -o " + file("a.h5")).code, 3) << "no pitch";
  EXPECT_EQ(convert(scan + " --pitch 1um -o " + file("a.xyz")).code, 2) << "no such format";
  EXPECT_EQ(convert(scan + " --pitch 0 -o " + file("a.h5")).code, 2);
  EXPECT_EQ(convert(scan + " --pitch 1,2,3 -o " + file("a.h5")).code, 2);
  EXPECT_EQ(convert(file("none") + " -o " + file("a.h5")).code, 3);
  EXPECT_EQ(convert(scan + " --pitch 1um,2um -o " + file("a.dat")).code, 3) << "one pitch for both axes";
  EXPECT_EQ(convert(scan).code, 2);
  ASSERT_EQ(convert(scan + " --pitch 1um -o " + file("a.npy")).code, 0);
  const Outcome itself = convert(file("a.npy") + " --pitch 1um -o " + file("a.npy"));
  EXPECT_EQ(itself.code, 3);
  EXPECT_NE(itself.out.find("never overwritten"), std::string::npos) << itself.out;
  // Nothing half-done stays behind.
  std::size_t files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder.path()))
    ++files;
  EXPECT_EQ(files, 2u);
}

}  // namespace
}  // namespace micro::tools
