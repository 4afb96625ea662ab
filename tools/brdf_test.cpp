// `microbrdf brdf`, as people and programs call it.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>
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

constexpr double kDegree = std::numbers::pi / 180, kFloat = 1e-6;

/// A slice of a file holds the model's f: wo from its angles, in the plane that its attributes name.
void expect_slice(const std::string& slice, const std::string& path, const AnyBrdf& model, double lambda_um,
                  double tolerance = kFloat) {
  const Hdf5Reader reader(path);
  const auto f = reader.read<double>(slice + "/f"), theta = reader.read<double>(slice + "/theta_o");
  const double theta_i = reader.number_attribute(slice, "theta_i"),
               phi_i = reader.number_attribute(slice, "phi_i"),
               phi_o = phi_i + std::numbers::pi + reader.number_attribute(slice, "plane");
  const auto direction = [](double t, double phi) {
    return Vec3(std::sin(t) * std::cos(phi), std::sin(t) * std::sin(phi), std::cos(t));
  };
  for (const std::size_t k : {700u, 1100u, 1250u}) {  // 20 degrees back, 20 and 35 forwards
    const double expected = model.f(direction(theta_i, phi_i), direction(theta[k], phi_o), lambda_um);
    EXPECT_NEAR(f[k] / expected, 1, tolerance) << path << ' ' << slice << ' ' << theta[k];
  }
}

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
  EXPECT_EQ(json.at("furnace_directions"), 37);
  EXPECT_EQ(json.at("furnace_not_reached"), 0);
  EXPECT_LE(json.at("reciprocity").get<double>(), 1e-12);
  EXPECT_GT(json.at("linear_srgb").at(0).get<double>(), json.at("linear_srgb").at(2).get<double>());
  EXPECT_LE(json.at("albedo").at(0).at("error").get<double>(), 5e-3);
  for (const char* name : {"a_slices.csv", "a_albedo.csv", "a_spectrum.csv", "a_slice0.png"})
    EXPECT_TRUE(std::filesystem::exists(file(name))) << name;

  expect_slice("/brdf/slice0", file("a.h5"), AnyBrdf(Microfacet(gtr2_anisotropic(0.3, 0.1), material("Cu"))),
               0.55);
}

TEST_F(BrdfCommand, ReadsTablesOfAResult) {
  write_tables("r.h5");
  const std::string common = " --wi 40deg --lambda 500nm --no-figure -o " + file("o.h5");
  const AnyBrdf model(Microfacet(ggx(0.3)));
  for (const std::string distribution : {"filtered", "kirchhoff_spectrum"}) {
    ASSERT_EQ(run(file("r.h5") + " --distribution " + distribution + common).code, 0);
    expect_slice("/brdf/slice0", file("o.h5"), model, 0.5, 0.01);  // of a table of 257²
  }
}

TEST_F(BrdfCommand, HasSunsModelAndTheCoatCorrectedAndPrinted) {
  const Fresnel copper = under(material("Cu"), 1.4);
  const Coat coat{1.4, 30};
  const SunForm printed = SunForm::AsPrinted;
  const std::vector<std::pair<std::string, AnyBrdf>> cases = {
      {"--model sun --smoothness 5", AnyBrdf(SunReflection(5, material("Cu")))},
      {"--model sun --smoothness 5 --form printed", AnyBrdf(SunReflection(5, material("Cu"), printed))},
      {"--alpha 0.3,0.1 --coat 1.4 --coat-smoothness 30",
       AnyBrdf(Coated(Microfacet(gtr2_anisotropic(0.3, 0.1), copper), coat))},
      {"--model sun --smoothness 5 --coat 1.4 --coat-smoothness 30 --form printed",
       AnyBrdf(Coated(SunReflection(5, copper, printed), coat, printed))}};
  for (const auto& [arguments, model] : cases) {
    ASSERT_EQ(run(arguments + " --material Cu --wi 30deg --lambda 550nm --no-figure -o " + file("s.h5")).code,
              0)
        << arguments;
    expect_slice("/brdf/slice0", file("s.h5"), model, 0.55);
  }
}

TEST_F(BrdfCommand, TakesARangeOfWavelengths) {
  ASSERT_EQ(
      run("--alpha 0.2 --lambda 380nm --lambda 400nm..700nm/20nm --wi 45deg --no-figure -o " + file("o.h5"))
          .code,
      0);
  const auto lambda = Hdf5Reader(file("o.h5")).read<double>("/brdf/lambda_um");
  ASSERT_EQ(lambda.size(), 17u);
  for (std::size_t k = 0; k < lambda.size(); ++k)
    EXPECT_NEAR(lambda[k], 0.38 + 0.02 * static_cast<double>(k), 1e-9);
}

