#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "height/height_field.h"

namespace micro::bench {

/// A surface that curves are measured on.
struct NamedSurface {
  std::string name;
  HeightField surface;
};

/// 640 × 480 points at 0.11 µm: smooth (rms 0.03 µm, τ 5 µm), rough (0.3, 3), steep (1, 1.5: slopes of 0.94),
/// holed (rough with 4 % of its points missing), brushed (scratches 50 µm long and 1.5 µm wide, rms 0.1 µm).
std::vector<NamedSurface> made_surfaces();

/// Real scans, levelled by their mean planes, under their file names.
std::vector<NamedSurface> real_surfaces(std::span<const std::filesystem::path> scans);

}  // namespace micro::bench
