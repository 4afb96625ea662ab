#include "io/text_matrix.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/bytes.h"
#include "io/printable.h"

namespace micro {
namespace {

using std::string_view;

constexpr char kBlanks = ' ';  // as a separator: any number of blanks or tabs

string_view trimmed(string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t\r");
  if (begin == string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

/// A line without its comment; outer blanks go, but tabs stay, for they may part cells.
string_view without_comment(string_view line) {
  line = line.substr(0, line.find('#'));
  const std::size_t end = line.find_last_not_of(" \r");
  return end == string_view::npos || trimmed(line).empty() ? string_view{} : line.substr(0, end + 1);
}

char separator_of(string_view line) {
  line = trimmed(line);
  for (const char candidate : {';', '\t', ','})
    if (line.find(candidate) != string_view::npos) return candidate;
  return kBlanks;
}

/// A height in µm, NaN if it is missing, nothing if the cell is neither.
std::optional<double> parse_cell(string_view cell) {
  constexpr std::array missing = {string_view(""), string_view("NA"), string_view("BAD"), string_view("*")};
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  cell = trimmed(cell);
  if (std::find(missing.begin(), missing.end(), cell) != missing.end()) return nan;
  if (cell.starts_with('+')) cell.remove_prefix(1);
  double value = 0;
  const auto [rest, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (rest != cell.data() + cell.size() || error == std::errc::invalid_argument) return std::nullopt;
  return error == std::errc() ? value : nan;
}

/// Calls visit(cell) for each cell of a line until it returns false.
template <typename Visit>
void for_each_cell(string_view line, char separator, Visit&& visit) {
  if (separator == kBlanks) line = trimmed(line);
  while (!line.empty()) {
    const std::size_t end =
        std::min(separator == kBlanks ? line.find_first_of(" \t") : line.find(separator), line.size());
    if (!visit(line.substr(0, end))) return;
    line.remove_prefix(std::min(end + 1, line.size()));
    if (separator == kBlanks) line = trimmed(line);
    if (trimmed(line).empty()) return;  // a separator at the end closes the line
  }
}

constexpr string_view kByteOrderMark = "\xEF\xBB\xBF";

/// Calls visit(line number, line) for each line that has more than a comment, until it returns false.
template <typename Visit>
void for_each_line(string_view text, Visit&& visit) {
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const string_view line = without_comment(text.substr(0, end));
    if (!line.empty() && !visit(number, line)) return;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
}

}  // namespace

bool is_text_matrix(const FileHead& head) {
  const string_view text(reinterpret_cast<const char*>(head.bytes.data()), head.bytes.size());
  if (text.find('\0') != string_view::npos) return false;
  const bool whole = head.bytes.size() == head.size;
  bool numbers = false, missing = false, other = false;
  for_each_line(text, [&](std::size_t, string_view line) {
    const char* end_of_head = text.data() + text.size();
    for_each_cell(line, separator_of(line), [&](string_view cell) {
      if (!whole && cell.data() + cell.size() == end_of_head) return false;  // it may go on
      const auto value = parse_cell(cell);
      other |= !value;
      numbers |= value && std::isfinite(*value);
      missing |= value && !std::isfinite(*value);
      return value.has_value();
    });
    return !numbers && !other;
  });
  return (numbers || missing) && !other;
}

HeightField read_text_matrix(const std::filesystem::path& path, const ReadOptions& options) {
  const Pitch pitch = user_pitch(path, options);
  const FileBytes file(path);
  std::vector<double> z;
  std::size_t rows = 0, cols = 0;
  char separator = 0;
  for_each_line(file.text(), [&](std::size_t number, string_view line) {
    if (rows == 0) separator = separator_of(line);
    const std::size_t before = z.size();
    for_each_cell(line, separator, [&](string_view cell) {
      const auto value = parse_cell(cell);
      if (!value)
        throw FileError(path,
                        "line " + std::to_string(number) + ": " + in_quotes(trimmed(cell)) + " is no number" +
                            (cell.find(',') != string_view::npos ? " (write decimals with a point)" : ""));
      z.push_back(*value);
      return true;
    });
    const std::size_t count = z.size() - before;
    if (rows == 0) cols = count;
    if (count != cols)
      throw FileError(path, "line " + std::to_string(number) + " has " + std::to_string(count) +
                                " values, the first row has " + std::to_string(cols));
    ++rows;
    return true;
  });
  return read_height_field(path, rows, cols, pitch,
                           [&](Eigen::Index k) { return z[static_cast<std::size_t>(k)]; });
}

}  // namespace micro
