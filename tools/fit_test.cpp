// `microbrdf fit`, and the stage of `microbrdf run`, as people and programs call them.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "distribution/ellipsoid.h"
#include "distribution/tabulate.h"
#include "io/hdf5_reader.h"
#include "testing/run_program.h"
#include "testing/temporary_folder.h"

namespace micro::tools {
namespace {

using testing::run_program;
using Outcome = testing::ProgramOutcome;

class FitCommand : public ::testing::Test {
 protected:
  Outcome run(const std::string& arguments) const {
    return run_program(testing::microbrdf(arguments + " 2>/dev/null"));
  }
  std::string file(const std::string& name) const { return (folder_.path() / name).string(); }
  TemporaryFolder folder_;
};

TEST_F(FitCommand, WritesFitsFiguresAndJson) {
  {
    const DiskTable table = tabulate(Ellipsoid(slope_frame({0.3, 0.1, 0.05, -0.1, 0.4})), {129, 0.9});
    Hdf5Writer writer(file("a.h5"));
    writer.write("/ndf/mine/density", table.density);
    writer.set_attribute("/ndf/mine", "extent", 0.9);
    writer.finish();
  }
  const Outcome made = run("fit --json " + file("a.h5"));
  ASSERT_EQ(made.code, 0);
  const nlohmann::json json = nlohmann::json::parse(made.out);
  EXPECT_EQ(json.at("output"), file("a.h5"));
  const nlohmann::json fit = json.at("fits").at(0);
  EXPECT_EQ(fit.at("method"), "mine");
  EXPECT_EQ(fit.at("model"), "ellipsoid");
  EXPECT_EQ(fit.at("status"), "converged");
  EXPECT_NEAR(fit.at("alpha_x").get<double>(), 0.3, 1e-6);
  EXPECT_NEAR(fit.at("alpha_y").get<double>(), 0.1, 1e-6);
  EXPECT_NEAR(fit.at("theta_x").get<double>(), 0.05, 1e-6);
  EXPECT_NEAR(fit.at("theta_y").get<double>(), -0.1, 1e-6);
  EXPECT_NEAR(fit.at("theta_z").get<double>(), 0.4, 1e-6);
  EXPECT_LE(fit.at("rel_rms").get<double>(), 1e-5);
  EXPECT_GT(fit.at("iterations").get<int>(), 0);
  EXPECT_TRUE(std::filesystem::exists(file("a_fit_mine.png")));
  EXPECT_TRUE(Hdf5Reader(file("a.h5")).is_group("/fit/mine/beckmann"));

  EXPECT_EQ(run("fit --no-figure --weighting log -o " + file("b.h5") + " " + file("a.h5")).code, 0);
  EXPECT_TRUE(std::filesystem::exists(file("b.h5")));
  EXPECT_FALSE(std::filesystem::exists(file("b_fit_mine.png")));
  EXPECT_EQ(run("fit " + file("missing.h5")).code, 3);
  EXPECT_EQ(run("fit --weighting cubic " + file("a.h5")).code, 2);
}

// The file stays as it is, byte for byte, and none is made beside it.
TEST_F(FitCommand, NothingFittedWritesNothing) {
  {
    Grid<double> density = Grid<double>::Ones(33, 33);
    density(16, 16) = NAN;
    Hdf5Writer writer(file("a.h5"));
    writer.write("/ndf/mine/density", density);
    writer.set_attribute("/ndf/mine", "extent", 0.9);
    writer.create_group("/fit/mine/ellipsoid");
    writer.set_attribute("/fit/mine/ellipsoid", "alpha_x", 0.25);
    writer.finish();
  }
  EXPECT_EQ(run("fit " + file("a.h5")).code, 3);
  EXPECT_EQ(run("fit -o " + file("b.h5") + " " + file("a.h5")).code, 3);
  EXPECT_FALSE(std::filesystem::exists(file("b.h5")));
  EXPECT_EQ(Hdf5Reader(file("a.h5")).number_attribute("/fit/mine/ellipsoid", "alpha_x"), 0.25);
}

TEST_F(FitCommand, IsAStageOfRun) {
  std::filesystem::create_directory(file("scans"));
  ASSERT_EQ(run("synth gaussian --rows 60 --cols 60 -o " + file("scans/a.dat")).code, 0);
  const std::string common =
      "run " + file("scans") + " -o " + file("with") + " --json --size 129 --without kirchhoff";
  const Outcome with = run(common);
  ASSERT_EQ(with.code, 0);
  EXPECT_TRUE(Hdf5Reader(file("with/result.h5")).is_group("/fit/filtered/ellipsoid"));
  EXPECT_TRUE(std::filesystem::exists(file("with/fit_filtered.png")));
  ASSERT_EQ(run(common + ",fit").code, 0);
  EXPECT_FALSE(Hdf5Reader(file("with/result.h5")).contains("/fit"));
  EXPECT_FALSE(std::filesystem::exists(file("with/fit_filtered.png")));
  const auto plan = nlohmann::json::parse(Hdf5Reader(file("with/result.h5")).read_text("/plan"));
  bool told = false;
  for (const auto& stage : plan)
    told = told || (stage.at("stage") == "fit" && stage.at("ran") == false);
  EXPECT_TRUE(told);
}

TEST_F(FitCommand, RunFitsEveryWavelengthAsFitDoes) {
  std::filesystem::create_directory(file("scans"));
  ASSERT_EQ(run("synth gaussian --rows 60 --cols 60 -o " + file("scans/a.dat")).code, 0);
  ASSERT_EQ(run("run " + file("scans") + " -o " + file("out") +
                " --size 65 --lambda-q 0.5..0.6/0.05 --without naive,filtered,pictures")
                .code,
            0);
  ASSERT_EQ(run("fit --no-figure -o " + file("again.h5") + " " + file("out/result.h5")).code, 0);
  const Hdf5Reader ran(file("out/result.h5")), again(file("again.h5"));
  constexpr double kFloat = 1e-3;  // widths; the file's tables are float32
  for (const std::string wavelength : {"0.5um", "0.55um", "0.6um"})
    for (const std::string model : {"/ellipsoid", "/beckmann"}) {
      const std::string group = "/fit/kirchhoff_spectrum_" + wavelength + model;
      ASSERT_TRUE(ran.contains(group)) << group;
      const double alpha = ran.number_attribute(group, "alpha_x");
      EXPECT_NEAR(again.number_attribute(group, "alpha_x"), alpha, kFloat * alpha);
    }
}

}  // namespace
}  // namespace micro::tools
