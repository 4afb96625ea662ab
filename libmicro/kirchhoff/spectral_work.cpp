#include "kirchhoff/spectral_work.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <string>

#include "core/error.h"
#include "kirchhoff/disk_geometry.h"
#include "kirchhoff/spread.h"
#include "kirchhoff/surface_quadrature.h"

namespace micro {
namespace {

/// "some 7.3 minutes", "some 2.7 hours", "some 15 days".
std::string duration_text(double seconds) {
  constexpr double kMinute = 60, kHour = 60 * kMinute, kDay = 24 * kHour, kYear = 365 * kDay;
  std::ostringstream text;
  text << "some ";
  text.precision(2);
  if (seconds < kHour)
    text << seconds / kMinute << " minutes";
  else if (seconds < 3 * kDay)
    text << seconds / kHour << " hours";
  else if (seconds < kYear)
    text << static_cast<int>(seconds / kDay) << " days";
  else
    return "years";
  return text.str();
}

}  // namespace

double table_seconds(const SpectralWork& work, double nodes, const SpectralCosts& costs) {
  const double length = static_cast<double>(std::max<std::int64_t>(work.fft_length, 1));
  const double sums = costs.spread * work.spread +
                      costs.butterfly * static_cast<double>(work.transforms) * length * std::log2(length) +
                      costs.node * nodes * work.terms;
  return sums * (work.sums == Sums::Double ? costs.twofold : 1) + costs.table * work.tables +
         costs.recurrence * work.recurrences;
}

double spread_work(const HeightField& surface, const SpectralChoice& choice, std::int64_t grid_cols,
                   std::int64_t steep_points, int terms) {
  const int w = choice.kernel_width, refinement = 2 * choice.subdivision;
  const double padded = std::ceil(static_cast<double>(terms) / kTermLanes) * kTermLanes;
  const double rows = static_cast<double>(surface.rows() - 1) * refinement + 1,
               cols = static_cast<double>(surface.cols() - 1) * refinement + 1;
  // Every grid column of a lattice row is then spread along y.
  const double along_y = static_cast<double>(grid_cols) * w;
  return padded * (rows * (cols * lattice_point_work(w) + along_y) +
                   static_cast<double>(steep_points) * facet_point_work(w, std::max(padded, 1.)));
}

void check_work(const SpectralWork& work, double nodes, const HeightField& surface, double lambda_q) {
  constexpr double kMostSeconds = 300;  // of one core
  constexpr std::int64_t kMostSteepPoints = 10'000'000;
  const double seconds = table_seconds(work, nodes);
  if (seconds <= kMostSeconds && work.steep_points <= kMostSteepPoints) return;
  const double pitch = std::max(surface.dx, surface.dy), order = lambda_q / (2 * pitch);
  std::ostringstream text;
  text << "cliffs, spikes or a steep form would take ";
  if (seconds > kMostSeconds)
    text << duration_text(seconds) << " of a core";
  else
    text << work.steep_points << " points";
  text << " at an effective wavelength of " << lambda_q << " µm and a pitch of " << pitch
       << " µm: level them away, reject outliers, ";
  if (order < 1) text << "lower the extent towards " << order << ", where false orders begin, ";
  text << "or ask for a larger tolerance";
  throw InputError(text.str());
}

SpectralWork predict_work(const Window& window, const DiskGrid& grid, double lambda_q,
                          const SpectralChoice& choice) {
  const HeightField& surface = window.surface;
  const double radius = 4 * std::numbers::pi / lambda_q;
  const QuadratureLattice lattice(surface, choice.subdivision, window.taper, choice.steepest, choice.highest);
  BasisSize basis =
      expected_basis(height_histogram(surface), wave_range(radius, grid), choice.basis_tolerance);
  if (!lattice.complete()) ++basis.terms;
  return disk_work(make_disk_geometry(surface, grid, lambda_q, choice), surface, choice,
                   LeftOut(lattice, facet_phases(radius, grid, choice.basis_tolerance)).points(), basis);
}

}  // namespace micro
