#include "kirchhoff/spectral.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "core/error.h"
#include "kirchhoff/kirchhoff.h"
#include "kirchhoff/subdivision.h"

namespace micro {
namespace {

/// Below this tolerance sums are kept in double: single precision leaves some 1e-6 of the peak of |F|.
constexpr double kDoubleBelow = 3e-5;
constexpr int kMostWidth = 14;
/// Refinements before the error is taken for what it is.
constexpr int kRefinements = 3;

}  // namespace

bool sums_in_double(double tol) {
  return tol < kDoubleBelow;
}

int checked_nodes(const HeightField& surface, const DiskGrid& grid, const SpectralWork& work) {
  constexpr double kCell = 20e-9;  // seconds of an exact node on one core
  constexpr int kFewest = 12, kMost = 48;
  const double cells = static_cast<double>(surface.rows()) * static_cast<double>(surface.cols());
  const double table = table_seconds(work, static_cast<double>(grid.size) * grid.size);
  return static_cast<int>(std::clamp<double>(0.15 * table / (kCell * cells), kFewest, kMost));
}

SpectralChoice refine(SpectralChoice choice, double excess) {
  const double finer = choice.subdivision * std::clamp(std::pow(2 * excess, 0.25), 1.25, 2.0);
  choice.basis_tolerance = std::max(choice.basis_tolerance / 4, 1e-8);
  choice.subdivision =
      std::max(choice.subdivision, std::min(static_cast<int>(std::ceil(finer)), kMostSubdivision));
  choice.kernel_width = std::min(choice.kernel_width + 2, kMostWidth);
  return choice;
}

SpectralChoice choose_spectral(const HeightField& surface, const DiskGrid& grid, double lambda_q,
                               double tol) {
  const double phase = 4 * std::numbers::pi / lambda_q * std::max(surface.dx, surface.dy);
  const double sin_theta = grid.outermost_sine();
  SpectralChoice choice;
  choice.basis_tolerance = 0.6 * tol;
  choice.kernel_width = std::clamp(static_cast<int>(std::ceil(1.7 - 1.1 * std::log10(tol))), 3, kMostWidth);
  const Subdivision subdivision = choose_subdivision(surface, {phase, sin_theta, tol, choice.kernel_width});
  choice.subdivision = subdivision.n;
  choice.steepest = subdivision.steepest;
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
  return (*this)(Window{surface, {}}, seed);
}

KirchhoffTable SpectralSolver::operator()(const Window& window, std::uint64_t seed) {
  const Stopwatch watch;
  const HeightField& surface = window.surface;
  kirchhoff_area(surface);
  KirchhoffTable result;
  result.choice = choose_spectral(surface, grid_, lambda_q_, tol_);
  for (int attempt = 0; attempt <= kRefinements; ++attempt) {
    DiskDensity density = sums_in_double(tol_)
                              ? transform_disk(window, grid_, lambda_q_, result.choice, memory_->twofold)
                              : transform_disk(window, grid_, lambda_q_, result.choice, memory_->single);
    result.table = std::move(density.table);
    result.work = density.work;
    result.cost.evaluations += density.work.transforms;
    const int nodes = checked_nodes(surface, grid_, density.work);
    result.error = sample_error(window, result.table, lambda_q_, tol_, nodes, seed);
    result.reached = result.error.within(tol_);
    // A dozen nodes know the error to some 30 %.
    constexpr double kMargin = 0.8;
    const double excess = std::max(result.error.error(), result.error.error_core_free()) / tol_;
    const SpectralChoice finer = refine(result.choice, excess);
    // What takes long is not tried again: `reached` tells.
    constexpr double kMostSeconds = 30;  // of one core
    SpectralWork again = density.work;
    again.spread *= std::pow(static_cast<double>(finer.subdivision) / result.choice.subdivision, 2);
    if (table_seconds(again, static_cast<double>(grid_.size) * grid_.size) > kMostSeconds) break;
    if ((result.reached && excess <= kMargin) || finer == result.choice || attempt == kRefinements) break;
    result.choice = finer;
  }
  result.cost.seconds = watch.seconds();
  return result;
}

KirchhoffTable spectral_table(const HeightField& surface, const DiskGrid& grid, double lambda_q, double tol) {
  return SpectralSolver(grid, lambda_q, tol)(surface);
}

}  // namespace micro
