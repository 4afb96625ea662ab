#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "distribution/disk_table.h"
#include "distribution/table_mean.h"
#include "pipelines/kirchhoff_estimate.h"
#include "pipelines/ndf_estimator.h"
#include "pipelines/plan.h"

namespace micro {

/// One table over all scans.
struct NdfOfScans {
  NdfMethod method;
  std::string estimator;                       ///< what ran: "triangles", "plane fits", "spectral", …
  DiskTable density;                           ///< 1/sr
  std::optional<Grid<double>> standard_error;  ///< 1/sr, over scans
  Grid<double> estimator_error;                ///< 1/sr, Monte Carlo's own; 0×0 for other estimators
  std::int64_t scans = 0;
  double area = 0;                         ///< Σ A_perp, µm²
  double outside = 0;                      ///< fraction of the samples beyond the extent
  std::int64_t samples = 0;                ///< normals counted
  std::int64_t without_normal = 0;         ///< points whose neighbours determine no plane
  std::optional<double> truncation_error;  ///< bound on a slope's error from cutting the window
  std::int64_t unreached = 0;              ///< tables or directions of D_K that missed their tolerance
  double valid_sin_theta = 1;              ///< beyond it the pitch does not resolve the surface
  double rel_error = 0;                    ///< relative error of the estimator; 0: exact but for rounding
  double seconds = 0;                      ///< of computing it, summed over scans
  std::optional<std::string> signature;    ///< name of the signature that it was blurred with
};

/// Running sums of one method over scans.
class NdfMean {
 public:
  /// `spared`: see NdfEstimator.
  NdfMean(const NdfMethod& method, const DiskGrid& grid, std::optional<DiskGrid> spared);

  /// `area`: the scan's weight, A_perp in µm²; `pitch`: the larger of its two, µm.
  void add(const ScanNdf& scan, double area, double pitch);
  /// A scan that the method does not apply to, and why.
  void refuse(const std::string& reason) { ++refusals_[reason]; }

  /// Adds what another sum of the same method holds. Throws InputError if it stands on another grid.
  void merge(const NdfMean& other);

  template <typename Archive>
  void persist(Archive& archive) {
    archive(ndf_.method, ndf_.estimator, ndf_.truncation_error, ndf_.samples, ndf_.without_normal,
            ndf_.seconds, mean_, grid_, spared_, outside_, kirchhoff_, pitch_, refusals_);
  }

  const DiskGrid& grid() const { return grid_; }
  std::int64_t count() const { return mean_.count(); }
  NdfOfScans finish() const;
  /// What was done, or why nothing was.
  Plan plan() const;

 private:
  NdfOfScans ndf_;
  TableMean mean_;
  DiskGrid grid_;
  std::optional<DiskGrid> spared_;
  std::int64_t outside_ = 0;
  std::optional<KirchhoffTally> kirchhoff_;
  double pitch_ = 0;  // the largest, µm
  Refusals refusals_;
};

}  // namespace micro
