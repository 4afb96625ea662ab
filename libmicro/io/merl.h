#pragma once

#include <filesystem>
#include <span>

namespace micro {

/// Writes an isotropic BRDF as a MERL binary [Matusik03]: three int32 (90, 90, 180), then 3·90·90·180
/// float64, red, green, blue, each [θ_h, θ_d, φ_d] in bins of √θ_h, θ_d and φ_d (0…π), scaled so that f =
/// value·(1, 1.15, 1.66)/1500 sr⁻¹. The format has no header for units or sources. `rgb` is f in 1/sr in that
/// order and size; NaN marks a direction below the horizon, which is −1 in the file as in MERL's own. Throws
/// InputError for a value that is infinite or negative, FileError.
void write_merl(const std::filesystem::path& path, std::span<const float> rgb);

}  // namespace micro
