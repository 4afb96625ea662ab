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

}  // namespace

bool is_gsf(const FileHead& head) {
  return begins_with(head.bytes, kMagic);
}

HeightField read_gsf(const std::filesystem::path& path, const ReadOptions& options) {
  const FileBytes file(path);
  const std::size_t end = file.text().find('\0');
  file.require(end != string_view::npos, "is cut in its header");
  const string_view header = file.text().substr(0, end);
  const auto get = [&](string_view key, auto otherwise) {
    const string_view text = value_of(header, key);
    if (!text.empty() && !parse_number(text, otherwise))
      throw FileError(path, "its " + std::string(key) + " is no number");
    return otherwise;
  };
  const std::uint64_t cols = get("XRes", std::uint32_t{0}), rows = get("YRes", std::uint32_t{0});
  file.require(rows > 0 && cols > 0, "holds no heights");
  const std::uint64_t begin = end / 4 * 4 + 4;
  file.require(begin <= file.size() && rows <= (file.size() - begin) / sizeof(float) / cols,
               "is cut: its header promises more heights than it has");
  file.require(value_of(header, "ZUnits") == "m", "its values are not in metres (ZUnits): no heights");
  const string_view unit = value_of(header, "XYUnits");
  file.require(unit.empty() || unit == "m", "its lateral unit (XYUnits) is not the metre");
  const double metres = unit.empty() ? 0 : 1e6;  // µm in one; without a unit the pitch is unknown
  const Pitch pitch = file_pitch(path,
                                 {get("XReal", 0.) / static_cast<double>(cols) * metres,
                                  get("YReal", 0.) / static_cast<double>(rows) * metres},
                                 options);
  const std::byte* data = file.data() + begin;
  return read_height_field(path, rows, cols, pitch, [=](Eigen::Index k) {
    return 1e6 * static_cast<double>(
                     load<float>(data + k * static_cast<Eigen::Index>(sizeof(float)), std::endian::little));
  });
}

}  // namespace micro
