#pragma once

#include "io/scan.h"

namespace micro {

bool is_digital_surf(const FileHead& head);
HeightField read_digital_surf(const std::filesystem::path& path, const ReadOptions& options);

/// The offsets of x and y, in the units of their pitch.
std::optional<StageWindow> stage_of_digital_surf(const std::filesystem::path& path);

/// Digital Surf .sur, plain or compressed (zlib), PC or Macintosh byte order, 16 or 32 bits, one surface.
/// Each axis has a unit of its own. With special points, raw = zmin − 2 is missing.
inline constexpr ScanFormat kDigitalSurf = {
    "digital-surf",       "Digital Surf .sur", ScanFormat::Listed::WhenFound,
    is_digital_surf,      read_digital_surf,   {},
    stage_of_digital_surf};

}  // namespace micro
