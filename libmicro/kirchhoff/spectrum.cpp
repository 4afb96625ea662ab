#include "kirchhoff/spectrum.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <string>

#include "core/error.h"
#include "kirchhoff/kirchhoff.h"
#include "kirchhoff/spectrum_transform.h"

namespace micro {
namespace {

/// Refinements before the error is taken for what it is.
constexpr int kRefinements = 3;
/// Nodes on which each table is compared with `exact`, and more of them where these look bad: on the scans of
/// a profilometer an exact value takes 1/10 of a table's time, on small ones next to nothing.
constexpr int kFewestNodes = 4, kMostNodes = 48, kSecondLook = 16;
constexpr double kCells = 1e6;
/// Room for two draws of each of many wavelengths.
constexpr std::uint64_t kSeedsPerScan = 8192;

/// The error of one table.
ErrorSample measure(const Window& window, const DiskGrid& grid, const Grid<float>& table, double lambda_q,
                    double tol, std::uint64_t seed) {
  const double cells =
      static_cast<double>(window.surface.rows()) * static_cast<double>(window.surface.cols());
  const int nodes = static_cast<int>(std::clamp<double>(kCells / cells, kFewestNodes, kMostNodes));
  ErrorSample sample = sample_error(window, grid, table, lambda_q, tol, nodes, seed);
  if (!sample.within(tol)) sample += sample_error(window, grid, table, lambda_q, tol, kSecondLook, seed + 1);
  return sample;
}

}  // namespace

struct SpectrumSolver::Memory {
  SpectrumMemory<float> single;
  SpectrumMemory<double> twofold;
};

SpectrumSolver::SpectrumSolver(const DiskGrid& grid, std::vector<double> lambda_q, double tol,
                               std::int64_t most_bytes)
    : grid_(grid),
      lambda_q_(std::move(lambda_q)),
      tol_(tol),
      most_bytes_(most_bytes),
      memory_(std::make_unique<Memory>()) {
  make_disk_table(grid);
  if (!(tol > 0 && tol < 1))
    throw InputError("the tolerance must lie between 0 and 1, not " + std::to_string(tol));
  if (lambda_q_.empty()) throw InputError("a spectrum needs a wavelength");
  for (const double lambda : lambda_q_)
    wave_vector(Vec3(0, 0, 1), lambda);
  if (std::adjacent_find(lambda_q_.begin(), lambda_q_.end(), std::greater_equal<>()) != lambda_q_.end())
    throw InputError("a spectrum's wavelengths must ascend");
}

SpectrumSolver::~SpectrumSolver() = default;
SpectrumSolver::SpectrumSolver(SpectrumSolver&&) noexcept = default;

KirchhoffSpectrum SpectrumSolver::operator()(const HeightField& surface, std::uint64_t seed) {
  const Stopwatch watch;
  kirchhoff_area(surface);
  const SpectralChoice choice = choose_spectral(surface, grid_, lambda_q_.front(), tol_);
  KirchhoffSpectrum result = least_spectra_bytes(surface, grid_, lambda_q_.front(), choice) > most_bytes_
                                 ? one_by_one(surface, seed)
                                 : together(surface, choice, seed);
  result.cost.seconds = watch.seconds();
  return result;
}

KirchhoffSpectrum SpectrumSolver::together(const HeightField& surface, SpectralChoice choice,
                                           std::uint64_t seed) {
  KirchhoffSpectrum result;
  result.choice = choice;
  const Window whole{surface, {}};
  result.tables.resize(lambda_q_.size());
  std::vector<std::size_t> left(lambda_q_.size());
  std::iota(left.begin(), left.end(), std::size_t{0});
  for (int attempt = 0; !left.empty() && attempt <= kRefinements; ++attempt) {
    std::vector<double> lambda_q;
    for (const std::size_t k : left)
      lambda_q.push_back(lambda_q_[k]);
    SpectrumDensity density = choice.sums == Sums::Double
                                  ? transform_spectrum(surface, grid_, lambda_q, choice, memory_->twofold)
                                  : transform_spectrum(surface, grid_, lambda_q, choice, memory_->single);
    if (attempt == 0) result.work = density.work;
    result.cost.evaluations += density.work.transforms;
    std::vector<std::size_t> missed;
    double excess = 1;
    for (std::size_t n = 0; n < left.size(); ++n) {
      SpectrumTable& table = result.tables[left[n]];
      table.density = std::move(density.tables[n]);
      table.error =
          measure(whole, grid_, table.density, lambda_q[n], tol_, seed * kSeedsPerScan + 2 * left[n]);
      table.reached = table.error.within(tol_);
      if (table.reached) continue;
      missed.push_back(left[n]);
      excess = std::max({excess, table.error.error() / tol_, table.error.error_core_free() / tol_});
    }
    left = std::move(missed);
    SpectralChoice finer = refine(choice, excess);
    finer.sums = Sums::Double;  // rounding may be what is left
    if (finer == choice) break;
    choice = finer;
  }
  return result;
}

KirchhoffSpectrum SpectrumSolver::one_by_one(const HeightField& surface, std::uint64_t seed) const {
  KirchhoffSpectrum result;
  result.shared = false;
  for (std::size_t k = 0; k < lambda_q_.size(); ++k) {
    const KirchhoffTable one =
        SpectralSolver(grid_, lambda_q_[k], tol_)(surface, seed * kSeedsPerScan + 2 * k);
    result.tables.push_back({one.table.density.cast<float>(), one.error, one.reached});
    if (k == 0) result.choice = one.choice;
    if (k == 0) result.work = one.work;
    result.cost.evaluations += one.cost.evaluations;
  }
  return result;
}

}  // namespace micro
