#include "tools/ndf_options.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "core/error.h"
#include "core/estimate.h"
#include "io/signature_file.h"
#include "tools/commands.h"
#include "tools/json_output.h"
#include "tools/kirchhoff_options.h"
#include "tools/listing_output.h"
#include "tools/scan_output.h"
#include "tools/units.h"

namespace micro::tools {
namespace {

/// An angle, or else the file of a measured signature.
NamedSignature make_signature(const std::string& text) {
  if (std::filesystem::exists(text))
    return {std::filesystem::path(text).stem().string(), read_signature(text)};
  double fwhm = 0;
  try {
    fwhm = parse_angle(text);
  } catch (const CLI::ValidationError&) {
    throw CLI::ValidationError("--signature: '" + text + "' is neither an angle like 1.5deg nor a file");
  }
  std::ostringstream name;
  name << fwhm * 180 / std::numbers::pi << "deg";
  return {name.str(), gaussian_signature(fwhm)};
}

Extent make_extent(const std::string& text) {
  if (text.empty()) return WholeDisk{};
  if (text == "auto") return HoldsEnergy{};
  try {
    std::size_t end = 0;
    const double extent = std::stod(text, &end);
    if (end == text.size() && extent > 0 && extent <= 1) return extent;
  } catch (const std::exception&) {
    // falls through to the sentence below
  }
  throw CLI::ValidationError("--extent: '" + text + "' is neither 'auto' nor a number in (0, 1]");
}

/// Where --help lists the options that one method alone uses.
std::string group_of(const std::string& method) {
  return "Options of the " + method + " NDF";
}

}  // namespace

void add_ndf_options(CLI::App& app, NdfOptions& options) {
  app.add_option_function<std::vector<std::string>>(
         "--sigma",
         [&options](const std::vector<std::string>& texts) {
           for (const std::string& text : texts)
             options.sigmas.push_back(parse_length(text));
         },
         "Standard deviation of the filtered NDF's Gaussian window (default 1um); repeatable")
      ->type_name("LENGTH")
      ->allow_extra_args(false)
      ->group(group_of("filtered"));
  app.add_option("--size", options.size, "Nodes along a side of the disk table, odd")
      ->check(CLI::Range(3, 16385))
      ->capture_default_str();
  app.add_option(
      "--extent", options.extent,
      "Half width of the table in m_xy, in (0, 1], or 'auto': what holds the energy (default: all of the "
      "disk that the data can tell of)");
  add_level(app, options.level);
  CLI::Option* reject =
      app.add_flag("--reject-outliers", options.reject_outliers,
                   "Make points missing that lie far off their neighbours (off by default)");
  app.add_option("--outlier-threshold", options.outlier_threshold,
                 "How far: robust standard deviations from the local median")
      ->needs(reject)
      ->check([](const std::string& text) {
        return std::atof(text.c_str()) > 0 ? std::string()
                                           : "the threshold must be a positive number, not " + text;
      })
      ->capture_default_str();
  app.add_flag("--fill-holes", options.fill_holes, "Fill missing points harmonically (off by default)");
  app.add_option(
      "--signature", options.signature,
      "Also write every NDF convolved with the instrument's signature: the full width at half maximum of a "
      "Gaussian in half-vector angle, e.g. 1.5deg, or a file of rows `angle_deg response`");
  const std::size_t before = app.get_options().size();
  add_kirchhoff_options(app, options.kirchhoff);
  for (std::size_t k = before; k < app.get_options().size(); ++k)
    app.get_options()[k]->group(group_of("kirchhoff"));
  add_pitch(app, options.pitch,
            "Distance between points, P or X,Y, for files that don't say it (.npy, .exr, plain text)");
  app.add_flag("--mixed", options.mixed, "Take scans of different pitch together");
}

namespace {

NdfRequest request_of(const NdfOptions& options, const std::vector<std::string>& methods) {
  NdfRequest request;
  request.size = options.size;
  request.extent = make_extent(options.extent);
  make_disk_table({request.size, 1});  // refuses a table that cannot be
  request.prepare.level = options.level;
  if (options.reject_outliers) request.prepare.outlier_threshold = options.outlier_threshold;
  if (options.fill_holes) request.prepare.holes = Preparation::Holes::Fill;
  request.prepare.read = parse_pitch(options.pitch);
  if (options.mixed) request.pitches = NdfRequest::Pitches::MayDiffer;
  if (!options.signature.empty()) request.signature = make_signature(options.signature);
  std::vector<double> sigmas = options.sigmas.empty() ? std::vector<double>{1} : options.sigmas;
  for (const double sigma : sigmas)
    if (!(sigma > 0)) throw CLI::ValidationError("--sigma: the window must be wider than nothing");
  const auto add = [&](NdfMethod method) {
    const bool again = std::any_of(request.methods.begin(), request.methods.end(),
                                   [&](const NdfMethod& known) { return known.name == method.name; });
    if (!again) request.methods.push_back(std::move(method));
  };
  for (const std::string& method : methods) {
    if (method == "naive") add({"naive", Naive{}});
    if (method == "kirchhoff") {
      request.directions = make_directions(options.kirchhoff);
      if (wants_spectrum(options.kirchhoff))
        request.spectrum = make_spectrum(options.kirchhoff);
      else if (!request.directions)
        add({"kirchhoff", make_kirchhoff(options.kirchhoff)});
    }
    if (method == "filtered")
      for (const double sigma : sigmas)
        add({sigma == sigmas.front() ? "filtered" : filtered_name(sigma), Filtered{sigma}});
  }
  if (request.directions && request.methods.empty()) {
    if (request.signature)
      throw CLI::ValidationError("--signature blurs tables, and --directions makes none");
    if (!options.extent.empty() && !std::holds_alternative<int>(request.directions->directions))
      throw CLI::ValidationError("--extent is for tables and --directions N, not for directions from a file");
  }
  return request;
}

}  // namespace

NdfRequest make_request(const NdfOptions& options, const std::vector<std::string>& methods) {
  try {
    return request_of(options, methods);
  } catch (const InputError& error) {
    throw CLI::ValidationError(error.what());  // what the options say makes no sense
  }
}

void require_in_use(const CLI::App& app, const std::vector<std::string>& methods) {
  for (const std::string method : {"naive", "filtered", "kirchhoff"}) {
    if (std::find(methods.begin(), methods.end(), method) != methods.end()) continue;
    for (const CLI::Option* option : app.get_options())
      if (option->count() > 0 && option->get_group() == group_of(method))
        throw CLI::ValidationError(option->get_name() + " is for the " + method +
                                   " NDF, which is not computed here");
  }
}

std::function<void(const Progress&)> progress_line(const CommonOptions& options) {
  if (!shows_progress(options)) return [](const Progress&) {};
  return [watch = Stopwatch(), last = -1.](const Progress& progress) mutable {
    const double seconds = watch.seconds();
    const bool end = progress.done == progress.total;
    if (!end && seconds - last < 0.1) return;
    last = seconds;
    const double rate = static_cast<double>(progress.done) / std::max(seconds, 1e-9);
    const double left = static_cast<double>(progress.total - progress.done) / rate;
    std::fprintf(stderr, "\r\033[K%lld of %lld scans, %.1f scans/s, %.0f s left%s",
                 static_cast<long long>(progress.done), static_cast<long long>(progress.total), rate, left,
                 end ? "\n" : "");
    std::fflush(stderr);
  };
}

int conclude(const NdfResult& result, const ScanListing& listing, const CommonOptions& options,
             const std::filesystem::path& output) {
  const nlohmann::json failed = report_failed(result.scans);
  const std::size_t done = result.scans.size() - failed.size();
  if (options.json) {
    const auto number = [](double value) {
      return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json();
    };
    nlohmann::json methods = nlohmann::json::array();
    for (const NdfOfScans& ndf : result.ndfs) {
      methods.push_back({{"method", ndf.method.name},
                         {"estimator", ndf.estimator},
                         {"normalization", number(normalization(ndf.density))},
                         {"rel_error", number(ndf.rel_error)},
                         {"seconds", number(ndf.seconds)},
                         {"extent", ndf.density.grid.extent},
                         {"outside_extent", number(ndf.outside)},
                         {"scans", ndf.scans},
                         {"samples", ndf.samples},
                         {"without_normal", ndf.without_normal}});
      if (ndf.truncation_error) methods.back()["slope_truncation_error"] = number(*ndf.truncation_error);
    }
    if (result.spectrum) methods.push_back(spectrum_summary(*result.spectrum));
    if (result.directions) {
      const DirectionsOfScans& directions = *result.directions;
      methods.push_back({{"method", kDirectionsName},
                         {"estimator", directions.estimator},
                         {"normalization", nullptr},
                         {"rel_error", number(directions.rel_error)},
                         {"seconds", number(directions.seconds)},
                         {"extent", nullptr},
                         {"directions", directions.h.size()},
                         {"scans", directions.scans}});
    }
    const nlohmann::json summary = {
        {"output", output.string()}, {"scans", done},
        {"failed", failed},          {"skipped", skipped_json(listing)},
        {"methods", methods},        {"plan", nlohmann::json::parse(to_json(result.plan))}};
    print_json(summary);
  } else {
    if (result.spectrum) print_spectrum(*result.spectrum);
    for (const NdfOfScans& ndf : result.ndfs)
      std::printf("%s: normalization %.6g over sin(theta) <= %.4g, %.3g s\n", ndf.method.name.c_str(),
                  normalization(ndf.density), ndf.density.grid.extent, ndf.seconds);
    if (result.directions)
      std::printf("%s: %zu directions, %.3g s\n", kDirectionsName, result.directions->h.size(),
                  result.directions->seconds);
    if (done > 0) std::printf("%s", to_text(result.plan).c_str());
    print_skipped(listing);
    if (!result.empty()) std::printf("%s\n", output.c_str());
  }
  if (result.empty()) {
    std::fprintf(stderr, "microbrdf: no scan gave a normal distribution\n");
    return kNothing;
  }
  return failed.empty() ? kDone : kSomeFailed;
}

}  // namespace micro::tools
