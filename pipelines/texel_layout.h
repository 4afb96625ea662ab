#pragma once

#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "core/grid.h"
#include "pipelines/scan_listing.h"

namespace micro {

/// How the places of scans are known: they lie side by side along x in the listing's order; their names say
/// it, by a pattern like "r{row}_c{col}" (one of the two may be left out: it is 0); or a manifest, a text
/// file of lines `source,row,col` (blank lines and those that begin with # count for nothing).
struct InOrder {};
struct ByName {
  std::string pattern;
};
struct Manifest {
  std::filesystem::path path;
};
using LayoutRule = std::variant<InOrder, ByName, Manifest>;

/// Where each scan of a listing lies: rows run along y, columns along x; gaps are allowed.
struct TexelLayout {
  struct Place {
    Eigen::Index row, col;
  };
  Eigen::Index rows = 0, cols = 0;
  std::vector<Place> places;  ///< of the scans, the smallest row and column being 0
  std::string how;            ///< for the plan
};

/// Throws InputError (FileError for the manifest's own faults) if a scan has no place, two have the same, or
/// the grid would have more than 10⁸ places.
TexelLayout lay_out(const ScanListing& listing, const LayoutRule& rule);

}  // namespace micro
