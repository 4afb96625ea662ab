#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "core/grid.h"

namespace micro {

/// One channel of a picture.
struct ExrChannel {
  std::string name;  ///< "Y" for a single value, or e.g. "alpha.x"
  Grid<float> values;
};

/// Writes 32-bit float channels of one size as an OpenEXR picture, row 0 on top, with string attributes; the
/// file is whole or absent. Throws FileError.
void write_exr(const std::filesystem::path& path, const std::vector<ExrChannel>& channels,
               const std::vector<std::pair<std::string, std::string>>& attributes);

}  // namespace micro
