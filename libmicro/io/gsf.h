#pragma once

#include "io/scan.h"

namespace micro {

bool is_gsf(const FileHead& head);
HeightField read_gsf(const std::filesystem::path& path, const ReadOptions& options);

/// XOffset and YOffset; what is absent is 0 [GSF 1.0].
std::optional<StageWindow> stage_of_gsf(const std::filesystem::path& path);

/// Gwyddion Simple Field 1.0: a text header that NULs fill up to a multiple of four bytes, then 32-bit floats
/// in metres, the top row first; missing is NaN.
inline constexpr ScanFormat kGsf = {
    "gsf", "Gwyddion Simple Field .gsf", ScanFormat::Listed::WhenFound, is_gsf, read_gsf, {}, stage_of_gsf};

}  // namespace micro
