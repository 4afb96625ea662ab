#pragma once

#include "io/scan.h"

namespace micro {

bool is_exr_heights(const FileHead& head);
HeightField read_exr_heights(const std::filesystem::path& path, const ReadOptions& options);

constexpr std::string_view kExrSignature("\x76\x2f\x31\x01", 4);

/// An OpenEXR picture whose channel Y, or only channel, is height in µm; row 0 on top; missing is NaN or
/// ±inf. The pitch comes from the user.
inline constexpr ScanFormat kExrHeights = {"exr",
                                           "OpenEXR height map (heights in µm)",
                                           ScanFormat::Listed::WhenNamed,
                                           is_exr_heights,
                                           read_exr_heights,
                                           kExrSignature};

}  // namespace micro
