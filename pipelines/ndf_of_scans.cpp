#include "pipelines/ndf_of_scans.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "core/error.h"
#include "core/estimate.h"
#include "core/parallel.h"
#include "pipelines/finish_sums.h"
#include "pipelines/ndf_grids.h"
#include "pipelines/pitch_groups.h"
#include "pipelines/run_sums.h"
#include "pipelines/scan_outcome.h"

namespace micro {
namespace {

/// Refuses scans of different pitch, all of them by name, before anything is computed. Reading costs little
/// beside an estimate; what cannot be read, or holds no point, fails when its turn comes.
void require_one_pitch(const ScanListing& listing, const NdfRequest& request) {
  if (request.pitches == NdfRequest::Pitches::MayDiffer || listing.scans.size() < 2) return;
  struct Look {
    double dx = 0, dy = 0;
    std::optional<std::string> failure;
  };
  PitchGroups pitches;
  std::vector<FailedScan> failed;
  parallel_in_order(
      static_cast<std::int64_t>(listing.scans.size()),
      [&](std::int64_t k) {
        Look look;
        const std::filesystem::path& path = listing.scans[static_cast<std::size_t>(k)].path;
        try {
          const HeightField surface = read_scan(path, request.prepare.read).surface;
          if (missing_count(surface) == surface.z.size()) throw FileError(path, "every point is missing");
          look.dx = surface.dx;
          look.dy = surface.dy;
        } catch (...) {
          look.failure = reason_of_failure();
        }
        return look;
      },
      [&](std::int64_t k, const Look& look) {
        const std::string& source = listing.scans[static_cast<std::size_t>(k)].source;
        if (look.failure)
          failed.push_back({source, *look.failure});
        else
          pitches.add(look.dx, look.dy, source);
      });
  if (pitches.mixed()) throw MixedPitches(pitches, std::move(failed), " (--mixed takes them together)");
}

/// Sums that nothing has been added to.
RunSums empty_sums(const ScanListing& listing, const NdfRequest& request,
                   const std::vector<GridOfMethod>& grids) {
  RunSums sums;
  for (std::size_t m = 0; m < grids.size(); ++m)
    sums.means.emplace_back(request.methods[m], grids[m].grid, grids[m].spared);
  if (request.directions)
    sums.directions.emplace(request.directions->kirchhoff, choose_directions(listing, request),
                            DiskGrid{request.size, 1});
  return sums;
}

/// Whether two sums stand on the same grids and directions: scans that changed may have moved them.
bool add_up(const RunSums& a, const RunSums& b) {
  const auto same_grid = [](const NdfMean& x, const NdfMean& y) { return x.grid() == y.grid(); };
  if (!std::equal(a.means.begin(), a.means.end(), b.means.begin(), b.means.end(), same_grid)) return false;
  if (a.directions.has_value() != b.directions.has_value()) return false;
  return !a.directions || a.directions->h() == b.directions->h();
}

void add_outcome(RunSums& sums, ScanOutcome outcome) {
  if (!outcome.record.failure) {
    const double pitch = std::max(outcome.record.dx, outcome.record.dy);
    for (std::size_t m = 0; m < sums.means.size(); ++m) {
      if (!outcome.refusals[m].empty()) sums.means[m].refuse(outcome.refusals[m]);
      if (outcome.ndfs[m]) sums.means[m].add(*outcome.ndfs[m], outcome.area, pitch);
    }
    if (!outcome.directions_refusal.empty()) sums.directions->refuse(outcome.directions_refusal);
    if (outcome.directions) sums.directions->add(*outcome.directions, outcome.area, pitch);
    if (outcome.thumbnail) sums.thumbnails.push_back(std::move(*outcome.thumbnail));
  }
  sums.scans.push_back(std::move(outcome.record));
}

/// Refuses scans of different pitch that came from different shards.
void require_one_pitch(const std::vector<ScanRecord>& scans) {
  PitchGroups pitches;
  std::vector<FailedScan> failed;
  for (const ScanRecord& scan : scans)
    if (scan.failure)
      failed.push_back({scan.source, *scan.failure});
    else
      pitches.add(scan.dx, scan.dy, scan.source);
  if (pitches.mixed()) throw MixedPitches(pitches, std::move(failed), " (--mixed takes them together)");
}

/// Keeps a run's sums in its checkpoint, as often as a fifth of the time allows.
class CheckpointKeeper {
 public:
  CheckpointKeeper(const NdfRequest& request, const Course& course) : request_(request), course_(course) {}

  void consider(const RunSums& sums) {
    constexpr double kShare = 5;
    if (course_.checkpoint.empty()) return;
    if (since_.seconds() < std::max(course_.seconds_between, kShare * cost_)) return;
    keep(sums);
  }
  void keep(const RunSums& sums) {
    if (course_.checkpoint.empty()) return;
    const Stopwatch watch;
    write_checkpoint(course_.checkpoint, request_, course_.shard, sums);
    cost_ = watch.seconds();
    since_ = Stopwatch();
  }

 private:
  const NdfRequest& request_;
  const Course& course_;
  Stopwatch since_;
  double cost_ = 0;
};

/// Tells of each scan; after it the run may stop, or its sums are kept.
class Steps {
 public:
  Steps(const NdfRequest& request, const std::function<void(const Progress&)>& report, const Course& course)
      : report_(report), course_(course), checkpoint_(request, course) {}

