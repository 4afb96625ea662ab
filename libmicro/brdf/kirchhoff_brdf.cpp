#include "brdf/kirchhoff_brdf.h"

#include <algorithm>

#include "core/error.h"

namespace micro {

SpectrumDensity::SpectrumDensity(std::vector<double> lambda_q_um, const std::vector<Tabulated>& tables,
                                 double medium)
    : lambda_q_(std::move(lambda_q_um)),
      tables_(tables),
      integrals_(tables.begin(), tables.end()),
      medium_(medium) {
  if (lambda_q_.empty() || tables_.size() != lambda_q_.size() ||
      !std::ranges::is_sorted(lambda_q_, std::less_equal{}) || !(lambda_q_.front() > 0))
    throw InputError("a spectrum of D_K needs positive, ascending wavelengths and a table for each");
}

SpectrumDensity::Place SpectrumDensity::place_of(double lambda_q) const {
  const auto next =
      static_cast<std::size_t>(std::ranges::upper_bound(lambda_q_, lambda_q) - lambda_q_.begin());
  if (next == 0) return {0, 0};
  if (next == lambda_q_.size()) return {next - 1, 0};
  const double below = 1 / lambda_q_[next - 1], above = 1 / lambda_q_[next];
  return {next - 1, (1 / lambda_q - below) / (above - below)};
}

double SpectrumDensity::operator()(const Vec3& q) const {
  const double norm = q.norm();
  const Vec3 m = q / norm;
  const auto [table, next] = place_of(4 * std::numbers::pi / (medium_ * norm));
  const double here = tables_[table].D(m);
  return next > 0 ? std::lerp(here, tables_[table + 1].D(m), next) : here;
}

Estimate<double> SpectrumDensity::over_half_vectors(const Vec3& wi, double lambda_um,
                                                    const std::function<double(const Vec3& h)>& g,
                                                    double tolerance) const {
  Estimate<double> sum{0, 0, {}};
  const double share_of_tolerance = tolerance / static_cast<double>(tables_.size());
  for (std::size_t k = 0; k < tables_.size(); ++k) {
    const auto share_of_table = [&](const Vec3& h) {
      const double cosine = wi.dot(h);
      if (!(cosine > 0)) return 0.;
      const auto [table, next] = place_of(lambda_um / (medium_ * cosine));
      const double share = table == k ? 1 - next : table + 1 == k ? next : 0;
      return share > 0 ? share * g(h) : 0;
    };
    const double left = (tolerance - sum.error) / static_cast<double>(tables_.size() - k);
    // What the tables before did not use; no less than a share if they missed theirs.
    const Estimate<double> part = integrals_[k](share_of_table, std::max(left, share_of_tolerance));
    sum.value += part.value;
    sum.error += part.error;
    sum.cost.seconds += part.cost.seconds;
    sum.cost.evaluations += part.cost.evaluations;
  }
  return sum;
}

}  // namespace micro
