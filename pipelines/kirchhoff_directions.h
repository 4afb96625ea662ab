#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "pipelines/kirchhoff_estimate.h"
#include "pipelines/plan.h"

namespace micro {

/// D_K at chosen half vectors alone: so many, spread evenly over what a table would show
/// (distribution/directions.h), or given ones (unit length, h_z ≥ 0).
struct DirectionsRequest {
  std::variant<int, std::vector<Vec3>> directions;
  Kirchhoff kirchhoff;
};

/// D_K at chosen half vectors over all scans.
struct DirectionsOfScans {
  Kirchhoff kirchhoff;
  std::vector<Vec3> h;
  std::vector<double> density;                        ///< 1/sr
  std::optional<std::vector<double>> standard_error;  ///< 1/sr, over scans
  std::vector<double> estimator_error;  ///< 1/sr, Monte Carlo's own standard error of the mean; 0 for exact
  std::int64_t scans = 0;
  double area = 0;             ///< Σ A_perp, µm²
  std::int64_t unreached = 0;  ///< directions of a scan that missed the tolerance
  double valid_sin_theta = 1;  ///< beyond it the pitch does not resolve the surface
  std::string estimator;
  double rel_error = 0;
  double seconds = 0;  ///< summed over scans
};

/// The name of its group under /ndf.
constexpr const char* kDirectionsName = "kirchhoff_directions";

/// Running sums over scans.
class DirectionsMean {
 public:
  /// `table`: the one that is spared.
  DirectionsMean(const Kirchhoff& kirchhoff, const std::vector<Vec3>& h, const DiskGrid& table);

  /// `area`: the scan's weight, A_perp in µm²; `pitch`: the larger of its two, µm.
  void add(const KirchhoffEstimate& scan, double area, double pitch);
  /// A scan that it does not apply to, and why.
  void refuse(const std::string& reason) { ++refusals_[reason]; }
  /// Adds what another sum over the same directions holds.
  void merge(const DirectionsMean& other);

  template <typename Archive>
  void persist(Archive& archive) {
    archive(result_.kirchhoff, result_.h, mean_, tally_, table_, pitch_, refusals_);
  }

  const std::vector<Vec3>& h() const { return result_.h; }
  /// Nothing if no scan gave any.
  std::optional<DirectionsOfScans> finish() const;
  /// What was done, or why nothing was.
  Plan plan() const;

 private:
  DirectionsOfScans result_;
  WeightedMean mean_;
  KirchhoffTally tally_;
  DiskGrid table_;
  double pitch_ = 0;  // the largest, µm
  Refusals refusals_;
};

}  // namespace micro
