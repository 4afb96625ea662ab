#pragma once

#include <optional>
#include <string>

#include "height/level.h"
#include "io/scan.h"
#include "pipelines/scan_listing.h"

namespace micro {

/// What is done to a scan before anything is computed from it.
struct Preparation {
  ReadOptions read;
  Level level = Level::Plane;
  std::optional<double> outlier_threshold;  ///< robust standard deviations; absent: every point stays
  enum class Holes { Keep, Fill } holes = Holes::Keep;
};

/// A surface ready to be looked at.
struct PreparedScan {
  HeightField surface;
  std::string_view format;
  Eigen::Index missing = 0;   ///< as in the file
  Eigen::Index rejected = 0;  ///< outliers made missing
  Eigen::Index filled = 0;    ///< missing points filled
};

/// Reads, rejects outliers, levels, and fills holes; rejecting and filling only if asked for. Throws
/// FileError naming the file.
PreparedScan prepare_scan(const std::filesystem::path& path, const Preparation& preparation);

}  // namespace micro
