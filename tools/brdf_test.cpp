// `microbrdf brdf`, as people and programs call it.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "brdf/microfacet.h"
#include "distribution/ellipsoid.h"
#include "distribution/tabulate.h"
#include "io/hdf5_reader.h"
#include "pipelines/brdf_model.h"
#include "testing/run_program.h"
#include "testing/temporary_folder.h"

namespace micro::tools {
namespace {

using testing::run_program;

class BrdfCommand : public ::testing::Test {
 protected:
  testing::ProgramOutcome run(const std::string& arguments) const {
    return run_program(testing::microbrdf("brdf " + arguments + " 2>/dev/null"));
  }
  std::string file(const std::string& name) const { return (folder_.path() / name).string(); }

  /// Tables of GGX: /ndf/filtered, and /ndf/kirchhoff_spectrum at two wavelengths.
  void write_tables(const std::string& name) const {
    const DiskTable table = tabulate(ggx(0.3), {257, 1});
    Hdf5Writer writer(file(name));
    writer.write("/ndf/filtered/density", table.density);
    writer.set_attribute("/ndf/filtered", "extent", 1.0);
    const Grid<float> slice = table.density.cast<float>();
    writer.write_slices("/ndf/kirchhoff_spectrum/density", {2, 257, 257}, 0,
                        [&](std::size_t) { return slice; });
    const std::vector<double> lambda_q = {0.4, 0.8};
    writer.write<double>("/ndf/kirchhoff_spectrum/lambda_q_um", lambda_q, {2});
    writer.set_attribute("/ndf/kirchhoff_spectrum", "extent", 1.0);
    writer.finish();
  }
  TemporaryFolder folder_;
};

TEST_F(BrdfCommand, WritesAModelsSlicesAlbedoColourAndFurnace) {
  const auto made =
      run("--alpha 0.3,0.1 --material Cu --wi 30deg --lambda 550nm --albedo --spectrum 8 --furnace "
          "--tol 5e-3 --json -o " +
          file("a.h5"));
  ASSERT_EQ(made.code, 0);
  const nlohmann::json json = nlohmann::json::parse(made.out);
  EXPECT_LE(json.at("furnace_most").get<double>(), 1);
  EXPECT_LE(json.at("reciprocity").get<double>(), 1e-12);
  EXPECT_GT(json.at("linear_srgb").at(0).get<double>(), json.at("linear_srgb").at(2).get<double>());
  EXPECT_LE(json.at("albedo").at(0).at("error").get<double>(), 5e-3);
  for (const char* name : {"a_slices.csv", "a_albedo.csv", "a_spectrum.csv", "a_slice0.png"})
    EXPECT_TRUE(std::filesystem::exists(file(name))) << name;

  const Hdf5Reader reader(file("a.h5"));
  const auto theta = reader.read<double>("/brdf/slice0/theta_o");
  const auto f = reader.read<double>("/brdf/slice0/f");
  const Microfacet model(gtr2_anisotropic(0.3, 0.1), material("Cu"));
  const std::size_t k = 1100;
  const double s = std::sin(reader.number_attribute("/brdf/slice0", "theta_i"));
  const Vec3 wi(s, 0, std::sqrt(1 - s * s)), wo(-std::sin(theta[k]), 0, std::cos(theta[k]));
  EXPECT_NEAR(f[k] / model.f(wi, wo, 0.55), 1, 1e-6);
}

TEST_F(BrdfCommand, ReadsTablesOfAResult) {
  write_tables("r.h5");
  const std::string common = " --wi 40deg --lambda 500nm --no-figure -o " + file("o.h5");
  const Microfacet model(ggx(0.3));
  for (const std::string distribution : {"filtered", "kirchhoff_spectrum"}) {
    ASSERT_EQ(run(file("r.h5") + " --distribution " + distribution + common).code, 0);
    const Hdf5Reader reader(file("o.h5"));
    const auto f = reader.read<double>("/brdf/slice0/f"), theta = reader.read<double>("/brdf/slice0/theta_o");
    const double t = reader.number_attribute("/brdf/slice0", "theta_i");
    const std::size_t k = 1250;
    const Vec3 wi(std::sin(t), 0, std::cos(t)), wo(-std::sin(theta[k]), 0, std::cos(theta[k]));
    EXPECT_NEAR(f[k] / model.f(wi, wo, 0.5), 1, 0.01) << distribution;  // of a table of 257²
  }
}

TEST_F(BrdfCommand, RefusesWhatMakesNoSense) {
  write_tables("r.h5");
  const std::string out = " -o " + file("o.h5");
  EXPECT_EQ(run("--alpha 0.2" + out).code, 2);  // nothing asked for
  EXPECT_EQ(run("--wi 30deg" + out).code, 2);   // no model
  EXPECT_EQ(run("--alpha 0.2 --wi 90deg" + out).code, 2);
  EXPECT_EQ(run("--alpha x --wi 30deg" + out).code, 2);
  EXPECT_EQ(run("--alpha 0.2 --wi 30deg --material Xx" + out).code, 3);
  EXPECT_EQ(run("--alpha 0.2 --wi 30deg --lambda 2um --material Cu" + out).code,
            3);  // beyond the metal's table
  EXPECT_EQ(run(file("r.h5") + " --distribution naive --wi 30deg" + out).code, 3);      // not in the file
  EXPECT_EQ(run(file("r.h5") + " --distribution ellipsoid --wi 30deg" + out).code, 3);  // not fitted
  EXPECT_EQ(run(file("r.h5") + " --alpha 0.2 --wi 30deg" + out).code, 2);
  EXPECT_FALSE(std::filesystem::exists(file("o.h5")));
}

}  // namespace
}  // namespace micro::tools
