#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "pipelines/kirchhoff_directions.h"
#include "tools/spectrum_options.h"

namespace micro::tools {

/// What D_K takes, as typed.
struct KirchhoffOptions {
  LambdaQ lambda_q = 0.555;
  double lambda = 0;   ///< µm, with theta_d instead of lambda_q; 0: lambda_q says it
  double theta_d = 0;  ///< radians
  double tolerance = 1e-3;
  std::string coherence = "patch";
  std::string estimator;   ///< empty: the fastest
  std::string directions;  ///< empty: a table
};

void add_kirchhoff_options(CLI::App& app, KirchhoffOptions& options);

/// The method that the options make. Throws CLI::ValidationError, with a sentence, if they make none.
Kirchhoff make_kirchhoff(const KirchhoffOptions& options);

/// Whether the options ask for many wavelengths; then make_spectrum() is what they make.
bool wants_spectrum(const KirchhoffOptions& options);
SpectrumRequest make_spectrum(const KirchhoffOptions& options);
/// The half vectors that --directions asks for, or nothing. Throws like make_kirchhoff, and FileError.
std::optional<DirectionsRequest> make_directions(const KirchhoffOptions& options);

}  // namespace micro::tools
