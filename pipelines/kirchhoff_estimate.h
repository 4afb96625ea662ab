#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "distribution/disk_table.h"
#include "distribution/weighted_mean.h"
#include "height/height_field.h"
#include "kirchhoff/choose.h"
#include "kirchhoff/coherence.h"
#include "kirchhoff/error_sample.h"

namespace micro {

/// Which estimator of D_K is to be used: one by name, or the one that the cost model (kirchhoff/choose.h)
/// takes for the fastest on each scan.
enum class KirchhoffBy { Fastest, Exact, MonteCarlo, Spectral };

/// The Kirchhoff distribution D_K [Dong15 Eq. 6] at one |q| = 4π/λ_q.
struct Kirchhoff {
  double lambda_q = 0.555;  ///< µm
  double tolerance = 1e-3;  ///< of the spectral estimator's table or of each Monte Carlo direction (choose.h)
  Coherence coherence = WholePatch{};
  KirchhoffBy by = KirchhoffBy::Fastest;
};

/// Where D_K is wanted: on every node of a disk table, or at half vectors h (unit length, h_z ≥ 0).
using KirchhoffTargets = std::variant<DiskGrid, std::vector<Vec3>>;

/// D_K of one scan, and how it came about.
struct KirchhoffEstimate {
  Grid<double> density;           ///< 1/sr; [size, size] of a table, [n, 1] of directions
  Grid<double> variance;          ///< of Monte Carlo, same shape, 1/sr²; 0×0: none
  ErrorSample checked;            ///< of the spectral estimator: its tables against `exact`
  std::string estimator;          ///< "exact", "monte-carlo" or "spectral"
  KirchhoffPrediction predicted;  ///< s, of each estimator, before it began
  double predicted_spared = 0;    ///< s, of the fastest one on the table that was spared
  std::int64_t windows = 0;       ///< coherent ones
  std::int64_t asked = 0;         ///< of these promises …
  std::int64_t unreached = 0;     ///< … so many were missed: Monte Carlo directions, spectral tables
  double seconds = 0;
};

/// D_K at the same targets for any number of scans, from several threads at once. It keeps memory and plans
/// from scan to scan.
class KirchhoffScans {
 public:
  /// `spared`: the larger table that the targets stand for, if they are a part of it. Throws InputError if
  /// the estimator cannot serve the targets.
  KirchhoffScans(const Kirchhoff& kirchhoff, KirchhoffTargets targets, std::optional<DiskGrid> spared);
  ~KirchhoffScans();

  /// Cuts the surface into its coherent windows, estimates each one's D_K and averages them, weighted by
  /// effective area. Throws InputError, with the reason, where that cannot be.
  KirchhoffEstimate operator()(const HeightField& surface) const;

 private:
  class Solvers;
  Kirchhoff kirchhoff_;
  KirchhoffTargets targets_;
  std::optional<DiskGrid> spared_;
  std::unique_ptr<Solvers> solvers_;  // of tables, else null
};

/// What is known of D_K's estimation over many scans.
class KirchhoffTally {
 public:
  /// `area`: the scan's weight, A_perp in µm².
  void add(const KirchhoffEstimate& scan, double area);

  /// Adds what another tally holds.
  void merge(const KirchhoffTally& other);

  template <typename Archive>
  void persist(Archive& archive) {
    archive(checked_.nodes, checked_.squared, checked_.squared_core_free, checked_.significant,
            checked_.significant_bad, variance_, area_, seconds_, predicted_spared_, predicted_.exact,
            predicted_.monte_carlo, predicted_.spectral, predicted_.subdivision, scans_, windows_, asked_,
            unreached_, estimators_);
  }

  /// "spectral", or "exact and spectral" where the cost model chose differently for different scans.
  std::string estimator() const;
  /// Relative L2 error of the mean: the spectral estimator's against `exact` on a few nodes (with and without
  /// the coherent core), or Monte Carlo's standard error √(Σ variance/ΣD²); 0 for exact.
  double rel_error(const Grid<double>& mean) const;
  /// Monte Carlo's standard error of the mean, 1/sr; 0×0 if there was none.
  Grid<double> standard_error() const;
  std::int64_t unreached() const { return unreached_; }
  double seconds() const { return seconds_; }
  /// For the plan: which estimator, why, what was predicted and what it took, how far it got.
  std::string sentence(KirchhoffBy by) const;
  /// For the plan: how many nodes out of the table that was spared, and what that would have taken.
  std::string saving(std::int64_t nodes, const DiskGrid& spared) const;

 private:
  ErrorSample checked_;
  Grid<double> variance_;  // Σ A²·variance
  double area_ = 0, seconds_ = 0, predicted_spared_ = 0;
  KirchhoffPrediction predicted_{0, 0, 0, 1};
  std::int64_t scans_ = 0, windows_ = 0, asked_ = 0, unreached_ = 0;
  std::vector<std::string> estimators_;  // without repetition, sorted
};

}  // namespace micro
