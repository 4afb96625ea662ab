#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace micro {

/// Small scans by the names of their formats, several where a format has several faces; what cuts and
/// mutations start from. `folder` is for scratch.
std::map<std::string, std::vector<std::vector<std::byte>>> small_scans_of_every_format(
    const std::filesystem::path& folder);

}  // namespace micro
