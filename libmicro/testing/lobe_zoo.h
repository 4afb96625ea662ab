#pragma once

#include <string>
#include <vector>

#include "distribution/disk_table.h"
#include "distribution/slope_space.h"

namespace micro::testing {

/// A lobe of extreme parameters, and the grid that a table of it has.
struct ZooLobe {
  std::string name;
  EllipsoidParameters parameters;
  DiskGrid grid;
};

/// Widths from 1e-5 to 1e3, their ratio up to 1e5, tilts to the horizon.
std::vector<ZooLobe> zoo_lobes();

}  // namespace micro::testing
