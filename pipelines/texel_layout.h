#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/grid.h"
#include "pipelines/scan_listing.h"

namespace micro {

/// How the places of scans are known: they lie side by side along x in the order of their names, where a2
/// comes before a10; their names say it, by a pattern like "r{row}_c{col}" (one of the two may be left out:
/// it is 0); a manifest, a text file of lines `source,row,col` (blank lines, those that begin with #, and a
/// head `source,row,col` count for nothing); or the stage coordinates in their headers, as rows and columns
/// of a grid of even steps.
struct InOrder {};
struct ByName {
  std::string pattern;
};
struct Manifest {
  std::filesystem::path path;
};
struct ByStage {};
using LayoutRule = std::variant<InOrder, ByName, Manifest, ByStage>;

/// Throws InputError if a grid has more texels, gaps counted, than memory is there for: 4 million.
void require_few_texels(Eigen::Index rows, Eigen::Index cols);

/// Where each scan of a listing lies: rows run along y, columns along x; gaps are allowed.
struct TexelLayout {
  struct Place {
    Eigen::Index row, col;
  };
  Eigen::Index rows = 0, cols = 0;
  std::vector<std::optional<Place>> places;      ///< of the scans, the smallest row and column being 0
  std::map<std::int64_t, std::string> unplaced;  ///< scans without a place, and why
  std::string how;                               ///< for the plan
};

/// Throws InputError (FileError for the manifest's own faults) if a scan has no place, two have the same, the
/// grid would have more places than require_few_texels allows, or stage coordinates form none. By stage, a
/// scan whose header does not say where it lies has no place; it throws FileError if that is so for all.
TexelLayout lay_out(const ScanListing& listing, const LayoutRule& rule);

}  // namespace micro
