#include "pipelines/texels.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/estimate.h"
#include "core/parallel.h"
#include "pipelines/pitch_groups.h"

namespace micro {
namespace {

struct ScanTexels {
  ScanRecord record;
  SurfaceTexels cut;
};

/// Points of a block `length` µm long. Throws InputError if it holds none.
Eigen::Index points_of(double length, double pitch) {
  const double points = std::round(length / pitch);
  if (!(points >= 1)) throw InputError("its points are too far apart for texels so small");
  // What no scan is as long as needs no count.
  return static_cast<Eigen::Index>(std::min(points, 1e15));
}

ScanTexels cut_scan(const ListedScan& scan, const TexelRequest& request) {
  ScanTexels outcome;
  outcome.record.source = scan.source;
  try {
    const PreparedScan prepared = hash_and_prepare(scan.path, request.prepare, outcome.record);
    describe(outcome.record, prepared);
    TexelCut cut{.sigma = request.sigma, .ndf_size = request.ndf_size};
    if (request.block) {
      cut.cols = points_of(request.block->x(), prepared.surface.dx);
      cut.rows = points_of(request.block->y(), prepared.surface.dy);
    }
    outcome.cut = texels_of_surface(prepared.surface, cut);
  } catch (...) {
    outcome.record.failure = reason_of_failure();
  }
  return outcome;
}

/// Where the rows (or columns) of a layout begin in the grid of texels, and the grid's end: each is as wide
/// as the scan of most texels in it, or as `usual` where there is none.
template <typename PlaceOf, typename CountOf>
std::vector<Eigen::Index> begins_of(const std::vector<ScanTexels>& cuts, Eigen::Index places,
                                    Eigen::Index usual, PlaceOf&& place_of, CountOf&& count_of) {
  std::vector<Eigen::Index> counts(static_cast<std::size_t>(places), 0);
  for (std::size_t k = 0; k < cuts.size(); ++k) {
    if (cuts[k].record.failure) continue;  // and with it perhaps the place
    Eigen::Index& count = counts[static_cast<std::size_t>(place_of(k))];
    count = std::max(count, count_of(cuts[k].cut));
  }
  std::vector<Eigen::Index> begins = {0};
  for (const Eigen::Index count : counts)
    begins.push_back(begins.back() + (count > 0 ? count : usual));
  return begins;
}

/// A texel of a scan, and where in the grid it lies.
struct PlacedTexel {
  std::int64_t place;
  std::int32_t scan;
  std::size_t of_scan;
};

/// Puts the scans' texels into the grid. Scans of different sizes leave gaps where others of their row or
/// column of the layout hold more: a strip across beside one along, strips of unequal length.
void assemble(Texels& texels, std::vector<ScanTexels>& cuts, const TexelLayout& layout,
              const TexelRequest& request) {
  const auto first =
      std::find_if(cuts.begin(), cuts.end(), [](const ScanTexels& c) { return !c.record.failure; });
  if (first == cuts.end()) return;
  const ScanRecord& like = first->record;
  texels.width =
      like.dx * static_cast<double>(request.block ? points_of(request.block->x(), like.dx) : like.cols);
  texels.height =
      like.dy * static_cast<double>(request.block ? points_of(request.block->y(), like.dy) : like.rows);
  const auto row_begins = begins_of(
      cuts, layout.rows, first->cut.rows, [&](std::size_t k) { return layout.places[k]->row; },
      [](const SurfaceTexels& cut) { return cut.rows; });
  const auto col_begins = begins_of(
      cuts, layout.cols, first->cut.cols, [&](std::size_t k) { return layout.places[k]->col; },
      [](const SurfaceTexels& cut) { return cut.cols; });
  texels.rows = row_begins.back();
  texels.cols = col_begins.back();
  require_few_texels(texels.rows, texels.cols);
  std::vector<PlacedTexel> placed;
  for (std::size_t k = 0; k < cuts.size(); ++k) {
    const SurfaceTexels& cut = cuts[k].cut;
    if (cuts[k].record.failure) continue;
    const Eigen::Index top = row_begins[static_cast<std::size_t>(layout.places[k]->row)],
                       left = col_begins[static_cast<std::size_t>(layout.places[k]->col)];
    for (Eigen::Index j = 0; j < cut.rows; ++j)
      for (Eigen::Index i = 0; i < cut.cols; ++i)
        placed.push_back({(top + j) * texels.cols + left + i, static_cast<std::int32_t>(k),
                          static_cast<std::size_t>(j * cut.cols + i)});
  }
  std::sort(placed.begin(), placed.end(), [](const auto& a, const auto& b) { return a.place < b.place; });
  for (const PlacedTexel& at : placed) {
    Texel& texel = cuts[static_cast<std::size_t>(at.scan)].cut.texels[at.of_scan];
    texels.places.push_back(at.place);
    texels.scan.push_back(at.scan);
    texels.states.push_back(texel.normals > 0 ? TexelState::Fitted : TexelState::Gap);
    texels.texels.push_back(std::move(texel));
  }
}

/// A common plane's slope is taken off every slope, which moves every lobe's centre as much.
void remove_common_tilt(Texels& texels) {
  double normals = 0;
  Vec2 sum = {0, 0};
  for (const Texel& texel : texels.texels) {
    normals += static_cast<double>(texel.normals);
    sum += static_cast<double>(texel.normals) * texel.mean_slope;
  }
  if (normals == 0) return;
  texels.tilt = sum / normals;
  for (Texel& texel : texels.texels) {
    if (texel.normals == 0) continue;
    texel.fit.frame.centre -= texels.tilt;
    texel.fit.parameters = canonical_parameters(texel.fit.frame);
  }
}

/// What a plan says of whole scans that are not all of one size; nothing where they are.
std::string unequal_sizes(const Texels& texels, const TexelRequest& request) {
  double least = std::numeric_limits<double>::infinity(), most = 0;
  for (const ScanRecord& scan : texels.scans) {
    if (scan.failure) continue;
    const double area = static_cast<double>(scan.rows * scan.cols) * scan.dx * scan.dy;
    least = std::min(least, area);
    most = std::max(most, area);
  }
  constexpr double kAlike = 1.05;
  if (request.block || most <= kAlike * least) return "";
  return ", of unequal size, " + std::to_string(std::lround(least)) + " to " +
         std::to_string(std::lround(most)) + " square µm (--texel cuts them alike)";
}

void plan_texels(Texels& texels, const TexelLayout& layout, const TexelRequest& request) {
  const auto read = std::count_if(texels.scans.begin(), texels.scans.end(),
                                  [](const ScanRecord& scan) { return !scan.failure; });
  texels.plan.push_back(ran("layout", layout.how));
  const Eigen::Index places = texels.rows * texels.cols;
  std::int64_t converged = 0;
  double independent = 0;
  for (const Texel& texel : texels.texels) {
    converged += texel.normals > 0 && texel.fit.status == FitStatus::Converged ? 1 : 0;
    independent += texel.independent;
  }
  const auto n = std::max<std::int64_t>(1, texels.count());
  texels.plan.push_back(ran("texels", std::to_string(texels.rows) + " x " + std::to_string(texels.cols) +
                                          " of " + counted(read, "scan") + ", " + counted(converged, "fit") +
                                          " converged, " + counted(places - texels.count(), "gap") +
                                          ", about " +
                                          std::to_string(std::lround(independent / static_cast<double>(n))) +
                                          " independent normals each" + unequal_sizes(texels, request)));
  const bool removed = request.tilt == TexelRequest::Tilt::RemoveCommon;
  texels.plan.push_back(stage_if(removed, "common tilt",
                                 removed ? "slope " + std::to_string(texels.tilt.x()) + ", " +
                                               std::to_string(texels.tilt.y()) + " removed from all"
                                         : "scans were levelled one by one"));
}

}  // namespace

std::int64_t Texels::count() const {
  return std::count_if(states.begin(), states.end(), [](TexelState s) { return s != TexelState::Gap; });
}

Texels texels_of_scans(const ScanListing& listing, const TexelLayout& layout, const TexelRequest& request,
                       const std::function<void(const Progress&)>& report) {
  const Stopwatch watch;
  Texels texels;
  texels.sigma = request.sigma;
  texels.ndf_size = request.ndf_size;
  std::vector<ScanTexels> cuts;
  PitchGroups pitches;
  const auto total = static_cast<std::int64_t>(listing.scans.size());
  parallel_in_order(
      total, [&](std::int64_t k) { return cut_scan(listing.scans[static_cast<std::size_t>(k)], request); },
      [&](std::int64_t k, ScanTexels outcome) {
        if (const auto why = layout.unplaced.find(k); !outcome.record.failure && why != layout.unplaced.end())
          outcome.record.failure = why->second;
        if (!outcome.record.failure) pitches.add(outcome.record.dx, outcome.record.dy, outcome.record.source);
        cuts.push_back(std::move(outcome));
        report({k + 1, total, cuts.back().record.source});
      });
  if (pitches.mixed()) {
    std::vector<FailedScan> failed;
    for (const ScanTexels& cut : cuts)
      if (cut.record.failure) failed.push_back({cut.record.source, *cut.record.failure});
    throw MixedPitches(pitches, std::move(failed));
  }
  assemble(texels, cuts, layout, request);
  for (ScanTexels& cut : cuts)
    texels.scans.push_back(std::move(cut.record));
  if (request.tilt == TexelRequest::Tilt::RemoveCommon) remove_common_tilt(texels);
  plan_texels(texels, layout, request);
  shrink_few(texels, request.enough);
  texels.seconds = watch.seconds();
  return texels;
}

}  // namespace micro
