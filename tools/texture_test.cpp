// `microbrdf texture`, as people and programs call it.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "io/hdf5_reader.h"
#include "testing/run_program.h"
#include "testing/temporary_folder.h"

namespace micro::tools {
namespace {

class TextureCommand : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const char* name : {"r0_c0", "r0_c1", "r1_c0"})
      ASSERT_EQ(run("synth gaussian --rows 80 --cols 80 --pitch 0.25um --seed " +
                    std::to_string(name[1] + name[4]) + " -o " + file(std::string(name) + ".dat"))
                    .code,
                0);
  }
  testing::ProgramOutcome run(const std::string& arguments) const {
    return testing::run_program(testing::microbrdf(arguments + " 2>/dev/null"));
  }
  std::string file(const std::string& name) const { return (folder_.path() / name).string(); }
  std::string scans() const { return folder_.path().string(); }
  TemporaryFolder folder_;
};

TEST_F(TextureCommand, WritesTexelsTextureAndJson) {
  const std::string out = file("out");
  const auto made =
      run("texture " + scans() + " -o " + out + " --layout 'r{row}_c{col}' --texel 10um --size 20x12 --json");
  ASSERT_EQ(made.code, 0);
  const nlohmann::json json = nlohmann::json::parse(made.out);
  EXPECT_EQ(json.at("texels").at("rows"), 4);
  EXPECT_EQ(json.at("texels").at("cols"), 4);
  EXPECT_EQ(json.at("texels").at("fitted"), 12);
  EXPECT_EQ(json.at("texture").at("rows"), 12);
  EXPECT_EQ(json.at("texture").at("recipe"), "joint");
  EXPECT_GT(json.at("texture").at("coarsest").at("alpha_x").get<double>(), 0);
  for (const char* name : {"texture.h5", "texture.exr", "texture.png"})
    EXPECT_TRUE(std::filesystem::exists(out + "/" + name)) << name;
  const Hdf5Reader reader(out + "/texture.h5");
  reader.require_complete();
  EXPECT_EQ(reader.shape("/texture/parameters"), (Shape{12, 20, 5}));
  EXPECT_EQ(reader.shape("/texels/parameters"), (Shape{4, 4, 5}));
  // Its own outputs in the folder are no scans: the same again.
  EXPECT_EQ(run("texture " + scans() + " -o " + out + " --layout 'r{row}_c{col}' --no-texture").code, 0);
  EXPECT_FALSE(Hdf5Reader(out + "/texture.h5").contains("/texture"));
  EXPECT_FALSE(std::filesystem::exists(out + "/texture.exr"));
}

TEST_F(TextureCommand, RefusesWhatMakesNoSense) {
  const std::string command = "texture " + scans() + " -o " + file("out");
  EXPECT_EQ(run(command + " --size 0").code, 2);
  EXPECT_EQ(run(command + " --size 12y4").code, 2);
  EXPECT_EQ(run(command + " --texel -3um").code, 2);
  EXPECT_EQ(run(command + " --recipe best").code, 2);
  EXPECT_EQ(run(command + " --layout 'x{row}'").code, 3);
  EXPECT_EQ(run(command + " --recipe full").code, 3);  // one strip is no block
  EXPECT_EQ(run(command + " --texel 1mm").code, 3);
  EXPECT_FALSE(std::filesystem::exists(file("out/texture.h5")));
  std::filesystem::resize_file(file("r0_c1.dat"), 3000);
  EXPECT_EQ(run(command + " --size 8").code, 1);
}

}  // namespace
}  // namespace micro::tools
