#pragma once

#include "io/scan.h"

namespace micro {

bool is_zygo_dat(const FileHead& head);
HeightField read_zygo_dat(const std::filesystem::path& path, const ReadOptions& options);

/// Writes the heights (the mean included) as a MetroPro file of format 1 without intensities, in the finest
/// step that holds them in 31 bits. Throws InputError if the surface does not fit the format (dx ≠ dy, more
/// than 65535 rows or columns), FileError if the file cannot be written.
void write_zygo_dat(const std::filesystem::path& path, const HeightField& surface);

/// Zygo MetroPro .dat, formats 1 to 3. All numbers big-endian; missing is raw ≥ 2147483640; the lateral scale
/// 0 means unknown.
inline constexpr ScanFormat kZygoDat = {"zygo-dat", "Zygo MetroPro .dat", ScanFormat::Listed::WhenFound,
                                        is_zygo_dat, read_zygo_dat};

}  // namespace micro
