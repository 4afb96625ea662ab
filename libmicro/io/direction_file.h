#pragma once

#include <filesystem>
#include <vector>

#include "core/grid.h"

namespace micro {

/// Half directions from a text file: one per line, `hx hy` (h_z = √(1 − h_x² − h_y²)) or `hx hy hz` with a
/// length within 1 % of 1 (it is made exactly 1) and hz ≥ 0; blanks, tabs or commas between, `#` starts a
/// comment, empty lines are skipped. Throws FileError, naming the line, for anything else and for a file
/// without a direction.
std::vector<Vec3> read_directions(const std::filesystem::path& path);

}  // namespace micro
