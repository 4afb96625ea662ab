#pragma once

#include "io/scan.h"

namespace micro {

bool is_wyko_opd(const FileHead& head);
HeightField read_wyko_opd(const std::filesystem::path& path, const ReadOptions& options);

/// Wyko (Veeco, Bruker) .opd: named blocks behind a directory. Heights are 16-bit integers (missing ≥ 32766)
/// or 32-bit floats (missing ≥ 1e38), stored column by column from the bottom; z = raw · Wavelength / Mult.
inline constexpr ScanFormat kWykoOpd = {"wyko-opd", "Wyko/Bruker .opd", ScanFormat::Listed::WhenFound,
                                        is_wyko_opd, read_wyko_opd};

}  // namespace micro
