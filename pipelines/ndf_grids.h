#pragma once

#include <optional>
#include <vector>

#include "pipelines/ndf_of_scans.h"
#include "pipelines/scan_outcome.h"

namespace micro {

/// A method's grid, and all of the disk that the data can tell of with nodes as dense.
struct GridOfMethod {
  DiskGrid grid;
  std::optional<DiskGrid> spared;  ///< if it is more
};

/// The grid of each method: what all scans together call for.
std::vector<GridOfMethod> choose_grids(const ScanListing& listing, const NdfRequest& request);

/// Estimators of tables on those grids.
Estimators make_estimators(const NdfRequest& request, const std::vector<GridOfMethod>& grids);

/// The one grid of all wavelengths: what the shortest can tell of, and what holds the energy of both ends.
DiskGrid spectrum_grid(const ScanListing& listing, const NdfRequest& request);

/// The half vectors that are asked for.
std::vector<Vec3> choose_directions(const ScanListing& listing, const NdfRequest& request);

}  // namespace micro
