#include "pipelines/ndf_of_scans.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <iomanip>
#include <map>
#include <new>
#include <numbers>
#include <sstream>

#include "core/error.h"
#include "core/estimate.h"
#include "core/parallel.h"
#include "distribution/compare.h"
#include "distribution/table_mean.h"
#include "height/statistics.h"
#include "height/triangles.h"
#include "io/sha256.h"
#include "pipelines/pitch_groups.h"
#include "pipelines/thumbnail.h"

namespace micro {
namespace {

/// One scan's outcome.
struct ScanOutcome {
  ScanRecord record;
  double area = 0;  // A_perp, µm²
  std::vector<std::optional<ScanNdf>> ndfs;
  std::vector<std::string> refusals;  // for each method: why it is left out on this scan, or empty
  std::optional<Picture> thumbnail;
};

/// sinθ of the half vectors that a pitch resolves: a geometric NDF has its facets' own slopes, D_K needs half
/// a fringe from point to point [λ_q/(4·pitch)].
double valid_sin_theta(const NdfMethod& method, double pitch) {
  const auto* kirchhoff = std::get_if<Kirchhoff>(&method.kind);
  return kirchhoff ? std::min(1., kirchhoff->lambda_q / (4 * pitch)) : 1;
}

/// Why a scan is not part of the result: what the exception in flight says, without the file's name.
std::string failure() {
  try {
    throw;
  } catch (const FileError& error) {
    return error.fact();
  } catch (const std::bad_alloc&) {
    return "not enough memory for this scan";
  } catch (const std::exception& error) {
    return error.what();
  }
}

ScanOutcome look_at(const ListedScan& scan, const NdfRequest& request,
                    const std::vector<NdfEstimator>& estimators, bool thumbnail) {
  ScanOutcome outcome;
  ScanRecord& record = outcome.record;
  record.source = scan.source;
  outcome.ndfs.resize(request.methods.size());
  outcome.refusals.resize(request.methods.size());
  try {
    record.sha256 = sha256_of_file(scan.path);
    const PreparedScan prepared = prepare_scan(scan.path, request.prepare);
    const HeightField& surface = prepared.surface;
    record.format = prepared.format;
    record.rows = surface.rows();
    record.cols = surface.cols();
    record.dx = surface.dx;
    record.dy = surface.dy;
    record.missing = prepared.missing;
    record.holes = missing_count(surface);
    record.rejected = prepared.rejected;
    record.filled = prepared.filled;
    if (request.statistics == NdfRequest::Statistics::Compute) {
      record.Sq = Sq(surface);
      record.Sdq = Sdq(surface);
    }
    outcome.area = projected_area(surface);
    if (!(outcome.area > 0)) throw FileError(scan.path, "has no three neighbouring points, so no surface");
    for (std::size_t m = 0; m < request.methods.size(); ++m) {
      try {
        outcome.ndfs[m] = estimators[m](surface);
        if (outcome.ndfs[m]->samples == 0) outcome.refusals[m] = "no point's neighbours determine a plane";
      } catch (const FileError&) {
        throw;
      } catch (const InputError& error) {
        if (request.unfit == NdfRequest::Unfit::Fail) throw FileError(scan.path, error.what());
        outcome.refusals[m] = error.what();
      }
    }
    if (thumbnail) outcome.thumbnail = thumbnail_of(surface);
  } catch (...) {
    record.failure = failure();
  }
  return outcome;
}

/// Only what it takes to say which pitch a scan has.
ScanOutcome look_at_pitch(const ListedScan& scan, const NdfRequest& request) {
  ScanOutcome outcome;
  outcome.record.source = scan.source;
  try {
    const HeightField surface = read_scan(scan.path, request.prepare.read).surface;
    outcome.record.dx = surface.dx;
    outcome.record.dy = surface.dy;
  } catch (...) {
    outcome.record.failure = failure();
  }
  return outcome;
}

/// The larger pitch of the first scan that can be read, µm.
std::optional<double> pitch_of(const ScanListing& listing, const NdfRequest& request) {
  for (const ListedScan& scan : listing.scans)
    try {
      const HeightField surface = read_scan(scan.path, request.prepare.read).surface;
      return std::max(surface.dx, surface.dy);
    } catch (const std::exception&) {
      continue;  // it is reported when its turn comes
    }
  return std::nullopt;
}

/// All of the disk that the data can tell of: D_K ends where the grid of points throws its first false order.
double whole_extent(const NdfMethod& method, std::optional<double> pitch) {
  const auto* kirchhoff = std::get_if<Kirchhoff>(&method.kind);
  return kirchhoff && pitch ? std::min(1., kirchhoff->lambda_q / (2 * *pitch)) : 1;
}

std::vector<NdfEstimator> make_estimators(const NdfRequest& request, const std::vector<DiskGrid>& grids) {
  std::vector<NdfEstimator> estimators;
  for (std::size_t m = 0; m < grids.size(); ++m)
    estimators.emplace_back(request.methods[m], grids[m]);
  return estimators;
}

/// Half widths that hold the energy of a few scans spread over the listing.
std::vector<double> survey(const ScanListing& listing, const NdfRequest& request,
                           const std::vector<double>& whole) {
  constexpr std::size_t kSurveyed = 8;
  constexpr int kCoarse = 257;
  constexpr double kEnergy = 0.999, kMargin = 1.25;  // the margin is for what other scans may hold
  NdfRequest brief = request;
  brief.statistics = NdfRequest::Statistics::LeaveOut;
  std::vector<DiskGrid> grids;
  for (const double extent : whole)
    grids.push_back({std::min(request.size, kCoarse), extent});
  const std::vector<NdfEstimator> estimators = make_estimators(brief, grids);
  std::vector<double> extents(whole.size(), 0.);
  const std::size_t surveyed = std::min(kSurveyed, listing.scans.size());
  parallel_in_order(
      static_cast<std::int64_t>(surveyed),
      [&](std::int64_t k) {
        const std::size_t scan = static_cast<std::size_t>(k) * listing.scans.size() / surveyed;
        return look_at(listing.scans[scan], brief, estimators, false);
      },
      [&](std::int64_t, const ScanOutcome& outcome) {
        for (std::size_t m = 0; m < extents.size(); ++m)
          if (outcome.ndfs[m])
            extents[m] = std::max(extents[m], kMargin * extent_holding(outcome.ndfs[m]->density, kEnergy));
      });
  // A blurred lobe needs room for the signature's reach as well.
  const double reach =
      request.signature ? std::sin(std::min(request.signature->signature.angle.back(), std::numbers::pi / 2))
                        : 0;
  for (std::size_t m = 0; m < extents.size(); ++m)
    extents[m] = extents[m] > 0 ? std::min(whole[m], extents[m] + reach) : whole[m];
  return extents;
}

/// The grid of each method.
std::vector<DiskGrid> choose_grids(const ScanListing& listing, const NdfRequest& request) {
  std::vector<double> extents;
  if (const auto* extent = std::get_if<double>(&request.extent)) {
    extents.assign(request.methods.size(), *extent);
  } else {
    const bool needs_pitch =
        std::any_of(request.methods.begin(), request.methods.end(),
                    [](const NdfMethod& method) { return std::holds_alternative<Kirchhoff>(method.kind); });
    const std::optional<double> pitch = needs_pitch ? pitch_of(listing, request) : std::nullopt;
    for (const NdfMethod& method : request.methods)
      extents.push_back(whole_extent(method, pitch));
    if (std::holds_alternative<HoldsEnergy>(request.extent)) extents = survey(listing, request, extents);
  }
  std::vector<DiskGrid> grids;
  for (const double extent : extents)
    grids.push_back({request.size, extent});
  return grids;
}

/// The one grid of all wavelengths: what the shortest can tell of, and what holds the energy of both ends.
DiskGrid spectrum_grid(const ScanListing& listing, const NdfRequest& request) {
  std::vector<double> ends;
  if (const auto* range = std::get_if<AsManyAsNeeded>(&request.spectrum->lambda_q)) {
    ends = {range->shortest, range->longest};
  } else {
    const auto& lambda_q = std::get<std::vector<double>>(request.spectrum->lambda_q);
    ends = {lambda_q.front(), lambda_q.back()};
  }
  NdfRequest brief = request;
  brief.methods.clear();
  for (const double lambda : ends)
    brief.methods.push_back({"kirchhoff", Kirchhoff{lambda, request.spectrum->tolerance}});
  const std::vector<DiskGrid> grids = choose_grids(listing, brief);
  const bool energy = std::holds_alternative<HoldsEnergy>(request.extent);
  return {request.size, energy ? std::max(grids[0].extent, grids[1].extent) : grids[0].extent};
}

/// Running sums of one method over all scans.
struct Accumulator {
  NdfOfScans ndf;
  TableMean mean;
  std::int64_t outside_count = 0, unreached = 0;
  std::optional<ErrorSample> kirchhoff_error;
  double pitch = 0;  // the largest, µm
  std::map<std::string, std::int64_t> refusals;

