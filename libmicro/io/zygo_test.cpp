#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/error.h"
#include "io/scan.h"
#include "io/small_hdf5_scans_test.h"
#include "io/small_scans_test.h"
#include "io/zygo_dat.h"
#include "testing/temporary_folder.h"

namespace micro {
namespace {

class Zygo : public ::testing::Test {
 protected:
  HeightField read_text(const std::string& text) const {
    write_text(path, text);
    return read_scan(path).surface;
  }
  HeightField read(const DatHeader& header) const {
    write_bytes(path, small_dat(header));
    return read_scan(path).surface;
  }
  HeightField read(const Datx& datx) const {
    write_small_datx(path, datx);
    return read_scan(path).surface;
  }
  static double height(const HeightField& surface, Eigen::Index j, Eigen::Index i) {
    return surface.mean + static_cast<double>(surface.z(j, i));
  }
  void expect_refused(const auto& content, const char* word) const {
    try {
      read(content);
      ADD_FAILURE() << "not refused: " << word;
    } catch (const FileError& error) {
      EXPECT_NE(error.fact().find(word), std::string::npos) << error.what();
    }
  }
  TemporaryFolder folder;
  std::filesystem::path path = folder.path() / "scan";
};

// Heights are floats about their mean: some 1e-7 of their range.
constexpr double kRounding = 1e-6;

TEST_F(Zygo, DatHeightIsRawTimesSWOOverR) {
  constexpr std::array resolution = {4096., 32768., 131072.};
  for (int format = 1; format <= 3; ++format)
    for (int phase_res = 0; phase_res < 3; ++phase_res)
      for (const int sign : {0, 1}) {
        const HeightField surface = read(DatHeader{.format = format, .phase_res = phase_res, .sign = sign});
        ASSERT_EQ(surface.rows(), 3);
        ASSERT_EQ(surface.cols(), 4);
        EXPECT_NEAR(surface.dx, 0.25, 1e-7);
        EXPECT_NEAR(surface.dy, 0.25, 1e-7);
        EXPECT_EQ(missing_count(surface), 1);
        EXPECT_TRUE(is_missing(surface.z(1, 1)));
        const double step = (sign ? -1 : 1) * 0.5 * 0.5 * 2 / resolution[static_cast<std::size_t>(phase_res)];
        for (const int k : {0, 1, 4, 11})
          EXPECT_NEAR(height(surface, k / 4, k % 4), (k * 1000 - 3000) * step,
                      kRounding * 8000 * std::abs(step));
      }
}

TEST_F(Zygo, DatRefusesWhatItWouldHaveToGuess) {
  expect_refused(DatHeader{.phase_res = 3}, "phase resolution 3");
  expect_refused(DatHeader{.phase_res = -1}, "phase resolution -1");
  expect_refused(DatHeader{.lateral = 0}, "--pitch");
  expect_refused(DatHeader{.lateral = -1e-6F}, "lateral");
  expect_refused(DatHeader{.lateral = NAN}, "lateral");
  expect_refused(DatHeader{.lateral = INFINITY}, "lateral");
  expect_refused(DatHeader{.wavelength = 0}, "wavelength");
  expect_refused(DatHeader{.wavelength = NAN}, "wavelength");
  write_bytes(path, small_dat({.lateral = 0}));
  const HeightField surface = read_scan(path, {.pitch_x = 0.3, .pitch_y = 0.4}).surface;
  EXPECT_EQ(surface.dx, 0.3);
  EXPECT_EQ(surface.dy, 0.4);
}

TEST_F(Zygo, DatWhoseHeaderLiesIsRefusedAtOnce) {
  const auto lie = [&](std::size_t at, std::initializer_list<unsigned> values) {
    auto bytes = small_dat({});
    for (const unsigned value : values)
      bytes[at++] = static_cast<std::byte>(value);
    write_bytes(path, bytes);
    EXPECT_THROW(read_scan(path), FileError) << at;
  };
  lie(68, {0xFF, 0xFF, 0xFF, 0xFF});                          // 65535 × 65535
  lie(68, {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xF8, 0x00, 0x04});  // … and the byte count says so too
  lie(68, {0, 0, 0, 3, 0, 0, 0, 0});                          // no columns
  lie(6, {0, 0, 0, 8});                                       // header shorter than itself
  lie(6, {0xFF, 0xFF, 0xFF, 0xFF});
  lie(60, {0xFF, 0xFF, 0xFF, 0xFF});  // intensities beyond the end
  lie(72, {0, 0, 0, 4});              // fewer height bytes than points
}

TEST_F(Zygo, DatWrittenIsDatRead) {
  for (const double offset : {0., 1e-3, -50., 76000.})
    for (const double amplitude : {0., 1e-4, 3.}) {
      Grid<double> z(7, 5);
      for (Eigen::Index k = 0; k < z.size(); ++k)
        z.data()[k] = offset + amplitude * std::sin(static_cast<double>(k) * std::numbers::sqrt2);
      z(2, 3) = NAN;
      z(6, 4) = NAN;
      const HeightField surface = make_height_field(z, 0.11, 0.11);
      write_zygo_dat(path, surface);
      const Scan back = read_scan(path);
      EXPECT_EQ(back.format, "zygo-dat");
      EXPECT_NEAR(back.surface.dx, 0.11, 1e-8);
      EXPECT_EQ(missing_count(back.surface), 2);
      EXPECT_TRUE(is_missing(back.surface.z(2, 3)));
      // Half a step of 2³¹ over the largest height, and the floats' own rounding.
      const double tolerance = (std::abs(offset) + amplitude) * 0.5000001 / 2147482000 + 1e-7 * amplitude;
      for (Eigen::Index j = 0; j < 7; ++j)
        for (Eigen::Index i = 0; i < 5; ++i)
          if (!is_missing(surface.z(j, i))) {
            EXPECT_NEAR(height(back.surface, j, i), height(surface, j, i), tolerance)
                << offset << " " << amplitude;
          }
    }
}

TEST_F(Zygo, DatCannotHoldEverySurface) {
  const Grid<double> z = Grid<double>::Zero(2, 2);
  EXPECT_THROW(write_zygo_dat(path, make_height_field(z, 0.1, 0.2)), InputError);
  EXPECT_THROW(write_zygo_dat(path, make_height_field(Grid<double>::Zero(1, 65536), 1, 1)), InputError);
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST_F(Zygo, DatxOfBothConvertersAndUnits) {
  for (const int fields : {3, 5})
    for (const bool metadata : {true, false})
      for (const char* unit : {"NanoMeters", "Fringes", "MicroMeters"}) {
        const HeightField surface =
            read(Datx{.converter_fields = fields, .unit = unit, .metadata = metadata, .hard_link = true});
        ASSERT_EQ(surface.rows(), 3);
        ASSERT_EQ(surface.cols(), 4);
        EXPECT_DOUBLE_EQ(surface.dx, 0.25);
        EXPECT_DOUBLE_EQ(surface.dy, 0.5);
        EXPECT_EQ(missing_count(surface), 1);
        EXPECT_TRUE(is_missing(surface.z(1, 1)));
        // Fringes are W·S·O = 0.6 µm · 0.5 · 2; nanometres know nothing of these.
        const double scale = unit[0] == 'N' ? 1e-3 : unit[0] == 'F' ? 0.6 : 1;
        for (const int k : {0, 1, 4, 11})
          EXPECT_NEAR(height(surface, k / 4, k % 4), (k + 0.5) * scale, kRounding * 12 * scale);
      }
}

TEST_F(Zygo, DatxOfEveryAgeOfHdf5) {
  const HeightField plain = read(Datx{.converter_fields = 5});
  for (const Hdf5Layout layout : {Hdf5Layout::Earliest, Hdf5Layout::Latest})
    for (const Hdf5Storage storage : {Hdf5Storage::Contiguous, Hdf5Storage::Deflated}) {
      const HeightField surface = read(Datx{.converter_fields = 5, .layout = layout, .storage = storage});
      EXPECT_DOUBLE_EQ(surface.dx, 0.25);
      EXPECT_DOUBLE_EQ(surface.dy, 0.5);
      EXPECT_TRUE((surface.z == plain.z || (surface.z.isNaN() && plain.z.isNaN())).all());
    }
}

TEST_F(Zygo, DatxRefusesWhatItWouldHaveToGuess) {
  expect_refused(Datx{.unit = "Furlongs"}, "Furlongs");
  expect_refused(Datx{.converter_fields = 5, .sub_unit = "Furlongs"}, "Furlongs");
  expect_refused(Datx{.pitch_x = 0}, "--pitch");
  expect_refused(Datx{.pitch_y = -1}, "lateral");
  expect_refused(Datx{.pitch_x = NAN}, "lateral");
  expect_refused(Datx{.surfaces = 2, .metadata = false}, "2 surfaces");
  expect_refused(Datx{.surfaces = 0, .metadata = false}, "no surface");
  EXPECT_NO_THROW(read(Datx{.surfaces = 2}));
}

TEST_F(Zygo, AscHeightIsRawTimesSWOOverR) {
  const auto crlf = [](std::string text) {
    for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 2)
      text.insert(at, "\r");
    return text;
  };
  for (const std::string& text :
       {small_asc("1 2 3 4 \n#\n"), small_asc(""), small_asc("#\n"), crlf(small_asc("1 2 3 4 \n#\n"))}) {
    // Without intensities a header that counts none goes with a closing "#" or without.
    std::string whole = text;
    if (const auto at = whole.find("#\n#\n"); at != std::string::npos)
      whole.replace(whole.find("2 2 1 255"), 9, "2 2 0 255");
    const HeightField surface = read_text(whole);
    ASSERT_EQ(surface.rows(), 2);
    ASSERT_EQ(surface.cols(), 3);
    EXPECT_DOUBLE_EQ(surface.dx, 0.25);
    EXPECT_NEAR(height(surface, 0, 0), 1, kRounding);
    EXPECT_NEAR(height(surface, 0, 1), -1, kRounding);
    EXPECT_NEAR(height(surface, 0, 2), 0, kRounding);
    EXPECT_TRUE(is_missing(surface.z(1, 0)));
    EXPECT_NEAR(height(surface, 1, 1), 2, kRounding);
  }
  EXPECT_NEAR(height(read_text(small_asc("", 1)), 0, 0), -1, kRounding) << "data_sign negates";
}

TEST_F(Zygo, AscRefusesWhatIsWrong) {
  const auto refused = [&](const std::string& from, const std::string& to) {
    std::string text = small_asc("1 2 3 4 \n#\n");
    text.replace(text.find(from), from.size(), to);
    EXPECT_THROW(read_text(text), FileError) << to;
  };
  refused("0 0 3 2\n", "0 0 65535 65535\n");
  refused("0 0 3 2\n", "0 0 4294967295 4294967295\n");
  refused("0 0 3 2\n", "0 0 -3 2\n");
  refused("0 0 3 2\n", "0 0 0 2\n");
  refused("0 0 3 2\n", "0 0 3 3\n");
  refused("0 0 3 2\n", "0 0 3 1\n");
  refused("2e-006", "0");
  refused("2.5e-007", "0");
  refused("2.5e-007", "nan");
  refused("\n1 0 7 1 60", "\n7 0 7 1 60");
  refused("65536", "6x536");
  refused("65536", "99999999999");
}

TEST_F(Zygo, XyzIsMicrometresAtCameraPixels) {
  const HeightField surface = read_text(small_xyz());
  ASSERT_EQ(surface.rows(), 2);
  ASSERT_EQ(surface.cols(), 3);
  EXPECT_DOUBLE_EQ(surface.dx, 0.25);
  EXPECT_NEAR(height(surface, 0, 0), 0.5, kRounding);
  EXPECT_NEAR(height(surface, 0, 1), -0.125, kRounding);
  EXPECT_TRUE(is_missing(surface.z(0, 2)));
  EXPECT_NEAR(height(surface, 1, 2), 4, kRounding);
  for (const char* wrong : {"9 21 3", "10 21 3", "11 21 x", "11 22 3", "11 21 No Idea"}) {
    std::string text = small_xyz();
    text.replace(text.find("11 21 3"), 7, wrong);
    EXPECT_THROW(read_text(text), FileError) << wrong;
  }
}

}  // namespace
}  // namespace micro
