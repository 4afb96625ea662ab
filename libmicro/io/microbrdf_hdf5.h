#pragma once

#include <string>

#include "io/hdf5_writer.h"
#include "io/scan.h"

namespace micro {

/// Who made one of our HDF5 files: root attributes of every one of them.
struct Origin {
  std::string version;  ///< of microbrdf
  std::string created;  ///< ISO 8601, UTC
  std::string command;  ///< as typed
};

/// Writes format = "microbrdf", format_version = 1 and the origin as root attributes.
void write_origin(Hdf5Writer& file, const Origin& origin);

bool is_microbrdf_hdf5(const FileHead& head);
HeightField read_microbrdf_hdf5(const std::filesystem::path& path, const ReadOptions& options);

/// Writes a height field as /height/z [rows, cols] with its axes /height/x and /height/y (µm). Throws
/// FileError.
void write_microbrdf_hdf5(const std::filesystem::path& path, const HeightField& surface,
                          const Origin& origin);

/// Our own height file. A result.h5 without /height is no scan; a file that was cut while it was written is
/// refused.
inline constexpr ScanFormat kMicrobrdfHdf5 = {"microbrdf-hdf5", "microbrdf height file (HDF5)",
                                              ScanFormat::Listed::WhenFound, is_microbrdf_hdf5,
                                              read_microbrdf_hdf5};

}  // namespace micro
