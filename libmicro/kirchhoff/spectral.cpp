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

/// Below this tolerance sums are kept in double: single precision leaves some 1e-6 of what |F| would be if
/// all of the surface shone in one direction.
constexpr double kDoubleBelow = 3e-5;
constexpr int kMostWidth = 14;
/// Refinements before the error is taken for what it is.
constexpr int kRefinements = 3;

/// The relative L2 error of D that rounding in single precision leaves, about: δ of the field F changes |F|²
/// by 2|F|δ, which adds up to δ·√(ΣD/ΣD²) in units of D = |F|²/(4π²A).
double rounding_error(const DiskTable& table, const Window& window, double lambda_q) {
  constexpr double kOfBrightest = 1e-7;
  const double area = effective_area(window), brightest = 4 * std::numbers::pi / lambda_q * area;
  const double dark = std::sqrt(table.density.sum() / table.density.square().sum());
  return 2 * kOfBrightest * std::sqrt(kirchhoff_density(brightest, area)) * dark;
}

}  // namespace

int checked_nodes(const HeightField& surface, const DiskGrid& grid, const SpectralWork& work) {
  constexpr double kCell = 20e-9;  // seconds of an exact node on one core
  constexpr int kFewest = 12, kMost = 48, kMostOnSmall = 400;
  constexpr double kSmall = 3e-3;  // seconds that small surfaces may take in any case
  const double cells = static_cast<double>(surface.rows()) * static_cast<double>(surface.cols());
  const double table = table_seconds(work, static_cast<double>(grid.size) * grid.size), node = kCell * cells;
  const double nodes = std::clamp<double>(0.15 * table / node, kFewest, kMost);
  return static_cast<int>(std::max(nodes, std::min<double>(kSmall / node, kMostOnSmall)));
}

SpectralChoice refine(SpectralChoice choice, double excess) {
  const double finer = choice.subdivision * std::clamp(std::pow(2 * excess, 0.25), 1.25, 2.0);
  if (choice.subdivision >= kMostSubdivision) choice.steepest = choice.highest = 0;
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
  if (tol < kDoubleBelow) choice.sums = Sums::Double;
  choice.kernel_width = std::clamp(static_cast<int>(std::ceil(1.7 - 1.1 * std::log10(tol))), 3, kMostWidth);
  const Subdivision subdivision = choose_subdivision(surface, {phase, sin_theta, tol, choice.kernel_width});
  choice.subdivision = subdivision.n;
  choice.steepest = subdivision.steepest;
  // Simpson's rule of steps of δ rad errs by δ⁴/180 of the edge.
  const double step = std::pow(90 * tol, 0.25), q = 4 * std::numbers::pi / lambda_q;
  choice.highest = step * 2 * subdivision.n / q;
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
    DiskDensity density = result.choice.sums == Sums::Double
                              ? transform_disk(window, grid_, lambda_q_, result.choice, memory_->twofold)
                              : transform_disk(window, grid_, lambda_q_, result.choice, memory_->single);
    result.table = std::move(density.table);
    result.work = density.work;
    result.cost.evaluations += density.work.transforms;
    const int nodes = checked_nodes(surface, grid_, density.work);
    result.error = sample_error(window, grid_, result.table.density, lambda_q_, tol_, nodes, seed);
    result.reached = result.error.within(tol_);
    // A dozen nodes know the error to some 30 %.
    constexpr double kMargin = 0.8;
    const double excess = std::max(result.error.error(), result.error.error_core_free()) / tol_;
    SpectralChoice finer = refine(result.choice, excess);
    if (attempt > 0 || rounding_error(result.table, window, lambda_q_) > tol_ / 4) finer.sums = Sums::Double;
    if ((result.reached && excess <= kMargin) || finer == result.choice || attempt == kRefinements) break;
    // What takes long is not tried again: `reached` tells.
    constexpr double kMostSeconds = 30;  // of one core
    const SpectralWork again = predict_work(window, grid_, lambda_q_, finer);
    if (table_seconds(again, static_cast<double>(grid_.size) * grid_.size) > kMostSeconds) break;
    result.choice = finer;
  }
  result.cost.seconds = watch.seconds();
  return result;
}

KirchhoffTable spectral_table(const HeightField& surface, const DiskGrid& grid, double lambda_q, double tol) {
  return SpectralSolver(grid, lambda_q, tol)(surface);
}

}  // namespace micro
