#include "pipelines/kirchhoff_spectrum.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <sstream>

#include "core/error.h"
#include "core/estimate.h"
#include "height/triangles.h"
#include "kirchhoff/spectrum.h"

namespace micro {
namespace {

/// One scan's tables.
struct ScanSpectrum {
  std::vector<Grid<float>> tables;
  std::vector<ErrorSample> errors;
  std::vector<std::int64_t> unreached;
  std::int64_t windows = 0;
  double area = 0;   // A_perp, µm²
  double pitch = 0;  // µm
};

/// Wavelengths that share their windows, and the solver that keeps its memory from scan to scan.
struct WavelengthGroup {
  std::size_t first, count;
  Coherence coherence;
  SpectrumSolver solver;
};

std::vector<WavelengthGroup> make_groups(const DiskGrid& grid, const SpectrumRequest& request,
                                         const std::vector<double>& lambda_q) {
  std::vector<WavelengthGroup> groups;
  if (!request.source) {
    groups.push_back(
        {0, lambda_q.size(), request.coherence, SpectrumSolver(grid, lambda_q, request.tolerance)});
    return groups;
  }
  for (std::size_t k = 0; k < lambda_q.size(); ++k)
    groups.push_back({k, 1, SubWindows{coherence_area(lambda_q[k], *request.source)},
                      SpectrumSolver(grid, {lambda_q[k]}, request.tolerance)});
  return groups;
}

/// Mean over windows, weighted by their areas.
void add_group(const HeightField& surface, WavelengthGroup& group, ScanSpectrum& scan) {
  const std::vector<Window> windows = coherent_windows(surface, group.coherence);
  std::vector<Grid<double>> sums(windows.size() > 1 ? group.count : 0);
  double total = 0;
  for (const Window& window : windows) {
    KirchhoffSpectrum spectrum = group.solver(window.surface);
    const double weight = effective_area(window);
    total += weight;
    for (std::size_t k = 0; k < group.count; ++k) {
      SpectrumTable& table = spectrum.tables[k];
      scan.errors[group.first + k] += table.error;
      scan.unreached[group.first + k] += table.reached ? 0 : 1;
      if (windows.size() == 1)
        scan.tables[group.first + k] = std::move(table.density);
      else if (sums[k].size() == 0)
        sums[k] = weight * table.density.cast<double>();
      else
        sums[k] += weight * table.density.cast<double>();
    }
    ++scan.windows;
  }
  for (std::size_t k = 0; k < sums.size(); ++k)
    scan.tables[group.first + k] = (sums[k] / total).cast<float>();
}

ScanSpectrum spectrum_of(const HeightField& surface, std::vector<WavelengthGroup>& groups,
                         std::size_t wavelengths) {
  ScanSpectrum scan;
  scan.tables.resize(wavelengths);
  scan.errors.resize(wavelengths);
  scan.unreached.assign(wavelengths, 0);
  scan.area = projected_area(surface);
  scan.pitch = std::max(surface.dx, surface.dy);
  for (WavelengthGroup& group : groups)
    add_group(surface, group, scan);
  return scan;
}

/// λ_q/(2L) of a scan's shorter side, or of a window's.
double longer_speckle(const HeightField& scan, const SpectrumRequest& request, double longest) {
  double side = std::min(static_cast<double>(scan.cols() - 1) * scan.dx,
                         static_cast<double>(scan.rows() - 1) * scan.dy);
  if (const auto* windows = std::get_if<SubWindows>(&request.coherence))
    side = std::min(side, std::sqrt(windows->area));
  if (request.source) side = std::min(side, std::sqrt(coherence_area(longest, *request.source)));
  return longest / (2 * side);
}

/// Nothing for a single wavelength. `scan` decides on the cells.
std::optional<WavelengthDependence> make_dependence(const DiskGrid& grid, const SpectrumRequest& request,
                                                    const std::vector<double>& lambda_q,
                                                    const HeightField& scan) {
  if (lambda_q.size() < 2) return std::nullopt;
  return WavelengthDependence(grid, lambda_q, longer_speckle(scan, request, lambda_q.back()));
}

std::string percent(double fraction) {
  std::ostringstream text;
  text.precision(2);
  text << 100 * fraction << " %";
  return text.str();
}

std::string micrometres(double length) {
  std::ostringstream text;
  text.precision(4);
  text << length << " µm";
  return text.str();
}

/// What the tables say about how D_K depends on the wavelength.
Stage dependence_stage(const WavelengthDependence& dependence) {
  const auto farthest = dependence.largest();
  const auto [typical, distance] = dependence.most_typical();
  std::ostringstream text;
  text.precision(2);
  const bool scatter = dependence.scans() > 1;
  text << "means over cells of " << dependence.cell() << " in m_xy differ by " << percent(farthest.measured)
       << " (relative L2) between the most different wavelengths";
  if (scatter) text << ", whose standard error over scans is " << percent(farthest.scatter);
  const bool one = distance.beyond() <= kSameTables;
  text << (one ? "; one wavelength would have done: " : "; one wavelength would not have done: ")
       << micrometres(dependence.lambda_q()[typical]) << " is within " << percent(distance.beyond())
       << " of every other" << (scatter ? " beyond scatter" : "") << " (tables within "
       << percent(kSameTables) << " are taken for the same)";
  return ran("dependence on wavelength", text.str());
}

/// Scans that `auto` judges by, spread over the listing, and the table size that it does with.
constexpr std::size_t kSurveyed = 4;
constexpr int kSurveySize = 513;

/// How many surfaces there were to judge by, and what was chosen.
struct Survey {
  ChosenWavelengths chosen;
  std::int64_t scans;
};

/// The first scan of a part [begin, end) of the listing that has a surface; which scans fail is only known
/// when each has had its turn.
std::optional<HeightField> first_surface(const ScanListing& listing, const Preparation& preparation,
                                         std::size_t begin, std::size_t end) {
  for (; begin < end; ++begin)
    try {
      HeightField surface = prepare_scan(listing.scans[begin].path, preparation).surface;
      if (projected_area(surface) > 0) return surface;
    } catch (const std::exception&) {
      continue;
    }
  return std::nullopt;
}

/// One surface from each of as many parts of the listing.
std::vector<HeightField> surveyed_surfaces(const ScanListing& listing, const Preparation& preparation) {
  const std::size_t n = listing.scans.size(), parts = std::min(kSurveyed, n);
  std::vector<HeightField> surfaces;
  for (std::size_t k = 0; k < parts; ++k)
    if (auto surface = first_surface(listing, preparation, k * n / parts, (k + 1) * n / parts))
      surfaces.push_back(std::move(*surface));
  return surfaces;
}

Survey survey(const std::vector<HeightField>& surfaces, const DiskGrid& grid, const SpectrumRequest& request,
              const AsManyAsNeeded& range) {
  const DiskGrid coarse = {std::min(grid.size, kSurveySize), grid.extent};
  // Each wavelength once: later rounds ask for the earlier ones again.
  std::map<double, std::vector<ScanSpectrum>> known;
  const auto dependence_of = [&](const std::vector<double>& lambda_q) {
    std::vector<double> missing;
    for (const double lambda : lambda_q)
      if (!known.contains(lambda)) missing.push_back(lambda);
    std::vector<WavelengthGroup> groups;
    if (!missing.empty()) groups = make_groups(coarse, request, missing);
    for (const HeightField& surface : surfaces) {
      if (missing.empty()) break;
      ScanSpectrum scan = spectrum_of(surface, groups, missing.size());
      for (std::size_t k = 0; k < missing.size(); ++k) {
        ScanSpectrum one = scan;
        one.tables = {scan.tables[k]};
        known[missing[k]].push_back(std::move(one));
      }
    }
    WavelengthDependence dependence = *make_dependence(coarse, request, lambda_q, surfaces.front());
    for (std::size_t s = 0; s < surfaces.size(); ++s) {
      std::vector<Grid<float>> tables;
      for (const double lambda : lambda_q)
        tables.push_back(known.at(lambda)[s].tables.front());
      dependence.add(tables, known.at(lambda_q.front())[s].area);
    }
    return dependence;
  };
  return {choose_wavelengths(range, dependence_of), static_cast<std::int64_t>(surfaces.size())};
}

Stage survey_stage(const Survey& survey, const AsManyAsNeeded& range) {
  const std::size_t chosen = survey.chosen.lambda_q.size();
  std::ostringstream text;
  text.precision(4);
  text << counted(static_cast<std::int64_t>(chosen), "wavelength") << " over " << range.shortest << " to "
       << range.longest << " µm, judged by " << counted(survey.scans, "scan") << ": "
       << (chosen == 1 ? "the ends" : "neighbours") << " differ by " << percent(survey.chosen.farthest)
       << (survey.scans > 1 ? " beyond scatter, " : ", ") << percent(kSameTables) << " may be ("
       << (chosen == 1 ? "so the middle in 1/λ stands for all" : "halved in 1/λ until they do") << ")";
  return ran("choice of wavelengths", text.str());
}

}  // namespace

double SpectrumOfScans::rel_error(std::size_t wavelength) const {
  return std::max(errors[wavelength].error(), errors[wavelength].error_core_free());
}

double SpectrumOfScans::valid_sin_theta(std::size_t wavelength) const {
  return std::min(1., lambda_q[wavelength] / (4 * pitch));
}

ChosenWavelengths choose_wavelengths(
    const AsManyAsNeeded& range,
    const std::function<WavelengthDependence(const std::vector<double>&)>& dependence_of) {
  constexpr std::size_t kMost = 65;
  const auto middle = [](double a, double b) { return 2 / (1 / a + 1 / b); };
  std::vector<double> lambda_q = {range.shortest, range.longest};
  const double ends = dependence_of(lambda_q).between(0, 1).beyond();
  if (ends <= kSameTables) return {{middle(range.shortest, range.longest)}, ends};
  for (;;) {
    const WavelengthDependence dependence = dependence_of(lambda_q);
    std::vector<double> finer = {lambda_q.front()};
    double farthest = 0;
    for (std::size_t k = 1; k < lambda_q.size(); ++k) {
      const double distance = dependence.between(k - 1, k).beyond();
      farthest = std::max(farthest, distance);
      if (distance > kSameTables) finer.push_back(middle(lambda_q[k - 1], lambda_q[k]));
      finer.push_back(lambda_q[k]);
    }
    if (finer.size() == lambda_q.size() || finer.size() > kMost) return {lambda_q, farthest};
    lambda_q = std::move(finer);
  }
}

SpectrumSums begin_spectrum(const ScanListing& listing, const Preparation& preparation, const DiskGrid& grid,
                            const SpectrumRequest& request) {
  SpectrumSums sums;
  std::vector<double> lambda_q;
  std::optional<HeightField> first;
  const Stopwatch watch;
  if (const auto* range = std::get_if<AsManyAsNeeded>(&request.lambda_q)) {
    std::vector<HeightField> surfaces = surveyed_surfaces(listing, preparation);
    if (surfaces.empty()) return sums;
    try {
      const Survey chosen = survey(surfaces, grid, request, *range);
      lambda_q = chosen.chosen.lambda_q;
      sums.choice.push_back(survey_stage(chosen, *range));
    } catch (const InputError& error) {  // what is refused to one of the survey's scans is to all
      sums.unfit = error.what();
      return sums;
    }
    first = std::move(surfaces.front());
  } else {
    lambda_q = std::get<std::vector<double>>(request.lambda_q);
    if (lambda_q.size() > 1) first = first_surface(listing, preparation, 0, listing.scans.size());
  }
  if (first) sums.dependence = make_dependence(grid, request, lambda_q, *first);
  const std::size_t n = lambda_q.size();
  sums.spectrum = SpectrumOfScans{.lambda_q = std::move(lambda_q),
                                  .mean = SpectrumMean(grid, n),
                                  .errors = std::vector<ErrorSample>(n),
                                  .unreached = std::vector<std::int64_t>(n, 0),
                                  .tolerance = request.tolerance,
                                  .coherence_area = {},
                                  .seconds = watch.seconds()};
  if (request.source || std::holds_alternative<SubWindows>(request.coherence))
    for (const double lambda : sums.spectrum->lambda_q)
      sums.spectrum->coherence_area.push_back(request.source ? coherence_area(lambda, *request.source)
                                                             : std::get<SubWindows>(request.coherence).area);
  return sums;
}

bool add_up(const SpectrumSums& a, const SpectrumSums& b) {
  if (a.spectrum.has_value() != b.spectrum.has_value() || a.unfit != b.unfit ||
      a.dependence.has_value() != b.dependence.has_value())
    return false;
  return (!a.spectrum || (a.spectrum->lambda_q == b.spectrum->lambda_q &&
                          a.spectrum->mean.grid() == b.spectrum->mean.grid())) &&
         (!a.dependence || a.dependence->cell() == b.dependence->cell());
}

void merge(SpectrumSums& sums, const SpectrumSums& more) {
  if (!add_up(sums, more))
    throw InputError(
        "the shards' spectra stand on different wavelengths or tables: the directory changed "
        "between them");
  if (sums.spectrum) {
    SpectrumOfScans& all = *sums.spectrum;
    const SpectrumOfScans& other = *more.spectrum;
    all.mean.merge(other.mean);
    for (std::size_t n = 0; n < all.lambda_q.size(); ++n) {
      all.errors[n] += other.errors[n];
      all.unreached[n] += other.unreached[n];
    }
    all.windows += other.windows;
    all.pitch = std::max(all.pitch, other.pitch);
    all.seconds += other.seconds;
  }
  if (sums.dependence) sums.dependence->merge(*more.dependence);
  add(sums.refusals, more.refusals);
  sums.looked_at += more.looked_at;
}

void add_spectra(SpectrumSums& sums, std::size_t scans, const SpectrumRequest& request,
                 const std::function<std::optional<HeightField>(std::size_t)>& surface_of,
                 const std::function<void(std::size_t, const std::string&)>& after) {
  std::vector<WavelengthGroup> groups;  // made when the first scan wants them
  const auto add = [&](const HeightField& surface) {
    SpectrumOfScans& all = *sums.spectrum;
    const Stopwatch watch;
    if (groups.empty()) groups = make_groups(all.mean.grid(), request, all.lambda_q);
    const ScanSpectrum scan = spectrum_of(surface, groups, all.lambda_q.size());
    all.mean.add(scan.tables, scan.area);
    for (std::size_t n = 0; n < all.lambda_q.size(); ++n) {
      all.errors[n] += scan.errors[n];
      all.unreached[n] += scan.unreached[n];
    }
    all.windows += scan.windows;
    all.pitch = std::max(all.pitch, scan.pitch);
    if (sums.dependence) sums.dependence->add(scan.tables, scan.area);
    all.seconds += watch.seconds();
  };
  for (auto k = static_cast<std::size_t>(sums.looked_at); k < scans; ++k) {
    ++sums.looked_at;
    const std::optional<HeightField> surface = surface_of(k);
    if (!surface) continue;
    std::string refusal = sums.unfit;
    if (sums.spectrum) try {
        add(*surface);
      } catch (const InputError& error) {
        refusal = error.what();
      }
    if (!refusal.empty()) ++sums.refusals[refusal];
    after(k, refusal);
  }
}

Plan plan_of(const SpectrumSums& sums) {
  const std::string name = "kirchhoff spectrum", refused = to_text(sums.refusals);
  if (!sums.spectrum || sums.spectrum->mean.count() == 0)
    return {left_out(name, refused.empty() ? "no scan could be used" : refused)};
  const SpectrumOfScans& all = *sums.spectrum;
  std::string done = counted(all.mean.count(), "scan") + ", " +
                     counted(static_cast<std::int64_t>(all.lambda_q.size()), "wavelength") + ", " +
                     counted(all.windows, "coherent window");
  const std::int64_t unreached = std::accumulate(all.unreached.begin(), all.unreached.end(), std::int64_t{0});
  if (unreached > 0) done += ", " + counted(unreached, "table") + " missed the tolerance";
  Plan plan = sums.choice;
  plan.push_back(ran(name, done + (refused.empty() ? "" : "; " + refused)));
  if (sums.dependence) plan.push_back(dependence_stage(*sums.dependence));
  return plan;
}

}  // namespace micro
