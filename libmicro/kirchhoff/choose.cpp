#include "kirchhoff/choose.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

#include "core/error.h"
#include "height/triangles.h"
#include "kirchhoff/spectral.h"

namespace micro {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kMaxSubdivision = 2000;

/// Triangles and their root mean square slope, over all windows.
struct Relief {
  double triangles = 0, slope2 = 0, dx = 0, dy = 0;
};

Relief relief_of(std::span<const Window> windows) {
  Relief relief;
  for (const Window& window : windows) {
    const HeightField& surface = window.surface;
    relief.dx = surface.dx;
    relief.dy = surface.dy;
    for (Eigen::Index j = 0; j + 1 < surface.rows(); ++j)
      for_each_triangle(surface, j, [&](const Triangle& t) {
        ++relief.triangles;
        relief.slope2 += t.zx * t.zx + t.zy * t.zy;
      });
  }
  if (!(relief.triangles > 0))
    throw InputError("not one triangle of the surface is there: D_K needs three neighbouring heights");
  return relief;
}

/// The relative standard error of D with n² strata.
double monte_carlo_error(const Relief& s, double q, int n) {
  const double slope2 = s.slope2 / s.triangles;
  const double phase2 = q * q * slope2 * (s.dx * s.dx + s.dy * s.dy) / 18 / (n * n);
  const double variance = std::min(0.3 * phase2 * phase2, 1.0 / 3);
  const double density = 1 / (2 * kPi * slope2), triangle = s.dx * s.dy / 2;
  return q * std::sqrt(triangle * variance / (4 * kPi * kPi * density)) / n;
}

double spectral_seconds(const Window& window, const DiskGrid& grid, const KirchhoffRequest& request,
                        const KirchhoffCosts& costs) {
  const HeightField& surface = window.surface;
  const SpectralChoice choice = choose_spectral(surface, grid, request.lambda_q, request.tolerance);
  const SpectralWork work = predict_work(window, grid, request.lambda_q, choice);
  const double nodes = static_cast<double>(grid.size) * grid.size,
               points = static_cast<double>(surface.z.size());
  const double table = table_seconds(work, nodes, costs.spectral);
  return table + costs.spectral_surface * points +
         costs.exact_triangle * 2 * points * checked_nodes(surface, grid, work);
}

std::string seconds_text(double seconds) {
  if (std::isinf(seconds)) return "cannot serve chosen directions";
  char text[32];
  std::snprintf(text, sizeof text, "%.2g s", seconds);
  return text;
}

}  // namespace

std::string name_of(const KirchhoffEstimator& estimator) {
  if (std::holds_alternative<Exact>(estimator)) return "exact";
  return std::holds_alternative<Spectral>(estimator) ? "spectral" : "monte-carlo";
}

KirchhoffPrediction predict_seconds(std::span<const Window> windows, const KirchhoffRequest& request,
                                    const KirchhoffCosts& costs) {
  const Relief relief = relief_of(windows);
  const double q = 4 * kPi / request.lambda_q, threads = std::max(request.threads, 1);
  const auto* grid = std::get_if<DiskGrid>(&request.targets);
  const auto directions =
      static_cast<double>(grid ? disk_nodes(*grid) : std::get<Directions>(request.targets).count);
  KirchhoffPrediction result;
  while (result.subdivision < kMaxSubdivision &&
         !(monte_carlo_error(relief, q, result.subdivision) <= request.tolerance))
    ++result.subdivision;
  const double n = result.subdivision, strata = n > 1 ? n * n + 1 : 1, batches = std::ceil(directions / 512);
  result.exact = costs.exact_triangle * relief.triangles * directions / threads;
  result.monte_carlo = strata * relief.triangles *
                       (6 * costs.monte_carlo_point * directions + costs.monte_carlo_draw * batches) /
                       threads;
  if (!grid)
    result.spectral = std::numeric_limits<double>::infinity();
  else
    for (const Window& window : windows)
      result.spectral += spectral_seconds(window, *grid, request, costs) / threads;
  return result;
}

KirchhoffChoice choose_estimator(std::span<const Window> windows, const KirchhoffRequest& request,
                                 const KirchhoffCosts& costs) {
  if (!(request.tolerance > 0 && std::isfinite(request.tolerance)))
    throw InputError("the tolerance must be positive and finite, not " + std::to_string(request.tolerance));
  if (!(request.lambda_q > 0 && std::isfinite(request.lambda_q)))
    throw InputError("the effective wavelength must be positive and finite, not " +
                     std::to_string(request.lambda_q) + " µm");
  const KirchhoffPrediction p = predict_seconds(windows, request, costs);
  if (p.exact <= std::min(p.monte_carlo, p.spectral))
    return {Exact{}, p};  // of equals, the one without error
  if (p.spectral <= p.monte_carlo) return {Spectral{request.tolerance}, p};
  return {MonteCarlo{.tolerance = request.tolerance}, p};
}

std::string to_text(const KirchhoffPrediction& p) {
  return "exact " + seconds_text(p.exact) + ", monte-carlo " + seconds_text(p.monte_carlo) + ", spectral " +
         seconds_text(p.spectral);
}

}  // namespace micro
