#include "io/sdf.h"

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/words.h"

namespace micro {
namespace {

using std::string_view;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::array kAscii = {string_view("aISO-1.0"), string_view("aBCR-1.0")};
constexpr std::array kBinary = {string_view("bISO-1.0"), string_view("bBCR-1.0")};

/// What both kinds of header say that matters here.
struct Header {
  std::uint64_t cols, rows;  ///< points of a profile, profiles
  double dx, dy, dz;         ///< metres between points, between profiles, per unit of height
  int compression, type;
};

/// Checks what can be wrong whatever the kind. Returns micrometres per unit of height.
double checked_step(const FileBytes& file, const Header& header) {
  file.require(header.cols > 0 && header.rows > 0, "holds no heights");
  file.require(header.compression == 0, "its heights are compressed, in a way that nothing says");
  const double step = header.dz * 1e6;
  file.require(std::isfinite(step) && step != 0, "its height scale makes no sense");
  return step;
}

bool starts_with_any(std::span<const std::byte> bytes, const std::array<string_view, 2>& magics) {
  return begins_with(bytes, magics[0]) || begins_with(bytes, magics[1]);
}

string_view first_word(string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t");
  if (begin == string_view::npos) return {};
  return text.substr(begin, text.find_first_of(" \t", begin) - begin);
}

/// The lines "key = value" up to and with the line "*".
Header read_ascii_header(const FileBytes& file, Words& words) {
  std::map<string_view, string_view> fields;
  constexpr int most_lines = 100;
  for (int lines = 0;; ++lines) {
    const string_view line = words.line();
    if (line.starts_with('*')) break;
    file.require(lines < most_lines, "its header does not end");
    if (const std::size_t equals = line.find('='); equals != string_view::npos)
      fields.emplace(first_word(line.substr(0, equals)), first_word(line.substr(equals + 1)));
  }
  const auto get = [&](string_view key, auto value) {
    const auto found = fields.find(key);
    if (found == fields.end() || !parse_number(found->second, value))
      throw FileError(file.path(), "its header has no number " + std::string(key));
    return value;
  };
  return {.cols = get("NumPoints", std::uint32_t{}),
          .rows = get("NumProfiles", std::uint32_t{}),
          .dx = get("Xscale", 0.),
          .dy = get("Yscale", 0.),
          .dz = get("Zscale", 0.),
          .compression = get("Compression", 0),
          .type = get("DataType", 0)};
}

HeightField read_ascii(const FileBytes& file, const ReadOptions& options) {
  Words words(file, "*");
  const Header header = read_ascii_header(file, words);
  const double step = checked_step(file, header);
  const Pitch pitch = file_pitch(file.path(), {header.dx * 1e6, header.dy * 1e6}, options);
  const std::uint64_t count = header.cols * header.rows;  // two 32-bit numbers
  constexpr std::size_t shortest = sizeof "0 " - 1;
  file.require(count <= words.remaining() / shortest,
               "is cut: it has fewer heights than its header promises");
  std::vector<double> z(count);
  for (double& value : z) {
    if (const string_view next = words.peek(); next == "BAD" || next == "bad") {
      words.word();
      value = kNaN;
    } else {
      value = words.number<double>() * step;
    }
  }
  words.close_block();
  return read_height_field(file.path(), header.rows, header.cols, pitch,
                           [&](Eigen::Index k) { return z[static_cast<std::size_t>(k)]; });
}

/// Where the fields of a binary header stand, bytes; all little-endian.
enum Offset : std::size_t {
  kCols = 42,         // u16
  kRows = 44,         // u16
  kDx = 46,           // f64, m
  kDy = 54,           // f64, m
  kDz = 62,           // f64, m
  kCompression = 78,  // u8
  kType = 79,         // u8
};
constexpr std::size_t kHeaderBytes = 81;
constexpr std::size_t kOlympusExtra = 8;  ///< Olympus's software puts two more integers behind the header

template <typename T>
HeightField read_points(const FileBytes& file, const Header& header, double step, Pitch pitch) {
  const std::uint64_t bytes = header.cols * header.rows * sizeof(T);  // two 16-bit numbers, 8 at most
  file.require(bytes <= file.size() - kHeaderBytes, "is cut: its header promises more heights than it has");
  const bool olympus = file.size() == kHeaderBytes + bytes + kOlympusExtra;
  const std::byte* data = file.data() + kHeaderBytes + (olympus ? kOlympusExtra : 0);
  constexpr bool marked = sizeof(T) > 1;  // bytes have no value to spare
  constexpr T missing =
      std::numeric_limits<T>::is_signed ? std::numeric_limits<T>::lowest() : std::numeric_limits<T>::max();
  return read_height_field(file.path(), header.rows, header.cols, pitch, [=](Eigen::Index k) {
    const T raw = load<T>(data + k * static_cast<Eigen::Index>(sizeof(T)), std::endian::little);
    return marked && raw == missing ? kNaN : static_cast<double>(raw) * step;
  });
}

HeightField read_binary(const FileBytes& file, const ReadOptions& options) {
  file.require(file.size() >= kHeaderBytes, "is cut in its header");
  const auto real = [&](Offset offset) { return load<double>(file.data() + offset, std::endian::little); };
  const auto count = [&](Offset offset) {
    return load<std::uint16_t>(file.data() + offset, std::endian::little);
  };
  const auto byte = [&](Offset offset) { return std::to_integer<int>(file.data()[offset]); };
  const Header header = {.cols = count(kCols),
                         .rows = count(kRows),
                         .dx = real(kDx),
                         .dy = real(kDy),
                         .dz = real(kDz),
                         .compression = byte(kCompression),
                         .type = byte(kType)};
  const double step = checked_step(file, header);
  const Pitch pitch = file_pitch(file.path(), {header.dx * 1e6, header.dy * 1e6}, options);
  using Read = HeightField (*)(const FileBytes&, const Header&, double, Pitch);
  constexpr std::array<Read, 8> read = {
      read_points<std::uint8_t>, read_points<std::uint16_t>, read_points<std::uint32_t>, read_points<float>,
      read_points<std::int8_t>,  read_points<std::int16_t>,  read_points<std::int32_t>,  read_points<double>};
  const auto type = static_cast<std::size_t>(header.type);
  if (type >= read.size())
    throw FileError(file.path(), "its data type " + std::to_string(type) + " is unknown (0 to 7 are known)");
  return read[type](file, header, step, pitch);
}

}  // namespace

bool is_sdf(const FileHead& head) {
  return starts_with_any(head.bytes, kAscii) || starts_with_any(head.bytes, kBinary);
}

HeightField read_sdf(const std::filesystem::path& path, const ReadOptions& options) {
  const FileBytes file(path);
  return starts_with_any(file.bytes(), kAscii) ? read_ascii(file, options) : read_binary(file, options);
}

}  // namespace micro
