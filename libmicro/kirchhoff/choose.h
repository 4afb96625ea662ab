#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <variant>

#include "distribution/disk_table.h"
#include "kirchhoff/coherence.h"
#include "kirchhoff/monte_carlo.h"
#include "kirchhoff/spectral_work.h"

namespace micro {

/// The closed form, triangle by triangle (exact.h).
struct Exact {};

/// The whole table at once; tolerance is the relative L2 error of D over the table.
struct Spectral {
  double tolerance = 1e-3;
};

/// How D_K is computed.
using KirchhoffEstimator = std::variant<Exact, MonteCarlo, Spectral>;

/// "exact", "monte-carlo" or "spectral".
std::string name_of(const KirchhoffEstimator& estimator);

/// So many chosen directions.
struct Directions {
  std::int64_t count = 0;
};

/// What is asked for.
struct KirchhoffRequest {
  std::variant<DiskGrid, Directions> targets;  ///< every node of a disk table, or chosen directions
  double lambda_q = 0.555;                     ///< µm
  double tolerance = 1e-3;                     ///< see MonteCarlo and Spectral
  int threads = 1;
};

/// Seconds on one thread of an AVX2 core at 2.4 GHz. bench/kirchhoff_costs_bench measures them again.
struct KirchhoffCosts {
  double exact_triangle = 10e-9;      ///< one triangle in one direction
  double monte_carlo_point = 0.6e-9;  ///< one point in one direction
  double monte_carlo_draw = 16e-9;    ///< placing the points of one triangle's stratum, for 512 directions
  SpectralCosts spectral;
  double spectral_surface = 10e-9;  ///< one point of the surface: its heights' histogram and slopes
};

/// Predicted seconds; infinite where an estimator cannot serve the request.
struct KirchhoffPrediction {
  double exact = 0, monte_carlo = 0, spectral = 0;
  int subdivision = 1;  ///< n that the Monte Carlo estimate is predicted to need
};

/// Exact: directions times triangles. Monte Carlo: six points in each of n² strata of each triangle, after a
/// first pass with n = 1. With s² = |q|²·slope²·(dx²+dy²)/18 the mean variance of the phase over a triangle
/// (q_⊥ and q_z∇z being as wide as the lobe), the mean of a rotated draw has the variance v = min(0.3 s⁴,
/// 1/3), and Var F̂ = Σ|q·a_T|²·v(s/n)/n²; relative to the lobe's mean D = 1/(2π·slope²) the standard error is
/// |q|·√(a_T v(s/n)/(4π²D))/n ≤ tolerance. Spectral: spreading, transforms and nodes of predict_work
/// (spectral_work.h) for each window, and the exact nodes that its error is measured on; twice that where
/// the tolerance takes double precision; infinite for chosen directions. Throws InputError if no window has a
/// triangle.
KirchhoffPrediction predict_seconds(std::span<const Window> windows, const KirchhoffRequest& request,
                                    const KirchhoffCosts& costs = {});

struct KirchhoffChoice {
  KirchhoffEstimator estimator;
  KirchhoffPrediction seconds;
};

/// The estimator that is predicted to be the fastest to reach the tolerance.
/// Throws InputError unless λ_q and the tolerance are positive and finite.
KirchhoffChoice choose_estimator(std::span<const Window> windows, const KirchhoffRequest& request,
                                 const KirchhoffCosts& costs = {});

/// "exact 4.1e+03 s, monte-carlo 1.8e+03 s, spectral 0.3 s".
std::string to_text(const KirchhoffPrediction& prediction);

}  // namespace micro
