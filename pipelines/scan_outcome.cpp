#include "pipelines/scan_outcome.h"

#include "core/error.h"
#include "height/statistics.h"
#include "height/triangles.h"
#include "pipelines/thumbnail.h"

namespace micro {

ScanOutcome look_at(const ListedScan& scan, const NdfRequest& request, const Estimators& estimators,
                    Thumbnail thumbnail) {
  ScanOutcome outcome;
  ScanRecord& record = outcome.record;
  record.source = scan.source;
  outcome.ndfs.resize(request.methods.size());
  outcome.refusals.resize(request.methods.size());
  try {
    const PreparedScan prepared = hash_and_prepare(scan.path, request.prepare, record);
    const HeightField& surface = prepared.surface;
    describe(record, prepared);
    if (request.statistics == NdfRequest::Statistics::Compute) {
      record.Sq = Sq(surface);
      record.Sdq = Sdq(surface);
    }
    outcome.area = projected_area(surface);
    if (!(outcome.area > 0)) throw FileError(scan.path, "has no three neighbouring points, so no surface");
    const auto unless_unfit = [&](std::string& refusal, const auto& estimate) {
      try {
        estimate();
      } catch (const FileError&) {
        throw;
      } catch (const InputError& error) {
        if (request.unfit == NdfRequest::Unfit::Fail) throw FileError(scan.path, error.what());
        refusal = error.what();
      }
    };
    for (std::size_t m = 0; m < request.methods.size(); ++m)
      unless_unfit(outcome.refusals[m], [&] {
        outcome.ndfs[m] = estimators.tables[m](surface);
        if (outcome.ndfs[m]->samples == 0) outcome.refusals[m] = "no point's neighbours determine a plane";
      });
    if (estimators.directions)
      unless_unfit(outcome.directions_refusal,
                   [&] { outcome.directions = (*estimators.directions)(surface); });
    if (thumbnail == Thumbnail::Make) outcome.thumbnail = thumbnail_of(surface);
  } catch (...) {
    record.failure = reason_of_failure();
  }
  return outcome;
}

}  // namespace micro
