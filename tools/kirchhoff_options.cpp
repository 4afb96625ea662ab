#include "tools/kirchhoff_options.h"

#include <cmath>
#include <map>
#include <string_view>

#include "io/direction_file.h"
#include "tools/units.h"

namespace micro::tools {
namespace {

const std::map<std::string, KirchhoffBy> kEstimators = {{"", KirchhoffBy::Fastest},
                                                        {"exact", KirchhoffBy::Exact},
                                                        {"monte-carlo", KirchhoffBy::MonteCarlo},
                                                        {"spectral", KirchhoffBy::Spectral}};

constexpr std::string_view kSource = "source:", kTaper = "taper:";

/// An area in µm² or source:ANGLE, the full diameter of a round source at wavelength λ; nothing if it is
/// neither.
std::optional<double> make_area(const std::string& text, double lambda) {
  if (text.starts_with(kSource)) return coherence_area(lambda, parse_angle(text.substr(kSource.size())));
  try {
    std::size_t end = 0;
    const double area = std::stod(text, &end);
    if (end == text.size() && area > 0 && std::isfinite(area)) return area;
  } catch (const std::exception&) {
    // it is no number
  }
  return std::nullopt;
}

/// patch, or an area cut into squares, or with taper: into Gaussians.
Coherence make_coherence(const std::string& text, double lambda) {
  if (text == "patch") return WholePatch{};
  const bool taper = text.starts_with(kTaper);
  const auto area = make_area(taper ? text.substr(kTaper.size()) : text, lambda);
  if (!area)
    throw CLI::ValidationError("--coherence: '" + text +
                               "' is not patch, an area in µm², source:ANGLE, or one of these after taper:");
  if (taper) return GaussianTaper{*area};
  return SubWindows{*area};
}

}  // namespace

Kirchhoff make_kirchhoff(const KirchhoffOptions& options) {
  const double lambda_q = options.lambda > 0 ? options.lambda / std::cos(options.theta_d / 2)
                                             : std::get<double>(options.lambda_q);
  if (!(lambda_q > 0)) throw CLI::ValidationError("--lambda-q: a wavelength must be positive");
  if (!(options.tolerance > 0 && options.tolerance < 1))
    throw CLI::ValidationError("--tol: must lie in (0, 1)");
  return {lambda_q, options.tolerance,
          make_coherence(options.coherence, options.lambda > 0 ? options.lambda : lambda_q),
          kEstimators.at(options.estimator)};
}

std::optional<DirectionsRequest> make_directions(const KirchhoffOptions& options) {
  const std::string& text = options.directions;
  if (text.empty()) return std::nullopt;
  if (wants_spectrum(options)) throw CLI::ValidationError("--directions takes one wavelength at a time");
  DirectionsRequest request{.directions = 0, .kirchhoff = make_kirchhoff(options)};
  if (request.kirchhoff.by == KirchhoffBy::Spectral)
    throw CLI::ValidationError(
        "--estimator spectral computes whole tables at once; --directions takes exact or monte-carlo");
  if (text.find_first_not_of("0123456789") != std::string::npos) {
    request.directions = read_directions(text);
    return request;
  }
  constexpr int kMost = 1000000;
  const long count = text.size() < 9 ? std::stol(text) : kMost + 1L;
  if (count < 1 || count > kMost)
    throw CLI::ValidationError("--directions: from 1 to " + std::to_string(kMost) + " directions, not " +
                               text);
  request.directions = static_cast<int>(count);
  return request;
}

bool wants_spectrum(const KirchhoffOptions& options) {
  return !(options.lambda > 0) && !std::holds_alternative<double>(options.lambda_q);
}

SpectrumRequest make_spectrum(const KirchhoffOptions& options) {
  if (!(options.tolerance > 0 && options.tolerance < 1))
    throw CLI::ValidationError("--tol: must lie in (0, 1)");
  if (options.estimator == "exact" || options.estimator == "monte-carlo")
    throw CLI::ValidationError(
        "--estimator " + options.estimator +
        " takes one wavelength at a time; many are computed by the spectral estimator");
  if (options.coherence.starts_with(kTaper))
    throw CLI::ValidationError("--coherence " + std::string(kTaper) + " takes one wavelength at a time");
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
  app.add_option(
         "--tol", options.tolerance,
         "Relative L2 error of D_K's table, or with monte-carlo the standard error of each direction, "
         "relative to D or, in dark speckles, to the mean of D around")
      ->capture_default_str();
  app.add_option(
         "--estimator", options.estimator,
         "How D_K is computed: exact (the closed form of every triangle, for each direction), "
         "monte-carlo (stops at --tol or after 10^12 points, and says how far it got) or spectral (whole "
         "tables only). Default: what is predicted to be the fastest; the plan says which and why")
      ->check(CLI::IsMember({"exact", "monte-carlo", "spectral"}));
  app.add_option(
         "--directions", options.directions,
         "D_K at chosen half vectors only, without a table: so many, spread over the extent, or a file of "
         "rows `hx hy` or `hx hy hz`")
      ->type_name("N|FILE");
  app.add_option(
         "--coherence", options.coherence,
         "Coherence area of D_K: patch, an area in µm², or source:9deg, the diameter of a round source "
         "(lambda^2 over its solid angle). Areas are cut into squares side by side, or after taper: (as "
         "taper:16, taper:source:9deg) into overlapping Gaussians, which leave no tails")
      ->capture_default_str();
  lambda->check([](const std::string& text) {
    return parse_length(text) > 0 ? std::string() : "a wavelength must be positive, not " + text;
  });
}

}  // namespace micro::tools
