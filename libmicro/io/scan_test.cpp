#include "io/scan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <map>
#include <sstream>

#include "core/error.h"
#include "io/microbrdf_hdf5.h"
#include "io/small_scans_of_every_format_test.h"
#include "io/small_scans_test.h"
#include "testing/temporary_folder.h"

namespace micro {
namespace {

namespace fs = std::filesystem;

/// Heights in µm, the mean included.
Grid<double> heights(const HeightField& surface) {
  return surface.z.cast<double>() + surface.mean;
}

struct Expected {
  std::string file;
  Eigen::Index nx = 0, ny = 0, missing = 0;
  double dx = 0, dy = 0, min = 0, max = 0, mean = 0, rms = 0, first = 0, second = 0, last = 0;
};

std::vector<Expected> expected_table(const fs::path& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  std::vector<Expected> table;
  while (std::getline(file, line)) {
    std::istringstream words(line);
    Expected e;
    std::string first, second, last;
    words >> e.file >> e.nx >> e.ny >> e.dx >> e.dy >> e.min >> e.max >> e.mean >> e.rms >> e.missing >>
        first >> second >> last;
    e.first = std::stod(first);
    e.second = std::stod(second);
    e.last = std::stod(last);
    table.push_back(e);
  }
  return table;
}

void expect_height(double value, double expected, double tolerance, const char* which) {
  if (std::isnan(expected)) {
    EXPECT_TRUE(std::isnan(value)) << which;
  } else {
    EXPECT_NEAR(value, expected, tolerance) << which;
  }
}

class RealFile : public ::testing::TestWithParam<const char*> {};

TEST_P(RealFile, GivesWhatTwoOtherReadersGive) {
  const fs::path folder = MICRO_SCANS_DIR;
  if (!fs::exists(folder / "expected.tsv")) GTEST_SKIP() << "NOT CHECKED: " << folder << " is missing";
  const auto table = expected_table(folder / "expected.tsv");
  const std::string file = GetParam();
  const auto e =
      std::find_if(table.begin(), table.end(), [&](const Expected& row) { return row.file == file; });
  ASSERT_NE(e, table.end());
  const Scan scan = read_scan(folder / file);
  ASSERT_EQ(scan.surface.cols(), e->nx);
  ASSERT_EQ(scan.surface.rows(), e->ny);
  EXPECT_EQ(missing_count(scan.surface), e->missing);
  constexpr double digits = 1e-8;  // of the table's dx and dy, which have nine
  EXPECT_NEAR(scan.surface.dx, e->dx, digits * e->dx);
  EXPECT_NEAR(scan.surface.dy, e->dy, digits * e->dy);
  const double tolerance = 1e-6 * (e->max - e->min);
  const Grid<double> z = heights(scan.surface);
  const auto valid = !z.isNaN();
  const double count = static_cast<double>(valid.count());
  EXPECT_NEAR(valid.select(z, e->max).minCoeff(), e->min, tolerance);
  EXPECT_NEAR(valid.select(z, e->min).maxCoeff(), e->max, tolerance);
  EXPECT_NEAR(scan.surface.mean, e->mean, tolerance);
  EXPECT_NEAR(std::sqrt(valid.select((z - scan.surface.mean).square(), 0).sum() / count), e->rms, tolerance);
  expect_height(z(0, 0), e->first, tolerance, "first");
  expect_height(z(0, 1), e->second, tolerance, "second");
  expect_height(z(e->ny - 1, e->nx - 1), e->last, tolerance, "last");
}

constexpr const char* kRealFiles[] = {
    "newview_milled.asc",       "newview_smooth.dat",       "wyko_rough_float.opd",
    "sensofar_brushed.plu",     "example_ascii.sdf",        "scratches.sur",
    "zygo_gpi_fringes.datx",    "wyko_toolmarks_int16.opd", "uncompressed.sur",
    "grooves_mountainsmap.x3p", "striated_bullet_land.x3p", "rubber_alicona.x3p",
    "bullet_land_nested.x3p"};
INSTANTIATE_TEST_SUITE_P(Scans, RealFile, ::testing::ValuesIn(kRealFiles), [](const auto& file) {
  std::string name = file.param;
  std::replace(name.begin(), name.end(), '.', '_');
  return name;
});

TEST(Scan, EveryRealFileIsTried) {
  const fs::path folder = MICRO_SCANS_DIR;
  if (!fs::exists(folder / "expected.tsv")) GTEST_SKIP() << "NOT CHECKED: " << folder << " is missing";
  for (const Expected& e : expected_table(folder / "expected.tsv"))
    EXPECT_NE(std::find(std::begin(kRealFiles), std::end(kRealFiles), e.file), std::end(kRealFiles))
        << e.file;
}

TEST(Scan, StageCoordinatesAreThoseOfTheHeaders) {
  const fs::path folder = MICRO_SCANS_DIR;
  if (!fs::exists(folder / "expected.tsv")) GTEST_SKIP() << "NOT CHECKED: " << folder << " is missing";
  // As a hexadecimal dump and the XML show them.
  const StageWindow sur = stage_window(folder / "scratches.sur");
  EXPECT_NEAR(sur.x, 3.457248265448243e-06, 1e-15);
  EXPECT_NEAR(sur.y, -1.4278494830932686e-05, 1e-15);
  const StageWindow x3p = stage_window(folder / "grooves_mountainsmap.x3p");
  EXPECT_NEAR(x3p.x, 76.5614218798151, 1e-10);
  EXPECT_NEAR(x3p.y, 12.9451679506934, 1e-10);
  for (const char* file : {"scratches.sur", "grooves_mountainsmap.x3p"}) {
    const HeightField surface = read_scan(folder / file).surface;
    const StageWindow window = stage_window(folder / file);
    EXPECT_NEAR(window.width, surface.dx * static_cast<double>(surface.cols()), 1e-9 * window.width);
    EXPECT_NEAR(window.height, surface.dy * static_cast<double>(surface.rows()), 1e-9 * window.height);
  }
  EXPECT_THROW(stage_window(folder / "newview_smooth.dat"), FileError);
}

TEST(Scan, OtherFilesAreNoScans) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "scan.dat";  // the name says nothing
  for (const std::string& text :
       {std::string(), std::string("# only a comment\n"), std::string("x y z\n1 2 3\n"),
        std::string("PK\3\4"), std::string(5000, 'a'), std::string(5000, '\0')}) {
    write_text(path, text);
    EXPECT_EQ(recognise_scan(path), nullptr) << text.substr(0, 20);
    EXPECT_THROW(read_scan(path), FileError);
  }
  EXPECT_THROW(recognise_scan(folder.path()), FileError);
  EXPECT_THROW(recognise_scan(folder.path() / "none"), FileError);
}

TEST(Scan, APitchThatContradictsTheFileIsRefused) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a";
  write_bytes(path, small_dat({}));
  EXPECT_NO_THROW(read_scan(path, {.pitch_x = 0.25, .pitch_y = {}}));
  EXPECT_THROW(read_scan(path, {.pitch_x = 0.26, .pitch_y = {}}), FileError);
  EXPECT_THROW(read_scan(path, {.pitch_x = 0.25, .pitch_y = 0.5}), FileError);
}

