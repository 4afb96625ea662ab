#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "distribution/disk_table.h"

namespace micro {

/// The mean over scans of tables at many wavelengths, weighted by each scan's projected area A_perp, and its
/// standard error: what TableMean is to one table, in a third of its memory. Means are running means in
/// double; deviations are summed about them in float, from the second scan on, since they have no digits to
/// lose: 8 bytes a node of the disk and wavelength, 16 from the second scan on (41 wavelengths of 1025²: 0.27
/// and 0.54 GB), however many scans there are.
class SpectrumMean {
 public:
  /// Of no wavelength, to be read from an archive.
  SpectrumMean() = default;
  SpectrumMean(const DiskGrid& grid, std::size_t wavelengths);

  /// Adds one scan's tables with its weight, A_perp in µm². A weight of zero (no surface) is counted nowhere.
  /// As many tables of the grid's size as there are wavelengths.
  void add(const std::vector<Grid<float>>& tables, double weight);

  /// Adds what another mean holds, as if its scans had been added here: means to rounding, standard errors to
  /// that of float. Throws InputError if it has another grid or number of wavelengths.
  void merge(const SpectrumMean& other);

  template <typename Archive>
  void persist(Archive& archive) {
    archive(grid_, nodes_, count_, weight_, weight2_, sums_);
  }

  const DiskGrid& grid() const { return grid_; }
  std::size_t wavelengths() const { return sums_.size(); }
  std::int64_t count() const { return count_; }
  double weight() const { return weight_; }  ///< ΣA_perp, µm²

  /// D̄ = Σ A·D / Σ A at one wavelength, 1/sr.
  DiskTable mean(std::size_t wavelength) const;

  /// Standard error of D̄ over n scans, 1/sr: √(n/(n−1)·Σ A²(D − D̄)²) / ΣA. Nothing if there are fewer than
  /// two.
  std::optional<Grid<double>> standard_error(std::size_t wavelength) const;

 private:
  struct Sums {
    std::vector<double> mean;
    std::vector<float> first, square;  // Σ A²·(D − D̄), Σ A²·(D − D̄)²

    template <typename Archive>
    void persist(Archive& archive) {
      archive(mean, first, square);
    }
  };
  void add(const Grid<float>& table, double weight, Sums& sums) const;
  void merge(const SpectrumMean& other, std::size_t wavelength);

  DiskGrid grid_;
  std::vector<std::int32_t> nodes_;  // those of the disk
  std::int64_t count_ = 0;
  double weight_ = 0, weight2_ = 0;  // Σ A, Σ A²
  std::vector<Sums> sums_;
};

}  // namespace micro
