#include "pipelines/kirchhoff_estimate.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iomanip>
#include <iterator>
#include <mutex>
#include <span>
#include <sstream>

#include "core/error.h"
#include "core/estimate.h"
#include "core/parallel.h"
#include "kirchhoff/exact.h"
#include "kirchhoff/spectral.h"
#include "pipelines/plan.h"

namespace micro {
namespace {

/// A seed that follows from the heights, so that scans draw different points and each always the same.
std::uint64_t seed_of(const HeightField& surface) {
  constexpr std::uint64_t kOffset = 0xcbf29ce484222325, kPrime = 0x100000001b3;  // FNV-1a
  std::uint64_t hash = kOffset;
  for (const std::byte byte : std::as_bytes(std::span(surface.z.data(), surface.z.size())))
    hash = (hash ^ static_cast<std::uint64_t>(byte)) * kPrime;
  return hash;
}

std::vector<Vec3> wave_vectors(const KirchhoffTargets& targets, double lambda_q) {
  std::vector<Vec3> q;
  if (const auto* directions = std::get_if<std::vector<Vec3>>(&targets)) {
    for (const Vec3& h : *directions)
      q.push_back(wave_vector(h, lambda_q));
    return q;
  }
  const DiskGrid& grid = std::get<DiskGrid>(targets);
  for (Eigen::Index j = 0; j < grid.size; ++j)
    for (Eigen::Index i = 0; i < grid.size; ++i)
      if (grid.mz2(j, i) > 0)
        q.push_back(
            wave_vector({grid.coordinate(i), grid.coordinate(j), std::sqrt(grid.mz2(j, i))}, lambda_q));
  return q;
}

/// Values in the order of wave_vectors, as the targets have them.
Grid<double> shaped(const KirchhoffTargets& targets, const std::vector<double>& values) {
  const auto* grid = std::get_if<DiskGrid>(&targets);
  if (!grid) return Eigen::Map<const Eigen::ArrayXd>(values.data(), static_cast<Eigen::Index>(values.size()));
  Grid<double> table = make_disk_table(*grid).density;
  auto value = values.begin();
  for (Eigen::Index j = 0; j < grid->size; ++j)
    for (Eigen::Index i = 0; i < grid->size; ++i)
      if (grid->mz2(j, i) > 0) table(j, i) = *value++;
  return table;
}

std::vector<double> exact_densities(std::span<const Window> windows, std::span<const Vec3> q) {
  std::vector<double> power(q.size(), 0.);
  double area = 0;
  for (const Window& window : windows) {
    const auto fields = exact_field(window, q);
    for (std::size_t k = 0; k < q.size(); ++k)
      power[k] += std::norm(fields[k]);
    area += effective_area(window);
  }
  for (double& value : power)
    value *= kirchhoff_density(1, area);
  return power;
}

KirchhoffEstimator estimator_by(const Kirchhoff& kirchhoff, const KirchhoffEstimator& fastest,
                                const HeightField& surface) {
  switch (kirchhoff.by) {
    case KirchhoffBy::Exact:
      return Exact{};
    case KirchhoffBy::Spectral:
      return Spectral{kirchhoff.tolerance};
    case KirchhoffBy::MonteCarlo:
      return MonteCarlo{.tolerance = kirchhoff.tolerance, .seed = seed_of(surface)};
    case KirchhoffBy::Fastest:
      break;
  }
  KirchhoffEstimator estimator = fastest;
  if (auto* monte_carlo = std::get_if<MonteCarlo>(&estimator)) monte_carlo->seed = seed_of(surface);
  return estimator;
}

std::string seconds_text(double seconds) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g s", seconds);
  return text;
}

}  // namespace

/// One spectral solver for each thread that works on scans, kept with its memory and plans.
class KirchhoffScans::Solvers {
 public:
  Solvers(const DiskGrid& grid, const Kirchhoff& kirchhoff) : grid_(grid), kirchhoff_(kirchhoff) {}

  KirchhoffTable operator()(const Window& window) {
    std::unique_ptr<SpectralSolver> solver = take();
    KirchhoffTable table = (*solver)(window);
    const std::scoped_lock lock(mutex_);
    idle_.push_back(std::move(solver));
    return table;
  }

 private:
  std::unique_ptr<SpectralSolver> take() {
    const std::scoped_lock lock(mutex_);
    if (idle_.empty())
      return std::make_unique<SpectralSolver>(grid_, kirchhoff_.lambda_q, kirchhoff_.tolerance);
    std::unique_ptr<SpectralSolver> solver = std::move(idle_.back());
    idle_.pop_back();
    return solver;
  }

  DiskGrid grid_;
  Kirchhoff kirchhoff_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<SpectralSolver>> idle_;
};

KirchhoffScans::KirchhoffScans(const Kirchhoff& kirchhoff, KirchhoffTargets targets,
                               std::optional<DiskGrid> spared)
    : kirchhoff_(kirchhoff), targets_(std::move(targets)), spared_(spared) {
  const auto* grid = std::get_if<DiskGrid>(&targets_);
  if (!grid && kirchhoff.by == KirchhoffBy::Spectral)
    throw InputError("the spectral estimator computes whole tables, not chosen directions");
  if (grid) solvers_ = std::make_unique<Solvers>(*grid, kirchhoff);
}

KirchhoffScans::~KirchhoffScans() = default;

