#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <variant>
#include <vector>

#include "pipelines/kirchhoff_spectrum.h"

namespace micro::tools {

/// What --lambda-q may say: one effective wavelength, many (ascending), or auto. µm.
using LambdaQ = std::variant<double, std::vector<double>, AsManyAsNeeded>;

/// Reads one wavelength, `555nm`, or a range of them, `0.38..0.78/0.01`, in µm; see parse_lambda_q().
std::vector<double> parse_wavelengths(const std::string& text);

/// Reads `555nm`, `0.38..0.78/0.01` (first..last/step, units as of any length, the last included if a step
/// falls on it to rounding) or `auto`. Throws CLI::ValidationError with a sentence if it is none of them.
LambdaQ parse_lambda_q(const std::string& text);

CLI::Option* add_lambda_q(CLI::App& app, LambdaQ& target);

/// The summary's entry in `methods`.
nlohmann::json spectrum_summary(const SpectrumOfScans& spectrum);

/// A closing line on stdout.
void print_spectrum(const SpectrumOfScans& spectrum);

}  // namespace micro::tools
