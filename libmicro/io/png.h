#pragma once

#include <array>
#include <cstdint>
#include <filesystem>

#include "core/grid.h"

namespace micro {

/// Red, green, blue; sRGB, 8 bits each.
using Rgb = std::array<std::uint8_t, 3>;
using Picture = Grid<Rgb>;

/// Writes a picture as PNG, row 0 on top; the file is whole or absent. Throws FileError.
void write_png(const std::filesystem::path& path, const Picture& picture);

}  // namespace micro
