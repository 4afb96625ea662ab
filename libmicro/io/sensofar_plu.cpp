#include "io/sensofar_plu.h"

#include <limits>
#include <span>
#include <string_view>

#include "io/bytes.h"

namespace micro {
namespace {

using std::string_view;

/// Where the fields stand, bytes; all little-endian.
enum Offset : std::size_t {
  kSize = 388,      // u32 rows, u32 cols
  kDx = 404,        // f32, µm
  kDy = 408,        // f32, µm
  kKind = 428,      // u32: 1 profile, 3 topography
  kAreaType = 444,  // u32
  kRows = 500,      // u32, once more
  kCols = 504,      // u32
  kHeights = 508,   // f32, µm
};
constexpr std::uint32_t kTopography = 3;
constexpr std::uint32_t kOtherLayout = 6;  ///< an area type whose header is laid out in another way
constexpr float kMissingHeight = 1000001;

/// Does the text begin with one of the names, three letters each?
bool has_name(string_view text, string_view names) {
  for (std::size_t k = 0; k < names.size(); k += 3)
    if (text.starts_with(names.substr(k, 3))) return true;
  return false;
}

/// A date as asctime and ctime write it.
bool begins_with_date(std::span<const std::byte> bytes) {
  constexpr string_view pattern = "Fri Mar 10 16:35:59 2023";
  const string_view date(reinterpret_cast<const char*>(bytes.data()), pattern.size() + 1);
  return has_name(date, "SunMonTueWedThuFriSat") && date[3] == ' ' &&
         has_name(date.substr(4), "JanFebMarAprMayJunJulAugSepOctNovDec") && date[7] == ' ' &&
         date[13] == ':' && date[16] == ':' && (date.back() == '\0' || date.back() == '\n');
}

/// A topography whose two statements of its size are one, and which has that many heights: the date before it
/// may be written in any way.
bool agrees_with_itself(const FileHead& head) {
  const auto integer = [&](std::size_t at) {
    return load<std::uint32_t>(head.bytes.data() + at, std::endian::little);
  };
  const std::uint64_t rows = integer(kRows), cols = integer(kCols);
  return integer(kKind) == kTopography && rows > 0 && cols > 0 && rows == integer(kSize) &&
         cols == integer(kSize + 4) && rows <= (head.size - kHeights) / sizeof(float) / cols;
}

}  // namespace

bool is_sensofar_plu(const FileHead& head) {
  if (head.bytes.size() < kHeights) return false;
  return begins_with_date(head.bytes) || agrees_with_itself(head);
}

HeightField read_sensofar_plu(const std::filesystem::path& path, const ReadOptions& options) {
  const FileBytes file(path);
  file.require(file.size() >= kHeights, "is cut in its header");
  const auto integer = [&](Offset at) { return load<std::uint32_t>(file.data() + at, std::endian::little); };
  const auto real = [&](Offset at) -> double { return load<float>(file.data() + at, std::endian::little); };
  file.require(integer(kKind) == kTopography, "is a Sensofar file, but holds no topography");
  file.require(integer(kAreaType) != kOtherLayout, "its area was measured in a way that is not read");
  const std::uint64_t rows = integer(kRows), cols = integer(kCols);
  file.require(rows > 0 && cols > 0, "holds no heights");
  file.require(rows <= (file.size() - kHeights) / sizeof(float) / cols,
               "is cut: its header promises more heights than it has");
  const Pitch pitch = file_pitch(path, {real(kDx), real(kDy)}, options);
  const std::byte* data = file.data() + kHeights;
  return read_height_field(path, rows, cols, pitch, [=](Eigen::Index k) {
    const float z = load<float>(data + k * static_cast<Eigen::Index>(sizeof(float)), std::endian::little);
    return z == kMissingHeight ? std::numeric_limits<double>::quiet_NaN() : static_cast<double>(z);
  });
}

}  // namespace micro
