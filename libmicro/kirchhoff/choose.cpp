#include "kirchhoff/choose.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

#include "core/error.h"
#include "height/triangles.h"
#include "kirchhoff/kirchhoff.h"

namespace micro {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kMaxSubdivision = 2000;

/// The relative standard error of D with n² strata.
double monte_carlo_error(const KirchhoffSurface& s, double q, int n) {
  const double phase2 = q * q * s.slope * s.slope * (s.dx * s.dx + s.dy * s.dy) / 18 / (n * n);
  const double variance = std::min(0.3 * phase2 * phase2, 1.0 / 3);
  const double density = 1 / (2 * kPi * s.slope * s.slope), triangle = s.dx * s.dy / 2;
  return q * std::sqrt(triangle * variance / (4 * kPi * kPi * density)) / n;
}

std::string seconds_text(double seconds) {
  if (std::isinf(seconds)) return "cannot serve chosen directions";
  char text[32];
  std::snprintf(text, sizeof text, "%.2g s", seconds);
  return text;
}

}  // namespace

KirchhoffSurface kirchhoff_surface(const HeightField& surface) {
  kirchhoff_area(surface);
  KirchhoffSurface result{.dx = surface.dx, .dy = surface.dy};
  double slope2 = 0;
  float low = std::numeric_limits<float>::infinity(), high = -low;
  for (Eigen::Index j = 0; j + 1 < surface.rows(); ++j)
    for_each_triangle(surface, j, [&](const Triangle& t) {
      ++result.triangles;
      slope2 += t.zx * t.zx + t.zy * t.zy;
      for (const Eigen::Vector2i& corner : {t.a, t.b, t.c}) {
        low = std::min(low, surface.z(corner.y(), corner.x()));
        high = std::max(high, surface.z(corner.y(), corner.x()));
      }
    });
  result.slope = std::sqrt(slope2 / result.triangles);
  result.height_range = static_cast<double>(high) - low;
  return result;
}

KirchhoffPrediction predict_seconds(const KirchhoffSurface& surface, const KirchhoffRequest& request,
                                    const KirchhoffCosts& costs) {
  const double q = 4 * kPi / request.lambda_q, threads = std::max(request.threads, 1);
  KirchhoffPrediction result;
  while (result.subdivision < kMaxSubdivision &&
         !(monte_carlo_error(surface, q, result.subdivision) <= request.tolerance))
    ++result.subdivision;
  const double n = result.subdivision, strata = n > 1 ? n * n + 1 : 1,
               batches = std::ceil(request.directions / 512);
  result.exact = costs.exact_triangle * surface.triangles * request.directions / threads;
  result.monte_carlo = strata * surface.triangles *
                       (6 * costs.monte_carlo_point * request.directions + costs.monte_carlo_draw * batches) /
                       threads;
  const double nodes = q * surface.height_range / 4 + std::log(1 / request.tolerance) + 3;
  result.spectral = request.targets == Targets::Table ? costs.spectral_plane_point * (surface.triangles / 2) *
                                                            std::max(nodes, 3.0) / threads
                                                      : std::numeric_limits<double>::infinity();
  return result;
}

KirchhoffChoice choose_estimator(const KirchhoffSurface& surface, const KirchhoffRequest& request,
                                 const KirchhoffCosts& costs) {
  if (!(request.tolerance > 0 && std::isfinite(request.tolerance)))
    throw InputError("the tolerance must be positive and finite, not " + std::to_string(request.tolerance));
  if (!(request.lambda_q > 0 && std::isfinite(request.lambda_q)))
    throw InputError("the effective wavelength must be positive and finite, not " +
                     std::to_string(request.lambda_q) + " µm");
  const KirchhoffPrediction p = predict_seconds(surface, request, costs);
  const double least = std::min({p.exact, p.monte_carlo, p.spectral});
  KirchhoffChoice choice{Exact{}, p, {}};
  const char* name = "exact";
  if (p.exact > least) {  // of equals, the one without an error
    const bool spectral = p.spectral <= p.monte_carlo;
    name = spectral ? "spectral" : "monte-carlo";
    if (spectral)
      choice.estimator = Spectral{request.tolerance};
    else
      choice.estimator = MonteCarlo{.tolerance = request.tolerance};
  }
  choice.reason = std::string(name) + " is predicted to be the fastest: exact " + seconds_text(p.exact) +
                  ", monte-carlo " + seconds_text(p.monte_carlo) + ", spectral " + seconds_text(p.spectral);
  return choice;
}

}  // namespace micro
