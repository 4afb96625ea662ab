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
  double area = 0;  // A_perp, µm²
  double side_x = 0, side_y = 0, pitch = 0;
  double seconds = 0;
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
  const Stopwatch watch;
  ScanSpectrum scan;
  scan.tables.resize(wavelengths);
  scan.errors.resize(wavelengths);
  scan.unreached.assign(wavelengths, 0);
  scan.area = projected_area(surface);
  scan.side_x = static_cast<double>(surface.cols() - 1) * surface.dx;
  scan.side_y = static_cast<double>(surface.rows() - 1) * surface.dy;
  scan.pitch = std::max(surface.dx, surface.dy);
  for (WavelengthGroup& group : groups)
    add_group(surface, group, scan);
  scan.seconds = watch.seconds();
  return scan;
}

/// λ_q/(2L) of a scan's shorter side, or of a window's.
double longer_speckle(const ScanSpectrum& scan, const SpectrumRequest& request, double longest) {
  double side = std::min(scan.side_x, scan.side_y);
  if (const auto* windows = std::get_if<SubWindows>(&request.coherence))
    side = std::min(side, std::sqrt(windows->area));
  if (request.source) side = std::min(side, std::sqrt(coherence_area(longest, *request.source)));
  return longest / (2 * side);
}

void add_to(std::optional<WavelengthDependence>& dependence, const DiskGrid& grid,
            const SpectrumRequest& request, const std::vector<double>& lambda_q, const ScanSpectrum& scan) {
  if (lambda_q.size() < 2) return;
  if (!dependence) dependence.emplace(grid, lambda_q, longer_speckle(scan, request, lambda_q.back()));
  dependence->add(scan.tables, scan.area);
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

std::string count(std::int64_t n, const std::string& what) {
  return std::to_string(n) + " " + what + (n == 1 ? "" : "s");
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
  return {Stage::Outcome::Ran, "dependence on wavelength", text.str()};
}

/// Scans that `auto` judges by, spread over the listing, and the table size that it does with.
constexpr std::size_t kSurveyed = 4;
constexpr int kSurveySize = 513;

/// How many surfaces there were to judge by, and what was chosen.
struct Survey {
  ChosenWavelengths chosen;
  std::int64_t scans;
};

Survey survey(const ScanListing& listing, const Preparation& preparation, const DiskGrid& grid,
              const SpectrumRequest& request, const AsManyAsNeeded& range,
              const std::vector<std::size_t>& usable) {
  const std::size_t surveyed = std::min(kSurveyed, usable.size());
  std::vector<HeightField> surfaces;
  for (std::size_t k = 0; k < surveyed; ++k)
    surfaces.push_back(
        prepare_scan(listing.scans[usable[k * usable.size() / surveyed]].path, preparation).surface);
  const DiskGrid coarse = {std::min(grid.size, kSurveySize), grid.extent};
  // Each wavelength once: later rounds ask for the earlier ones again.
  std::map<double, std::vector<ScanSpectrum>> known;
  std::int64_t judged = 0;
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
    std::optional<WavelengthDependence> dependence;
    for (std::size_t s = 0; s < surfaces.size(); ++s) {
      ScanSpectrum all = known.at(lambda_q.front())[s];
      all.tables.clear();
      for (const double lambda : lambda_q)
        all.tables.push_back(known.at(lambda)[s].tables.front());
      add_to(dependence, coarse, request, lambda_q, all);
    }
    judged = static_cast<std::int64_t>(surfaces.size());
    return *dependence;
  };
  const ChosenWavelengths chosen = choose_wavelengths(range, dependence_of);
  return {chosen, judged};
}

