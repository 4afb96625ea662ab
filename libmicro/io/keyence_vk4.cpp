#include "io/keyence_vk4.h"

#include <string_view>

#include "io/bytes.h"

namespace micro {
namespace {

/// Where the fields stand, bytes; all are u32, little-endian.
enum Header : std::size_t {
  kKind = 8,        // 0: a measurement
  kSettings = 12,   // where the settings begin
  kHeights = 36,    // where the first height image begins, 0: there is none
  kHeaderSize = 84  // 18 such places, from 12 on
};
enum Settings : std::size_t {
  kSettingsSize = 0,  // bytes, this field included
  kDx = 168,          // pm
  kDy = 172,          // pm
  kDz = 176,          // pm a digit
  kLeastSettings = 180
};
enum Image : std::size_t {
  kCols = 0,
  kRows = 4,
  kBits = 8,  // of a height: 8, 16, 32
  kCompression = 12,
  kPoints = 796  // behind the image's size in bytes, a range and a palette of 3 · 256 bytes
};
constexpr std::string_view kMagic = "VK4_";
constexpr double kPicometre = 1e-6;  // µm

std::uint32_t integer(const std::byte* at) {
  return load<std::uint32_t>(at, std::endian::little);
}

/// The height of a point, digits.
std::uint32_t digits(const std::byte* points, std::size_t k, std::uint32_t bits) {
  if (bits == 8) return load<std::uint8_t>(points + k, std::endian::little);
  if (bits == 16) return load<std::uint16_t>(points + 2 * k, std::endian::little);
  return integer(points + 4 * k);
}

}  // namespace

bool is_keyence_vk4(const FileHead& head) {
  return begins_with(head.bytes, kMagic) && head.bytes.size() >= kSettings &&
         integer(head.bytes.data() + kKind) == 0;
}

HeightField read_keyence_vk4(const std::filesystem::path& path, const ReadOptions& options) {
  const FileBytes file(path);
  file.require(file.size() >= kHeaderSize, "is cut in its header");
  const auto part = [&](Header place, std::size_t size, const char* cut) {
    const std::size_t begin = integer(file.data() + place);
    file.require(begin <= file.size() && size <= file.size() - begin, cut);
    return file.data() + begin;
  };
  const std::byte* settings = part(kSettings, kLeastSettings, "is cut: its settings are not there");
  file.require(integer(settings + kSettingsSize) >= kLeastSettings, "its settings are too short for a scale");
  file.require(integer(file.data() + kHeights) > 0, "holds no heights");
  const std::byte* image = part(kHeights, kPoints, "is cut: its heights are not there");

  const std::uint32_t bits = integer(image + kBits), unit = integer(settings + kDz);
  file.require(bits == 8 || bits == 16 || bits == 32, "its heights do not have 8, 16 or 32 bits");
  file.require(integer(image + kCompression) == 0, "its heights are compressed, which is not read");
  file.require(unit > 0, "its height scale makes no sense: 0 pm");
  const std::uint64_t rows = integer(image + kRows), cols = integer(image + kCols);
  file.require(rows > 0 && cols > 0, "holds no heights");
  const std::byte* points = image + kPoints;
  const auto available = static_cast<std::uint64_t>(file.data() + file.size() - points);
  file.require(rows <= available / (bits / 8) / cols, "is cut: its header promises more heights than it has");
  const Pitch pitch =
      file_pitch(path, {integer(settings + kDx) * kPicometre, integer(settings + kDy) * kPicometre}, options);
  return read_height_field(path, rows, cols, pitch, [=](Eigen::Index k) {
    return digits(points, static_cast<std::size_t>(k), bits) * (unit * kPicometre);
  });
}

}  // namespace micro
