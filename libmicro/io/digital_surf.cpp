#include "io/digital_surf.h"

#include <zlib.h>

#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/bytes.h"
#include "io/printable.h"

namespace micro {
namespace {

using std::string_view;

constexpr string_view kPlain = "DIGITAL SURF";
constexpr string_view kCompressed = "DSCOMPRESSED";
constexpr std::size_t kHeaderBytes = 512;

/// Where the fields stand in the header, bytes.
enum Offset : std::size_t {
  kByteOrder = 12,      // i16: 0 PC, 257 Macintosh
  kObjects = 14,        // i16
  kType = 18,           // i16: 2 is a surface
  kSpecialPoints = 86,  // i16
  kBits = 98,           // i16
  kZMin = 100,          // i32
  kCols = 108,          // i32
  kRows = 112,          // i32
  kDx = 120,            // f32
  kDy = 124,            // f32
  kDz = 128,            // f32
  kDxUnit = 180,        // char[16]
  kDyUnit = 196,        // char[16]
  kDzUnit = 212,        // char[16]
  kCommentSize = 334,   // u16
  kPrivateSize = 336,   // u16
  kXOffset = 466,       // f32, in the unit of x
  kYOffset = 470,       // f32, in the unit of y
  kZOffset = 474,       // f32, in the unit of z
};

/// A unit of length in µm. Throws FileError if it is unknown.
double micrometres(const FileBytes& file, Offset offset, const char* axis) {
  constexpr std::size_t size = 16;
  string_view unit = file.text().substr(offset, size);
  unit = unit.substr(0, unit.find('\0'));
  unit = unit.substr(0, unit.find_last_not_of(' ') + 1);
  struct Unit {
    string_view name;
    double micrometres;
  };
  constexpr std::array units = {Unit{"m", 1e6},       Unit{"mm", 1e3},      Unit{"\xB5m", 1},  // Latin-1
                                Unit{"\xC2\xB5m", 1}, Unit{"\xCE\xBCm", 1},  // UTF-8: micro sign, Greek mu
                                Unit{"um", 1},        Unit{"nm", 1e-3}};
  for (const Unit& candidate : units)
    if (candidate.name == unit) return candidate.micrometres;
  throw FileError(file.path(),
                  "its unit along " + std::string(axis) + ", " + in_quotes(unit) + ", is unknown");
}

/// What the header says, in the file's byte order. Throws FileError if it is no header of one.
class Header {
 public:
  explicit Header(const FileBytes& file) : data_(file.data()) {
    file.require(file.size() >= kHeaderBytes, "is shorter than a Digital Surf header");
    const auto byte_order = load<std::int16_t>(data_ + kByteOrder, std::endian::little);
    file.require(byte_order == 0 || byte_order == 257, "its byte order is unknown");
    order = byte_order == 0 ? std::endian::little : std::endian::big;
  }

  std::int32_t integer(Offset offset) const { return load<std::int32_t>(data_ + offset, order); }
  std::int16_t small(Offset offset) const { return load<std::int16_t>(data_ + offset, order); }
  double real(Offset offset) const { return load<float>(data_ + offset, order); }

  std::endian order;

