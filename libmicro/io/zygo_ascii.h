#pragma once

#include "io/scan.h"

namespace micro {

bool is_zygo_asc(const FileHead& head);
HeightField read_zygo_asc(const std::filesystem::path& path, const ReadOptions& options);

bool is_zygo_xyz(const FileHead& head);
HeightField read_zygo_xyz(const std::filesystem::path& path, const ReadOptions& options);

/// "Zygo ASCII Data File": the fields of MetroPro .dat as text, then blocks of integers closed by lines "#".
inline constexpr ScanFormat kZygoAsc = {"zygo-asc", "Zygo ASCII .asc", ScanFormat::Listed::WhenFound,
                                        is_zygo_asc, read_zygo_asc};

/// "Zygo XYZ Data File": the same header, then a record "col row z" (µm) or "col row No Data" for every
/// point.
inline constexpr ScanFormat kZygoXyz = {"zygo-xyz", "Zygo XYZ .xyz", ScanFormat::Listed::WhenFound,
                                        is_zygo_xyz, read_zygo_xyz};

}  // namespace micro
