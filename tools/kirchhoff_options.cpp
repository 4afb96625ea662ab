#include "tools/kirchhoff_options.h"

#include <cmath>
#include <string_view>

#include "tools/units.h"

namespace micro::tools {
namespace {

constexpr std::string_view kSource = "source:";

/// patch, an area in µm² or source:ANGLE, the full diameter of a round source at wavelength λ.
Coherence make_coherence(const std::string& text, double lambda) {
  if (text == "patch") return WholePatch{};
  if (text.starts_with(kSource))
    return SubWindows{coherence_area(lambda, parse_angle(text.substr(kSource.size())))};
  try {
    std::size_t end = 0;
    const double area = std::stod(text, &end);
    if (end == text.size() && area > 0 && std::isfinite(area)) return SubWindows{area};
  } catch (const std::exception&) {
    // falls through to the sentence below
  }
  throw CLI::ValidationError("--coherence: '" + text + "' is not patch, an area in µm², or source:ANGLE");
}

}  // namespace

Kirchhoff make_kirchhoff(const KirchhoffOptions& options) {
  const double lambda_q = options.lambda > 0 ? options.lambda / std::cos(options.theta_d / 2)
                                             : std::get<double>(options.lambda_q);
  if (!(lambda_q > 0)) throw CLI::ValidationError("--lambda-q: a wavelength must be positive");
  if (!(options.tolerance > 0 && options.tolerance < 1))
    throw CLI::ValidationError("--tol: must lie in (0, 1)");
  return {lambda_q, options.tolerance,
          make_coherence(options.coherence, options.lambda > 0 ? options.lambda : lambda_q)};
}

bool wants_spectrum(const KirchhoffOptions& options) {
  return !(options.lambda > 0) && !std::holds_alternative<double>(options.lambda_q);
}

SpectrumRequest make_spectrum(const KirchhoffOptions& options) {
  if (!(options.tolerance > 0 && options.tolerance < 1))
    throw CLI::ValidationError("--tol: must lie in (0, 1)");
  SpectrumRequest request;
  request.tolerance = options.tolerance;
  if (const auto* lambda_q = std::get_if<std::vector<double>>(&options.lambda_q))
    request.lambda_q = *lambda_q;
  else
    request.lambda_q = std::get<AsManyAsNeeded>(options.lambda_q);
  // Refuses what makes no sense; the coherence area of a source is each wavelength's own.
  request.coherence = make_coherence(options.coherence, 1);
  if (options.coherence.starts_with(kSource)) {
    request.source = parse_angle(options.coherence.substr(kSource.size()));
    request.coherence = WholePatch{};
  }
  return request;
}

void add_kirchhoff_options(CLI::App& app, KirchhoffOptions& options) {
  CLI::Option* lambda_q = add_lambda_q(app, options.lambda_q);
  CLI::Option* lambda =
      add_length(app, "--lambda", options.lambda, "Wavelength of light, instead of --lambda-q");
  lambda->excludes(lambda_q);
  add_angle(app, "--theta-d", options.theta_d,
            "Full angle between light and viewer, with --lambda (default 0)")
      ->needs(lambda);
  app.add_option("--tol", options.tolerance, "Relative L2 error of D_K's table")->capture_default_str();
  app.add_option(
         "--coherence", options.coherence,
         "Coherence area of D_K: patch, an area in µm², or source:9deg, the diameter of a round source")
      ->capture_default_str();
  lambda->check([](const std::string& text) {
    return parse_length(text) > 0 ? std::string() : "a wavelength must be positive, not " + text;
  });
}

}  // namespace micro::tools
