#include "pipelines/shadowing_study.h"

#include <cmath>
#include <iomanip>
#include <limits>
#include <numbers>
#include <sstream>

#include "brdf/free_travel.h"
#include "distribution/beckmann.h"
#include "distribution/tabulate.h"
#include "distribution/tabulated.h"

namespace micro {
namespace {

constexpr double kTolerance = 1e-6;

/// The direction whose rays have slope ν on a surface of smoothness s: cot θ = ν/s.
Vec3 direction(double nu, double s) {
  return Vec3(s, 0, nu).normalized();
}

std::string with_error(const Estimate<double>& estimate) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(4) << estimate.value << " ± " << estimate.error;
  return text.str();
}

/// k of [Sun02 Eq. 3.4.9] in 1/τ that makes his quadrature at the mean height what is simulated.
Estimate<double> wanted_rate(const ShadowingStudyRow& row) {
  const Estimate<double>& simulated = row.simulated.from_mean_height().all;
  return {-std::log(simulated.value) / row.covered.value,
          simulated.error / simulated.value / row.covered.value,
          {}};
}

/// Polar angle in degrees on a surface of smoothness s.
double theta_deg(double nu, double s) {
  return std::atan2(s, nu) * 180 / std::numbers::pi;
}

}  // namespace

double smith_at_height(double eta, double lambda) {
  return std::pow(std::erfc(-eta / std::numbers::sqrt2) / 2, lambda);
}

std::vector<double> shadowing_study_slopes() {
  return {0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1, 1.25, 1.5, 2, 2.5, 3, 4, 6};
}

std::vector<ShadowingStudyRow> study_shadowing(const ShadowingRequest& request) {
  const Beckmann normals = gaussian_surface_normals({1, kTableSmoothness, kTableSmoothness});
  const Tabulated table(tabulate(normals, DiskGrid{}));
  std::vector<ShadowingStudyRow> rows;
  for (ShadowingRow& simulated : simulate_shadowing(request)) {
    const double nu = simulated.nu;
    const Vec3 ray = direction(nu, kTableSmoothness);
    ShadowingStudyRow row;
    row.simulated = std::move(simulated);
    row.sun_closed = free_travel_probability(nu);
    row.covered = mean_covered_length(0, nu, kTolerance);
    row.sun_mean_height = std::exp(-row.covered.value);
    row.sun_mean = mean_free_travel_product(nu, std::numeric_limits<double>::infinity(), kTolerance);
    row.sun_product = mean_free_travel_product(nu, nu, kTolerance);
    row.facing = std::erfc(-nu / 2) / 2;
    row.smith_lambda = normals.visible_area(ray) / ray.z() - 1;
    row.table_g1 = table.G1(ray);
    rows.push_back(std::move(row));
  }
  return rows;
}

std::string to_markdown(const std::vector<ShadowingStudyRow>& rows) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(4);
  const auto start = [&](const ShadowingStudyRow& row) {
    text << "| " << std::setprecision(2) << row.simulated.nu << " | " << std::setprecision(1)
         << theta_deg(row.simulated.nu, 1) << "° | " << theta_deg(row.simulated.nu, 10) << "° | "
         << std::setprecision(4);
  };
  const std::string head = "| ν = s·cot θ | θ at s = 1 | θ at s = 10 | ";
  text << "### From the mean height\n\n"
       << head
       << "Γ₀ (3.4.23) | Γ(0) (3.4.14) | simulated, all rays | simulated from crossings | Smith, P·2^−Λ | "
          "simulated, facing | Smith 2^−Λ | k·τ that (3.4.14) would need "
          "|\n|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const ShadowingStudyRow& row : rows) {
    const EscapingPart& mean_height = row.simulated.from_mean_height();
    const double smith = smith_at_height(0, row.smith_lambda);
    start(row);
    text << row.sun_closed << " | " << row.sun_mean_height << " | " << with_error(mean_height.all) << " | "
         << with_error(row.simulated.from_crossings) << " | " << row.facing * smith << " | "
         << with_error(mean_height.facing) << " | " << smith << " | " << with_error(wanted_rate(row))
         << " |\n";
  }
  text
      << "\n### From all heights\n\n"
      << head
      << "⟨Γ⟩ (3.2.11) | simulated, all rays | Smith, P·G1 | simulated, facing | Smith G1 | the table's G1 | "
         "Γ₀/G1 |\n|---|---|---|---|---|---|---|---|---|---|\n";
  for (const ShadowingStudyRow& row : rows) {
    const double g1 = 1 / (1 + row.smith_lambda);
    start(row);
    text << row.sun_mean.value << " | " << with_error(row.simulated.from_anywhere.all) << " | "
         << row.facing * g1 << " | " << with_error(row.simulated.from_anywhere.facing) << " | " << g1 << " | "
         << row.table_g1 << " | " << row.sun_closed / g1 << " |\n";
  }
  text << "\n### Light and view at the same angle on opposite sides\n\n"
       << head
       << "Γ₀Γ₀ (3.5.2) | ⟨ΓΓ⟩ (3.5.1) | simulated, all | simulated, facing both | simulated, level | Smith "
          "1/(1 + 2Λ) | G1² "
          "|\n|---|---|---|---|---|---|---|---|---|---|\n";
  for (const ShadowingStudyRow& row : rows) {
    const double lambda = row.smith_lambda;
    start(row);
    text << row.sun_closed * row.sun_closed << " | " << row.sun_product.value << " | "
         << with_error(row.simulated.both_ways.all) << " | " << with_error(row.simulated.both_ways.facing)
         << " | " << with_error(row.simulated.level_both_ways) << " | " << 1 / (1 + 2 * lambda) << " | "
         << 1 / (1 + lambda) / (1 + lambda) << " |\n";
  }
  return text.str();
}

std::string to_csv(const std::vector<ShadowingStudyRow>& rows) {
  std::ostringstream text;
  text << "nu,rays,sun_closed,covered_length,sun_mean_height,sun_mean,sun_product,facing,smith_lambda,table_"
          "g1";
  for (const char* name : {"mean_height", "mean_height_facing", "crossings", "anywhere", "anywhere_facing",
                           "both", "both_facing", "both_level"})
    text << ',' << name << ',' << name << "_error";
  text << '\n' << std::setprecision(9);
  for (const ShadowingStudyRow& row : rows) {
    const ShadowingRow& simulated = row.simulated;
    text << simulated.nu << ',' << simulated.rays << ',' << row.sun_closed << ',' << row.covered.value << ','
         << row.sun_mean_height << ',' << row.sun_mean.value << ',' << row.sun_product.value << ','
         << row.facing << ',' << row.smith_lambda << ',' << row.table_g1;
    for (const Estimate<double>& estimate :
         {simulated.from_mean_height().all, simulated.from_mean_height().facing, simulated.from_crossings,
          simulated.from_anywhere.all, simulated.from_anywhere.facing, simulated.both_ways.all,
          simulated.both_ways.facing, simulated.level_both_ways})
      text << ',' << estimate.value << ',' << estimate.error;
    text << '\n';
  }
  return text.str();
}

}  // namespace micro
