#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <new>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "height/autocorrelation.h"
#include "height/level.h"
#include "height/repair.h"
#include "height/statistics.h"
#include "io/scan.h"
#include "tools/commands.h"
#include "tools/common_options.h"
#include "tools/json_output.h"
#include "tools/listing_output.h"
#include "tools/scan_output.h"

namespace micro::tools {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
  CommonOptions common;
  std::vector<std::string> scans;
  std::vector<std::string> pitch;
  Level level = Level::Plane;
  bool fill_holes = false;
  bool reject_outliers = false;
};

/// What a repair did, without the surface.
struct Change {
  Eigen::Index points;
  double largest;  ///< µm
};

struct Description {
  std::string source;
  std::string format;
  Eigen::Index rows, cols, missing;
  double dx, dy;
  HeightRange as_read;
  std::optional<Change> rejected, filled;
  HeightParameters height;
  double Sdq, Sdr;
  TextureDirection texture;
  CorrelationLengths lengths;
};

Change apply(Repair repair, HeightField& surface) {
  surface = std::move(repair.surface);
  return {repair.changed, repair.largest_change};
}

/// Reads a scan; rejects outliers, levels and fills holes as asked; measures.
Description describe(const std::filesystem::path& path, const Options& options, const ReadOptions& reading) {
  Scan scan = read_scan(path, reading);
  HeightField& surface = scan.surface;
  Description d{};
  d.source = path.string();
  d.format = scan.format;
  d.rows = surface.rows(), d.cols = surface.cols();
  d.dx = surface.dx, d.dy = surface.dy;
  d.missing = missing_count(surface);
  d.as_read = height_range(surface);
  try {
    if (options.reject_outliers) d.rejected = apply(reject_outliers(surface), surface);
    surface = level(std::move(surface), options.level);
    if (options.fill_holes) d.filled = apply(fill_holes(surface), surface);
  } catch (const FileError&) {
    throw;
  } catch (const InputError& error) {
    throw FileError(path, error.what());
  }
  d.height = height_parameters(surface);
  d.Sdq = Sdq(surface);
  d.Sdr = Sdr(surface);
  d.texture = texture_direction(surface);
  d.lengths = correlation_lengths(autocorrelation(surface), d.texture.direction);
  return d;
}

/// A description, or why there is none.
struct Outcome {
  std::optional<Description> description;
  std::string message;
};

Outcome try_to_describe(const std::filesystem::path& path, const Options& options,
                        const ReadOptions& reading) {
  try {
    return {describe(path, options, reading), {}};
  } catch (const FileError& error) {
    return {{}, error.fact()};
  } catch (const std::bad_alloc&) {
    return {{}, "not enough memory for this scan"};
  } catch (const std::exception& error) {
    return {{}, error.what()};
  }
}

Json to_json(const Description& d, Level level) {
  Json json = {{"source", d.source},
               {"format", d.format},
               {"rows", d.rows},
               {"cols", d.cols},
               {"dx_um", d.dx},
               {"dy_um", d.dy},
               {"missing", d.missing},
               {"min_um", d.as_read.min},
               {"max_um", d.as_read.max},
               {"mean_um", d.as_read.mean},
               {"rms_um", d.as_read.rms},
               {"level", name_of(level)},
               {"Sq_um", d.height.Sq},
               {"Sa_um", d.height.Sa},
               {"Sz_um", d.height.Sz},
               {"Ssk", d.height.Ssk},
               {"Sku", d.height.Sku},
               {"Sdq", d.Sdq},
               {"Sdr", d.Sdr},
               {"Sal_um", d.lengths.Sal},
               {"Str", d.lengths.Str},
               {"tau_along_um", d.lengths.along},
               {"tau_across_um", d.lengths.across},
               {"direction_rad", d.texture.direction},
               {"anisotropy", d.texture.anisotropy}};
  const auto add = [&](const std::string& what, const std::optional<Change>& change) {
    if (!change) return;
    json[what] = change->points;
    json["largest_" + what + "_um"] = change->largest;
  };
  add("rejected", d.rejected);
  add("filled", d.filled);
  return json;
}

/// A number for people: six digits, a dash for what is none.
std::string number(double value) {
  if (!std::isfinite(value)) return "–";
  std::ostringstream text;
  text << value;
  return text.str();
}