  void after(std::int64_t done, std::int64_t total, const RunSums& sums) {
    report_({done, total, sums.scans[static_cast<std::size_t>(done - 1)].source});
    if (course_.interrupted()) {
      checkpoint_.keep(sums);
      throw Interrupted("interrupted after " + std::to_string(done) + " of " + counted(total, "scan") +
                        (sums.spectrum ? " of the spectrum" : "") +
                        (course_.checkpoint.empty() ? "" : "; the same command goes on from there"));
    }
    checkpoint_.consider(sums);
  }

 private:
  const std::function<void(const Progress&)>& report_;
  const Course& course_;
  CheckpointKeeper checkpoint_;
};

/// Looks at the scans that the sums do not hold yet.
void gather(const ScanListing& listing, const NdfRequest& request, const Estimators& estimators,
            RunSums& sums, Steps& steps) {
  const auto total = static_cast<std::int64_t>(listing.scans.size()),
             first = static_cast<std::int64_t>(sums.scans.size());
  parallel_in_order(
      total - first,
      [&](std::int64_t k) {
        const ListedScan& scan = listing.scans[static_cast<std::size_t>(first + k)];
        return look_at(scan, request, estimators,
                       first + k < request.thumbnails ? Thumbnail::Make : Thumbnail::LeaveOut);
      },
      [&](std::int64_t k, ScanOutcome outcome) {
        add_outcome(sums, std::move(outcome));
        steps.after(first + k + 1, total, sums);
      });
}

/// The surface of a scan that is part of the result, read once more; nothing, and a failure, if its file is
/// no longer the one that was looked at.
std::optional<HeightField> surface_again(const std::filesystem::path& path, const Preparation& preparation,
                                         ScanRecord& record) {
  if (record.failure) return std::nullopt;
  try {
    ScanRecord again;
    PreparedScan prepared = hash_and_prepare(path, preparation, again);
    if (again.sha256 == record.sha256) return std::move(prepared.surface);
  } catch (const FileError&) {
    // It is gone, cannot be read any more, or changes at this moment.
  }
  record.failure = "changed between two readings: the spectrum leaves it out, other tables hold what it was";
  record.sha256.clear();  // so that a checkpoint does not take it for looked at
  return std::nullopt;
}

/// Then the spectrum, of the scans that had no failure. `listing` is that of all shards.
void gather_spectrum(const ScanListing& listing, const ScanListing& own, const NdfRequest& request,
                     RunSums& sums, Steps& steps) {
  SpectrumSums start =
      begin_spectrum(listing, request.prepare, spectrum_grid(listing, request), *request.spectrum);
  if (!sums.spectrum || !add_up(*sums.spectrum, start)) sums.spectrum = std::move(start);
  const auto total = static_cast<std::int64_t>(own.scans.size());
  add_spectra(
      *sums.spectrum, own.scans.size(), *request.spectrum,
      [&](std::size_t k) { return surface_again(own.scans[k].path, request.prepare, sums.scans[k]); },
      [&](std::size_t k, const std::string& refusal) {
        if (!refusal.empty() && request.unfit == NdfRequest::Unfit::Fail) sums.scans[k].failure = refusal;
        steps.after(static_cast<std::int64_t>(k) + 1, total, sums);
      });
}

}  // namespace

std::string to_text(const Shard& shard) {
  return std::to_string(shard.index) + "/" + std::to_string(shard.count);
}

NdfResult ndf_of_scans(const ScanListing& listing, const NdfRequest& request,
                       const std::function<void(const Progress&)>& report, const Course& course) {
  const ScanListing own = scans_of(course.shard, listing);
  require_one_pitch(own, request);
  // Shards agree on what all the scans decide, the grids; then each looks at its own.
  const std::vector<GridOfMethod> grids = choose_grids(listing, request);
  RunSums sums = empty_sums(listing, request, grids);
  std::int64_t resumed = 0;
  if (std::optional<RunSums> found = read_checkpoint(course.checkpoint, request, course.shard, own))
    if (add_up(*found, sums)) {
      sums = std::move(*found);
      resumed = static_cast<std::int64_t>(sums.scans.size());
    }
  Estimators estimators = make_estimators(request, grids);
  if (request.directions)
    estimators.directions = std::make_unique<KirchhoffScans>(request.directions->kirchhoff,
                                                             sums.directions->h(), DiskGrid{request.size, 1});
  Steps steps(request, report, course);
  gather(own, request, estimators, sums, steps);
  if (request.spectrum) gather_spectrum(listing, own, request, sums, steps);

  std::shared_ptr<ShardSums> shard;
  if (course.shard.count > 1) shard = std::make_shared<ShardSums>(ShardSums{request, course.shard, sums});
  NdfResult result = finish_sums(std::move(sums), request);
  result.resumed = resumed;
  result.shard = std::move(shard);
  return result;
}

NdfResult ndf_of_shards(ShardSums joined) {
  if (joined.request.pitches == NdfRequest::Pitches::MustAgree) require_one_pitch(joined.sums.scans);
  return finish_sums(std::move(joined.sums), joined.request);
}

}  // namespace micro
