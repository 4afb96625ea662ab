#pragma once

#include <cstdint>
#include <limits>

#include "distribution/disk_table.h"
#include "height/height_field.h"
#include "kirchhoff/coherence.h"

namespace micro {

/// What sums and transforms are kept in.
enum class Sums { Single, Double };

/// How finely a table is computed. Every one of them only trades time for error.
struct SpectralChoice {
  double basis_tolerance = 1e-3;  ///< of ψ's expansion, relative: see height_basis.h
  int subdivision = 1;            ///< of the triangles (quadrature_lattice.h) …
  /// … but for those of a greater slope (steep_facets.h).
  double steepest = std::numeric_limits<double>::infinity();
  double highest = std::numeric_limits<double>::infinity();  ///< µm: edges of the rim of a greater rise, too
  int kernel_width = 6;                                      ///< of gridding, in grid points
  double oversampling = 1.25;                                ///< of the transform over the table, at least
  Sums sums = Sums::Single;
  bool operator==(const SpectralChoice&) const = default;
};

/// What it took.
struct SpectralWork {
  int terms = 0;  ///< real images
  std::int64_t fft_length = 0;
  std::int64_t transforms = 0;    ///< complex transforms of fft_length numbers, rows and columns
  std::int64_t bytes = 0;         ///< of memory held at most, without the table
  double spread = 0;              ///< multiply-adds that take the sources to the grid, about
  std::int64_t steep_points = 0;  ///< on facets and edges that the lattice leaves out
  double tables = 0;              ///< multiply-adds that make tables of φ_k and c_k (term_tables.h)
  double recurrences = 0;         ///< steps of those that give c_k(q_z) of great heights (height_basis.h)
  Sums sums = Sums::Single;
};

/// Seconds on one thread of an AVX2 core at 2.4 GHz. bench/kirchhoff_costs_bench measures the first three
/// again; the others are from spikes of 10 µm to 1 mm.
struct SpectralCosts {
  double spread = 0.1e-9;     ///< one multiply-add of spreading
  double butterfly = 0.1e-9;  ///< of a transform of n numbers, n·log2(n) of them
  double node = 1e-9;         ///< one term at one node of the table
  double table = 0.1e-9;      ///< one multiply-add of tables
  double recurrence = 3e-9;   ///< one step
  double twofold = 2;         ///< spreading, transforms and nodes in double over those in single precision
};

/// Seconds that a table of so many nodes takes, about.
double table_seconds(const SpectralWork& work, double nodes, const SpectralCosts& costs = {});

/// Multiply-adds a term that spreading takes with a kernel of width w: a lattice point is spread along x, and
/// takes four for φ_k; a point of a steep facet is spread onto all of its neighbours, and its place and its
/// kernel are worked out once for all `terms`.
constexpr double lattice_point_work(int w) {
  return 0.75 * (w + 4);
}
constexpr double facet_point_work(int w, double terms) {
  constexpr double kPlace = 1000;  // some 0.1 µs
  return w * w + 4 + kPlace / terms;
}

/// Multiply-adds that take so many terms of all sources onto a grid of so many columns.
double spread_work(const HeightField& surface, const SpectralChoice& choice, std::int64_t grid_cols,
                   std::int64_t steep_points, int terms);

/// Throws InputError if a table of so many nodes would take many minutes, or its steep facets' points more
/// than a gigabyte; says how far out the table may go instead.
void check_work(const SpectralWork& work, double nodes, const HeightField& surface, double lambda_q);

/// What a table will take, without computing it; `bytes` are left out, and the terms are what the ranges of
/// heights and of q_z suggest (expected_basis).
SpectralWork predict_work(const Window& window, const DiskGrid& grid, double lambda_q,
                          const SpectralChoice& choice);

}  // namespace micro
