#include "pipelines/finish_sums.h"

#include <algorithm>
#include <string>
#include <utility>

#include "core/estimate.h"

namespace micro {
namespace {

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
  plan.push_back(ran("read", counted(read, "scan") + ", " + counted(missing, "missing point")));
  plan.push_back(prepare.level == Level::None ? left_out("level", "--level none")
                                              : ran("level", std::string(name_of(prepare.level))));
  plan.push_back(prepare.outlier_threshold
                     ? ran("outlier rejection", counted(rejected, "point") + " made missing")
                     : left_out("outlier rejection", "not asked for"));
  plan.push_back(prepare.holes == Preparation::Holes::Fill
                     ? ran("hole filling", counted(filled, "point") + " filled")
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
                                ? counted(with_holes, "scan") + " with missing points, near these"
                                : "no point is missing: two convolutions and border profiles are enough"));
  return plan;
}

void append(Plan& plan, Plan stages) {
  plan.insert(plan.end(), stages.begin(), stages.end());
}

/// The means of everything that was summed, each with its stages.
void finish_means(RunSums& sums, NdfResult& result) {
  for (const NdfMean& mean : sums.means) {
    append(result.plan, mean.plan());
    if (mean.count() > 0) result.ndfs.push_back(mean.finish());
  }
  if (sums.directions) {
    append(result.plan, sums.directions->plan());
    result.directions = sums.directions->finish();
  }
  if (sums.spectrum) {
    append(result.plan, plan_of(*sums.spectrum));
    if (sums.spectrum->spectrum && sums.spectrum->spectrum->mean.count() > 0)
      result.spectrum = std::move(sums.spectrum->spectrum);
  }
}

/// Whether anything came from two scans or more.
bool has_standard_error(const NdfResult& result) {
  return std::any_of(result.ndfs.begin(), result.ndfs.end(),
                     [](const NdfOfScans& ndf) { return ndf.standard_error.has_value(); }) ||
         (result.directions && result.directions->standard_error) ||
         (result.spectrum && result.spectrum->mean.count() > 1);
}

NdfOfScans blurred_by(const NamedSignature& instrument, const NdfOfScans& ndf) {
  const Stopwatch stopwatch;
  NdfOfScans blurred = ndf;
  blurred.density = convolve(blurred.density, instrument.signature);
  // Neighbouring nodes are correlated: errors of the blurred ones do not follow from the nodes' own.
  blurred.standard_error.reset();
  blurred.estimator_error.resize(0, 0);
  blurred.method.name += "_signature" + instrument.name;
  blurred.signature = instrument.name;
  blurred.outside = std::max(0., 1 - normalization(blurred.density));
  blurred.seconds = stopwatch.seconds();
  return blurred;
}

/// Beside each table what the instrument would see of it, and the stages that say so.
void add_blurred(const NamedSignature& instrument, NdfResult& result) {
  const std::size_t plain = result.ndfs.size();
  for (std::size_t k = 0; k < plain; ++k)
    result.ndfs.push_back(blurred_by(instrument, result.ndfs[k]));
  result.plan.push_back(ran("instrument signature", instrument.name));
  if (result.spectrum)
    result.plan.push_back(
        left_out("instrument signature of the spectrum", "only tables of one wavelength are blurred"));
  if (has_standard_error(result))
    result.plan.push_back(
        left_out("standard error under the signature",
                 "a blur mixes nodes whose errors are correlated, and the nodes' own errors do "
                 "not tell how"));
}

}  // namespace

NdfResult finish_sums(RunSums sums, const NdfRequest& request) {
  NdfResult result;
  result.scans = std::move(sums.scans);
  result.thumbnails = std::move(sums.thumbnails);
  result.plan = plan_of_scans(result.scans, request);
  finish_means(sums, result);
  const bool errors = has_standard_error(result);
  result.plan.push_back(
      stage_if(errors, "standard error", errors ? "over scans" : "needs two scans or more"));
  if (request.signature)
    add_blurred(*request.signature, result);
  else
    result.plan.push_back(left_out("instrument signature", "not asked for"));
  return result;
}

}  // namespace micro
