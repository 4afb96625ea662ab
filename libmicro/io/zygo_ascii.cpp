#include "io/zygo_ascii.h"

#include <algorithm>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "io/words.h"
#include "io/zygo_scale.h"

namespace micro {
namespace {

constexpr std::string_view kAsc = "Zygo ASCII Data File - Format ";
constexpr std::string_view kXyz = "Zygo XYZ Data File - Format ";
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// What the header says that matters here.
struct Header {
  std::uint64_t intensities;  ///< their number
  std::int64_t first_col, first_row;
  std::uint64_t cols, rows;
  double lateral;  ///< µm, 0 = unknown
  ZygoScale scale;
};

/// Numbered words of a header line.
class Fields {
 public:
  Fields(const FileBytes& file, std::string_view line, const char* name) : file_(file), name_(name) {
    for (std::size_t at = 0; at < line.size();) {
      const std::size_t end = std::min(line.find_first_of(" \t", at), line.size());
      if (end > at) words_.push_back(line.substr(at, end - at));
      at = end + 1;
    }
  }
  template <typename T>
  T get(std::size_t index) const {
    T value{};
    if (index < words_.size() && parse_number(words_[index], value)) return value;
    throw FileError(file_.path(), std::string("its header has no ") + name_);
  }

 private:
  const FileBytes& file_;
  const char* name_;
  std::vector<std::string_view> words_;
};

/// Reads the header, up to and with the "#" that ends it.
Header read_header(const FileBytes& file, Words& words) {
  std::vector<std::string_view> lines = {""};  // counted from 1, like in the format's description
  for (;;) {
    const std::string_view line = words.line();
    if (line.starts_with('#')) break;
    lines.push_back(line);
    file.require(lines.size() <= 64, "its header does not end");
  }
  file.require(lines.size() > 13, "its header is too short");
  const Fields intensity(file, lines[3], "size of the intensities");
  const Fields phase(file, lines[4], "size of the heights");
  const Fields optics(file, lines[8], "scales");
  const Fields acquisition(file, lines[11], "phase resolution");
  return {.intensities = std::uint64_t{intensity.get<std::uint16_t>(2)} * intensity.get<std::uint16_t>(3) *
                         intensity.get<std::uint16_t>(4),
          .first_col = phase.get<std::int32_t>(0),
          .first_row = phase.get<std::int32_t>(1),
          .cols = phase.get<std::uint32_t>(2),
          .rows = phase.get<std::uint32_t>(3),
          .lateral = 1e6 * optics.get<double>(6),
          .scale = {.interferometric = optics.get<double>(1),
                    .wavelength = optics.get<double>(2),
                    .obliquity = optics.get<double>(4),
                    .phase_res = acquisition.get<std::int32_t>(0),
                    .sign = acquisition.get<std::int32_t>(7)}};
}

/// rows·cols, held against the bytes left when a point takes at least `bytes_each` of them.
std::uint64_t checked_count(const FileBytes& file, const Header& header, std::size_t remaining,
                            std::size_t bytes_each) {
  file.require(header.rows > 0 && header.cols > 0, "holds no heights");
  const std::uint64_t count = header.rows * header.cols;  // two 32-bit numbers
  file.require(count <= remaining / bytes_each, "is cut: it has fewer heights than its header promises");
  return count;
}

}  // namespace

bool is_zygo_asc(const FileHead& head) {
  return begins_with(head.bytes, kAsc);
}

HeightField read_zygo_asc(const std::filesystem::path& path, const ReadOptions& options) {
  const FileBytes file(path);
  Words words(file, "#");
  const Header header = read_header(file, words);
  const Pitch pitch = file_pitch(path, {header.lateral, header.lateral}, options);
  const double step = zygo_step(path, header.scale);
  if (header.intensities > 0) words.skip_block();
  const std::uint64_t count = checked_count(file, header, words.remaining(), sizeof "0 " - 1);
  // Without intensities their closing "#" may be there or not.
  if (header.intensities == 0 && words.peek() == "#") words.close_block();
  std::vector<std::int32_t> raw(count);
  for (std::int32_t& value : raw)
    value = words.number<std::int32_t>();
  words.close_block();
  return read_height_field(path, header.rows, header.cols, pitch, [&](Eigen::Index point) {
    const std::int32_t value = raw[static_cast<std::size_t>(point)];
    return value < kZygoMissing ? value * step : kNaN;
  });
}

bool is_zygo_xyz(const FileHead& head) {
  return begins_with(head.bytes, kXyz);
}

HeightField read_zygo_xyz(const std::filesystem::path& path, const ReadOptions& options) {
  const FileBytes file(path);
  Words words(file, "#");
  const Header header = read_header(file, words);
  const Pitch pitch = file_pitch(path, {header.lateral, header.lateral}, options);
  const std::uint64_t count = checked_count(file, header, words.remaining(), sizeof "0 0 0 " - 1);
  std::vector<double> z(count, kNaN);
  std::vector<bool> seen(count);
  for (std::uint64_t k = 0; k < count; ++k) {
    // Columns and rows are those of the camera.
    const auto col = words.number<std::int32_t>() - header.first_col;
    const auto row = words.number<std::int32_t>() - header.first_row;
    file.require(col >= 0 && row >= 0 && static_cast<std::uint64_t>(col) < header.cols &&
                     static_cast<std::uint64_t>(row) < header.rows,
                 "has a point outside the rows and columns that its header promises");
    const auto point = static_cast<std::uint64_t>(row) * header.cols + static_cast<std::uint64_t>(col);
    file.require(!seen[point], "has the same point twice");
    seen[point] = true;
    if (words.peek() == "No") {
      words.word();
      file.require(words.word() == "Data", "has a height that is neither a number nor No Data");
    } else {
      z[point] = words.number<double>();
    }
  }
  words.close_block();
  return read_height_field(path, header.rows, header.cols, pitch,
                           [&](Eigen::Index point) { return z[static_cast<std::size_t>(point)]; });
}

}  // namespace micro
