#include "pipelines/ndf_mean.h"

#include <algorithm>
#include <iomanip>
#include <sstream>

#include "distribution/compare.h"

namespace micro {
namespace {

/// sinθ of the half vectors that a pitch resolves: a geometric NDF has its facets' own slopes, D_K needs half
/// a fringe from point to point [λ_q/(4·pitch)].
double valid_sin_theta(const NdfMethod& method, double pitch) {
  const auto* kirchhoff = std::get_if<Kirchhoff>(&method.kind);
  return kirchhoff ? std::min(1., kirchhoff->lambda_q / (4 * pitch)) : 1;
}

}  // namespace

NdfMean::NdfMean(const NdfMethod& method, const DiskGrid& grid, std::optional<DiskGrid> spared)
    : mean_(grid), grid_(grid), spared_(spared) {
  ndf_.method = method;
  ndf_.estimator = std::holds_alternative<Naive>(method.kind) ? "triangles" : "plane fits";
}

void NdfMean::add(const ScanNdf& scan, double area, double pitch) {
  if (scan.samples == 0) return;
  std::visit([&](const auto& table) { mean_.add(table, area); }, scan.density);
  ndf_.samples += scan.samples;
  outside_ += scan.outside;
  ndf_.without_normal += scan.without_normal;
  if (scan.truncation_error)
    ndf_.truncation_error = std::max(ndf_.truncation_error.value_or(0), *scan.truncation_error);
  if (scan.kirchhoff) {
    if (!kirchhoff_) kirchhoff_.emplace();
    kirchhoff_->add(*scan.kirchhoff, area);
  }
  pitch_ = std::max(pitch_, pitch);
  ndf_.seconds += scan.seconds;
}

void NdfMean::merge(const NdfMean& other) {
  mean_.merge(other.mean_);
  ndf_.samples += other.ndf_.samples;
  ndf_.without_normal += other.ndf_.without_normal;
  ndf_.seconds += other.ndf_.seconds;
  if (other.ndf_.truncation_error)
    ndf_.truncation_error = std::max(ndf_.truncation_error.value_or(0), *other.ndf_.truncation_error);
  outside_ += other.outside_;
  if (other.kirchhoff_) {
    if (!kirchhoff_) kirchhoff_.emplace();
    kirchhoff_->merge(*other.kirchhoff_);
  }
  pitch_ = std::max(pitch_, other.pitch_);
  micro::add(refusals_, other.refusals_);
}

NdfOfScans NdfMean::finish() const {
  NdfOfScans ndf = ndf_;
  ndf.density = mean_.mean();
  ndf.standard_error = mean_.standard_error();
  ndf.scans = mean_.count();
  ndf.area = mean_.weight();
  ndf.outside = ndf.samples > 0 ? static_cast<double>(outside_) / static_cast<double>(ndf.samples) : 0;
  if (pitch_ > 0) ndf.valid_sin_theta = valid_sin_theta(ndf.method, pitch_);
  if (kirchhoff_) {
    ndf.estimator = kirchhoff_->estimator();
    ndf.rel_error = kirchhoff_->rel_error(ndf.density.density);
    ndf.estimator_error = kirchhoff_->standard_error();
    ndf.unreached = kirchhoff_->unreached();
  }
  return ndf;
}

Plan NdfMean::plan() const {
  const std::string name = ndf_.method.name + " NDF", refused = to_text(refusals_);
  if (count() == 0) return {left_out(name, refused.empty() ? "no scan could be used" : refused)};
  const auto* kirchhoff = std::get_if<Kirchhoff>(&ndf_.method.kind);
  std::string done = counted(count(), "scan") + ", " +
                     (kirchhoff ? kirchhoff_->sentence(kirchhoff->by) : counted(ndf_.samples, "normal"));
  if (ndf_.without_normal > 0) done += ", " + counted(ndf_.without_normal, "point") + " without a normal";
  if (ndf_.truncation_error) {
    std::ostringstream bound;
    bound << std::setprecision(2) << *ndf_.truncation_error;
    done += ", slopes within " + bound.str() + " of uncut windows'";
  }
  // A lobe that falls between the nodes has no shape in the table, and D_K's normalisation not even its mass.
  const DiskTable table = mean_.mean();
  const LobeWidth width = lobe_width(table);
  const double spacing = grid_.spacing();
  if (!(width.x >= spacing && width.y >= spacing) || (kirchhoff && !(normalization(table) < 1.1)))
    done += "; its lobe is narrower than a few nodes of the table, --extent auto resolves it";
  Plan plan = {ran(name, done + (refused.empty() ? "" : "; " + refused))};
  if (kirchhoff_ && spared_)
    plan.push_back(ran(ndf_.method.name + " extent", kirchhoff_->saving(disk_nodes(grid_), *spared_)));
  return plan;
}

}  // namespace micro
