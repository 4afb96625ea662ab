#include "pipelines/ndf_estimator.h"

#include <sstream>

#include "core/estimate.h"
#include "ndf/normal_counts.h"

namespace micro {
namespace {

ScanNdf counted(const NormalCounts& counts) {
  ScanNdf ndf;
  ndf.density = sparse_density(counts);
  ndf.samples = counts.total;
  ndf.outside = counts.outside;
  return ndf;
}

}  // namespace

NdfEstimator::NdfEstimator(const NdfMethod& method, const DiskGrid& grid, std::optional<DiskGrid> spared)
    : method_(method), grid_(grid) {
  if (const auto* kirchhoff = std::get_if<Kirchhoff>(&method.kind))
    kirchhoff_ = std::make_unique<KirchhoffScans>(*kirchhoff, grid, spared);
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

ScanNdf NdfEstimator::compute(const Kirchhoff&, const HeightField& surface) const {
  ScanNdf ndf;
  KirchhoffEstimate estimate = (*kirchhoff_)(surface);
  ndf.density = DiskTable{grid_, std::move(estimate.density)};
  ndf.samples = estimate.windows;
  ndf.kirchhoff = std::move(estimate);
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

}  // namespace micro
