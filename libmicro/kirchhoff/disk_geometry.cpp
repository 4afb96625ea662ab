#include "kirchhoff/disk_geometry.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kirchhoff/combine.h"

namespace micro {
namespace {

/// Lengths whose transforms are fast: 2^a·{1, 3, 5, 9, 15}, a ≥ 4.
std::int64_t transform_length(std::int64_t n) {
  std::int64_t best = 16;
  while (best < n)
    best *= 2;
  for (const std::int64_t odd : {3, 5, 9, 15}) {
    std::int64_t length = 16 * odd;
    while (length < n)
      length *= 2;
    best = std::min(best, length);
  }
  return best;
}

}  // namespace

DiskGeometry make_disk_geometry(const HeightField& surface, const DiskGrid& grid, double lambda_q,
                                const SpectralChoice& choice) {
  DiskGeometry g{};
  const double radius = 4 * std::numbers::pi / lambda_q;
  g.sphere = radius * radius;
  g.step = radius * grid.spacing();
  g.half = (grid.size - 1) / 2;
  // A hair below 1.25 is as good: 1280 for 1025.
  const auto wanted = static_cast<std::int64_t>(std::ceil(grid.size * choice.oversampling * 0.999));
  g.length = transform_length(std::max<std::int64_t>(wanted, grid.size + 2 * kColumnPadding));
  g.pitch = 2 * std::numbers::pi / g.step / static_cast<double>(g.length);
  const double reach = choice.kernel_width / 2.0;
  const auto last = [&](double extent) {
    return static_cast<std::int64_t>(std::floor(extent / g.pitch + reach)) + 1;
  };
  g.x_begin = g.y_begin = static_cast<std::int64_t>(std::ceil(-reach));
  g.x_end = last(static_cast<double>(surface.cols() - 1) * surface.dx);
  g.y_end = last(static_cast<double>(surface.rows() - 1) * surface.dy);
  return g;
}

WaveRange wave_range(double radius, const DiskGrid& grid) {
  const double sine = grid.outermost_sine();
  return {radius * std::sqrt(1 - sine * sine), radius};
}

FacetPhases facet_phases(double radius, const DiskGrid& grid, double basis_tolerance) {
  return {radius, grid.outermost_sine(), std::clamp(basis_tolerance / 60, 1e-9, 1e-5)};
}

double distances(const DiskGeometry& g) {
  const double squares = 2 * std::pow(g.half, 2), on_disk = std::floor(g.sphere / (g.step * g.step));
  return std::min(squares, on_disk) + 2;
}

TermTables disk_tables(const DiskGeometry& g, double phase_reach, double tolerance) {
  // Straight lines between the most entries err by 2e-6 for heights of ±50 µm.
  constexpr double kMostEntries = 1 << 18;
  const double lines = std::min(coefficient_entries(phase_reach, tolerance), kMostEntries);
  return {function_entries(phase_reach), static_cast<std::int64_t>(std::min(lines, distances(g)))};
}

int disk_pass(const DiskGeometry& g, const TermTables& tables, Sums sums) {
  constexpr std::int64_t kSpectraBytes = std::int64_t{1} << 27;
  const std::int64_t bytes = sums == Sums::Double ? 8 : 4;
  return terms_of_a_pass((2 * g.half + 1) * g.padded_rows() * bytes, table_bytes(tables, bytes),
                         kSpectraBytes);
}

SpectralWork disk_work(const DiskGeometry& g, const HeightField& surface, const SpectralChoice& choice,
                       std::int64_t steep_points, const BasisSize& basis) {
  const int terms = basis.terms;
  const TermTables tables = disk_tables(g, basis.phase_reach, choice.basis_tolerance);
  SpectralWork work;
  work.terms = terms;
  work.fft_length = g.length;
  work.transforms = (std::int64_t{terms} + 1) / 2 * (g.rows() + 2 * g.half + 1);
  work.steep_points = steep_points;
  work.spread = spread_work(surface, choice, g.x_end - g.x_begin, steep_points, terms);
  work.tables = table_work(basis, tables);
  // Every pass starts them again.
  if (!basis.orthonormal())
    work.recurrences = std::ceil(static_cast<double>(terms) / disk_pass(g, tables, choice.sums)) * terms *
                       static_cast<double>(tables.coefficients);
  work.sums = choice.sums;
  return work;
}

}  // namespace micro
