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

/// What the subdivision depends on, `phase` = |q|·pitch.
struct Demands {
  double phase, sin_theta, rim, tol;
};

/// How finely triangles are cut. Three laws, the last two with constants measured against `exact`:
/// - facets whose phase turns by more than a whole period of the lattice, |q|·√(1 + slope²)·d >
/// 2π·subdivision, are
///   taken for gentler ones (they alias), so hardly any such facet may be left;
/// - the midpoint rule's error grows as the fourth power of the phase across a sub-triangle, and as slope³;
/// - along rims the in-plane phase alone counts: in the whole where rims are dense, and in the directions far
/// from the
///   peak (which have 30 times the tolerance) always.
int choose_subdivision(const Slopes& slopes, const Demands& d) {
  const double slope = slopes.rms() / std::sqrt(2.0);
  const double midpoint = 38 * 1.5e-4 * slope * slope * slope;
  const double rim = 1.7e-2 * d.rim * d.rim, far = 2e-3 * (1 + 3 * std::min(1.0, d.rim / 0.024));
  const double in_plane = std::max(2 * rim / d.tol, far / (25 * d.tol));
  const double finest =
      std::max(std::pow(3 * midpoint / d.tol, 0.25), d.sin_theta * std::pow(in_plane, 0.25));
  int subdivision = std::clamp(static_cast<int>(std::ceil(d.phase / 2.5 * finest)), 1, kMostSubdivision);
  const auto aliased = [&](int s) {
    const double turns = 2 * std::numbers::pi * s / d.phase;
    // In-plane phases alone must stay within half a period.
    if (turns < 2 * d.sin_theta) return 1.0;
    return turns > 1 ? slopes.fraction_above(std::sqrt(turns * turns - 1)) : 1.0;
  };
  // Cliffs are few and their light goes everywhere: beyond 4 the measured error decides.
  constexpr int kMost = 4096;
  while (subdivision < kMost && aliased(subdivision) > (subdivision < 4 ? 2 * d.tol : 0.1))
    ++subdivision;
  return subdivision;
}

/// Nodes whose exact values take some 15 % of a table's time: by operation counts, so that they are always
/// the same.
int checked_nodes(const HeightField& surface, const DiskGrid& grid, const SpectralChoice& choice,
                  const SpectralWork& work) {
  constexpr double kPoint = 1.0, kButterfly = 0.1, kNode = 10,
                   kCell = 20;  // ns: term and point; FFT; node; exact cell
  constexpr int kFewest = 3, kMost = 48;
  const double cells = static_cast<double>(surface.rows()) * static_cast<double>(surface.cols());
  const double length = static_cast<double>(work.fft_length),
               nodes = static_cast<double>(grid.size) * grid.size;
  const double points = cells * 4 * choice.subdivision * choice.subdivision * work.terms;
  const double table = kPoint * points +
                       kButterfly * static_cast<double>(work.transforms) * length * std::log2(length) +
                       kNode * nodes;
  return std::clamp(static_cast<int>(0.15 * table / (kCell * cells)), kFewest, kMost);
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
  const double sin_theta = std::min(1.0, grid.extent * std::numbers::sqrt2);
  SpectralChoice choice;
  choice.basis_tolerance = 0.6 * tol;
  choice.kernel_width = std::clamp(static_cast<int>(std::ceil(1.7 - 1.1 * std::log10(tol))), 3, kMostWidth);
  choice.subdivision =
      choose_subdivision(sample_slopes(surface), {phase, sin_theta, rim_fraction(surface), tol});
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
    const int nodes = checked_nodes(surface, grid_, result.choice, density.work);
    result.error = sample_error(surface, result.table, lambda_q_, tol_, nodes, seed);
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