TEST_F(BrdfCommand, SlicesLieInThePlaneAskedFor) {
  ASSERT_EQ(run("--alpha 0.3,0.1 --wi 30deg --azimuth 20deg --plane 0 --plane 70deg --lambda 550nm -o " +
                file("p.h5"))
                .code,
            0);
  const AnyBrdf model(Microfacet(gtr2_anisotropic(0.3, 0.1)));
  expect_slice("/brdf/slice0", file("p.h5"), model, 0.55);
  expect_slice("/brdf/slice1", file("p.h5"), model, 0.55);
  const Hdf5Reader reader(file("p.h5"));
  EXPECT_NEAR(reader.number_attribute("/brdf/slice1", "plane"), 70 * kDegree, 1e-12);
  EXPECT_NE(reader.text_attribute("/", "command").find("--plane 0 --plane 70deg"), std::string::npos);
}

/// Light along the normal has no plane of incidence of its own: --azimuth names it.
TEST_F(BrdfCommand, SlicesOfLightAlongTheNormalLieInThePlaneOfItsAzimuth) {
  ASSERT_EQ(run("--alpha 0.3,0.1 --theta 10deg,-15deg --wi 0 --azimuth 20deg --plane 0 --plane 70deg "
                "--lambda 550nm -o " +
                file("n.h5"))
                .code,
            0);
  const AnyBrdf model(Microfacet(Ellipsoid(slope_frame({0.3, 0.1, 10 * kDegree, -15 * kDegree}))));
  for (const std::string slice : {"/brdf/slice0", "/brdf/slice1"}) {
    EXPECT_NEAR(Hdf5Reader(file("n.h5")).number_attribute(slice, "phi_i"), 20 * kDegree, 1e-12);
    expect_slice(slice, file("n.h5"), model, 0.55);
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
  for (const char* arguments :
       {"--model sun", "--smoothness 5", "--model sun --smoothness 0",
        "--model sun --smoothness 5 --alpha 0.2", "--model kirchhoff", "--alpha 0.2 --coat 0.9",
        "--alpha 0.2 --coat-smoothness 5", "--alpha 0.2 --form printed", "--alpha 0.2 --plane x",
        "--alpha 0.2 --masking none", "--alpha 0.2 --fit-of filtered", "--alpha 0.2 --lambda=-1",
        "--alpha 0.2 --lambda 0.4..0.5", "--alpha 0.2 --lambda 0.5..0.4/0.1",
        "--alpha 0.2 --lambda 0.4..0.6/0.1 --lambda 0.6", "--alpha 0.2 --lambda 650nm --lambda 450nm",
        "--alpha 0.2 --tol nan --albedo", "--model sun --smoothness 5 --masking smith",
        "--alpha 0.2 --phi-h 10deg"})
    EXPECT_EQ(run(arguments + (" --wi 30deg" + out)).code, 2) << arguments;
  EXPECT_EQ(run("--alpha 0.2 --plane 10deg --furnace" + out).code, 2);  // of which light?
  EXPECT_EQ(run(file("r.h5") + " --model kirchhoff --distribution filtered --wi 30deg" + out).code, 2);
  for (const char* arguments : {"--masking none", "--distribution ellipsoid --masking none",
                                "--fit-of filtered", "--distribution kirchhoff_spectrum --fit-of filtered"})
    EXPECT_EQ(run(file("r.h5") + " " + arguments + " --wi 30deg" + out).code, 2) << arguments;
  EXPECT_EQ(run("--alpha 0.2 --azimuth 10deg --furnace" + out).code, 2);
  EXPECT_FALSE(std::filesystem::exists(file("o.h5")));
}

TEST_F(BrdfCommand, RefusesOutputsThatCannotBeWrittenBeforeItComputes) {
  write_tables("r.h5");
  std::filesystem::create_directory(file("folder"));
  std::filesystem::create_directory(file("p_slice0.png"));
  const std::string work = "--alpha 0.2 --furnace --tol 1e-9 --wi 30deg";  // would take far longer
  const std::string longest = file(std::string(300, 'x'));
  for (const std::string& outputs :
       {"-o " + file("none/o.h5"), "-o " + file("folder"), "-o " + longest,
        "-o " + file("o.h5") + " --write " + file("none/x.bsdf"),
        "-o " + file("o.h5") + " --write " + longest + ".bsdf",
        "-o " + file("o.h5") + " --write " + file("a.binary") + " --write " + file("none/a.xml"),
        "-o " + file("o.h5") + " --write " + file("a.xml") + " --write " + file("./a.xml"),
        "-o " + file("a.xml") + " --write " + file("a.xml"), "-o " + file("p.h5")})
    EXPECT_EQ(run(work + " " + outputs).code, 3) << outputs;
  EXPECT_EQ(run(file("r.h5") + " --wi 30deg -o " + file("r.h5")).code, 3);
  EXPECT_EQ(run("--alpha 0.2 --write " + file("a.astm") + " -o " + file("o.h5")).code, 2);
  for (const auto& entry : std::filesystem::directory_iterator(file("")))
    EXPECT_TRUE(entry.path().filename() == "r.h5" || entry.is_directory()) << entry.path();
}

}  // namespace
}  // namespace micro::tools