std::string length(double micrometres) {
  return std::isfinite(micrometres) ? number(micrometres) + " µm" : "–";
}

void print(std::ostream& out, const Description& d, Level level) {
  const double points = static_cast<double>(d.rows * d.cols);
  out << d.source << " (" << d.format << ")\n"
      << "  size         " << d.cols << " × " << d.rows << " points, " << number(d.dx) << " × "
      << number(d.dy) << " µm apart\n"
      << "  missing      " << d.missing << " points ("
      << number(100 * static_cast<double>(d.missing) / points) << " %)\n"
      << "  as in file   min " << length(d.as_read.min) << ", max " << length(d.as_read.max) << ", mean "
      << length(d.as_read.mean) << ", rms " << length(d.as_read.rms) << "\n";
  if (d.rejected)
    out << "  rejected     " << d.rejected->points << " outliers, at most " << length(d.rejected->largest)
        << " from the local median\n";
  if (d.filled)
    out << "  filled       " << d.filled->points << " points, at most " << length(d.filled->largest)
        << " from the mean\n";
  out << "  after --level " << name_of(level) << ":\n"
      << "  Sq " << length(d.height.Sq) << ", Sa " << length(d.height.Sa) << ", Sz " << length(d.height.Sz)
      << ", Ssk " << number(d.height.Ssk) << ", Sku " << number(d.height.Sku) << "\n"
      << "  Sdq " << number(d.Sdq) << ", Sdr " << (std::isfinite(d.Sdr) ? number(100 * d.Sdr) + " %" : "–")
      << ", Sal " << length(d.lengths.Sal) << ", Str " << number(d.lengths.Str) << "\n";
  if (std::isfinite(d.texture.direction))
    out << "  texture runs at " << number(d.texture.direction * 180 / std::numbers::pi)
        << "° from +x towards +y (anisotropy " << number(d.texture.anisotropy) << "), 1/e correlation length "
        << length(d.lengths.along) << " along, " << length(d.lengths.across) << " across\n";
  else
    out << "  no direction (anisotropy " << number(d.texture.anisotropy) << "), 1/e correlation length "
        << length(d.lengths.along) << " along x, " << length(d.lengths.across) << " along y\n";
}

int info(const Options& options) {
  const ReadOptions reading = parse_pitch(options.pitch);
  const ScanListing listing = list_scans({options.scans.begin(), options.scans.end()});
  require_scans(listing, options.scans);
  Json scans = Json::array(), failed = Json::array();
  parallel_in_order(
      static_cast<std::int64_t>(listing.scans.size()),
      [&](std::int64_t k) {
        return try_to_describe(listing.scans[static_cast<std::size_t>(k)].path, options, reading);
      },
      [&](std::int64_t k, Outcome outcome) {
        const std::string source = listing.scans[static_cast<std::size_t>(k)].path.string();
        if (!outcome.description) {
          print_failed(source, outcome.message);
          failed.push_back({{"source", source}, {"message", outcome.message}});
        } else {
          scans.push_back(to_json(*outcome.description, options.level));
          if (!options.common.json) print(std::cout, *outcome.description, options.level);
        }
      });
  if (options.common.json)
    print_json(Json{{"scans", scans}, {"failed", failed}, {"skipped", skipped_json(listing)}});
  else
    print_skipped(listing);
  if (failed.empty()) return kDone;
  return scans.empty() ? kNothing : kSomeFailed;
}

}  // namespace

Run add_info(CLI::App& app) {
  auto options = std::make_shared<Options>();
  app.add_option("SCAN", options->scans, "Scans in any readable format, or directories of scans")->required();
  add_pitch(app, options->pitch,
            "Distance between points, P or X,Y, for formats that do not keep it (.npy, .exr, plain text)");
  add_level(app, options->level);
  app.add_flag("--reject-outliers", options->reject_outliers,
               "Make points missing that lie beyond 6 robust sigma from the local median, before all else");
  app.add_flag("--fill-holes", options->fill_holes,
               "Fill missing points with the harmonic surface over each hole");
  add_common_options(app, options->common, "microbrdf info scan.dat other.datx --json");
  return [options] { return info(*options); };
}

}  // namespace micro::tools
