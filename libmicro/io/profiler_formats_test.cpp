#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <cstring>

#include "core/error.h"
#include "io/exr.h"
#include "io/scan.h"
#include "io/small_profiler_scans_test.h"
#include "io/small_scans_test.h"
#include "io/x3p.h"
#include "testing/temporary_folder.h"

namespace micro {
namespace {

constexpr double kRounding = 1e-6;  // of heights of a few µm, kept as floats

class ProfilerFormats : public ::testing::Test {
 protected:
  static std::vector<std::byte> bytes_of(const std::string& text) {
    const auto* begin = reinterpret_cast<const std::byte*>(text.data());
    return {begin, begin + text.size()};
  }
  Scan read(const std::vector<std::byte>& bytes) const {
    write_bytes(path, bytes);
    return read_scan(path);
  }
  /// Heights 1, 2, 3 / 4, 5, missing µm at 0.25 × 0.5 µm; or 6 µm where a format knows nothing missing.
  void expect_small_scan(const std::vector<std::byte>& bytes, const std::string& format,
                         double last = NAN) const {
    SCOPED_TRACE(format);
    const Scan scan = read(bytes);
    EXPECT_EQ(scan.format, format);
    ASSERT_EQ(scan.surface.rows(), 2);
    ASSERT_EQ(scan.surface.cols(), 3);
    EXPECT_FLOAT_EQ(static_cast<float>(scan.surface.dx), 0.25F);
    EXPECT_FLOAT_EQ(static_cast<float>(scan.surface.dy), 0.5F);
    for (Eigen::Index k = 0; k < 5; ++k)
      EXPECT_NEAR(scan.surface.mean + static_cast<double>(scan.surface.z.data()[k]),
                  static_cast<double>(k + 1), kRounding);
    if (std::isnan(last))
      EXPECT_TRUE(is_missing(scan.surface.z(1, 2)));
    else
      EXPECT_NEAR(scan.surface.mean + static_cast<double>(scan.surface.z(1, 2)), last, kRounding);
  }
  void expect_refused(const std::vector<std::byte>& bytes, const std::string& words) const {
    try {
      read(bytes);
      ADD_FAILURE() << "was read: " << words;
    } catch (const FileError& error) {
      EXPECT_EQ(error.file(), path);
      EXPECT_NE(error.fact().find(words), std::string::npos) << error.what();
    }
  }
  /// The bytes with some of them changed.
  static std::vector<std::byte> with(std::vector<std::byte> bytes, std::size_t at, const std::string& put) {
    std::memcpy(bytes.data() + at, put.data(), put.size());
    return bytes;
  }
  static std::string replaced(std::string text, const std::string& from, const std::string& to) {
    return text.replace(text.find(from), from.size(), to);
  }
  TemporaryFolder folder;
  std::filesystem::path path = folder.path() / "scan";
};

TEST_F(ProfilerFormats, SdfAscii) {
  expect_small_scan(bytes_of(small_sdf_ascii()), "sdf");
  expect_small_scan(bytes_of(replaced(small_sdf_ascii(), "aISO", "aBCR")), "sdf");
  std::string line_feeds = small_sdf_ascii();
  std::erase(line_feeds, '\r');
  expect_small_scan(bytes_of(line_feeds), "sdf");
}

TEST_F(ProfilerFormats, SdfAsciiRefusesWhatIsWrong) {
  const std::string sdf = small_sdf_ascii();
  expect_refused(bytes_of(replaced(sdf, "NumPoints = 3", "NumPoints = x")), "NumPoints");
  expect_refused(bytes_of(replaced(sdf, "NumPoints = 3", "NumPoints = 4294967295")), "cut");
  expect_refused(bytes_of(replaced(sdf, "NumPoints = 3", "NumPoints = 0")), "no heights");
  expect_refused(bytes_of(replaced(sdf, "NumProfiles = 2", "NumProfiles = 3")), "fewer heights");
  expect_refused(bytes_of(replaced(sdf, "NumProfiles = 2", "NumProfiles = 1")), "more heights");
  expect_refused(bytes_of(replaced(sdf, "Xscale = 0.25E-6", "Xscale = -1")), "lateral scale");
  expect_refused(bytes_of(replaced(sdf, "Xscale = 0.25E-6", "Xscale = 0")), "--pitch");
  expect_refused(bytes_of(replaced(sdf, "Zscale = 1.0E-6", "Zscale = nan")), "height scale");
  expect_refused(bytes_of(replaced(sdf, "Compression = 0", "Compression = 1")), "compressed");
  expect_refused(bytes_of(replaced(sdf, "4.00", "4,00")), "\"4,00\"");
}

TEST_F(ProfilerFormats, SdfBinaryOfEveryType) {
  for (int type = 0; type < 8; ++type) {
    const bool knows_missing = type != 0 && type != 4;
    expect_small_scan(small_sdf_binary({.type = type}), "sdf", knows_missing ? NAN : 6);
  }
  expect_small_scan(small_sdf_binary({.type = 5, .olympus = true}), "sdf");
}

TEST_F(ProfilerFormats, SdfBinaryRefusesWhatIsWrong) {
  const auto sdf = small_sdf_binary({});
  expect_refused({sdf.begin(), sdf.begin() + 80}, "cut");
  expect_refused({sdf.begin(), sdf.end() - 1}, "cut");
  expect_refused(with(sdf, 42, "\xFF\xFF\xFF\xFF"), "cut");
  expect_refused(with(sdf, 42, std::string(2, '\0')), "no heights");
  expect_refused(with(sdf, 78, "\x01"), "compressed");
  expect_refused(with(sdf, 79, "\x08"), "data type 8");
}

TEST_F(ProfilerFormats, WykoOpdOfIntegersAndFloatsUnderItsNames) {
  for (const bool floats : {false, true})
    for (const char* name : {"RAW_DATA", "RAW DATA", "OPD", "Raw"})
      expect_small_scan(small_opd({.floats = floats, .name = name}), "wyko-opd");
}

TEST_F(ProfilerFormats, WykoOpdRefusesWhatIsWrong) {
  const auto opd = small_opd({});
  const auto record = [](int k) { return static_cast<std::size_t>(2 + 24 * k); };
  expect_refused({opd.begin(), opd.begin() + 20}, "cut");
  expect_refused({opd.begin(), opd.end() - 1}, "Pixel_size");
  expect_refused(with(opd, 2 + 18, "\xFF\xFF\xFF\x7F"), "directory");
  expect_refused(with(opd, 2 + 18, "\xFF\xFF\xFF\xFF"), "directory");
  expect_refused(with(opd, record(3), "Q"), "no block of heights");
  expect_refused(with(opd, record(4), "Q"), "height scale");
  expect_refused(with(opd, record(6), "Q"), "--pitch");
  expect_refused(with(opd, record(4) + 16, "\x05"), "Wavelength");
  expect_refused(with(opd, record(3) + 18, "\xFF\xFF\xFF\x7F"), "RAW_DATA");
  const std::size_t heights = record(8) + 2;
  expect_refused(with(opd, heights, "\xFF\xFF\xFF\xFF"), "cut");
  expect_refused(with(opd, heights, std::string(2, '\0')), "no heights");
  expect_refused(with(opd, heights + 4, "\x03"), "bytes");
}

TEST_F(ProfilerFormats, KeyenceVk4) {
  for (const std::uint32_t bits : {8u, 16u, 32u})
    expect_small_scan(small_vk4({bits}), "keyence-vk4", 6);
  const auto vk4 = small_vk4({});
  constexpr std::size_t settings = 84, image = 388;
  const std::string none(4, '\0'), most(4, '\xFF');
  expect_refused({vk4.begin(), vk4.end() - 1}, "cut: its header promises");
  expect_refused({vk4.begin(), vk4.begin() + 83}, "cut in its header");
  expect_refused(with(vk4, 12, most), "settings are not there");
  expect_refused(with(vk4, settings, none), "too short");
  expect_refused(with(vk4, 36, none), "no heights");
  expect_refused(with(vk4, 36, most), "heights are not there");
  expect_refused(with(vk4, image, none), "no heights");
  expect_refused(with(vk4, image, most + most), "promises more");
  expect_refused(with(vk4, image + 8, std::string("\x18\0\0\0", 4)), "8, 16 or 32 bits");
  expect_refused(with(vk4, image + 12, "\1"), "compressed");
  expect_refused(with(vk4, settings + 176, none), "height scale");
  expect_refused(with(vk4, settings + 168, none), "--pitch");
  expect_refused(with(vk4, 8, "\1"), "no scan");
  // Counts are whole numbers without a sign, and the scale is of all 32 bits.
  const Scan high = read(with(with(vk4, image + 796, most), settings + 176, std::string("\1\0\0\0", 4)));
  EXPECT_FLOAT_EQ(static_cast<float>(high.surface.mean + static_cast<double>(high.surface.z(0, 0))),
                  4294.967295F);
}

TEST_F(ProfilerFormats, SensofarPlu) {
  expect_small_scan(small_plu(), "sensofar-plu");
  const auto plu = small_plu();
  expect_refused({plu.begin(), plu.begin() + 508 + 23}, "cut");
  expect_refused(with(plu, 500, "\xFF\xFF\xFF\xFF\xFF\xFF\xFF\xFF"), "cut");
  expect_refused(with(plu, 500, std::string(4, '\0')), "no heights");
  expect_refused(with(plu, 428, "\x01"), "no topography");
  expect_refused(with(plu, 444, "\x06"), "area");
  expect_refused(with(plu, 404, std::string("\0\0\x80\xBF", 4)), "lateral");
  // A log that begins with a date is none.
  write_text(path, "Fri Mar 10 16:35:59 2023 " + std::string(600, 'a'));
  EXPECT_EQ(recognise_scan(path), nullptr);
}

TEST_F(ProfilerFormats, GwyddionSimpleField) {
  const std::string gsf = small_gsf();
  expect_small_scan(bytes_of(gsf), "gsf");
  expect_refused(bytes_of(gsf.substr(0, gsf.size() - 1)), "cut");
  expect_refused(bytes_of(gsf.substr(0, 40)), "cut in its header");
  expect_refused(bytes_of(replaced(gsf, "XRes = 3", "XRes = 0")), "no heights");
  expect_refused(bytes_of(replaced(gsf, "XRes = 3", "XRes = x")), "XRes is no number");
  expect_refused(bytes_of(replaced(gsf, "XRes = 3", "XRes = 8")), "cut");
  expect_refused(bytes_of(replaced(gsf, "ZUnits =  m", "ZUnits =  A")), "not in metres");
  expect_refused(bytes_of(replaced(gsf, "XYUnits = m", "XYUnits = s")), "lateral unit");
  expect_refused(bytes_of(replaced(gsf, "XYUnits = m", "XYUnits =  ")), "--pitch");
  expect_refused(bytes_of(replaced(gsf, "XReal=7.5e-07", "XReal=-7.5e-7")), "lateral scale");
}

TEST_F(ProfilerFormats, X3pOfEveryTypeAndEveryWayToBeMissing) {
  for (const char type : {'I', 'L', 'F', 'D'})
    for (const char* inside : {"", "some name/", "a/b/"})
      for (const bool list : {false, true})
        for (const double missing : {std::nan(""), HUGE_VAL, -HUGE_VAL})
          expect_small_scan(
              small_x3p({.type = type, .folder = inside, .valid_points = list, .missing = missing}), "x3p");
}

TEST_F(ProfilerFormats, X3pChecksumsAreVerified) {
  // Of 1 … 6 µm as 64-bit floats; either case of the digits.
  const X3pFile list = {.valid_points = true, .md5 = ""};
  for (const char* right : {"8938b0f299162600759d0b0221d99926", "8938B0F299162600759D0B0221D99926"}) {
    X3pFile file = list;
    file.md5 = right;
    expect_small_scan(small_x3p(file), "x3p");
  }
  X3pFile file = list;
  file.md5 = "8938b0f299162600759d0b0221d99920";
  expect_refused(small_x3p(file), "MD5 checksum of its points");
}

TEST_F(ProfilerFormats, X3pRefusesWhatIsWrong) {
  const X3pFile file = {};
  const std::string main = x3p_main(file);
  const auto refused = [&](const std::string& from, const std::string& to, const char* words) {
    expect_refused(small_x3p(file, replaced(main, from, to)), words);
  };
  refused("<SizeX>3", "<SizeX>4", "fewer points");
  refused("<SizeX>3", "<SizeX>2", "make sense");
  refused("<SizeX>3", "<SizeX>4294967295", "fewer points");
  refused("<SizeX>3", "<SizeX>0", "no heights");
  refused("<SizeX>3", "<SizeX>three", "SizeX");
  refused("<SizeZ>1", "<SizeZ>2", "layers");
  refused("<DataType>D", "<DataType>X", "\"X\"");
  refused("2.5e-007", "2,5e-007", "\"2,5e-007\"");
  refused("2.5e-007", "", "--pitch");
  refused("2.5e-007", "-1", "lateral");
  refused("<CX><AxisType>I", "<CX><AxisType>A", "evenly");
  refused("</DataType><Increment/>", "</DataType><Increment>1e-6</Increment>", "increment");
  refused("bindata/data.bin", "bindata/other.bin", "missing");
  refused("<PointDataLink>bindata/data.bin</PointDataLink>", "", "main.xml");
  refused("</Record3>", "", "no XML");
  expect_refused(stored_zip({{"main.xml", main}}), "missing");
  auto bytes = small_x3p(file);
  expect_refused({bytes.begin(), bytes.end() - 1}, "zip");
  const std::size_t data =
      std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()).find("data.bin", main.size()) +
      8;
  expect_refused(with(bytes, data, "x"), "CRC");
  write_bytes(path, stored_zip({{"main.xml", "<other/>"}}));
  EXPECT_EQ(recognise_scan(path), nullptr);
  write_bytes(path, stored_zip({{"word/document.xml", "<document/>"}}));
  EXPECT_EQ(recognise_scan(path), nullptr);
}

HeightField some_surface() {
  Grid<double> z(5, 7);
  for (Eigen::Index k = 0; k < z.size(); ++k)
    z.data()[k] = 1e4 + std::sin(static_cast<double>(k));
  z(1, 2) = NAN;
  return make_height_field(z, 0.1276565, 0.3145821);
}

TEST_F(ProfilerFormats, X3pComesBackAsItWasWritten) {
  const HeightField surface = some_surface();
  write_x3p(path, surface);
  const HeightField back = read_scan(path).surface;
  constexpr double digits = 1e-15;  // of a product with 1e-6 and its inverse
  EXPECT_NEAR(back.dx, surface.dx, digits);
  EXPECT_NEAR(back.dy, surface.dy, digits);
  constexpr double rounding = 1e-7;  // of heights of ±1 µm, kept as floats
  for (Eigen::Index k = 0; k < surface.z.size(); ++k) {
    const float before = surface.z.data()[k], after = back.z.data()[k];
    if (is_missing(before))
      EXPECT_TRUE(is_missing(after));
    else
      EXPECT_NEAR(back.mean + static_cast<double>(after), surface.mean + static_cast<double>(before),
                  rounding);
  }
  // Equal surfaces make equal files.
  const auto bytes = read_bytes(path);
  write_x3p(path, surface);
  EXPECT_EQ(read_bytes(path), bytes);
}

TEST_F(ProfilerFormats, X3pIsWhatPythonReads) {
  write_x3p(path, some_surface());
  write_text(
      folder.path() / "read.py",
      "import hashlib, math, struct, zipfile\n"
      "import xml.etree.ElementTree as tree\n"
      "z = zipfile.ZipFile('" +
          path.string() +
          "')\n"
          "assert z.testzip() is None\n"
          "main, data = z.read('main.xml'), z.read('bindata/data.bin')\n"
          "assert z.read('md5checksum.hex').decode() == hashlib.md5(main).hexdigest() + ' *main.xml\\n'\n"
          "root = tree.fromstring(main)\n"
          "assert root.tag == '{http://www.opengps.eu/2008/ISO5436_2}ISO5436_2'\n"
          "text = lambda path: root.find(path).text\n"
          "assert text('Record3/DataLink/MD5ChecksumPointData') == hashlib.md5(data).hexdigest()\n"
          "assert (text('Record3/MatrixDimension/SizeX'), text('Record3/MatrixDimension/SizeY')) == ('7', "
          "'5')\n"
          "assert abs(float(text('Record1/Axes/CX/Increment')) - 0.1276565e-6) < 1e-20\n"
          "assert abs(float(text('Record1/Axes/CY/Increment')) - 0.3145821e-6) < 1e-20\n"
          "points = struct.unpack('<35d', data)\n"
          "for k, p in enumerate(points):\n"
          "  assert math.isnan(p) if k == 9 else abs(p * 1e6 - 1e4 - math.sin(k)) < 1e-6\n");
  if (std::system("/usr/bin/python3 -c ''") != 0) GTEST_SKIP() << "NOT CHECKED: there is no /usr/bin/python3";
  EXPECT_EQ(std::system(("/usr/bin/python3 " + (folder.path() / "read.py").string()).c_str()), 0);
}

TEST_F(ProfilerFormats, ExrHeightMapsAreReadWhenNamed) {
  const HeightField surface = some_surface();
  const auto read_with = [&](const std::vector<ExrChannel>& channels) {
    write_exr(path, channels, {});
    return read_scan(path, {.pitch_x = 0.25, .pitch_y = 0.5});
  };
  const Grid<float> other = Grid<float>::Zero(5, 7);
  for (const auto& channels : std::vector<std::vector<ExrChannel>>{
           {{"Y", surface.z}}, {{"height", surface.z}}, {{"A", other}, {"Y", surface.z}, {"Z", other}}}) {
    const Scan scan = read_with(channels);
    EXPECT_EQ(scan.format, "exr");
    EXPECT_EQ(recognise_scan(path)->listed, ScanFormat::Listed::WhenNamed);
    EXPECT_EQ(scan.surface.dx, 0.25);
    EXPECT_EQ(scan.surface.dy, 0.5);
    ASSERT_EQ(scan.surface.rows(), 5);
    ASSERT_EQ(scan.surface.cols(), 7);
    for (Eigen::Index k = 0; k < surface.z.size(); ++k)
      if (is_missing(surface.z.data()[k]))
        EXPECT_TRUE(is_missing(scan.surface.z.data()[k]));
      else
        EXPECT_NEAR(scan.surface.mean + static_cast<double>(scan.surface.z.data()[k]),
                    static_cast<double>(surface.z.data()[k]), kRounding);
  }
  EXPECT_THROW(read_with({{"R", other}, {"G", other}}), FileError);
  EXPECT_THROW(read_scan(path), FileError) << "no pitch";
}

}  // namespace
}  // namespace micro
