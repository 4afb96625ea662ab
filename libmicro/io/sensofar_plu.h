#pragma once

#include "io/scan.h"

namespace micro {

bool is_sensofar_plu(const FileHead& head);
HeightField read_sensofar_plu(const std::filesystem::path& path, const ReadOptions& options);

/// Sensofar (Leica) .plu with a topography. Heights are 32-bit floats in µm; missing is 1000001. The format
/// has no signature: it begins with a date, as C's asctime writes it, in 128 bytes.
inline constexpr ScanFormat kSensofarPlu = {"sensofar-plu", "Sensofar .plu", ScanFormat::Listed::WhenFound,
                                            is_sensofar_plu, read_sensofar_plu};

}  // namespace micro
