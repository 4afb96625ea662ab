#include "pipelines/ndf_estimator.h"

#include <mutex>
#include <sstream>
#include <vector>

#include "core/estimate.h"
#include "kirchhoff/spectral.h"
#include "ndf/normal_counts.h"

namespace micro {
namespace {

ScanNdf counted(const NormalCounts& counts) {
  ScanNdf ndf;
  ndf.density = density(counts);
  ndf.samples = counts.total;
  ndf.outside = counts.outside;
  return ndf;
}

}  // namespace

/// One D_K solver for each thread that works on scans, kept from scan to scan with its memory and plans.
class NdfEstimator::Solvers {
 public:
  Solvers(const DiskGrid& grid, const Kirchhoff& kirchhoff) : grid_(grid), kirchhoff_(kirchhoff) {}

  KirchhoffTable operator()(const HeightField& surface) {
    std::unique_ptr<SpectralSolver> solver = take();
    KirchhoffTable table = (*solver)(surface);
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

NdfEstimator::NdfEstimator(const NdfMethod& method, const DiskGrid& grid) : method_(method), grid_(grid) {
  if (const auto* kirchhoff = std::get_if<Kirchhoff>(&method.kind))
    solvers_ = std::make_unique<Solvers>(grid, *kirchhoff);
}

NdfEstimator::~NdfEstimator() = default;
NdfEstimator::NdfEstimator(NdfEstimator&&) noexcept = default;

ScanNdf NdfEstimator::compute(const Naive&, const HeightField& surface) const {
  return counted(naive_counts(surface, grid_));
}

ScanNdf NdfEstimator::compute(const Filtered& filtered, const HeightField& surface) const {
  const SlopeField slopes = local_planes(surface, filtered.sigma);
  ScanNdf ndf = counted(filtered_counts(slopes, grid_));
  ndf.without_normal = slopes.without_normal;
  ndf.truncation_error = slopes.truncation_error;
  return ndf;
}

ScanNdf NdfEstimator::compute(const Kirchhoff& kirchhoff, const HeightField& surface) const {
  ScanNdf ndf;
  ndf.density = make_disk_table(grid_);
  ndf.kirchhoff_error = ErrorSample{};
  double area = 0;
  for (const Window& window : coherent_windows(surface, kirchhoff.coherence)) {
    const KirchhoffTable table = (*solvers_)(window.surface);
    const double weight = effective_area(window);
    ndf.density.density += weight * table.table.density;
    area += weight;
    *ndf.kirchhoff_error += table.error;
    ndf.unreached += table.reached ? 0 : 1;
    ++ndf.samples;
  }
  if (area > 0) ndf.density.density /= area;
  return ndf;
}

ScanNdf NdfEstimator::operator()(const HeightField& surface) const {
  const Stopwatch stopwatch;
  ScanNdf ndf = std::visit([&](const auto& kind) { return compute(kind, surface); }, method_.kind);
  ndf.seconds = stopwatch.seconds();
  return ndf;
}

std::string filtered_name(double sigma) {
  std::ostringstream name;
  name << "filtered_" << sigma << "um";
  return name.str();
}

std::string_view estimator_of(const NdfMethod& method) {
  if (std::holds_alternative<Kirchhoff>(method.kind)) return "spectral";
  return std::holds_alternative<Naive>(method.kind) ? "triangles" : "plane fits";
}

}  // namespace micro
