#include "pipelines/texel_layout.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <sstream>
#include <utility>
#include <variant>

#include "core/error.h"
#include "core/parallel.h"
#include "io/scan.h"
#include "pipelines/name_pattern.h"
#include "pipelines/plan.h"

namespace micro {
namespace {

using Place = TexelLayout::Place;

std::optional<Eigen::Index> number(const std::string& text) {
  Eigen::Index value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

using Places = std::vector<std::optional<Place>>;

Places places_by_name(const ScanListing& listing, const std::string& pattern) {
  const NamePattern names(pattern);
  Places places;
  for (const ListedScan& scan : listing.scans) {
    const auto place = names.find(scan.source);
    if (!place) throw InputError(scan.source + ": its name does not follow the layout '" + pattern + "'");
    places.push_back(Place{place->row, place->col});
  }
  return places;
}

/// Without blanks about it.
std::string trimmed(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(" \t\r");
  return begin == text.npos ? "" : text.substr(begin, text.find_last_not_of(" \t\r") + 1 - begin);
}

/// A source as listings have it, from how people and spreadsheets write it: "./a.dat", quoted.
std::string listed_source(std::string text) {
  if (text.size() > 1 && text.front() == '"' && text.back() == '"') text = text.substr(1, text.size() - 2);
  return std::filesystem::path(text).lexically_normal().string();
}

/// A line `source,row,col`, split at its last two commas.
std::optional<std::array<std::string, 3>> fields_of(const std::string& line) {
  const std::size_t second = line.rfind(','),
                    first = second == line.npos || second == 0 ? line.npos : line.rfind(',', second - 1);
  if (first == line.npos) return std::nullopt;
  return std::array{trimmed(line.substr(0, first)), trimmed(line.substr(first + 1, second - first - 1)),
                    trimmed(line.substr(second + 1))};
}

std::map<std::string, Place> read_manifest(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file || std::filesystem::is_directory(path)) throw FileError(path, "cannot be read");
  std::map<std::string, Place> known;
  int line_number = 0;
  for (std::string line; std::getline(file, line);) {
    const std::string at = "line " + std::to_string(++line_number);
    if (line_number == 1 && line.starts_with("\xef\xbb\xbf")) line.erase(0, 3);
    line = trimmed(line);
    if (line.empty() || line.front() == '#') continue;
    const auto fields = fields_of(line);
    if (!fields) throw FileError(path, at + " is not 'source,row,col'");
    const auto& [source, row_text, col_text] = *fields;
    if (known.empty() && row_text == "row" && col_text == "col") continue;  // a table's head
    const auto row = number(row_text), col = number(col_text);
    if (!row || !col) throw FileError(path, at + " has no whole numbers for row and column");
    if (!known.try_emplace(listed_source(source), Place{*row, *col}).second)
      throw FileError(path, std::string(at).append(" gives ").append(source).append(" a second place"));
  }
  return known;
}

/// The places of scans by a manifest. Its lines for other scans leave gaps, which is said.
TexelLayout layout_by_manifest(const ScanListing& listing, const std::filesystem::path& path) {
  const std::map<std::string, Place> known = read_manifest(path);
  TexelLayout layout;
  std::set<std::string> unused;
  for (const auto& line : known)
    unused.insert(line.first);
  for (const ListedScan& scan : listing.scans) {
    const auto found = known.find(listed_source(scan.source));
    if (found == known.end()) throw FileError(path, "has no line for " + scan.source);
    layout.places.push_back(found->second);
    unused.erase(found->first);
  }
  layout.how = "by the manifest";
  if (!unused.empty())
    layout.how += ", of which " + counted(static_cast<std::int64_t>(unused.size()), "line") +
                  (unused.size() == 1 ? " is of no scan here: " : " are of no scan here, the first: ") +
                  *unused.begin();
  return layout;
}

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// Whether a name comes before another where runs of digits count as numbers: a2 before a10.
bool in_natural_order(const std::string& a, const std::string& b) {
  const auto digits = [](const std::string& text, std::size_t& at) {
    std::size_t begin = at;
    while (at < text.size() && is_digit(text[at]))
      ++at;
    while (begin + 1 < at && text[begin] == '0')
      ++begin;
    return text.substr(begin, at - begin);
  };
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (is_digit(a[i]) && is_digit(b[j])) {
      const std::string left = digits(a, i), right = digits(b, j);
      if (left.size() != right.size()) return left.size() < right.size();
      if (left != right) return left < right;
    } else if (a[i] != b[j]) {
      return static_cast<unsigned char>(a[i]) < static_cast<unsigned char>(b[j]);
    } else {
      ++i;
      ++j;
    }
  }
  // The same but for zeros in front, or for what one has more.
  return i < a.size() || j < b.size() ? i == a.size() : a < b;
}

/// Side by side along x.
Places places_in_order(const ScanListing& listing) {
  std::vector<std::size_t> order(listing.scans.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return in_natural_order(listing.scans[a].source, listing.scans[b].source);
  });
  Places places(order.size());
  for (std::size_t k = 0; k < order.size(); ++k)
    places[order[k]] = Place{0, static_cast<Eigen::Index>(k)};
  return places;
}

std::string in_micrometres(double length) {
  std::ostringstream text;
  text << length << " µm";
  return text.str();
}

