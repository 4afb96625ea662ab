#include "pipelines/texel_layout.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <map>
#include <optional>
#include <utility>

#include "core/error.h"
#include "pipelines/name_pattern.h"

namespace micro {
namespace {

using Place = TexelLayout::Place;

std::optional<Eigen::Index> number(const std::string& text) {
  Eigen::Index value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::vector<Place> places_by_name(const ScanListing& listing, const std::string& pattern) {
  const NamePattern names(pattern);
  std::vector<Place> places;
  for (const ListedScan& scan : listing.scans) {
    const auto place = names.find(scan.source);
    if (!place) throw InputError(scan.source + ": its name does not follow the layout '" + pattern + "'");
    places.push_back({place->row, place->col});
  }
  return places;
}

std::vector<Place> places_by_manifest(const ScanListing& listing, const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file) throw FileError(path, "cannot be read");
  std::map<std::string, Place> known;
  int line_number = 0;
  for (std::string line; std::getline(file, line);) {
    ++line_number;
    line.erase(line.find_last_not_of(" \t\r") + 1);
    if (line.empty() || line.front() == '#') continue;
    const std::size_t second = line.rfind(','), first = second == 0 ? line.npos : line.rfind(',', second - 1);
    if (second == line.npos || first == line.npos || first >= second)
      throw FileError(path, "line " + std::to_string(line_number) + " is not 'source,row,col'");
    const auto row = number(line.substr(first + 1, second - first - 1)),
               col = number(line.substr(second + 1));
    if (!row || !col)
      throw FileError(path,
                      "line " + std::to_string(line_number) + " has no whole numbers for row and column");
    known[line.substr(0, first)] = {*row, *col};
  }
  std::vector<Place> places;
  for (const ListedScan& scan : listing.scans) {
    const auto found = known.find(scan.source);
    if (found == known.end()) throw FileError(path, "has no line for " + scan.source);
    places.push_back(found->second);
  }
  return places;
}

}  // namespace

TexelLayout lay_out(const ScanListing& listing, const LayoutRule& rule) {
  constexpr Eigen::Index kMost = 100'000'000;
  TexelLayout layout;
  if (const auto* by_name = std::get_if<ByName>(&rule)) {
    layout.places = places_by_name(listing, by_name->pattern);
    layout.how = "by names, " + by_name->pattern;
  } else if (const auto* manifest = std::get_if<Manifest>(&rule)) {
    layout.places = places_by_manifest(listing, manifest->path);
    layout.how = "by the manifest";
  } else {
    for (std::size_t k = 0; k < listing.scans.size(); ++k)
      layout.places.push_back({0, static_cast<Eigen::Index>(k)});
    layout.how = "one strip along x, in the listing's order";
  }
  if (layout.places.empty()) return layout;
  Place least = layout.places.front(), most = least;
  for (const Place& place : layout.places) {
    least = {std::min(least.row, place.row), std::min(least.col, place.col)};
    most = {std::max(most.row, place.row), std::max(most.col, place.col)};
  }
  std::map<std::pair<Eigen::Index, Eigen::Index>, std::string> taken;
  for (std::size_t k = 0; k < layout.places.size(); ++k) {
    Place& place = layout.places[k];
    place = {place.row - least.row, place.col - least.col};
    const std::string& source = listing.scans[k].source;
    const auto [other, fresh] = taken.try_emplace({place.row, place.col}, source);
    if (!fresh) throw InputError(source + ": lies at the same place as " + other->second);
  }
  layout.rows = most.row - least.row + 1;
  layout.cols = most.col - least.col + 1;
  if (layout.rows > kMost / layout.cols) throw InputError("the layout spans more than 10^8 places");
  return layout;
}

}  // namespace micro
