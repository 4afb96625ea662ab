#include "pipelines/kirchhoff_directions.h"

#include <algorithm>

namespace micro {
namespace {

std::vector<double> column(const Grid<double>& values) {
  return {values.data(), values.data() + values.size()};
}

}  // namespace

DirectionsMean::DirectionsMean(const Kirchhoff& kirchhoff, const std::vector<Vec3>& h, const DiskGrid& table)
    : mean_(static_cast<Eigen::Index>(h.size()), 1), table_(table) {
  result_.kirchhoff = kirchhoff;
  result_.h = h;
}

void DirectionsMean::add(const KirchhoffEstimate& scan, double area, double pitch) {
  mean_.add(scan.density, area);
  tally_.add(scan, area);
  pitch_ = std::max(pitch_, pitch);
}

void DirectionsMean::merge(const DirectionsMean& other) {
  mean_.merge(other.mean_);
  tally_.merge(other.tally_);
  pitch_ = std::max(pitch_, other.pitch_);
  micro::add(refusals_, other.refusals_);
}

std::optional<DirectionsOfScans> DirectionsMean::finish() const {
  if (mean_.count() == 0) return std::nullopt;
  DirectionsOfScans result = result_;
  const Grid<double> mean = mean_.mean(), own = tally_.standard_error();
  result.density = column(mean);
  if (const auto error = mean_.standard_error()) result.standard_error = column(*error);
  result.estimator_error = own.size() > 0 ? column(own) : std::vector<double>(result.h.size(), 0.);
  result.scans = mean_.count();
  result.area = mean_.weight();
  result.unreached = tally_.unreached();
  result.valid_sin_theta = std::min(1., result.kirchhoff.lambda_q / (4 * pitch_));
  result.estimator = tally_.estimator();
  result.rel_error = tally_.rel_error(mean);
  result.seconds = tally_.seconds();
  return result;
}

Plan DirectionsMean::plan() const {
  const std::string refused = to_text(refusals_);
  if (mean_.count() == 0)
    return {left_out(kDirectionsName, refused.empty() ? "no scan could be used" : refused)};
  const auto n = static_cast<std::int64_t>(result_.h.size());
  return {ran(kDirectionsName, counted(mean_.count(), "scan") + ", " + counted(n, "direction") + ", " +
                                   tally_.sentence(result_.kirchhoff.by) +
                                   (refused.empty() ? "" : "; " + refused)),
          left_out("kirchhoff table", tally_.saving(n, table_))};
}

}  // namespace micro
