#pragma once

#include <string>

#include "io/hdf5_reader.h"
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

bool is_microbrdf_result(const FileHead& head);
/// Always throws FileError: a result holds no heights.
HeightField refuse_microbrdf_result(const std::filesystem::path& path, const ReadOptions& options);

/// Our own height file. One that was cut is refused.
inline constexpr ScanFormat kMicrobrdfHdf5 = {"microbrdf-hdf5",
                                              "microbrdf height file (HDF5)",
                                              ScanFormat::Listed::WhenFound,
                                              is_microbrdf_hdf5,
                                              read_microbrdf_hdf5,
                                              kHdf5Signature};

/// What runs leave: known so that it is taken neither for a scan nor for a broken one.
inline constexpr ScanFormat kMicrobrdfResult = {"microbrdf-result",        "result of microbrdf (HDF5)",
                                                ScanFormat::Listed::Never, is_microbrdf_result,
                                                refuse_microbrdf_result,   kHdf5Signature};

}  // namespace micro