 private:
  const std::byte* data_;
};

/// The points of a compressed file: from `at` on stand the number of streams, the bytes of each unpacked and
/// packed, and the streams themselves. Those behind the `wanted` bytes are left alone.
std::vector<std::byte> unpack(const FileBytes& file, std::uint64_t at, std::endian order,
                              std::uint64_t wanted) {
  constexpr std::uint64_t most_compression = 1100;  // deflate: 1032 : 1, and its frame
  constexpr std::uint64_t entry_bytes = 8;
  file.require(file.size() - at >= 4, "is cut: it has no directory of its compressed points");
  const auto integer = [&](std::uint64_t where) { return load<std::uint32_t>(file.data() + where, order); };
  const std::uint64_t streams = integer(at);
  std::uint64_t entry = at + 4;
  file.require(streams <= (file.size() - entry) / entry_bytes,
               "is cut in the directory of its compressed points");
  std::uint64_t packed_at = entry + streams * entry_bytes;
  std::vector<std::byte> points;
  for (std::uint64_t k = 0; k < streams && points.size() < wanted; ++k, entry += entry_bytes) {
    const std::uint64_t size = integer(entry), packed = integer(entry + 4);
    file.require(packed <= file.size() - packed_at, "is cut: its compressed points are longer than the file");
    file.require(size <= packed * most_compression,
                 "says that its compressed points are larger than they can be");
    const std::size_t before = points.size();
    points.resize(before + size);
    uLongf done = size;
    const int result = uncompress(reinterpret_cast<Bytef*>(points.data() + before), &done,
                                  reinterpret_cast<const Bytef*>(file.data() + packed_at), packed);
    file.require(result == Z_OK && done == size, "its compressed points cannot be unpacked");
    packed_at += packed;
  }
  return points;
}

template <typename T>
HeightField read_points(const FileBytes& file, const std::byte* data, std::endian order, std::uint64_t rows,
                        std::uint64_t cols, Pitch pitch, double step, double offset,
                        std::optional<std::int64_t> missing) {
  return read_height_field(file.path(), rows, cols, pitch, [=](Eigen::Index k) {
    const T raw = load<T>(data + k * static_cast<Eigen::Index>(sizeof(T)), order);
    return missing && raw == *missing ? std::numeric_limits<double>::quiet_NaN() : raw * step + offset;
  });
}

}  // namespace

bool is_digital_surf(const FileHead& head) {
  return begins_with(head.bytes, kPlain) || begins_with(head.bytes, kCompressed);
}

HeightField read_digital_surf(const std::filesystem::path& path, const ReadOptions& options) {
  const FileBytes file(path);
  const Header header(file);
  const std::endian order = header.order;
  file.require(header.small(kType) == 2, "is a Digital Surf file, but its object is no surface");
  file.require(header.small(kObjects) <= 1, "holds several objects; files with one surface are read");
  const int bits = header.small(kBits);
  file.require(bits == 16 || bits == 32, "its points have neither 16 nor 32 bits");
  file.require(header.integer(kCols) > 0 && header.integer(kRows) > 0, "holds no heights");
  const auto cols = static_cast<std::uint64_t>(header.integer(kCols));
  const auto rows = static_cast<std::uint64_t>(header.integer(kRows));
  const std::uint64_t begin = kHeaderBytes + load<std::uint16_t>(file.data() + kCommentSize, order) +
                              load<std::uint16_t>(file.data() + kPrivateSize, order);
  file.require(begin <= file.size(), "is cut in its header");
  const auto bytes_each = static_cast<std::uint64_t>(bits / 8);
  std::vector<std::byte> unpacked;
  std::span<const std::byte> data = file.bytes().subspan(begin);
  if (begins_with(file.bytes(), kCompressed))
    data = unpacked = unpack(file, begin, order, rows * cols * bytes_each);
  file.require(rows <= data.size() / bytes_each / cols,
               "is cut: its header promises more points than it has");

  const Pitch pitch = file_pitch(path,
                                 {header.real(kDx) * micrometres(file, kDxUnit, "x"),
                                  header.real(kDy) * micrometres(file, kDyUnit, "y")},
                                 options);
  const double unit = micrometres(file, kDzUnit, "z");
  const double step = header.real(kDz) * unit, offset = header.real(kZOffset) * unit;
  file.require(std::isfinite(step) && step != 0 && std::isfinite(offset), "its height scale makes no sense");
  const auto missing = header.small(kSpecialPoints) == 1
                           ? std::optional<std::int64_t>(std::int64_t{header.integer(kZMin)} - 2)
                           : std::nullopt;
  const auto read = bits == 16 ? read_points<std::int16_t> : read_points<std::int32_t>;
  return read(file, data.data(), order, rows, cols, pitch, step, offset, missing);
}

std::optional<StageWindow> stage_of_digital_surf(const std::filesystem::path& path) {
  const FileBytes file(path, kHeaderBytes);
  const Header header(file);
  const double x_unit = micrometres(file, kDxUnit, "x"), y_unit = micrometres(file, kDyUnit, "y");
  return StageWindow{.x = header.real(kXOffset) * x_unit,
                     .y = header.real(kYOffset) * y_unit,
                     .width = header.integer(kCols) * header.real(kDx) * x_unit,
                     .height = header.integer(kRows) * header.real(kDy) * y_unit};
}

}  // namespace micro