  Accumulator(const NdfMethod& method, const DiskGrid& grid) : mean(grid) { ndf.method = method; }

  void add(const ScanOutcome& outcome, std::size_t m) {
    if (!outcome.refusals[m].empty()) ++refusals[outcome.refusals[m]];
    if (!outcome.ndfs[m] || outcome.ndfs[m]->samples == 0) return;
    const ScanNdf& scan = *outcome.ndfs[m];
    mean.add(scan.density, outcome.area);
    ndf.samples += scan.samples;
    outside_count += scan.outside;
    ndf.without_normal += scan.without_normal;
    if (scan.truncation_error)
      ndf.truncation_error = std::max(ndf.truncation_error.value_or(0), *scan.truncation_error);
    if (scan.kirchhoff_error) {
      if (!kirchhoff_error) kirchhoff_error.emplace();
      *kirchhoff_error += *scan.kirchhoff_error;
    }
    unreached += scan.unreached;
    pitch = std::max({pitch, outcome.record.dx, outcome.record.dy});
    ndf.seconds += scan.seconds;
  }

  NdfOfScans finish() {
    ndf.density = mean.mean();
    ndf.standard_error = mean.standard_error();
    ndf.scans = mean.count();
    ndf.area = mean.weight();
    ndf.outside = ndf.samples > 0 ? static_cast<double>(outside_count) / static_cast<double>(ndf.samples) : 0;
    if (pitch > 0) ndf.valid_sin_theta = valid_sin_theta(ndf.method, pitch);
    if (kirchhoff_error)
      ndf.rel_error = std::max(kirchhoff_error->error(), kirchhoff_error->error_core_free());
    ndf.unreached = unreached;
    return std::move(ndf);
  }
};

std::string count(std::int64_t n, const std::string& what) {
  return std::to_string(n) + " " + what + (n == 1 ? "" : "s");
}

Stage ran(std::string name, std::string reason) {
  return {Stage::Outcome::Ran, std::move(name), std::move(reason)};
}

Stage left_out(std::string name, std::string reason) {
  return {Stage::Outcome::LeftOut, std::move(name), std::move(reason)};
}

Stage stage_if(bool done, std::string name, std::string reason) {
  return done ? ran(std::move(name), std::move(reason)) : left_out(std::move(name), std::move(reason));
}

/// The stages before the methods.
Plan plan_of_scans(const std::vector<ScanRecord>& scans, const NdfRequest& request) {
  std::int64_t read = 0, with_holes = 0, missing = 0, rejected = 0, filled = 0;
  for (const ScanRecord& scan : scans) {
    if (scan.failure) continue;
    ++read;
    with_holes += scan.holes > 0 ? 1 : 0;
    missing += scan.missing;
    rejected += scan.rejected;
    filled += scan.filled;
  }
  const Preparation& prepare = request.prepare;
  Plan plan;
  plan.push_back(ran("read", count(read, "scan") + ", " + count(missing, "missing point")));
  plan.push_back(prepare.level == Level::None ? left_out("level", "--level none")
                                              : ran("level", std::string(name_of(prepare.level))));
  plan.push_back(prepare.outlier_threshold
                     ? ran("outlier rejection", count(rejected, "point") + " made missing")
                     : left_out("outlier rejection", "not asked for"));
  plan.push_back(prepare.holes == Preparation::Holes::Fill
                     ? ran("hole filling", count(filled, "point") + " filled")
                     : left_out("hole filling", missing > 0 ? "not asked for" : "no point is missing"));
  plan.push_back(
      stage_if(request.statistics == NdfRequest::Statistics::Compute, "statistics",
               request.statistics == NdfRequest::Statistics::Compute ? "Sq, Sdq" : "not asked for"));
  const bool filters =
      std::any_of(request.methods.begin(), request.methods.end(),
                  [](const NdfMethod& method) { return std::holds_alternative<Filtered>(method.kind); });
  if (filters)
    plan.push_back(stage_if(with_holes > 0, "masked moments",
                            with_holes > 0
                                ? count(with_holes, "scan") + " with missing points, near these"
                                : "no point is missing: two convolutions and border profiles are enough"));
  return plan;
}

Stage stage_of(const NdfOfScans& ndf, const std::map<std::string, std::int64_t>& refusals) {
  std::string refused;
  for (const auto& [reason, scans] : refusals)
    refused += (refused.empty() ? "" : "; ") + count(scans, "scan") + " left out: " + reason;
  if (ndf.scans == 0)
    return left_out(ndf.method.name + " NDF", refused.empty() ? "no scan could be used" : refused);
  const bool kirchhoff = std::holds_alternative<Kirchhoff>(ndf.method.kind);
  std::string done =
      count(ndf.scans, "scan") + ", " + count(ndf.samples, kirchhoff ? "coherent window" : "normal");
  if (ndf.unreached > 0) done += ", " + std::to_string(ndf.unreached) + " of them missed the tolerance";
  if (ndf.without_normal > 0) done += ", " + count(ndf.without_normal, "point") + " without a normal";
  if (ndf.truncation_error) {
    std::ostringstream bound;
    bound << std::setprecision(2) << *ndf.truncation_error;
    done += ", slopes within " + bound.str() + " of uncut windows'";
  }
  // A lobe that falls between the nodes has no shape in the table, and D_K's normalisation not even its mass.
  const LobeWidth width = lobe_width(ndf.density);
  const double spacing = ndf.density.grid.spacing();
  if (!(width.x >= spacing && width.y >= spacing) || (kirchhoff && !(normalization(ndf.density) < 1.1)))
    done += "; its lobe is narrower than a few nodes of the table, --extent auto resolves it";
  return ran(ndf.method.name + " NDF", done + (refused.empty() ? "" : "; " + refused));
}

}  // namespace

NdfResult ndf_of_scans(const ScanListing& listing, const NdfRequest& request,
                       const std::function<void(const Progress&)>& report) {
  const std::vector<NdfEstimator> estimators = make_estimators(request, choose_grids(listing, request));
  std::vector<Accumulator> accumulators;
  for (const NdfEstimator& estimator : estimators)
    accumulators.emplace_back(estimator.method(), estimator.grid());

  NdfResult result;
  PitchGroups pitches;
  std::atomic<bool> refused = false;  // by a second pitch: from then on only the groups' names are wanted
  const auto total = static_cast<std::int64_t>(listing.scans.size());
  parallel_in_order(
      total,
      [&](std::int64_t k) {
        const ListedScan& scan = listing.scans[static_cast<std::size_t>(k)];
        return refused ? look_at_pitch(scan, request)
                       : look_at(scan, request, estimators, k < request.thumbnails);
      },
      [&](std::int64_t k, ScanOutcome outcome) {
        if (!outcome.record.failure) {
          pitches.add(outcome.record.dx, outcome.record.dy, outcome.record.source);
          refused = pitches.mixed() && request.pitches == NdfRequest::Pitches::MustAgree;
        }
        if (!outcome.record.failure && !refused) {
          for (std::size_t m = 0; m < accumulators.size(); ++m)
            accumulators[m].add(outcome, m);
          if (outcome.thumbnail) result.thumbnails.push_back(std::move(*outcome.thumbnail));
        }
        result.scans.push_back(std::move(outcome.record));
        report({k + 1, total, result.scans.back().source});
      });
  if (refused) {
    std::vector<FailedScan> failed;
    for (const ScanRecord& scan : result.scans)
      if (scan.failure) failed.push_back({scan.source, *scan.failure});
    throw MixedPitches(pitches, std::move(failed));
  }

  result.plan = plan_of_scans(result.scans, request);
  for (Accumulator& accumulator : accumulators) {
    NdfOfScans ndf = accumulator.finish();
    result.plan.push_back(stage_of(ndf, accumulator.refusals));
    if (ndf.scans > 0) result.ndfs.push_back(std::move(ndf));
  }
  if (request.spectrum) {
    SpectrumOutcome outcome = kirchhoff_spectrum(
        listing, request.prepare, spectrum_grid(listing, request), *request.spectrum,
        [&](std::size_t k) { return !result.scans[k].failure; },
        [&](std::size_t k) {
          report({static_cast<std::int64_t>(k) + 1, total, listing.scans[k].source});
        });
    result.spectrum = std::move(outcome.spectrum);
    for (const SpectrumRefusal& refusal : outcome.refusals)
      if (request.unfit == NdfRequest::Unfit::Fail) result.scans[refusal.scan].failure = refusal.reason;
    result.plan.insert(result.plan.end(), outcome.plan.begin(), outcome.plan.end());
  }
  const bool errors = std::any_of(result.ndfs.begin(), result.ndfs.end(),
                                  [](const NdfOfScans& ndf) { return ndf.standard_error.has_value(); }) ||
                      (result.spectrum && result.spectrum->mean.count() > 1);
  result.plan.push_back(
      stage_if(errors, "standard error", errors ? "over scans" : "needs two scans or more"));

  if (request.signature) {
    const std::size_t plain = result.ndfs.size();
    for (std::size_t k = 0; k < plain; ++k) {
      const Stopwatch stopwatch;
      NdfOfScans blurred = result.ndfs[k];
      blurred.density = convolve(blurred.density, request.signature->signature);
      blurred.standard_error
          .reset();  // neighbouring nodes are correlated: it does not follow from the nodes' own
      blurred.method.name += "_signature" + request.signature->name;
      blurred.signature = request.signature->name;
      blurred.outside = std::max(0., 1 - normalization(blurred.density));
      blurred.seconds = stopwatch.seconds();
      result.ndfs.push_back(std::move(blurred));
    }
  }
  result.plan.push_back(stage_if(request.signature.has_value(), "instrument signature",
                                 request.signature ? request.signature->name : "not asked for"));
  if (request.signature && result.spectrum)
    result.plan.push_back(
        left_out("instrument signature of the spectrum", "only tables of one wavelength are blurred"));
  if (request.signature && errors)
    result.plan.push_back(
        left_out("standard error under the signature",
                 "a blur mixes nodes whose errors are correlated, and the nodes' own errors do "
                 "not tell how"));
  return result;
}

}  // namespace micro
