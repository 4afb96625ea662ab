#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>

#include "core/error.h"
#include "io/hdf5_reader.h"
#include "io/microbrdf_hdf5.h"
#include "io/npy.h"
#include "io/scan.h"
#include "io/small_hdf5_scans_test.h"
#include "io/small_scans_test.h"
#include "testing/temporary_folder.h"

namespace micro {
namespace {

constexpr double kRounding = 1e-6;  // of heights of order one, kept as floats

class PlainFormats : public ::testing::Test {
 protected:
  HeightField read() const { return read_scan(path, {.pitch_x = 0.25, .pitch_y = 0.5}).surface; }
  HeightField read_text(const std::string& text) const {
    write_text(path, text);
    return read();
  }
  static double height(const HeightField& surface, Eigen::Index j, Eigen::Index i) {
    return surface.mean + static_cast<double>(surface.z(j, i));
  }
  bool python(const std::string& program) const {
    write_text(folder.path() / "program.py",
               "import numpy as np\npath = '" + path.string() + "'\n" + program);
    return std::system(("/usr/bin/python3 " + (folder.path() / "program.py").string()).c_str()) == 0;
  }
  TemporaryFolder folder;
  std::filesystem::path path = folder.path() / "scan";
};

HeightField some_surface() {
  Grid<double> z(3, 4);
  for (Eigen::Index k = 0; k < z.size(); ++k)
    z.data()[k] = 100 + std::sin(static_cast<double>(k));
  z(1, 2) = NAN;
  return make_height_field(z, 0.25, 0.5);
}

TEST_F(PlainFormats, NpyIsWhatNumpyReadsAndWrites) {
  if (!python("")) GTEST_SKIP() << "NOT CHECKED: /usr/bin/python3 has no numpy";
  const HeightField surface = some_surface();
  write_npy(path, surface);
  EXPECT_TRUE(
      python("z = np.load(path)\n"
             "assert z.shape == (3, 4) and z.dtype == '<f8', (z.shape, z.dtype)\n"
             "k = np.arange(12).reshape(3, 4)\n"
             "assert np.isnan(z[1, 2]) and np.isnan(z).sum() == 1\n"
             "assert np.nanmax(abs(z - 100 - np.sin(k))) < 1e-6\n"));
  // Every type, memory order and version, one file each.
  ASSERT_TRUE(python(
      "types = [b + t for t in ('f4', 'f8', 'i1', 'i2', 'i4', 'i8', 'u1', 'u2', 'u4', 'u8') for b in '<>']\n"
      "kinds = [(t, o, v) for t in types for o in 'CF' for v in (1, 2, 3)]\n"
      "for n, (t, o, v) in enumerate(kinds):\n"
      "  with open(path + str(n), 'wb') as f:\n"
      "    z = np.asarray(np.arange(12).reshape(3, 4), dtype=t, order=o)\n"
      "    np.lib.format.write_array(f, z, version=(v, 0))\n"));
  constexpr int kinds = 20 * 2 * 3;
  for (int n = 0; n < kinds; ++n) {
    const HeightField back =
        read_scan(path.string() + std::to_string(n), {.pitch_x = 0.25, .pitch_y = 0.5}).surface;
    ASSERT_EQ(back.rows(), 3);
    ASSERT_EQ(back.cols(), 4);
    EXPECT_EQ(back.dx, 0.25);
    EXPECT_EQ(back.dy, 0.5);
    for (int k = 0; k < 12; ++k)
      EXPECT_NEAR(height(back, k / 4, k % 4), k, 12 * kRounding) << n;
  }
}

TEST_F(PlainFormats, NpyRefusesWhatIsNoHeightField) {
  const auto refused = [&](const std::string& header) {
    std::string text = "\x93NUMPY\x01" + std::string(1, '\0') + static_cast<char>(header.size()) +
                       std::string(1, '\0') + header + std::string(96, '\0');
    write_text(path, text);
    EXPECT_THROW(read(), FileError) << header;
  };
  refused("{'descr': '<f8', 'fortran_order': False, 'shape': (12,), }");
  refused("{'descr': '<f8', 'fortran_order': False, 'shape': (3, 2, 2), }");
  refused("{'descr': '<f8', 'fortran_order': False, 'shape': (3, 5), }");
  refused("{'descr': '<f8', 'fortran_order': False, 'shape': (0, 4), }");
  refused("{'descr': '<f8', 'fortran_order': False, 'shape': (-3, 4), }");
  refused("{'descr': '<f8', 'fortran_order': False, 'shape': (4294967296, 4294967296), }");
  refused("{'descr': '<f8', 'fortran_order': False, 'shape': (99999999999999999999, 1), }");
  refused("{'descr': '<f8', 'fortran_order': Maybe, 'shape': (3, 4), }");
  refused("{'descr': '<c8', 'fortran_order': False, 'shape': (3, 4), }");
  refused("{'descr': '|O', 'fortran_order': False, 'shape': (3, 4), }");
  refused("{'descr': [('z', '<f8')], 'fortran_order': False, 'shape': (3, 4), }");
  refused("{'shape': (3, 4), }");
  refused("{");
  write_npy(path, some_surface());
  EXPECT_THROW(read_scan(path), FileError) << "no pitch";
}

TEST_F(PlainFormats, TextHasMissingPointsAndComments) {
  for (const std::string& text :
       {std::string("# µm\n1.5 -2 nan\n\n4e0\t+5   6 # last\n"), std::string("1.5,-2,\n4,5,6\n"),
        std::string("1.5;-2;NA\r\n4;5;6\r\n"), std::string("1.5\t-2\tBAD\n4\t5\t6"),
        std::string("\xEF\xBB\xBF"
                    "1.5, -2, *,\n4, 5, 6,\n"),
        std::string("1.5 -2 inf\n4 5 6\n")}) {
    if (text == "1.5,-2,\n4,5,6\n") {
      EXPECT_THROW(read_text(text), FileError) << "an empty last cell is no cell";
      continue;
    }
    const HeightField surface = read_text(text);
    ASSERT_EQ(surface.rows(), 2) << text;
    ASSERT_EQ(surface.cols(), 3) << text;
    EXPECT_NEAR(height(surface, 0, 0), 1.5, kRounding) << text;
    EXPECT_NEAR(height(surface, 0, 1), -2, kRounding) << text;
    EXPECT_TRUE(is_missing(surface.z(0, 2))) << text;
    EXPECT_NEAR(height(surface, 1, 2), 6, kRounding) << text;
  }
  EXPECT_TRUE(is_missing(read_text("1,,3\n4,5,6\n").z(0, 1)));
  EXPECT_TRUE(is_missing(read_text("1\t\t3\n4\t5\t6\n").z(0, 1)));
}

TEST_F(PlainFormats, TextRefusalsNameTheLine) {
  const auto refused = [&](const std::string& text, const char* words) {
    try {
      read_text(text);
      ADD_FAILURE() << text;
    } catch (const FileError& error) {
      EXPECT_NE(error.fact().find(words), std::string::npos) << error.what();
    }
  };
  refused("1 2 3\n# comment\n4 5\n", "line 3 has 2 values");
  refused("1 2\n3 four\n", "line 2: \"four\"");
  refused("1;2\n1,5;2,5\n", "decimals with a point");
  refused("1 2\n3 4x\n", "line 2");
  refused("0,5;0,6\n0,7;0,8\n", "nothing but numbers, with decimal points");
  refused("x y z\n1 2 3\n", "nothing but numbers");
  refused("", "is empty");
}

TEST_F(PlainFormats, DigitalSurfInEitherByteOrderAndWidth) {
  for (const bool macintosh : {false, true})
    for (const int bits : {16, 32})
      for (const int special_points : {0, 1})
        for (const char* unit : {"nm", "\xB5m", "\xC2\xB5m", "mm", "m"}) {
          write_bytes(
              path,
              small_surf(
                  {.macintosh = macintosh, .bits = bits, .special_points = special_points, .dz_unit = unit}));
          const HeightField surface = read_scan(path).surface;
          ASSERT_EQ(surface.rows(), 2);
          ASSERT_EQ(surface.cols(), 3);
          EXPECT_FLOAT_EQ(static_cast<float>(surface.dx), 0.25F);
          EXPECT_FLOAT_EQ(static_cast<float>(surface.dy), 0.5F);
          const std::string name = unit;
          const double scale = name == "nm" ? 1e-3 : name == "mm" ? 1e3 : name == "m" ? 1e6 : 1;
          EXPECT_NEAR(height(surface, 0, 0), (10 * 0.5 + 100) * scale, kRounding * 50 * scale);
          EXPECT_NEAR(height(surface, 1, 1), (50 * 0.5 + 100) * scale, kRounding * 50 * scale);
          EXPECT_EQ(is_missing(surface.z(1, 2)), special_points == 1);
        }
}

TEST_F(PlainFormats, CompressedDigitalSurfIsThePlainOne) {
  for (const int bits : {16, 32}) {
    const auto plain = small_surf({.bits = bits});
    const auto packed = compressed_surf(plain, static_cast<std::size_t>(6 * bits / 8));
    write_bytes(path, plain);
    const HeightField expected = read_scan(path).surface;
    write_bytes(path, packed);
    const HeightField surface = read_scan(path).surface;
    EXPECT_EQ(surface.mean, expected.mean);
    EXPECT_TRUE((surface.z == expected.z || (surface.z.isNaN() && expected.z.isNaN())).all());
    // Any byte less, and any number of bytes that is a lie.
    const auto refused = [&](std::vector<std::byte> bytes, std::size_t at, int value, const char* words) {
      if (at < bytes.size()) bytes[at] = static_cast<std::byte>(value);
      write_bytes(path, bytes);
      try {
        read_scan(path);
        ADD_FAILURE() << words;
      } catch (const FileError& error) {
        EXPECT_NE(error.fact().find(words), std::string::npos) << error.what();
      }
    };
    constexpr std::size_t directory = 512 + 7 + 5;
    refused({packed.begin(), packed.end() - 1}, SIZE_MAX, 0, "longer than the file");
    refused(packed, directory + 3, 0x7F, "cut in the directory");
    refused(packed, directory, 1, "cannot be unpacked");
    refused(packed, directory + 4 + 3, 0x7F, "larger than they can be");
    refused(packed, directory + 4, 5, "cannot be unpacked");
    refused(packed, directory + 20, 0, "cannot be unpacked");
  }
}

TEST_F(PlainFormats, DigitalSurfRefusesWhatIsWrong) {
  const auto refused = [&](std::size_t at, std::initializer_list<int> values, const char* words) {
    auto bytes = small_surf({});
    for (const int value : values)
      bytes[at++] = static_cast<std::byte>(value);
    write_bytes(path, bytes);
    try {
      read_scan(path);
      ADD_FAILURE() << words;
    } catch (const FileError& error) {
      EXPECT_NE(error.fact().find(words), std::string::npos) << error.what();
    }
  };
  refused(0, {'D', 'S', 'C', 'O', 'M', 'P', 'R', 'E', 'S', 'S', 'E', 'D'}, "cut in the directory");
  refused(108, {0xFF, 0xFF, 0xFF, 0x7F, 0xFF, 0xFF, 0xFF, 0x7F}, "cut");
  refused(108, {0xFF, 0xFF, 0xFF, 0xFF}, "no heights");
  refused(108, {0, 0, 0, 0}, "no heights");
  refused(98, {8, 0}, "bits");
  refused(12, {7, 0}, "byte order");
  refused(18, {1, 0}, "no surface");
  refused(14, {2, 0}, "several");
  refused(212, {'i', 'n'}, "unit along z, \"in\"");
  refused(128, {0, 0, 0, 0}, "height scale");
  refused(120, {0, 0, 0xC0, 0x7F}, "lateral");
  refused(120, {0, 0, 0, 0}, "--pitch");
  refused(334, {0xFF, 0xFF, 0xFF, 0xFF}, "cut");
}

TEST_F(PlainFormats, OurHeightFileComesBackToTheBit) {
  const HeightField surface = some_surface();
  write_microbrdf_hdf5(path, surface, {.version = "1", .created = "now", .command = "test"});
  const Scan back = read_scan(path);
  EXPECT_EQ(back.format, "microbrdf-hdf5");
  EXPECT_EQ(back.surface.dx, surface.dx);
  EXPECT_EQ(back.surface.dy, surface.dy);
  EXPECT_EQ(back.surface.mean, surface.mean);
  EXPECT_TRUE((back.surface.z == surface.z || (back.surface.z.isNaN() && surface.z.isNaN())).all());
}

TEST_F(PlainFormats, AHeightFileMayHaveAnotherWriter) {
  for (const Hdf5Layout layout : {Hdf5Layout::Earliest, Hdf5Layout::Latest})
    for (const Hdf5Storage storage : {Hdf5Storage::Contiguous, Hdf5Storage::Deflated}) {
      write_small_height_file(path, layout, storage);
      const Scan scan = read_scan(path);
      EXPECT_EQ(scan.format, "microbrdf-hdf5");
      ASSERT_EQ(scan.surface.rows(), 3);
      ASSERT_EQ(scan.surface.cols(), 4);
      EXPECT_EQ(scan.surface.mean, 10);
      EXPECT_EQ(missing_count(scan.surface), 1);
      EXPECT_TRUE(is_missing(scan.surface.z(1, 1)));
      for (const int k : {0, 1, 4, 11})
        EXPECT_EQ(scan.surface.z(k / 4, k % 4), static_cast<float>(k) + 0.5F);
    }
}

TEST_F(PlainFormats, TextOfMissingPointsAloneIsAScanOfNothing) {
  write_text(path, "nan nan\nNA nan\n");
  const Scan scan = read_scan(path, {.pitch_x = 1, .pitch_y = {}});
  EXPECT_EQ(scan.format, "text");
  EXPECT_EQ(missing_count(scan.surface), 4);
}

TEST_F(PlainFormats, AResultIsNoScanAndACutHeightFileIsRefused) {
  Hdf5Writer result(path);
  write_origin(result, {.version = "1", .created = "now", .command = "test"});
  result.create_group("/ndf");
  result.finish();
  EXPECT_EQ(recognise_scan(path)->listed, ScanFormat::Listed::Never);
  EXPECT_THROW(read_scan(path), FileError);

  Hdf5Writer cut(path);
  write_origin(cut, {.version = "1", .created = "now", .command = "test"});
  cut.write("/height/z", some_surface().z);
  cut.finish();
  EXPECT_THROW(read_scan(path), FileError) << "no pitch";
  write_microbrdf_hdf5(path, some_surface(), {.version = "1", .created = "now", .command = "test"});
  if (!python("import h5py\nwith h5py.File(path, 'r+') as f: del f.attrs['complete']\n"))
    GTEST_SKIP() << "NOT CHECKED: /usr/bin/python3 has no h5py";
  try {
    read_scan(path);
    FAIL() << "a cut file was read";
  } catch (const FileError& error) {
    EXPECT_NE(error.fact().find("cut"), std::string::npos) << error.what();
  }
}

TEST_F(PlainFormats, AnHdf5HeaderThatLiesIsRefused) {
  if (!python("import h5py\nwith h5py.File(path, 'w') as f:\n"
              "  f.create_dataset('z', (65535, 65535), dtype='f8', chunks=(64, 64), compression='gzip')\n"))
    GTEST_SKIP() << "NOT CHECKED: /usr/bin/python3 has no h5py";
  EXPECT_THROW(Hdf5Reader(path).read_grid<double>("/z"), FileError);
}

}  // namespace
}  // namespace micro
