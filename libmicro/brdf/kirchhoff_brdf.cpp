#include "brdf/kirchhoff_brdf.h"

#include <algorithm>

#include "core/error.h"

namespace micro {

SpectrumDensity::SpectrumDensity(std::vector<double> lambda_q_um, std::vector<Tabulated> tables)
    : lambda_q_(std::move(lambda_q_um)), tables_(std::move(tables)) {
  if (lambda_q_.empty() || tables_.size() != lambda_q_.size() ||
      !std::ranges::is_sorted(lambda_q_, std::less_equal{}) || !(lambda_q_.front() > 0))
    throw InputError("a spectrum of D_K needs positive, ascending wavelengths and a table for each");
}

double SpectrumDensity::operator()(const Vec3& q) const {
  const double norm = q.norm(), lambda = 4 * std::numbers::pi / norm;
  const Vec3 m = q / norm;
  const auto next = static_cast<std::size_t>(std::ranges::upper_bound(lambda_q_, lambda) - lambda_q_.begin());
  if (next == 0) return tables_.front().D(m);
  if (next == lambda_q_.size()) return tables_.back().D(m);
  const double below = 1 / lambda_q_[next - 1], above = 1 / lambda_q_[next];
  const double t = (1 / lambda - below) / (above - below);
  return std::lerp(tables_[next - 1].D(m), tables_[next].D(m), t);
}

}  // namespace micro
