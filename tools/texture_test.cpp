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

TEST_F(TextureCommand, SaysWhatRanAndWhatWasLeftOutAndWhy) {
  const std::string out = file("out");
  // {stage: [ran, reason]} as --json has it; /plan of the file says the same.
  const auto plan_of = [&](const std::string& arguments) {
    const auto made = run("texture " + scans() + " -o " + out + " --json " + arguments);
    EXPECT_EQ(made.code, 0) << arguments;
    const nlohmann::json plan = nlohmann::json::parse(made.out).at("plan");
    EXPECT_EQ(nlohmann::json::parse(Hdf5Reader(out + "/texture.h5").read_text("/plan")), plan) << arguments;
    nlohmann::json stages;
    for (const auto& stage : plan)
      stages[stage.at("stage")] = {stage.at("ran"), stage.at("reason")};
    return stages;
  };
  using nlohmann::json;
  json plan = plan_of("--size 8x4 --seed 3");
  EXPECT_EQ(plan.at("layout"),
            json({true, "one strip along x, in the order of names, numbers in them counting as numbers"}));
  EXPECT_EQ(plan.at("texels"),
            json({true, "1 x 3 of 3 scans, 3 fits converged, 0 gaps, about 32 independent normals each"}));
  EXPECT_EQ(plan.at("common tilt").at(0), true);
  EXPECT_EQ(plan.at("shrinkage"),
            json({false,
                  "3 texels of fewer than 50 independent normals, but too few texels to "
                  "tell what is usual"}));
  EXPECT_EQ(
      plan.at("texture"),
      json(
          {true,
           "4 x 8 texels, joint from 1 strip along x and no strip along y, marginals exemplar, taper hann"}));
  EXPECT_EQ(plan.at("minification"), json({true, "4 levels, each texel refitted"}));
  plan = plan_of(
      "--layout 'r{row}_c{col}' --texel 5um --enough 9 --level plane --size 1 --recipe full --marginals "
      "gaussian --taper none");
  EXPECT_EQ(plan.at("layout").at(1), "by names, r{row}_c{col}");
  EXPECT_EQ(plan.at("common tilt"), json({false, "scans were levelled one by one"}));
  EXPECT_EQ(plan.at("shrinkage"),
            json({true, "48 texels of fewer than 9 independent normals drawn towards the mean"}));
  EXPECT_EQ(plan.at("texture").at(1), "1 x 1 texels, full from a block, marginals gaussian, taper none");
  EXPECT_EQ(plan.at("minification"), json({false, "one texel has no coarser level"}));
  plan = plan_of("--enough 0 --size 8 --no-levels");
  EXPECT_EQ(plan.at("shrinkage"), json({false, "every texel has 0 independent normals or more"}));
  EXPECT_EQ(plan.at("minification"), json({false, "--no-levels"}));
  plan = plan_of("--no-texture");
  EXPECT_EQ(plan.at("texture"), json({false, "--no-texture"}));
  EXPECT_FALSE(plan.contains("minification"));
}

TEST_F(TextureCommand, RefusesWhatMakesNoSense) {
  const std::string command = "texture " + scans() + " -o " + file("out");
  EXPECT_EQ(run(command + " --size 0").code, 2);
  EXPECT_EQ(run(command + " --size 12y4").code, 2);
  EXPECT_EQ(run(command + " --texel -3um").code, 2);
  EXPECT_EQ(run(command + " --recipe best").code, 2);
  EXPECT_EQ(run(command + " --enough nan").code, 2);
  EXPECT_EQ(run(command + " --seed -1").code, 2);
  EXPECT_EQ(run(command + " --layout 'x{row}'").code, 3);
  // One strip is no block, as the layout tells before a scan is read.
  const auto full = testing::run_program(testing::microbrdf(command + " --recipe full --progress 2>&1"));
  EXPECT_EQ(full.code, 3);
  EXPECT_NE(full.out.find("needs a block"), std::string::npos) << full.out;
  EXPECT_EQ(full.out.find("of 3 scans"), std::string::npos) << full.out;
  EXPECT_EQ(run(command + " --recipe full --texel 20um").code, 3);
  EXPECT_EQ(run(command + " --texel 1mm").code, 3);
  EXPECT_FALSE(std::filesystem::exists(file("out/texture.h5")));
  std::filesystem::resize_file(file("r0_c1.dat"), 3000);
  EXPECT_EQ(run(command + " --size 8").code, 1);
}

}  // namespace
}  // namespace micro::tools
