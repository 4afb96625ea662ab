#pragma once

#include <string>
#include <variant>

#include "kirchhoff/monte_carlo.h"

namespace micro {

/// The closed form, triangle by triangle (exact.h).
struct Exact {};

/// The whole table at once; tolerance is the relative L2 error of D over the table.
struct Spectral {
  double tolerance = 1e-3;
};

/// How D_K is computed.
using KirchhoffEstimator = std::variant<Exact, MonteCarlo, Spectral>;

/// What is asked for: chosen directions, or every node of a disk table.
enum class Targets { Directions, Table };

/// What the surface's share of the cost depends on.
struct KirchhoffSurface {
  double triangles = 0;
  double dx = 0, dy = 0;    ///< µm
  double slope = 0;         ///< root mean square of |∇z| over the triangles (Sdq)
  double height_range = 0;  ///< µm, peak to valley
};

/// Throws InputError if there is no triangle.
KirchhoffSurface kirchhoff_surface(const HeightField& surface);

/// What is asked of it.
struct KirchhoffRequest {
  Targets targets = Targets::Table;
  double directions = 0;    ///< how many, or nodes of the table on the disk
  double lambda_q = 0.555;  ///< µm
  double tolerance = 1e-3;  ///< see MonteCarlo and Spectral
  int threads = 1;
};

/// Seconds on one thread of an AVX2 core at 2.4 GHz. bench/monte_carlo_bench regenerates the first three
/// (exact_rate, point_rate with many and with one direction); the fourth is what the spectral estimator's
/// required speed allows, 0.38 s on two threads for 640 × 480 points and 20 nodes in q_z.
struct KirchhoffCosts {
  double exact_triangle = 10e-9;         ///< one triangle in one direction
  double monte_carlo_point = 0.75e-9;    ///< one point in one direction
  double monte_carlo_draw = 12e-9;       ///< placing the points of one triangle's stratum, for 512 directions
  double spectral_plane_point = 120e-9;  ///< one point of the surface at one node of q_z
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
/// |q|·√(a_T v(s/n)/(4π²D))/n ≤ tolerance. Spectral: points times nodes in q_z, |q|·range/4 + ln(1/tolerance)
/// + 3; infinite for chosen directions.
KirchhoffPrediction predict_seconds(const KirchhoffSurface& surface, const KirchhoffRequest& request,
                                    const KirchhoffCosts& costs = {});

struct KirchhoffChoice {
  KirchhoffEstimator estimator;
  KirchhoffPrediction seconds;
  std::string reason;  ///< one sentence
};

/// The estimator that is predicted to be the fastest to reach the tolerance.
/// Throws InputError unless λ_q and the tolerance are positive and finite.
KirchhoffChoice choose_estimator(const KirchhoffSurface& surface, const KirchhoffRequest& request,
                                 const KirchhoffCosts& costs = {});

}  // namespace micro
