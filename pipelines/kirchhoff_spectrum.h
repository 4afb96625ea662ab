#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "distribution/spectrum_mean.h"
#include "kirchhoff/coherence.h"
#include "kirchhoff/error_sample.h"
#include "pipelines/plan.h"
#include "pipelines/prepare_scan.h"
#include "pipelines/scan_listing.h"
#include "pipelines/wavelength_dependence.h"

namespace micro {

/// The wavelengths that D_K is wanted at: given, or as few of a range as its tables take.
struct AsManyAsNeeded {
  double shortest = 0.38, longest = 0.78;  ///< λ_q in µm
};

/// D_K at many wavelengths.
struct SpectrumRequest {
  std::variant<std::vector<double>, AsManyAsNeeded> lambda_q;  ///< µm, ascending
  double tolerance = 1e-3;                                     ///< of every table, as Kirchhoff's
  Coherence coherence = WholePatch{};                          ///< WholePatch or SubWindows
  std::optional<double> source;  ///< instead: full diameter of the source (rad), whose coherence area follows
                                 ///< each wavelength
};

/// D_K at many wavelengths over all scans.
struct SpectrumOfScans {
  std::vector<double> lambda_q;  ///< µm, ascending
  SpectrumMean mean;
  std::vector<ErrorSample> errors;      ///< [λ] over all scans
  std::vector<std::int64_t> unreached;  ///< [λ] windows whose table missed its tolerance
  double tolerance = 0;
  std::vector<double> coherence_area;  ///< [λ] µm², or empty: whole patches
  std::int64_t windows = 0;            ///< at each wavelength if they differ: all together
  double pitch = 0;                    ///< the largest, µm
  double seconds = 0;

  double rel_error(std::size_t wavelength) const;
  /// sinθ up to which half a fringe from point to point is resolved, λ_q/(4·pitch), at most 1.
  double valid_sin_theta(std::size_t wavelength) const;
};

/// What a run has gathered of its spectrum. Beside the tables of SpectrumMean it takes 16 bytes a cell (at
/// most 100² of them) and wavelength.
struct SpectrumSums {
  std::optional<SpectrumOfScans> spectrum;         ///< nothing if no wavelengths could be chosen
  std::optional<WavelengthDependence> dependence;  ///< of two wavelengths or more
  std::string unfit;                               ///< why it applies to no scan at all, or empty
  Refusals refusals;
  Plan choice;                 ///< how the wavelengths were chosen
  std::int64_t looked_at = 0;  ///< scans of the listing, from its first on
};

/// Sums that nothing has been added to. The whole listing decides on the wavelengths and on the cells that
/// they are compared over, so that its shards agree.
SpectrumSums begin_spectrum(const ScanListing& listing, const Preparation& preparation, const DiskGrid& grid,
                            const SpectrumRequest& request);

/// Whether both stand on the same tables, wavelengths and cells.
bool add_up(const SpectrumSums& a, const SpectrumSums& b);

/// Adds what another shard's sums hold. Throws InputError if they do not add up.
void merge(SpectrumSums& sums, const SpectrumSums& more);

/// Adds the tables of every scan from the first that was not looked at yet to number `scans`, weighted by
/// projected area, or passes it over if there is no surface_of(k). One scan at a time, on all threads: a
/// spectrum's tables are large. Calls after(k, refusal) with the reason why a scan was refused, or an empty
/// one; what it throws goes through.
void add_spectra(SpectrumSums& sums, std::size_t scans, const SpectrumRequest& request,
                 const std::function<std::optional<HeightField>(std::size_t)>& surface_of,
                 const std::function<void(std::size_t, const std::string&)>& after);

/// What was done, and how weakly D_K depends on the wavelength on these scans: whether one would have done.
Plan plan_of(const SpectrumSums& sums);

/// Tables whose distance (wavelength_dependence.h) beyond what scatter explains stays below this are taken
/// for the same.
constexpr double kSameTables = 0.05;

/// The rule of `auto`: the ends of the range, then, between neighbours that are further apart than
/// kSameTables, the middle in 1/λ, until none are; if the ends already are not, the middle of the range
/// alone. `dependence_of` judges any set of wavelengths (ascending).
struct ChosenWavelengths {
  std::vector<double> lambda_q;
  double farthest;  ///< largest distance of neighbours, or of the ends where one wavelength does
};
ChosenWavelengths choose_wavelengths(
    const AsManyAsNeeded& range,
    const std::function<WavelengthDependence(const std::vector<double>&)>& dependence_of);

}  // namespace micro
