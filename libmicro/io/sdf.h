#pragma once

#include "io/scan.h"

namespace micro {

bool is_sdf(const FileHead& head);
HeightField read_sdf(const std::filesystem::path& path, const ReadOptions& options);

/// Surface data file of ISO 25178-71 (and of its forerunner BCR), ASCII or binary. Scales are in metres.
/// Missing is BAD in ASCII; in binary the lowest signed or the highest unsigned integer of 16 or 32 bits, or
/// NaN.
inline constexpr ScanFormat kSdf = {"sdf", "SDF .sdf (ISO 25178-71)", ScanFormat::Listed::WhenFound, is_sdf,
                                    read_sdf};

}  // namespace micro