Stage survey_stage(const Survey& survey, const AsManyAsNeeded& range) {
  const std::size_t chosen = survey.chosen.lambda_q.size();
  std::ostringstream text;
  text.precision(4);
  text << count(static_cast<std::int64_t>(chosen), "wavelength") << " over " << range.shortest << " to "
       << range.longest << " µm, judged by " << count(survey.scans, "scan") << ": "
       << (chosen == 1 ? "the ends" : "neighbours") << " differ by " << percent(survey.chosen.farthest)
       << (survey.scans > 1 ? " beyond scatter, " : ", ") << percent(kSameTables) << " may be ("
       << (chosen == 1 ? "so the middle in 1/λ stands for all" : "halved in 1/λ until they do") << ")";
  return {Stage::Outcome::Ran, "choice of wavelengths", text.str()};
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

SpectrumOutcome kirchhoff_spectrum(const ScanListing& listing, const Preparation& preparation,
                                   const DiskGrid& grid, const SpectrumRequest& request,
                                   const std::function<bool(std::size_t)>& wanted,
                                   const std::function<void(std::size_t)>& report) {
  const Stopwatch watch;
  SpectrumOutcome outcome;
  const auto left_out = [&](const std::string& reason) {
    outcome.plan.push_back({Stage::Outcome::LeftOut, "kirchhoff spectrum", reason});
    return outcome;
  };
  std::vector<std::size_t> scans;
  for (std::size_t k = 0; k < listing.scans.size(); ++k)
    if (wanted(k)) scans.push_back(k);
  if (scans.empty()) return left_out("no scan could be used");
  std::vector<double> lambda_q;
  if (const auto* range = std::get_if<AsManyAsNeeded>(&request.lambda_q)) {
    try {
      const Survey chosen = survey(listing, preparation, grid, request, *range, scans);
      lambda_q = chosen.chosen.lambda_q;
      outcome.plan.push_back(survey_stage(chosen, *range));
    } catch (const FileError&) {
      throw;
    } catch (const InputError& error) {  // what is refused to one of the survey's scans is to all
      for (const std::size_t k : scans)
        outcome.refusals.push_back({k, error.what()});
      return left_out(error.what());
    }
  } else {
    lambda_q = std::get<std::vector<double>>(request.lambda_q);
  }
  std::vector<WavelengthGroup> groups = make_groups(grid, request, lambda_q);
  SpectrumOfScans result{.lambda_q = lambda_q,
                         .mean = SpectrumMean(grid, lambda_q.size()),
                         .errors = std::vector<ErrorSample>(lambda_q.size()),
                         .unreached = std::vector<std::int64_t>(lambda_q.size(), 0),
                         .tolerance = request.tolerance,
                         .coherence_area = {}};
  if (request.source || std::holds_alternative<SubWindows>(request.coherence))
    for (const WavelengthGroup& group : groups)
      result.coherence_area.insert(result.coherence_area.end(), group.count,
                                   std::get<SubWindows>(group.coherence).area);
  std::optional<WavelengthDependence> dependence;
  for (const std::size_t k : scans) {
    try {
      const HeightField surface = prepare_scan(listing.scans[k].path, preparation).surface;
      const ScanSpectrum scan = spectrum_of(surface, groups, lambda_q.size());
      result.mean.add(scan.tables, scan.area);
      for (std::size_t n = 0; n < lambda_q.size(); ++n) {
        result.errors[n] += scan.errors[n];
        result.unreached[n] += scan.unreached[n];
      }
      result.windows += scan.windows;
      result.pitch = std::max(result.pitch, scan.pitch);
      add_to(dependence, grid, request, lambda_q, scan);
    } catch (const InputError& error) {
      outcome.refusals.push_back({k, error.what()});
    }
    report(k);
  }
  result.seconds = watch.seconds();
  std::string done = count(result.mean.count(), "scan") + ", " +
                     count(static_cast<std::int64_t>(lambda_q.size()), "wavelength") + ", " +
                     count(result.windows, "coherent window");
  const std::int64_t unreached =
      std::accumulate(result.unreached.begin(), result.unreached.end(), std::int64_t{0});
  if (unreached > 0) done += ", " + count(unreached, "table") + " missed the tolerance";
  std::map<std::string, std::int64_t> reasons;
  for (const SpectrumRefusal& refusal : outcome.refusals)
    ++reasons[refusal.reason];
  for (const auto& [reason, refused] : reasons)
    done += "; " + count(refused, "scan") + " left out: " + reason;
  const bool there = result.mean.count() > 0;
  outcome.plan.push_back({there ? Stage::Outcome::Ran : Stage::Outcome::LeftOut, "kirchhoff spectrum", done});
  if (dependence) outcome.plan.push_back(dependence_stage(*dependence));
  if (there) outcome.spectrum = std::move(result);
  return outcome;
}

}  // namespace micro
