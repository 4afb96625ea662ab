#include "pipelines/prepare_scan.h"

#include "core/error.h"
#include "height/repair.h"

namespace micro {

PreparedScan prepare_scan(const std::filesystem::path& path, const Preparation& preparation) {
  Scan scan = read_scan(path, preparation.read);
  PreparedScan prepared{.surface = std::move(scan.surface), .format = scan.format};
  prepared.missing = missing_count(prepared.surface);
  if (prepared.missing == prepared.surface.z.size()) throw FileError(path, "every point is missing");
  if (preparation.outlier_threshold) {
    Repair repair = reject_outliers(prepared.surface, {.threshold = *preparation.outlier_threshold});
    prepared.surface = std::move(repair.surface);
    prepared.rejected = repair.changed;
  }
  // The harmonic filling is flat across the image border, so it wants the surface level.
  prepared.surface = level(std::move(prepared.surface), preparation.level);
  if (preparation.holes == Preparation::Holes::Fill) {
    Repair repair = fill_holes(prepared.surface);
    prepared.surface = std::move(repair.surface);
    prepared.filled = repair.changed;
  }
  return prepared;
}

}  // namespace micro
