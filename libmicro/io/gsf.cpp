#include "io/gsf.h"

#include <cmath>
#include <string>
#include <string_view>

#include "io/words.h"

namespace micro {
namespace {

using std::string_view;

constexpr string_view kMagic = "Gwyddion Simple Field 1.0\n";

/// What the line "key = value" says; empty if there is none.
string_view value_of(string_view header, string_view key) {
  while (!header.empty()) {
    const string_view line = header.substr(0, header.find('\n'));
    header.remove_prefix(std::min(line.size() + 1, header.size()));
    if (!line.starts_with(key)) continue;
    string_view rest = line.substr(key.size());
    rest.remove_prefix(std::min(rest.find_first_not_of(" \t"), rest.size()));
    if (!rest.starts_with('=')) continue;
    rest.remove_prefix(std::min(rest.find_first_not_of(" \t", 1), rest.size()));
    return rest.substr(0, rest.find_last_not_of(" \t\r") + 1);
  }
  return {};
}

class GsfHeader {
 public:
  explicit GsfHeader(const FileBytes& file) : path_(file.path()), size_(file.text().find('\0')) {
    file.require(size_ != string_view::npos, "is cut in its header");
    text_ = file.text().substr(0, size_);
    cols = number("XRes", std::uint32_t{0});
    rows = number("YRes", std::uint32_t{0});
    file.require(rows > 0 && cols > 0, "holds no heights");
    const string_view unit = value("XYUnits");
    file.require(unit.empty() || unit == "m", "its lateral unit (XYUnits) is not the metre");
    micrometres = unit.empty() ? 0 : 1e6;
  }

  std::size_t size() const { return size_; }
  string_view value(string_view key) const { return value_of(text_, key); }
  template <typename Number>
  Number number(string_view key, Number otherwise) const {
    const string_view text = value(key);
    if (!text.empty() && !parse_number(text, otherwise))
      throw FileError(path_, "its " + std::string(key) + " is no number");
    return otherwise;
  }

  std::uint64_t cols = 0, rows = 0;
  double micrometres = 0;  ///< in a lateral unit; 0: without a unit the pitch is unknown

 private:
  std::filesystem::path path_;
  std::size_t size_;
  string_view text_;
};

}  // namespace

bool is_gsf(const FileHead& head) {
  return begins_with(head.bytes, kMagic);
}

HeightField read_gsf(const std::filesystem::path& path, const ReadOptions& options) {
  const FileBytes file(path);
  const GsfHeader header(file);
  const std::uint64_t begin = header.size() / 4 * 4 + 4;
  file.require(begin <= file.size() && header.rows <= (file.size() - begin) / sizeof(float) / header.cols,
               "is cut: its header promises more heights than it has");
  file.require(header.value("ZUnits") == "m", "its values are not in metres (ZUnits): no heights");
  const Pitch pitch =
      file_pitch(path,
                 {header.number("XReal", 0.) / static_cast<double>(header.cols) * header.micrometres,
                  header.number("YReal", 0.) / static_cast<double>(header.rows) * header.micrometres},
                 options);
  const std::byte* data = file.data() + begin;
  return read_height_field(path, header.rows, header.cols, pitch, [=](Eigen::Index k) {
    return 1e6 * static_cast<double>(
                     load<float>(data + k * static_cast<Eigen::Index>(sizeof(float)), std::endian::little));
  });
}

std::optional<StageWindow> stage_of_gsf(const std::filesystem::path& path) {
  const FileBytes file(path, kHeadBytes);
  const GsfHeader header(file);
  if (header.value("XOffset").empty() && header.value("YOffset").empty()) return std::nullopt;
  const auto length = [&](string_view key) { return header.number(key, 0.) * header.micrometres; };
  return StageWindow{
      .x = length("XOffset"), .y = length("YOffset"), .width = length("XReal"), .height = length("YReal")};
}

}  // namespace micro
