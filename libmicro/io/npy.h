#pragma once

#include "io/scan.h"

namespace micro {

bool is_npy(const FileHead& head);
HeightField read_npy(const std::filesystem::path& path, const ReadOptions& options);

/// Writes the heights in µm, the mean included, as '<f8' [rows, cols]. The pitch has no place in the format.
/// Throws FileError.
void write_npy(const std::filesystem::path& path, const HeightField& surface);

/// NumPy .npy, versions 1 to 3: a 2-D array of floats or integers, either byte order, either memory order;
/// heights in µm, missing is NaN or ±inf. The pitch comes from the user.
inline constexpr ScanFormat kNpy = {"npy", "NumPy .npy (heights in µm)", ScanFormat::Listed::WhenNamed,
                                    is_npy, read_npy};

}  // namespace micro
