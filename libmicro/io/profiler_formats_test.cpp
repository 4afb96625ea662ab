#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "core/error.h"
#include "io/scan.h"
#include "io/small_profiler_scans_test.h"
#include "io/small_scans_test.h"
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
  /// Heights 1, 2, 3 / 4, 5, missing µm at 0.25 × 0.5 µm.
  void expect_small_scan(const std::vector<std::byte>& bytes, const std::string& format) const {
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
    EXPECT_TRUE(is_missing(scan.surface.z(1, 2)));
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
    const auto bytes = small_sdf_binary({.type = type});
    if (type == 0 || type == 4) {
      const Scan scan = read(bytes);
      EXPECT_EQ(missing_count(scan.surface), 0);
      EXPECT_NEAR(scan.surface.mean + static_cast<double>(scan.surface.z(1, 2)), 6, kRounding);
    } else {
      expect_small_scan(bytes, "sdf");
    }
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

}  // namespace
}  // namespace micro