/// One small file of every format.
std::map<std::string, std::vector<std::byte>> one_of_each(const fs::path& folder) {
  std::map<std::string, std::vector<std::byte>> files;
  for (const auto& [name, scans] : small_scans_of_every_format(folder))
    files[name] = scans.front();
  return files;
}

TEST(Scan, EveryFormatIsRecognisedByContent) {
  const TemporaryFolder folder;
  const auto files = small_scans_of_every_format(folder.path());
  const auto readable =
      std::count_if(scan_formats().begin(), scan_formats().end(),
                    [](const ScanFormat& format) { return format.listed != ScanFormat::Listed::Never; });
  EXPECT_EQ(static_cast<std::ptrdiff_t>(files.size()), readable);
  for (const auto& [name, scans] : files)
    for (const auto& bytes : scans) {
      write_bytes(folder.path() / "a", bytes);
      const bool without_pitch = name == "npy" || name == "text" || name == "exr";
      const Scan scan = read_scan(
          folder.path() / "a", without_pitch ? ReadOptions{.pitch_x = 0.25, .pitch_y = 0.5} : ReadOptions{});
      EXPECT_EQ(scan.format, name);
      EXPECT_FLOAT_EQ(static_cast<float>(scan.surface.dx), 0.25F) << name;
      EXPECT_GE(scan.surface.rows(), 2) << name;
    }
}

TEST(Scan, OurFilesAreKnownWhenTheyAreCut) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a";
  const auto heights = one_of_each(folder.path())["microbrdf-hdf5"];
  write_bytes(path, {heights.begin(), heights.end() - 10});
  EXPECT_EQ(recognise_scan(path)->name, "microbrdf-hdf5");
  EXPECT_THROW(read_scan(path), FileError);
  fs::remove(path);
  Hdf5Writer result(path);
  write_origin(result, {.version = "0", .created = "now", .command = "test"});
  result.create_group("/scans");
  result.write("/ndf/naive/density", Grid<float>(Grid<float>::Ones(64, 64)));
  result.finish();
  EXPECT_EQ(recognise_scan(path)->name, "microbrdf-result");
  EXPECT_THROW(read_scan(path), FileError);
  const auto whole = read_bytes(path);
  write_bytes(path, {whole.begin(), whole.end() - 10});
  EXPECT_EQ(recognise_scan(path)->name, "microbrdf-result");
}

/// Reads whatever is there: a scan or a refusal are both fine, nothing else is.
void read_or_refuse(const fs::path& path, const std::string& what) {
  try {
    const Scan scan = read_scan(path, {.pitch_x = 0.25, .pitch_y = {}});
    EXPECT_GT(scan.surface.z.size(), 0) << what;
    EXPECT_FALSE(scan.surface.z.isInf().any()) << what;
  } catch (const FileError& error) {
    EXPECT_EQ(error.file(), path) << what;
  }
}

/// How many bytes of the small files may be lost without harm: a last line feed, a trailer, numbers that
/// nobody needs.
const std::map<std::string, std::size_t> kFreeBytes = {
    {"zygo-asc", 1}, {"zygo-xyz", 1}, {"sdf", 19}, {"sensofar-plu", 8}};

TEST(Scan, AFileCutAnywhereIsRefused) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a";
  for (auto [name, bytes] : one_of_each(folder.path())) {
    // Every length that our own parsers see; those on libraries are read in a child process.
    const bool library = name == "x3p" || name == "exr" || name == "zygo-datx" || name == "microbrdf-hdf5";
    const std::size_t stride = library ? 97 : 1;
    const auto free = kFreeBytes.find(name);
    const std::size_t trailing = free == kFreeBytes.end() ? 0 : free->second;
    for (std::size_t length = 0; length + trailing < bytes.size(); length += stride) {
      write_bytes(path, {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length)});
      const std::string what = name + " cut to " + std::to_string(length);
      if (name == "text")
        read_or_refuse(path, what);
      else
        EXPECT_THROW(read_scan(path, {.pitch_x = 0.25, .pitch_y = 0.5}), FileError) << what;
    }
  }
}

}  // namespace
}  // namespace micro