KirchhoffEstimate KirchhoffScans::operator()(const HeightField& surface) const {
  const Stopwatch stopwatch;
  const std::vector<Window> windows = coherent_windows(surface, kirchhoff_.coherence);
  const auto* grid = std::get_if<DiskGrid>(&targets_);
  KirchhoffRequest request{.targets = Directions{},
                           .lambda_q = kirchhoff_.lambda_q,
                           .tolerance = kirchhoff_.tolerance,
                           .threads = thread_count()};
  if (grid)
    request.targets = *grid;
  else
    request.targets = Directions{static_cast<std::int64_t>(std::get<std::vector<Vec3>>(targets_).size())};
  const KirchhoffChoice choice = choose_estimator(windows, request);
  const KirchhoffEstimator estimator = estimator_by(kirchhoff_, choice.estimator, surface);

  KirchhoffEstimate result;
  result.estimator = name_of(estimator);
  result.predicted = choice.seconds;
  if (spared_) {
    request.targets = *spared_;
    const KirchhoffPrediction whole = predict_seconds(windows, request);
    result.predicted_spared = std::min({whole.exact, whole.monte_carlo, whole.spectral});
  }
  result.windows = static_cast<std::int64_t>(windows.size());
  if (std::holds_alternative<Exact>(estimator)) {
    result.density = shaped(targets_, exact_densities(windows, wave_vectors(targets_, kirchhoff_.lambda_q)));
  } else if (const auto* monte_carlo = std::get_if<MonteCarlo>(&estimator)) {
    std::vector<double> density, variance;
    const std::vector<Vec3> q = wave_vectors(targets_, kirchhoff_.lambda_q);
    for (const DirectionEstimate& d : monte_carlo_density(windows, q, *monte_carlo).value) {
      density.push_back(d.density);
      variance.push_back(d.standard_error * d.standard_error);
      ++result.asked;
      result.unreached += d.reached ? 0 : 1;
    }
    result.density = shaped(targets_, density);
    result.variance = shaped(targets_, variance);
  } else {
    result.density = make_disk_table(*grid).density;
    double area = 0;
    for (const Window& window : windows) {
      const KirchhoffTable table = (*solvers_)(window);
      const double weight = effective_area(window);
      result.density += weight * table.table.density;
      area += weight;
      result.checked += table.error;
      ++result.asked;
      result.unreached += table.reached ? 0 : 1;
    }
    result.density /= area;
  }
  result.seconds = stopwatch.seconds();
  return result;
}

void KirchhoffTally::add(const KirchhoffEstimate& scan, double area) {
  checked_ += scan.checked;
  if (scan.variance.size() > 0) {
    if (variance_.size() == 0) variance_ = Grid<double>::Zero(scan.variance.rows(), scan.variance.cols());
    variance_ += area * area * scan.variance;
  }
  area_ += area;
  predicted_.exact += scan.predicted.exact;
  predicted_.monte_carlo += scan.predicted.monte_carlo;
  predicted_.spectral += scan.predicted.spectral;
  predicted_spared_ += scan.predicted_spared;
  seconds_ += scan.seconds;
  ++scans_;
  windows_ += scan.windows;
  asked_ += scan.asked;
  unreached_ += scan.unreached;
  const auto at = std::lower_bound(estimators_.begin(), estimators_.end(), scan.estimator);
  if (at == estimators_.end() || *at != scan.estimator) estimators_.insert(at, scan.estimator);
}

void KirchhoffTally::merge(const KirchhoffTally& other) {
  checked_ += other.checked_;
  if (variance_.size() == 0)
    variance_ = other.variance_;
  else if (other.variance_.size() > 0)
    variance_ += other.variance_;
  area_ += other.area_;
  seconds_ += other.seconds_;
  predicted_spared_ += other.predicted_spared_;
  predicted_.exact += other.predicted_.exact;
  predicted_.monte_carlo += other.predicted_.monte_carlo;
  predicted_.spectral += other.predicted_.spectral;
  scans_ += other.scans_;
  windows_ += other.windows_;
  asked_ += other.asked_;
  unreached_ += other.unreached_;
  std::vector<std::string> both;
  std::set_union(estimators_.begin(), estimators_.end(), other.estimators_.begin(), other.estimators_.end(),
                 std::back_inserter(both));
  estimators_ = std::move(both);
}

std::string KirchhoffTally::estimator() const {
  std::string text;
  for (const std::string& name : estimators_)
    text += (text.empty() ? "" : " and ") + name;
  return text;
}

Grid<double> KirchhoffTally::standard_error() const {
  if (variance_.size() == 0) return {};
  return variance_.sqrt() / area_;
}

double KirchhoffTally::rel_error(const Grid<double>& mean) const {
  const double checked = std::max(checked_.error(), checked_.error_core_free());
  if (variance_.size() == 0) return checked;
  return std::max(checked, std::sqrt(variance_.sum() / (area_ * area_) / mean.square().sum()));
}

std::string KirchhoffTally::sentence(KirchhoffBy by) const {
  std::string text =
      std::to_string(windows_) + " coherent window" + (windows_ == 1 ? "" : "s") + ", by " + estimator() +
      (by == KirchhoffBy::Fastest ? ", predicted to be the fastest (" : " as asked (predicted: ") +
      to_text(predicted_) + "; it took " + seconds_text(seconds_) + ")";
  if (asked_ > 0) {
    text += ", " + std::to_string(asked_ - unreached_) + " of " + std::to_string(asked_) +
            (variance_.size() > 0 ? " directions" : " tables") + " reached the tolerance";
  }
  return text;
}

std::string KirchhoffTally::saving(std::int64_t nodes, const DiskGrid& spared) const {
  const std::int64_t all = disk_nodes(spared);
  std::ostringstream text;
  text << nodes << " of the " << all << " nodes out to sin(theta) = " << std::setprecision(3) << spared.extent
       << ", " << 100 * static_cast<double>(nodes) / static_cast<double>(all)
       << " %; all of them were predicted to take " << seconds_text(predicted_spared_) << ", these took "
       << seconds_text(seconds_);
  return text.str();
}

}  // namespace micro
