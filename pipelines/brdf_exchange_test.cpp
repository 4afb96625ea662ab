// Every file is read back here by code of its own, field by field as its format is published.
#include "pipelines/brdf_exchange.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <numbers>
#include <pugixml.hpp>
#include <sstream>

#include "core/error.h"
#include "testing/temporary_folder.h"

namespace micro {
namespace {

constexpr double kPi = std::numbers::pi;

std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

template <typename T>
T number_at(const std::string& bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

class BrdfExchange : public testing::Test {
 protected:
  BrdfExchange() : model_(lobe_model("ellipsoid", {0.3, 0.3}, material("Cu"))) {
    BrdfRequest request;
    request.wi = {Vec3(std::sin(0.5), 0, std::cos(0.5))};
    report_ = evaluate_brdf(model_, "Cu", request);
  }

  std::string written(const std::string& name) {
    path_ = folder_.path() / name;
    kept_ = write_exchanged_brdf(path_, model_.metal, report_, "microbrdf brdf --wi 30deg").kept;
    return bytes_of(path_);
  }

  TemporaryFolder folder_;
  std::filesystem::path path_;
  std::string kept_;
  BrdfModel model_;
  BrdfReport report_;
};

TEST_F(BrdfExchange, TensorFileHasTheFieldsThatItsReadersWant) {
  const std::string bytes = written("cu.bsdf");
  ASSERT_EQ(bytes.substr(0, 14), std::string("tensor_file\0\1\0", 14));
  const auto fields = number_at<std::uint32_t>(bytes, 14);
  std::map<std::string, std::vector<std::uint64_t>> shapes;
  std::map<std::string, std::size_t> offsets;
  std::size_t at = 18;
  for (std::uint32_t k = 0; k < fields; ++k) {
    const auto length = number_at<std::uint16_t>(bytes, at);
    const std::string name = bytes.substr(at + 2, length);
    at += 2u + length;
    const auto dimensions = number_at<std::uint16_t>(bytes, at);
    const auto type = number_at<std::uint8_t>(bytes, at + 2);
    const auto offset = number_at<std::uint64_t>(bytes, at + 3);
    at += 11;
    std::uint64_t size = type == 1 ? 1 : 4;
    for (std::uint16_t d = 0; d < dimensions; ++d, at += 8) {
      shapes[name].push_back(number_at<std::uint64_t>(bytes, at));
      size *= shapes[name].back();
    }
    EXPECT_EQ(type, name == "description" || name == "jacobian" ? 1 : 10) << name;
    EXPECT_EQ(offset % 8, 0u) << name;
    EXPECT_LE(offset + size, bytes.size()) << name;
    offsets[name] = offset;
  }
  const auto sized = [&](const char* name, std::vector<std::uint64_t> shape) {
    EXPECT_EQ(shapes[name], shape) << name;
  };
  sized("phi_i", {1});
  sized("theta_i", {32});
  sized("wavelengths", {3});
  sized("spectra", {1, 32, 3, 64, 64});
  sized("luminance", {1, 32, 64, 64});
  EXPECT_EQ(shapes["vndf"].size(), 4u);
  EXPECT_EQ(number_at<std::uint8_t>(bytes, offsets["jacobian"]), 1);
  EXPECT_EQ(number_at<float>(bytes, offsets["wavelengths"] + 4), 550.f);
  const std::string text = bytes.substr(offsets["description"], shapes["description"].front());
  EXPECT_NE(text.find("1/sr"), text.npos);
  EXPECT_NE(text.find("--wi 30deg"), text.npos);
}

/// wi and wo at the middle of a bin of MERL's table, the half vector at azimuth phi_h.
std::pair<Vec3, Vec3> merl_directions(int i, int j, int k, double phi_h) {
  const double th = std::pow((i + 0.5) / 90, 2) * kPi / 2, td = (j + 0.5) / 90 * kPi / 2,
               pd = (k + 0.5) / 180 * kPi;
  const Vec3 e(std::cos(phi_h), std::sin(phi_h), 0), y(-std::sin(phi_h), std::cos(phi_h), 0), n(0, 0, 1);
  const Vec3 h = std::sin(th) * e + std::cos(th) * n, x = std::cos(th) * e - std::sin(th) * n;
  const Vec3 wi = std::cos(td) * h + std::sin(td) * (std::cos(pd) * x + std::sin(pd) * y);
  return {wi, 2 * wi.dot(h) * h - wi};
}

std::size_t merl_index(int c, int i, int j, int k) {
  return static_cast<std::size_t>(((c * 90 + i) * 90 + j) * 180 + k);
}

// θ_h in bins of √θ_h, 90 of θ_d, 180 of φ_d, colours one after the other, as MERL's own look-up has them.
TEST_F(BrdfExchange, MerlFileIsFoundByItsPublishedIndex) {
  report_.request.lambda_um = {0.55};  // one wavelength is grey
  const std::string bytes = written("cu.binary");
  ASSERT_EQ(bytes.size(), 12u + 8u * 3 * 90 * 90 * 180);
  EXPECT_EQ(number_at<std::int32_t>(bytes, 0), 90);
  EXPECT_EQ(number_at<std::int32_t>(bytes, 4), 90);
  EXPECT_EQ(number_at<std::int32_t>(bytes, 8), 180);
  const double theta_h = 0.21, theta_d = 0.4, phi_d = 1.1;
  const auto i = static_cast<int>(std::sqrt(theta_h / (kPi / 2)) * 90),
             j = static_cast<int>(theta_d / (kPi / 2) * 90), k = static_cast<int>(phi_d / kPi * 180);
  const auto [wi, wo] = merl_directions(i, j, k, 0);
  const double want = model_.metal.f(wi, wo, 0.55);
  const std::array<double, 3> scale = {1. / 1500, 1.15 / 1500, 1.66 / 1500};
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(
        number_at<double>(bytes, 12 + 8 * merl_index(c, i, j, k)) * scale[static_cast<std::size_t>(c)], want,
        2e-3 * want)
        << c;
  // Half vector and difference both grazing: below the horizon.
  EXPECT_EQ(number_at<double>(bytes, 12 + 8 * merl_index(0, 89, 89, 0)), -1);
  EXPECT_NE(bytes_of(path_.string() + ".txt").find("1/sr"), std::string::npos);
}

TEST_F(BrdfExchange, AstmFileHoldsTheSlices) {
  std::istringstream text(written("cu.astm"));
  std::string line;
  std::getline(text, line);
  EXPECT_EQ(line, "ASTM E1392-90");
  while (std::getline(text, line) && line.rfind("VARS", 0) != 0) {
  }
  EXPECT_EQ(line, "VARS theta_i,phi_i,theta_s,phi_s,BRDF 450 nm,BRDF 550 nm,BRDF 650 nm");
  std::size_t rows = 0;
  for (; std::getline(text, line); ++rows) {
    std::array<double, 7> v{};
    std::istringstream numbers(line);
    for (double& value : v) {
      numbers >> value;
      numbers.ignore();
    }
    const auto direction = [](double theta, double phi) {
      return Vec3(std::sin(theta * kPi / 180) * std::cos(phi * kPi / 180),
                  std::sin(theta * kPi / 180) * std::sin(phi * kPi / 180), std::cos(theta * kPi / 180));
    };
    const double want = model_.metal.f(direction(v[0], v[1]), direction(v[2], v[3]), 0.55);
    ASSERT_NEAR(v[5], want, 1e-5 * want + 1e-9) << line;
  }
  EXPECT_EQ(rows, report_.slices.front().theta_o.size());
}

TEST_F(BrdfExchange, RadianceFileIsAKlemsMatrix) {
  report_.request.lambda_um = {0.55};
  written("cu.xml");
  pugi::xml_document document;
  ASSERT_TRUE(document.load_file(path_.c_str()));
  const pugi::xml_node layer = document.child("WindowElement").child("Optical").child("Layer");
  int patches = 0;
  for (const pugi::xml_node& block :
       layer.child("DataDefinition").child("AngleBasis").children("AngleBasisBlock"))
    patches += block.child("nPhis").text().as_int();
  EXPECT_EQ(patches, 145);
  std::vector<std::string> directions;
  for (const pugi::xml_node& data : layer.children("WavelengthData")) {
    const pugi::xml_node block = data.child("WavelengthDataBlock");
    directions.emplace_back(block.child("WavelengthDataDirection").text().get());
    std::istringstream numbers(block.child("ScatteringData").text().get());
    std::size_t count = 0;
    for (double value = 0; numbers >> value; numbers.ignore()) {
      EXPECT_GE(value, 0);
      ++count;
    }
    EXPECT_EQ(count, 145u * 145u);
  }
  EXPECT_EQ(directions, (std::vector<std::string>{"Reflection Front", "Reflection Back"}));
}

TEST_F(BrdfExchange, RefusesWhatItCannotSay) {
  EXPECT_THROW(written("cu.csv"), InputError);
  report_.slices.clear();
  EXPECT_THROW(written("cu.astm"), InputError);
}

TEST_F(BrdfExchange, AveragesAzimuthsAndSaysWhatThatLost) {
  model_ = lobe_model("ellipsoid", {0.3, 0.1, 0, 0.1, 0.3}, Fresnel());
  report_.request.lambda_um = {0.55};
  const std::string bytes = written("cu.binary");
  EXPECT_NE(kept_.find("a mean over 8 azimuths"), std::string::npos) << kept_;
  constexpr int kI = 30, kJ = 20, kK = 70;
  double mean = 0;
  for (int a = 0; a < 8; ++a) {
    const auto [wi, wo] = merl_directions(kI, kJ, kK, a * kPi / 4);
    mean += model_.metal.f(wi, wo, 0.55) / 8;
  }
  EXPECT_NEAR(number_at<double>(bytes, 12 + 8 * merl_index(0, kI, kJ, kK)) / 1500, mean, 1e-5 * mean);
}

}  // namespace
}  // namespace micro
