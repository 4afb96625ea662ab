#pragma once

#include "io/hdf5_reader.h"
#include "io/scan.h"

namespace micro {

bool is_zygo_datx(const FileHead& head);
HeightField read_zygo_datx(const std::filesystem::path& path, const ReadOptions& options);

/// Zygo Mx .datx (HDF5). The height is the dataset that the graph in /MetaData leads to (Root → Measurement →
/// Surface → Path), or the only one in /Data/Surface; its dims are (rows, columns). An HDF5 file that cannot
/// be opened counts as one of these, so that a cut file is told and not passed over.
inline constexpr ScanFormat kZygoDatx = {"zygo-datx",  "Zygo Mx .datx", ScanFormat::Listed::WhenFound,
                                         is_zygo_datx, read_zygo_datx,  kHdf5Signature};

}  // namespace micro
