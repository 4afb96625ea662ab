#include "pipelines/ndf_grids.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/parallel.h"
#include "distribution/directions.h"

namespace micro {
namespace {

/// The larger pitch of the first scan that can be read, or of all of them where they may differ, µm.
std::optional<double> pitch_of(const ScanListing& listing, const NdfRequest& request) {
  std::optional<double> coarsest;
  for (const ListedScan& scan : listing.scans)
    try {
      const HeightField surface = read_scan(scan.path, request.prepare.read).surface;
      coarsest = std::max({coarsest.value_or(0), surface.dx, surface.dy});
      if (request.pitches == NdfRequest::Pitches::MustAgree) break;
    } catch (const std::exception&) {
      continue;  // it is reported when its turn comes
    }
  return coarsest;
}

/// All of the disk that the data can tell of: D_K ends where the grid of points throws its first false order.
double whole_extent(const NdfMethod& method, std::optional<double> pitch) {
  const auto* kirchhoff = std::get_if<Kirchhoff>(&method.kind);
  return kirchhoff && pitch ? std::min(1., kirchhoff->lambda_q / (2 * *pitch)) : 1;
}

GridOfMethod make_grid(int size, double extent, double whole) {
  GridOfMethod grid{{size, extent}, {}};
  if (extent < whole)
    grid.spared = {static_cast<int>(std::min(2 * std::ceil((size - 1) / 2 * whole / extent) + 1, 1e9)),
                   whole};
  return grid;
}

DiskTable table_of(const ScanNdf& ndf) {
  const auto* sparse = std::get_if<SparseTable>(&ndf.density);
  return sparse ? dense(*sparse) : std::get<DiskTable>(ndf.density);
}

/// Half widths that hold the energy of a few scans spread over the listing.
std::vector<double> survey(const ScanListing& listing, const NdfRequest& request,
                           const std::vector<double>& whole) {
  constexpr std::size_t kSurveyed = 8;
  constexpr int kCoarse = 257;
  constexpr double kEnergy = 0.999, kMargin = 1.25;  // the margin is for what other scans may hold
  NdfRequest brief = request;
  brief.statistics = NdfRequest::Statistics::LeaveOut;
  std::vector<GridOfMethod> grids;
  for (const double extent : whole)
    grids.push_back(make_grid(std::min(request.size, kCoarse), extent, extent));
  const Estimators estimators = make_estimators(brief, grids);
  std::vector<double> extents(whole.size(), 0.);
  const std::size_t surveyed = std::min(kSurveyed, listing.scans.size());
  parallel_in_order(
      static_cast<std::int64_t>(surveyed),
      [&](std::int64_t k) {
        const std::size_t scan = static_cast<std::size_t>(k) * listing.scans.size() / surveyed;
        return look_at(listing.scans[scan], brief, estimators, Thumbnail::LeaveOut);
      },
      [&](std::int64_t, const ScanOutcome& outcome) {
        for (std::size_t m = 0; m < extents.size(); ++m)
          if (outcome.ndfs[m])
            extents[m] = std::max(extents[m], kMargin * extent_holding(table_of(*outcome.ndfs[m]), kEnergy));
      });
  // A blurred lobe needs room for the signature's reach as well.
  const double reach =
      request.signature ? std::sin(std::min(request.signature->signature.angle.back(), std::numbers::pi / 2))
                        : 0;
  for (std::size_t m = 0; m < extents.size(); ++m)
    extents[m] = extents[m] > 0 ? std::min(whole[m], extents[m] + reach) : whole[m];
  return extents;
}

}  // namespace

Estimators make_estimators(const NdfRequest& request, const std::vector<GridOfMethod>& grids) {
  Estimators estimators;
  for (std::size_t m = 0; m < grids.size(); ++m)
    estimators.tables.emplace_back(request.methods[m], grids[m].grid, grids[m].spared);
  return estimators;
}

std::vector<GridOfMethod> choose_grids(const ScanListing& listing, const NdfRequest& request) {
  const bool needs_pitch =
      std::any_of(request.methods.begin(), request.methods.end(),
                  [](const NdfMethod& method) { return std::holds_alternative<Kirchhoff>(method.kind); });
  const std::optional<double> pitch = needs_pitch ? pitch_of(listing, request) : std::nullopt;
  std::vector<double> whole;
  for (const NdfMethod& method : request.methods)
    whole.push_back(whole_extent(method, pitch));
  std::vector<double> extents = whole;
  if (const auto* extent = std::get_if<double>(&request.extent))
    extents.assign(request.methods.size(), *extent);
  else if (std::holds_alternative<HoldsEnergy>(request.extent))
    extents = survey(listing, request, whole);
  std::vector<GridOfMethod> grids;
  for (std::size_t m = 0; m < extents.size(); ++m)
    grids.push_back(make_grid(request.size, extents[m], whole[m]));
  return grids;
}

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
  const std::vector<GridOfMethod> grids = choose_grids(listing, brief);
  const bool energy = std::holds_alternative<HoldsEnergy>(request.extent);
  return {request.size, energy ? std::max(grids[0].grid.extent, grids[1].grid.extent) : grids[0].grid.extent};
}

std::vector<Vec3> choose_directions(const ScanListing& listing, const NdfRequest& request) {
  if (const auto* given = std::get_if<std::vector<Vec3>>(&request.directions->directions)) return *given;
  NdfRequest table = request;
  table.methods = {{"kirchhoff", request.directions->kirchhoff}};
  return spread_directions(std::get<int>(request.directions->directions),
                           choose_grids(listing, table).front().grid.extent);
}

}  // namespace micro
