#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/grid.h"
#include "distribution/disk_table.h"

namespace micro {

/// How D_K changes with the wavelength [Dong15 §6, Fig. 6 right]. The speckle of a patch moves with |q|, so
/// tables are compared as means over square cells of the table, wider than the speckle:
///   distance of two wavelengths = ‖D̄₁ − D̄₂‖ / ‖(D̄₁ + D̄₂)/2‖ over cells, D̄ the mean over scans,
/// from which, where there are two scans or more, the standard error of D̄₁ − D̄₂ over scans is taken away, as
/// squares. One scan does not know its scatter: its distance stays as it is.
class WavelengthDependence {
 public:
  /// Of no wavelength, to be read from an archive.
  WavelengthDependence() = default;
  /// `longer_speckle`: λ_q/(2L), L the patch's shorter side, at the longest wavelength: cells are three times
  /// as wide, at least six nodes, and at least a hundredth of the table.
  WavelengthDependence(const DiskGrid& grid, std::vector<double> lambda_q, double longer_speckle);

  /// One scan's tables, with its weight A_perp (µm²).
  void add(const std::vector<Grid<float>>& tables, double weight);

  /// Adds what another sum over the same wavelengths and cells holds. Throws InputError if they differ.
  void merge(const WavelengthDependence& other);

  template <typename Archive>
  void persist(Archive& archive) {
    archive(grid_, lambda_q_, cell_, cell_of_, cells_, scans_, weight_, weight2_, sum_, sum2_, gram2_);
  }

  double cell() const { return cell_; }  ///< in m_xy
  std::int64_t scans() const { return scans_; }
  const std::vector<double>& lambda_q() const { return lambda_q_; }

  /// Relative distances.
  struct Distance {
    double measured;        ///< as it is
    double scatter;         ///< of that, what scatter explains
    double beyond() const;  ///< √(measured² − scatter²), or 0
  };
  Distance between(std::size_t first, std::size_t second) const;

  /// The largest of all pairs by beyond().
  Distance largest() const;
  /// The wavelength from which the farthest other one is nearest, and that distance.
  std::pair<std::size_t, Distance> most_typical() const;

 private:
  DiskGrid grid_;
  std::vector<double> lambda_q_;
  double cell_ = 0;
  std::vector<std::int32_t> cell_of_;  // of each column or row
  int cells_ = 0;                      // along a side
  std::int64_t scans_ = 0;
  double weight_ = 0, weight2_ = 0;
  Eigen::MatrixXd sum_, sum2_;  // [cells², λ] Σ A·D, Σ A²·D
  Eigen::MatrixXd gram2_;       // [λ, λ] Σ A²·DᵀD
};

}  // namespace micro
