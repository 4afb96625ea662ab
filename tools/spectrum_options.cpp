#include "tools/spectrum_options.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "pipelines/spectrum_file.h"
#include "tools/units.h"

namespace micro::tools {
namespace {

/// Wavelengths of one range: their tables have to fit somewhere.
constexpr int kMostWavelengths = 1000;

[[noreturn]] void refuse(const std::string& text, const std::string& why) {
  throw CLI::ValidationError("'" + text + "' " + why);
}

/// To twelve digits, so that 0.4 + 2·0.1 is 0.6.
double rounded(double length) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.12g", length);
  return std::strtod(text.data(), nullptr);
}

std::vector<double> parse_range(const std::string& text, std::size_t dots) {
  const std::size_t slash = text.find('/', dots);
  if (slash == std::string::npos) refuse(text, "has no step; write a range like 380nm..780nm/10nm");
  const double first = parse_length(text.substr(0, dots)),
               last = parse_length(text.substr(dots + 2, slash - dots - 2)),
               step = parse_length(text.substr(slash + 1));
  if (!(first > 0)) refuse(text, "begins with a wavelength that is not positive");
  if (!(last >= first)) refuse(text, "ends before it begins");
  if (!(step > 0)) refuse(text, "needs a positive step");
  constexpr double kRounding = 1e-9;  // of a step: the end counts if a step falls on it
  const double steps = std::floor((last - first) / step + kRounding);
  if (!(steps < kMostWavelengths))
    refuse(text, "has more than " + std::to_string(kMostWavelengths) + " wavelengths");
  std::vector<double> lambda_q;
  for (int k = 0; k <= static_cast<int>(steps); ++k)
    lambda_q.push_back(rounded(first + k * step));
  // Steps of 1e-17 µm would not move.
  for (std::size_t k = 1; k < lambda_q.size(); ++k)
    if (!(lambda_q[k] > lambda_q[k - 1])) refuse(text, "needs a larger step");
  return lambda_q;
}

}  // namespace

std::vector<double> parse_wavelengths(const std::string& text) {
  const std::size_t dots = text.find("..");
  if (dots != std::string::npos) return parse_range(text, dots);
  const double wavelength = parse_length(text);
  if (!(wavelength > 0)) refuse(text, "is no wavelength: it must be positive");
  return {wavelength};
}

LambdaQ parse_lambda_q(const std::string& text) {
  if (text == "auto") return AsManyAsNeeded{};
  std::vector<double> lambda_q = parse_wavelengths(text);
  if (text.find("..") == std::string::npos) return lambda_q.front();
  return lambda_q;
}

CLI::Option* add_lambda_q(CLI::App& app, LambdaQ& target) {
  return app
      .add_option_function<std::string>(
          "--lambda-q", [&target](const std::string& text) { target = parse_lambda_q(text); },
          "Effective wavelength of D_K, lambda/cos(theta_d/2) (default 555nm), a range of them like "
          "380nm..780nm/10nm, or 'auto': as many of the visible ones as D_K differs between")
      ->type_name("LENGTH|RANGE|auto");
}

nlohmann::json spectrum_summary(const SpectrumOfScans& spectrum) {
  const SpectrumNumbers numbers = numbers_of(spectrum);
  const auto number = [](double value) {
    return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json();
  };
  return {{"method", "kirchhoff_spectrum"},
          {"estimator", "spectral"},
          {"normalization", number(numbers.normalization)},
          {"rel_error", number(numbers.rel_error)},
          {"seconds", number(spectrum.seconds)},
          {"extent", spectrum.mean.grid().extent},
          {"scans", spectrum.mean.count()},
          {"samples", spectrum.windows},
          {"lambda_q_um", spectrum.lambda_q},
          {"normalizations", numbers.normalizations},
          {"rel_errors", numbers.rel_errors}};
}

void print_spectrum(const SpectrumOfScans& spectrum) {
  const SpectrumNumbers numbers = numbers_of(spectrum);
  std::printf("kirchhoff_spectrum: %zu wavelength%s, normalization %.6g over sin(theta) <= %.4g, %.3g s\n",
              spectrum.lambda_q.size(), spectrum.lambda_q.size() == 1 ? "" : "s", numbers.normalization,
              spectrum.mean.grid().extent, spectrum.seconds);
}

}  // namespace micro::tools