/// The numbers of columns (or rows) that positions along an axis, µm, lie in. Those within half a scan are
/// one column; columns are whole steps of the smallest one apart, to an eighth of it.
std::vector<Eigen::Index> columns_of(const std::vector<double>& positions, double scan, const char* axis) {
  std::vector<double> sorted = positions;
  std::sort(sorted.begin(), sorted.end());
  double step = std::numeric_limits<double>::infinity();
  for (std::size_t k = 1; k < sorted.size(); ++k)
    if (const double gap = sorted[k] - sorted[k - 1]; gap > scan / 2) step = std::min(step, gap);
  std::map<double, Eigen::Index> columns;
  Eigen::Index column = 0;
  for (std::size_t k = 0; k < sorted.size(); ++k) {
    const double gap = k == 0 ? 0 : sorted[k] - sorted[k - 1];
    if (gap > scan / 2) {
      const double steps = gap / step;
      if (std::abs(steps - std::round(steps)) > 0.125 || steps > 1e8)
        throw InputError("stage positions along " + std::string(axis) + " form no grid: steps of " +
                         in_micrometres(step) + " and " + in_micrometres(gap));
      column += std::lround(steps);
    }
    columns[sorted[k]] = column;
  }
  std::vector<Eigen::Index> numbers;
  numbers.reserve(positions.size());
  for (const double position : positions)
    numbers.push_back(columns[position]);
  return numbers;
}

/// The places of scans by their headers, which are read on all threads, and those without one.
TexelLayout layout_by_stage(const ScanListing& listing) {
  TexelLayout layout{.places = Places(listing.scans.size()), .unplaced = {}, .how = "by stage coordinates"};
  std::vector<std::int64_t> placed;
  std::vector<double> x, y;
  double width = std::numeric_limits<double>::infinity(), height = width;
  using Answer = std::variant<StageWindow, FileError>;
  parallel_in_order(
      static_cast<std::int64_t>(listing.scans.size()),
      [&](std::int64_t k) -> Answer {
        try {
          return stage_window(listing.scans[static_cast<std::size_t>(k)].path);
        } catch (const FileError& error) {
          return error;
        }
      },
      [&](std::int64_t k, const Answer& answer) {
        if (const auto* error = std::get_if<FileError>(&answer)) {
          layout.unplaced.emplace(k, error->fact());
          return;
        }
        const auto& window = std::get<StageWindow>(answer);
        placed.push_back(k);
        x.push_back(window.x);
        y.push_back(window.y);
        width = std::min(width, window.width);
        height = std::min(height, window.height);
      });
  if (placed.empty() && !layout.unplaced.empty())
    throw FileError(listing.scans.front().path, layout.unplaced.begin()->second);
  const auto cols = columns_of(x, width, "x"), rows = columns_of(y, height, "y");
  for (std::size_t n = 0; n < placed.size(); ++n)
    layout.places[static_cast<std::size_t>(placed[n])] = Place{rows[n], cols[n]};
  return layout;
}

constexpr Eigen::Index kFarthest = 1'000'000'000;  // rows or columns

}  // namespace

void require_few_texels(Eigen::Index rows, Eigen::Index cols) {
  constexpr Eigen::Index kMost = 4'000'000;
  if (rows > kMost / cols)
    throw InputError("the layout spans " + std::to_string(rows) + " x " + std::to_string(cols) +
                     " texels, gaps counted, more than 4 million");
}

TexelLayout lay_out(const ScanListing& listing, const LayoutRule& rule) {
  TexelLayout layout;
  if (const auto* by_name = std::get_if<ByName>(&rule)) {
    layout.places = places_by_name(listing, by_name->pattern);
    layout.how = "by names, " + by_name->pattern;
  } else if (const auto* manifest = std::get_if<Manifest>(&rule)) {
    layout = layout_by_manifest(listing, manifest->path);
  } else if (std::holds_alternative<ByStage>(rule)) {
    layout = layout_by_stage(listing);
  } else {
    layout.places = places_in_order(listing);
    layout.how = "one strip along x, in the order of names, numbers in them counting as numbers";
  }
  if (layout.places.empty()) return layout;
  Place least = {kFarthest, kFarthest}, most = {-kFarthest, -kFarthest};
  for (std::size_t k = 0; k < layout.places.size(); ++k) {
    const auto& place = layout.places[k];
    if (!place) continue;
    if (std::max({place->row, place->col, -1 - place->row, -1 - place->col}) >= kFarthest)
      throw InputError(listing.scans[k].source + ": lies in a row or column beyond 10^9");
    least = {std::min(least.row, place->row), std::min(least.col, place->col)};
    most = {std::max(most.row, place->row), std::max(most.col, place->col)};
  }
  std::map<std::pair<Eigen::Index, Eigen::Index>, std::string> taken;
  for (std::size_t k = 0; k < layout.places.size(); ++k) {
    if (!layout.places[k]) continue;
    Place& place = *layout.places[k];
    place = {place.row - least.row, place.col - least.col};
    const std::string& source = listing.scans[k].source;
    const auto [other, fresh] = taken.try_emplace({place.row, place.col}, source);
    if (!fresh) throw InputError(source + ": lies at the same place as " + other->second);
  }
  layout.rows = most.row - least.row + 1;
  layout.cols = most.col - least.col + 1;
  require_few_texels(layout.rows, layout.cols);
  return layout;
}

}  // namespace micro
