#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/grid.h"
#include "io/hdf5_writer.h"
#include "pipelines/prepare_scan.h"

namespace micro {

/// What is kept of each scan.
struct ScanRecord {
  std::string source, sha256, format;
  Eigen::Index rows = 0, cols = 0;
  Eigen::Index missing = 0;               ///< as in the file
  Eigen::Index holes = 0;                 ///< missing after the repairs
  double dx = 0, dy = 0;                  ///< µm
  Eigen::Index rejected = 0, filled = 0;  ///< outliers made missing; missing points filled
  std::optional<double> Sq;               ///< µm, after levelling
  std::optional<double> Sdq;              ///< after levelling
  std::optional<std::string> failure;     ///< why it is not part of the result; does not repeat its name
};

/// prepare_scan, and the file's hash in the record, which come from two reads: they are of one file only if
/// it was left alone meanwhile, else it is a FileError, and the record has no hash.
PreparedScan hash_and_prepare(const std::filesystem::path& path, const Preparation& preparation,
                              ScanRecord& record);

/// Notes what a prepared scan says of itself.
void describe(ScanRecord& record, const PreparedScan& prepared);

/// Why a scan is not part of the result: what the exception in flight says, without the file's name.
std::string reason_of_failure();

/// Writes /scans/<00000…>, one group each.
void write_scans(Hdf5Writer& file, const std::vector<ScanRecord>& scans);

}  // namespace micro
