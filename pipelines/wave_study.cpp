#include "pipelines/wave_study.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iomanip>
#include <numbers>
#include <sstream>

#include "core/error.h"
#include "distribution/beckmann.h"
#include "distribution/compare.h"
#include "distribution/tabulate.h"
#include "kirchhoff/spectral.h"
#include "ndf/normal_counts.h"

namespace micro {
namespace {

constexpr DiskGrid kGrid = {257, 0.8};
constexpr double kTolerance = 1e-3;
using std::numbers::pi;

/// Mean of the half interquartile ranges of m_x and m_y.
double width(const DiskTable& table) {
  const LobeWidth w = lobe_width(table);
  return (w.x + w.y) / 2;
}

DiskTable isotropic_beckmann(double alpha) {
  return tabulate(gaussian_surface_normals({alpha / 2, 1, 1}), kGrid);
}

/// The α of the Beckmann distribution that is as wide.
double equivalent_alpha(double wanted) {
  double low = 1e-3, high = 2;
  for (int step = 0; step < 30; ++step) {
    const double middle = std::sqrt(low * high);
    (width(isotropic_beckmann(middle)) < wanted ? low : high) = middle;
  }
  return std::sqrt(low * high);
}

/// A radial profile on the grid.
DiskTable radial(const std::function<double(double)>& profile) {
  constexpr int kRadii = 400;
  std::vector<double> values;
  for (int k = 0; k <= kRadii; ++k)
    values.push_back(profile(std::min(0.999, static_cast<double>(k) / kRadii)));
  DiskTable table = make_disk_table(kGrid);
  for (Eigen::Index j = 0; j < kGrid.size; ++j)
    for (Eigen::Index i = 0; i < kGrid.size; ++i) {
      if (!(kGrid.mz2(j, i) > 0)) continue;
      const double at = std::hypot(kGrid.coordinate(i), kGrid.coordinate(j)) * kRadii;
      const auto below = std::min<std::size_t>(static_cast<std::size_t>(at), kRadii - 1);
      const double t = at - static_cast<double>(below);
      table.density(j, i) = (1 - t) * values[below] + t * values[below + 1];
    }
  return table;
}

Estimate<double> mean_of(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  double sum = 0, square = 0;
  for (const double value : values) {
    sum += value;
    square += value * value;
  }
  const double mean = sum / n;
  return {mean, n > 1 ? std::sqrt(std::max(0., square / n - mean * mean) / (n - 1)) : 0, {}};
}

}  // namespace

std::vector<WaveStudyCase> wave_study_cases() {
  std::vector<WaveStudyCase> cases;
  for (const auto& [tau, pitch] :
       {std::pair{1.5, 0.08}, std::pair{3., 0.11}, std::pair{6., 0.2}, std::pair{12., 0.25}}) {
    std::ostringstream name;
    name << "rms " << tau / 10 << " µm, τ " << tau << " µm";
    cases.push_back({name.str(), {{tau / 10, tau, tau}}, pitch});
  }
  cases.push_back(
      {"power law, τ 2 to 60 µm, rms 2 µm", power_law_scales({.rms = 2, .tau_min = 2, .tau_max = 60}), 0.25});
  return cases;
}

double mean_kirchhoff_density(const std::vector<GaussianField>& scales, double lambda_q, double sin_theta) {
  const double q = 4 * pi / lambda_q, q_plane = q * sin_theta, qz2 = q * q - q_plane * q_plane;
  double variance = 0, longest = 0;
  for (const GaussianField& scale : scales) {
    variance += scale.rms * scale.rms;
    longest = std::max(longest, scale.tau_x);
  }
  const double g = qz2 * variance;
  const auto structure = [&](double lag) {  // g(1 − C)
    double sum = 0;
    for (const GaussianField& scale : scales)
      sum -= scale.rms * scale.rms * std::expm1(-lag * lag / (scale.tau_x * scale.tau_x));
    return qz2 * sum;
  };
  // Beyond five correlation lengths, or where e^{−g(1−C)} is 1e-13, nothing is left.
  double reach = 5 * longest;
  for (double lag = longest / 1000; lag < reach; lag *= 1.05)
    if (structure(lag) > 30) reach = lag;
  const double fastest = q_plane + std::sqrt(q * q * 2 * variance) / scales.front().tau_x;
  const int steps = 2 * static_cast<int>(std::ceil(std::max(500., 20 * reach * fastest / (2 * pi))));
  double sum = 0;  // Simpson
  for (int k = 0; k <= steps; ++k) {
    const double lag = reach * k / steps;
    const double value =
        (std::exp(-structure(lag)) - std::exp(-g)) * std::cyl_bessel_j(0, q_plane * lag) * lag;
    sum += value * (k == 0 || k == steps ? 1 : k % 2 == 1 ? 4 : 2);
  }
  return q * q * q * q / (2 * pi * qz2) * sum * reach / (3 * steps);
}

WaveStudyRow study_waves(const WaveStudyCase& surface, const WaveStudyRequest& request) {
  if (request.surfaces < 1) throw InputError("a study takes at least one surface");
  std::vector<double> kirchhoff, filtered;
  SpectralSolver solver(kGrid, request.lambda_q, kTolerance);
  for (int k = 0; k < request.surfaces; ++k) {
    const HeightField z = multiscale_surface({request.points, request.points, surface.pitch, surface.pitch},
                                             surface.scales, static_cast<std::uint64_t>(k));
    kirchhoff.push_back(equivalent_alpha(width(solver(z).table)));
    filtered.push_back(
        equivalent_alpha(width(density(filtered_counts(local_planes(z, request.sigma), kGrid)))));
  }
  double slopes2 = 0;  // α² of the filtered slopes
  for (const GaussianField& scale : surface.scales) {
    const double tau2 = scale.tau_x * scale.tau_x, wide = tau2 + 4 * request.sigma * request.sigma;
    slopes2 += 4 * scale.rms * scale.rms * tau2 / (wide * wide);
  }
  WaveStudyRow row;
  row.name = surface.name;
  row.lambda_q = request.lambda_q;
  row.kirchhoff = mean_of(kirchhoff);
  row.filtered = mean_of(filtered);
  row.filtered_predicted = std::sqrt(slopes2);
  row.kirchhoff_predicted = equivalent_alpha(width(radial([&](double sin_theta) {
    return mean_kirchhoff_density(surface.scales, request.lambda_q, sin_theta);
  })));
  return row;
}

std::string to_markdown(const std::vector<WaveStudyRow>& rows) {
  std::ostringstream text;
  text << "| surface | α of D_K | predicted | α of the filtered NDF | predicted | D_K/filtered | predicted "
          "|\n|---|---|---|---|---|---|---|\n"
       << std::fixed << std::setprecision(3);
  for (const WaveStudyRow& row : rows)
    text << "| " << row.name << " | " << row.kirchhoff.value << " ± " << row.kirchhoff.error << " | "
         << row.kirchhoff_predicted << " | " << row.filtered.value << " ± " << row.filtered.error << " | "
         << row.filtered_predicted << " | " << row.kirchhoff.value / row.filtered.value << " | "
         << row.kirchhoff_predicted / row.filtered_predicted << " |\n";
  return text.str();
}

std::string to_csv(const std::vector<WaveStudyRow>& rows) {
  std::ostringstream text;
  text << "surface,lambda_q_um,alpha_kirchhoff,error,predicted,alpha_filtered,error,predicted\n"
       << std::setprecision(6);
  for (const WaveStudyRow& row : rows)
    text << '"' << row.name << "\"," << row.lambda_q << ',' << row.kirchhoff.value << ','
         << row.kirchhoff.error << ',' << row.kirchhoff_predicted << ',' << row.filtered.value << ','
         << row.filtered.error << ',' << row.filtered_predicted << '\n';
  return text.str();
}

}  // namespace micro
