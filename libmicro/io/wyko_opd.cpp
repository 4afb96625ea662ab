#include "io/wyko_opd.h"

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <string_view>

#include "io/bytes.h"
#include "io/printable.h"

namespace micro {
namespace {

using std::string_view;

constexpr string_view kMagic("\x01\0Directory\0", 12);
constexpr std::size_t kDirectory = 2;     ///< where its own record stands
constexpr std::size_t kRecordBytes = 24;  ///< name char[16], type i16, length i32, attributes u16
constexpr std::array kHeightNames = {string_view("RAW_DATA"), string_view("RAW DATA"), string_view("OPD"),
                                     string_view("Raw")};

enum Type : int { kArray = 3, kInt16 = 6, kFloat = 7, kDouble = 8, kInt32 = 12 };

struct Block {
  int type;
  std::uint64_t begin, size;  ///< bytes
};

template <typename T>
T number(const FileBytes& file, std::uint64_t at) {
  return load<T>(file.data() + at, std::endian::little);
}

/// The blocks by their names. Their data follow the directory in its order; those without data are left out.
std::map<string_view, Block> read_directory(const FileBytes& file) {
  file.require(file.size() >= kDirectory + kRecordBytes, "is cut in its directory");
  const auto bytes = number<std::int32_t>(file, kDirectory + 18);
  file.require(bytes >= static_cast<std::int32_t>(kRecordBytes) &&
                   static_cast<std::uint64_t>(bytes) <= file.size() - kDirectory,
               "is cut: its directory is longer than the file");
  std::map<string_view, Block> blocks;
  std::uint64_t begin = kDirectory + static_cast<std::uint64_t>(bytes);
  const std::uint64_t records = static_cast<std::uint64_t>(bytes) / kRecordBytes;
  for (std::uint64_t k = 1; k < records; ++k) {
    const std::uint64_t record = kDirectory + k * kRecordBytes;
    const string_view padded = file.text().substr(record, 16);
    const string_view name = padded.substr(0, padded.find('\0'));
    const auto size = number<std::int32_t>(file, record + 18);
    if (size <= 0) continue;
    const Block block = {number<std::int16_t>(file, record + 16), begin, static_cast<std::uint64_t>(size)};
    if (block.size > file.size() - begin)
      throw FileError(file.path(), "is cut: its block " + in_quotes(name) + " is longer than the file");
    blocks.emplace(name, block);
    begin += block.size;
  }
  return blocks;
}

class Numbers {
 public:
  Numbers(const FileBytes& file, const std::map<string_view, Block>& blocks) : file_(file), blocks_(blocks) {}

  /// The number of that name, or `otherwise` if there is none.
  double get(string_view name, double otherwise) const {
    const auto found = blocks_.find(name);
    if (found == blocks_.end()) return otherwise;
    const auto [type, begin, size] = found->second;
    if (type == kInt16 && size >= 2) return number<std::int16_t>(file_, begin);
    if (type == kInt32 && size >= 4) return number<std::int32_t>(file_, begin);
    if (type == kFloat && size >= 4) return static_cast<double>(number<float>(file_, begin));
    if (type == kDouble && size >= 8) return number<double>(file_, begin);
    throw FileError(file_.path(), "its " + std::string(name) + " is no number");
  }

 private:
  const FileBytes& file_;
  const std::map<string_view, Block>& blocks_;
};

const Block& height_block(const FileBytes& file, const std::map<string_view, Block>& blocks) {
  for (const string_view name : kHeightNames)
    if (const auto found = blocks.find(name); found != blocks.end() && found->second.type == kArray)
      return found->second;
  throw FileError(file.path(), "holds no block of heights (RAW_DATA, RAW DATA, OPD or Raw)");
}

/// Columns one after the other, each from the bottom upwards; raw ≥ missing is missing.
template <typename T>
HeightField read_points(const FileBytes& file, std::uint64_t data, std::uint64_t rows, std::uint64_t cols,
                        Pitch pitch, double step, double missing) {
  return read_height_field(file.path(), rows, cols, pitch, [=, &file](Eigen::Index k) {
    const auto point = static_cast<std::uint64_t>(k);
    const std::uint64_t row = point / cols, col = point % cols;
    const T raw = number<T>(file, data + (col * rows + (rows - 1 - row)) * sizeof(T));
    const auto value = static_cast<double>(raw);
    return value < missing ? value * step : std::numeric_limits<double>::quiet_NaN();
  });
}

}  // namespace

bool is_wyko_opd(const FileHead& head) {
  return begins_with(head.bytes, kMagic);
}

HeightField read_wyko_opd(const std::filesystem::path& path, const ReadOptions& options) {
  const FileBytes file(path);
  const auto blocks = read_directory(file);
  const Numbers numbers(file, blocks);
  const Block& block = height_block(file, blocks);

  constexpr std::uint64_t array_header = 6;
  file.require(block.size >= array_header, "its block of heights is cut");
  const std::uint64_t cols = number<std::uint16_t>(file, block.begin);
  const std::uint64_t rows = number<std::uint16_t>(file, block.begin + 2);
  const std::uint64_t bytes_each = number<std::uint16_t>(file, block.begin + 4);
  file.require(rows > 0 && cols > 0, "holds no heights");
  file.require(bytes_each == 1 || bytes_each == 2 || bytes_each == 4,
               "its heights have neither 1, 2 nor 4 bytes");
  file.require(rows * cols * bytes_each <= block.size - array_header,
               "is cut: its block of heights is shorter than its rows and columns");

  const double step = numbers.get("Wavelength", 0) * 1e-3 / numbers.get("Mult", 1);  // nm to µm
  file.require(std::isfinite(step) && step != 0, "its Wavelength and Mult make no height scale");
  const double dx = numbers.get("Pixel_size", 0) * 1e3;  // mm to µm
  const Pitch pitch = file_pitch(path, {dx, dx * numbers.get("Aspect", 1)}, options);
  const std::uint64_t data = block.begin + array_header;
  constexpr double never = std::numeric_limits<double>::infinity();  // bytes have no value to spare
  if (bytes_each == 1) return read_points<std::uint8_t>(file, data, rows, cols, pitch, step, never);
  if (bytes_each == 2) return read_points<std::int16_t>(file, data, rows, cols, pitch, step, 32766);
  return read_points<float>(file, data, rows, cols, pitch, step, static_cast<double>(1e38F));
}

}  // namespace micro
