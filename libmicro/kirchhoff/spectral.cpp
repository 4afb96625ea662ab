#include "kirchhoff/spectral.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "core/error.h"
#include "height/triangles.h"
#include "kirchhoff/kirchhoff.h"

namespace micro {
namespace {

/// Below this tolerance sums are kept in double: single precision leaves some 1e-6 of the peak of |F|.
constexpr double kDoubleBelow = 3e-5;
constexpr int kMostSubdivision = 32;
constexpr int kMostWidth = 14;
/// Refinements before the error is taken for what it is.
constexpr int kRefinements = 3;

/// Slopes of some 50,000 facets, ascending.
struct Slopes {
  std::vector<double> sorted;

  double rms() const {
    double sum = 0;
    for (const double slope : sorted)
      sum += slope * slope;
    return sorted.empty() ? 0 : std::sqrt(sum / static_cast<double>(sorted.size()));
  }
  double fraction_above(double slope) const {
    const auto first = std::upper_bound(sorted.begin(), sorted.end(), slope);
    return sorted.empty() ? 0
                          : static_cast<double>(sorted.end() - first) / static_cast<double>(sorted.size());
  }
};

Slopes sample_slopes(const HeightField& surface) {
  constexpr Eigen::Index kSamples = 50000;
  const Eigen::Index step = std::max<Eigen::Index>(1, 2 * surface.rows() * surface.cols() / kSamples);
  Slopes slopes;
  Eigen::Index index = 0;
  for (Eigen::Index j = 0; j + 1 < surface.rows(); ++j)
    for (Eigen::Index i = index++ % step; i + 1 < surface.cols(); i += step) {
      const double z00 = surface.z(j, i), z01 = surface.z(j, i + 1), z11 = surface.z(j + 1, i + 1);
      const double slope = std::hypot((z01 - z00) / surface.dx, (z11 - z01) / surface.dy);
      if (std::isfinite(slope)) slopes.sorted.push_back(slope);
    }
  std::sort(slopes.sorted.begin(), slopes.sorted.end());
  return slopes;
}

/// How finely triangles are cut. Three laws, the last two with constants measured against `exact`:
/// - facets whose phase turns by more than a whole period of the lattice, |q|·√(1 + slope²)·d >
/// 2π·subdivision, are
///   taken for gentler ones (they alias), so hardly any such facet may be left;
/// - the midpoint rule's error grows as the fourth power of the phase across a sub-triangle, and as slope³;
/// - Simpson's along the rim is what significant directions far from the peak see.
int choose_subdivision(const Slopes& slopes, double phase, double sin_theta, double tol) {
  const double slope = slopes.rms() / std::sqrt(2.0);
  const double midpoint = phase * std::pow(1.5e-4 * slope * slope * slope * 3 / tol, 0.25);
  const double rim = sin_theta * phase / 2.5 * std::pow(2e-3 / (25 * tol), 0.25);
  int subdivision = std::max(1, static_cast<int>(std::ceil(std::max(midpoint, rim))));
  const auto aliased = [&](int s) {
    const double turns = 2 * std::numbers::pi * s / phase;
    // In-plane phases alone must stay within half a period.
    if (turns < 2 * sin_theta) return 1.0;
    return turns > 1 ? slopes.fraction_above(std::sqrt(turns * turns - 1)) : 1.0;
  };
  // Cliffs are few and their light goes everywhere: beyond 4 the measured error decides.
  while ((subdivision < 4 && aliased(subdivision) > 2 * tol) || aliased(subdivision) > 0.1) {
    if (subdivision >= 4096) break;
    ++subdivision;
  }
  return subdivision;
}

SpectralChoice refine(SpectralChoice choice) {
  choice.basis_tolerance = std::max(choice.basis_tolerance / 4, 1e-8);
  choice.subdivision = std::max(choice.subdivision, std::min(2 * choice.subdivision, kMostSubdivision));
  choice.kernel_width = std::min(choice.kernel_width + 2, kMostWidth);
  return choice;
}

}  // namespace

SpectralChoice choose_spectral(const HeightField& surface, const DiskGrid& grid, double lambda_q,
                               double tol) {
  const double phase = 4 * std::numbers::pi / lambda_q * std::max(surface.dx, surface.dy);
  SpectralChoice choice;
  choice.basis_tolerance = tol;
  choice.kernel_width = std::clamp(static_cast<int>(std::ceil(1.7 - 1.1 * std::log10(tol))), 3, kMostWidth);
  choice.subdivision = choose_subdivision(sample_slopes(surface), phase,
                                          std::min(1.0, grid.extent * std::numbers::sqrt2), tol);
  return choice;
}

struct SpectralSolver::Memory {
  DiskMemory<float> single;
  DiskMemory<double> twofold;
};

SpectralSolver::SpectralSolver(const DiskGrid& grid, double lambda_q, double tol)
    : grid_(grid), lambda_q_(lambda_q), tol_(tol), memory_(std::make_unique<Memory>()) {
  make_disk_table(grid);
  if (!(tol > 0 && tol < 1))
    throw InputError("the tolerance must lie between 0 and 1, not " + std::to_string(tol));
  wave_vector(Vec3(0, 0, 1), lambda_q);
}

SpectralSolver::~SpectralSolver() = default;

KirchhoffTable SpectralSolver::operator()(const HeightField& surface, std::uint64_t seed) {
  const Stopwatch watch;
  kirchhoff_area(surface);
  KirchhoffTable result;
  result.choice = choose_spectral(surface, grid_, lambda_q_, tol_);
  for (int attempt = 0; attempt <= kRefinements; ++attempt) {
    DiskDensity density = tol_ < kDoubleBelow
                              ? transform_disk(surface, grid_, lambda_q_, result.choice, memory_->twofold)
                              : transform_disk(surface, grid_, lambda_q_, result.choice, memory_->single);
    result.table = std::move(density.table);
    result.work = density.work;
    result.cost.evaluations += density.work.transforms;
    result.error = sample_error(surface, result.table, lambda_q_, tol_, kCheckedNodes, seed);
    result.reached = result.error.within(tol_);
    const SpectralChoice finer = refine(result.choice);
    if (result.reached || finer == result.choice || attempt == kRefinements) break;
    result.choice = finer;
  }
  result.cost.seconds = watch.seconds();
  return result;
}

KirchhoffTable spectral_table(const HeightField& surface, const DiskGrid& grid, double lambda_q, double tol) {
  return SpectralSolver(grid, lambda_q, tol)(surface);
}

}  // namespace micro
