#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "pipelines/ndf_of_scans.h"

namespace micro {

/// One scan's outcome.
struct ScanOutcome {
  ScanRecord record;
  double area = 0;  ///< A_perp, µm²
  std::vector<std::optional<ScanNdf>> ndfs;
  std::vector<std::string> refusals;  ///< for each method: why it is left out on this scan, or empty
  std::optional<KirchhoffEstimate> directions;
  std::string directions_refusal;
  std::optional<Picture> thumbnail;
};

/// What is asked of every scan.
struct Estimators {
  std::vector<NdfEstimator> tables;
  std::unique_ptr<KirchhoffScans> directions;
};

/// Whether a small picture of the surface is made as well.
enum class Thumbnail { Make, LeaveOut };

/// Reads, prepares and measures one scan. Throws nothing: what goes wrong is the record's failure.
ScanOutcome look_at(const ListedScan& scan, const NdfRequest& request, const Estimators& estimators,
                    Thumbnail thumbnail);

}  // namespace micro
