#include "kirchhoff/spectrum_transform.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cassert>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

#include "core/large_pages.h"
#include "core/parallel.h"
#include "kirchhoff/disk_geometry.h"
#include "kirchhoff/kirchhoff.h"
#include "kirchhoff/sphere_nodes.h"
#include "kirchhoff/term_tables.h"

namespace micro {
namespace {

using std::numbers::pi;

/// Bytes of spectra along x that are held at once, and the fewest terms of one pass (term_tables.h).
constexpr std::int64_t kSpectraBytes = std::int64_t{1} << 28, kFewestTerms = 8;
/// Bytes of partial sums that are held at once where there is more than one pass: decides how many
/// wavelengths go together.
constexpr std::int64_t kFieldBytes = std::int64_t{1} << 29;
/// Transform length over points: each wave number's neighbours are a third closer than the patch asks.
constexpr double kOversampling = 1.5;
/// Columns and rows of wave numbers of one tile, so that it stays in the caches; nodes along x of one.
constexpr std::int64_t kTileColumns = 24, kTileRows = 24;
constexpr int kTileNodes = 32;

/// The grids of wave numbers that serve all |q| up to that of the shortest wavelength.
struct Axes {
  SpectrumAxis x, y;
};

/// All that belongs to one wavelength.
template <typename Real>
struct Sphere {
  std::size_t index;                     ///< of the wavelength
  double radius, spacing;                ///< |q| and the nodes' distance, rad/µm
  NodeStencils<Real> x, y;               ///< of k_x = 0 … c and k_y = −c … c
  std::vector<double> plate_x, plate_y;  ///< ∫e^{−iqx}dx over the surface's sides about its middle, where
                                         ///< no triangle is missing
  Grid<float> density;
  FftVector<Real> field;  ///< [k_x, k_y, 4] partial sums (sphere_nodes.h) between passes, or none
};

/// ∫e^{−iqx}dx over [−side/2, side/2].
double plate_spectrum(double q, double side) {
  const double half = q * side / 2;
  return side * (std::abs(half) < 1e-8 ? 1 : std::sin(half) / half);
}

template <typename Real>
Sphere<Real> make_sphere(std::size_t index, double lambda_q, const DiskGrid& grid, const Axes& axes) {
  Sphere<Real> sphere{};
  sphere.index = index;
  sphere.radius = 4 * pi / lambda_q;
  sphere.spacing = sphere.radius * grid.spacing();
  const int half = (grid.size - 1) / 2;
  sphere.x = make_node_stencils<Real>(axes.x, sphere.spacing, 0, half);
  sphere.y = make_node_stencils<Real>(axes.y, sphere.spacing, -half, half);
  sphere.density.resize(grid.size, grid.size);
  prefer_large_pages(sphere.density.data(), sizeof(float) * static_cast<std::size_t>(sphere.density.size()));
  sphere.density.setZero();
  return sphere;
}

template <typename Real>
void make_plates(const Axes& axes, Sphere<Real>& sphere) {
  for (std::size_t k = 0; k < sphere.x.start.size(); ++k) {
    const double q = sphere.spacing * static_cast<double>(k);
    sphere.plate_x.push_back(plate_spectrum(q, axes.x.side));
    sphere.plate_y.push_back(plate_spectrum(q, axes.y.side));
  }
}

/// Tables for all wavelengths; densities are float in the end.
TermTables make_tables(double phase_reach, double tolerance) {
  constexpr double kFinest = 1e-8, kMost = 1e9;
  const double entries = std::min(coefficient_entries(phase_reach, std::max(tolerance, kFinest)), kMost);
  return {function_entries(phase_reach), static_cast<std::int64_t>(entries)};
}

template <typename Real>
TermCoefficients<Real> make_coefficients(const NestedTerms& terms, double phase_reach, const WaveRange& q,
                                         const TermBatch& batch, double tolerance) {
  TermCoefficients<Real> table;
  table.entries = static_cast<int>(make_tables(phase_reach, tolerance).coefficients);
  table.low = q.low;
  table.per_q = (table.entries - 1) / std::max(q.high - q.low, 1e-9 * q.high);
  table.padded = (batch.terms() + kTermLanes - 1) / kTermLanes * kTermLanes;
  table.data.assign(static_cast<std::size_t>(table.entries) * 2 * table.padded, 0);
  const Grid<std::complex<double>> c = terms.coefficients(table.entries, batch.first, batch.count);
  const int skipped = batch.with_area ? 1 : 0;
  parallel_blocks(table.entries, kEntryBlock, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t e = begin; e < end; ++e) {
      Real* at = table.data.data() + e * 2 * table.padded;
      for (int k = 0; k < batch.count; ++k) {
        at[skipped + k] = static_cast<Real>(c(e, k).real());
        at[table.padded + skipped + k] = static_cast<Real>(c(e, k).imag());
      }
      if (batch.with_area) at[0] = static_cast<Real>(q.low + static_cast<double>(e) / table.per_q);
    }
  });
  return table;
}

std::vector<TermBatch> make_batches(int terms, bool with_area, int most) {
  std::vector<TermBatch> batches;
  bool area = with_area;
  for (int first = 0; first < terms || batches.empty();) {
    const int count = std::min(most - (area ? 1 : 0), terms - first);
    batches.push_back({first, count, area});
    first += count;
    area = false;
  }
  return batches;
}

/// One pass: the terms of a batch on all spheres of a group.
template <typename Real>
class Pass {
 public:
  Pass(const DiskGrid& grid, const NestedTerms& terms, const TermBatch& batch,
       const TermCoefficients<Real>& coefficients, const TermSpectra<Real>& spectra, const SpectrumAxis& y)
      : grid_(grid),
        half_((grid.size - 1) / 2),
        terms_(terms),
        batch_(batch),
        coefficients_(coefficients),
        spectra_(spectra),
        y_(y) {}

  /// Calls flush(tile, memory, sphere) for each tile of each sphere.
  template <typename Flush>
  void operator()(std::vector<Sphere<Real>>& spheres, const Flush& flush) const {
    std::int32_t first = spheres.front().x.start.front(), last = spheres.front().x.start.back() + 1,
                 last_row = spheres.front().y.start.back() + 1;
    for (const Sphere<Real>& sphere : spheres) {
      first = std::min(first, sphere.x.start.front());
      last = std::max(last, sphere.x.start.back() + 1);
      last_row = std::max(last_row, sphere.y.start.back() + 1);
    }
    const std::int32_t first_row = -static_cast<std::int32_t>(y_.reach);
    // Workers rather than blocks in parallel: each keeps its memory from one to the next.
    std::atomic<std::int64_t> next = first;
    parallel_for(thread_count(), [&](std::int64_t) {
      TermColumns<Real> columns;
      TileMemory<Real> memory;
      for (std::int64_t begin; (begin = next.fetch_add(kTileColumns)) < last;) {
        const std::int64_t end = std::min<std::int64_t>(begin + kTileColumns, last);
        spectra_.columns(begin, end - begin + spheres.front().x.width - 1, columns);
        for (std::int64_t row = first_row; row < last_row; row += kTileRows)
          for (Sphere<Real>& sphere : spheres)
            visit(sphere, columns, begin, end, row, row + kTileRows, memory, flush);
      }
    });
  }

 private:
  template <typename Flush>
  void visit(Sphere<Real>& sphere, const TermColumns<Real>& columns, std::int64_t x0, std::int64_t x1,
             std::int64_t y0, std::int64_t y1, TileMemory<Real>& memory, const Flush& flush) const {
    const auto within = [](const std::vector<std::int32_t>& start, std::int64_t from, std::int64_t to) {
      return std::pair(static_cast<int>(std::lower_bound(start.begin(), start.end(), from) - start.begin()),
                       static_cast<int>(std::lower_bound(start.begin(), start.end(), to) - start.begin()));
    };
    const auto [kx_begin, kx_end] = within(sphere.x.start, x0, x1);
    const auto [row_begin, row_end] = within(sphere.y.start, y0, y1);
    if (row_begin == row_end) return;
    std::vector<Real> scale(static_cast<std::size_t>(columns.padded),
                            static_cast<Real>(sphere.radius * sphere.radius));
    if (batch_.with_area) scale[0] = 1;
    SphereTile<Real> tile{};
    tile.columns = &columns;
    tile.coefficients = &coefficients_;
    tile.scale = scale.data();
    tile.x = &sphere.x;
    tile.y = &sphere.y;
    tile.y_reach = y_.reach;
    tile.sphere = sphere.radius * sphere.radius;
    tile.spacing = sphere.spacing;
    tile.half = half_;
    tile.ky_begin = row_begin - half_;
    tile.ky_end = row_end - half_;
    for (int kx = kx_begin; kx < kx_end; kx += kTileNodes) {
      tile.kx_begin = kx;
      tile.kx_end = std::min(kx_end, kx + kTileNodes);
      const int ky = tile.ky_begin > 0 ? tile.ky_begin : tile.ky_end <= 0 ? tile.ky_end - 1 : 0;
      const double nearest = std::hypot(kx, ky) * sphere.spacing;
      if (!(nearest < sphere.radius)) continue;
      tile.terms = terms_in(std::sqrt(tile.sphere - nearest * nearest));
      evaluate_tile(tile, memory);
      flush(tile, memory, sphere);
    }
  }

  /// Terms of the batch that q_z takes, padded.
  int terms_in(double qz) const {
    const int count =
        std::clamp(terms_.needed(qz) - batch_.first, 0, batch_.count) + (batch_.with_area ? 1 : 0);
    return (count + kTermLanes - 1) / kTermLanes * kTermLanes;
  }

  const DiskGrid& grid_;
  int half_;
  const NestedTerms& terms_;
  const TermBatch& batch_;
  const TermCoefficients<Real>& coefficients_;
  const TermSpectra<Real>& spectra_;
  const SpectrumAxis& y_;
};

/// Adds a tile to the partial sums of its sphere.
template <typename Real>
void add_tile(const SphereTile<Real>& tile, TileMemory<Real>& memory, Sphere<Real>& sphere) {
  const int nodes = tile.ky_end - tile.ky_begin, size = 2 * tile.half + 1;
  for (int kx = tile.kx_begin; kx < tile.kx_end; ++kx) {
    const Real* from = &memory.field[static_cast<std::size_t>(kx - tile.kx_begin) * nodes * 4];
    Real* to = &sphere.field[(static_cast<std::size_t>(kx) * size + tile.ky_begin + tile.half) * 4];
    for (int n = 0; n < 4 * nodes; ++n)
      to[n] += from[n];
  }
}

/// The nodes of a quarter of the disk.
struct DiskQuarter {
  explicit DiskQuarter(const DiskGrid& grid) {
    const int half = (grid.size - 1) / 2;
    for (int k = 0; k <= half; ++k) {
      int nodes = 0;
      while (nodes <= half && grid.mz2(half + k, half + nodes) > 0)
        ++nodes;
      inside.push_back(nodes);
      squares.push_back(grid.coordinate(half + k) * grid.coordinate(half + k));
    }
  }
  std::vector<int> inside;      ///< of row k ≥ 0, those of k_x = 0 … inside−1
  std::vector<double> squares;  ///< m_x² of column k ≥ 0, m_y² of row k
};

/// Adds q_z·I[1] of a complete rectangle to a row of sums [nodes, 4] of F(q) and F(q').
template <typename Real>
void add_plate(const Sphere<Real>& sphere, const DiskQuarter& quarter, int ky, int kx_begin, int kx_end,
               double* sums) {
  const auto row = static_cast<std::size_t>(std::abs(ky));
  const double along_y = sphere.radius * sphere.plate_y[row], rest = 1 - quarter.squares[row];
  for (auto kx = static_cast<std::size_t>(kx_begin); kx < static_cast<std::size_t>(kx_end); ++kx, sums += 4) {
    const double add = along_y * sphere.plate_x[kx] * std::sqrt(rest - quarter.squares[kx]);
    sums[0] += add;
    sums[2] += add;
  }
}

/// Writes a tile's densities.
template <typename Real>
void write_tile(const SphereTile<Real>& tile, const TileMemory<Real>& memory, const DiskQuarter& quarter,
                double to_density, Sphere<Real>& sphere) {
  const int nodes = tile.ky_end - tile.ky_begin, half = tile.half, size = 2 * half + 1;
  std::array<double, 4 * kTileNodes> sums;
  for (int ky = tile.ky_begin; ky < tile.ky_end; ++ky) {
    const int end = std::min(tile.kx_end, quarter.inside[static_cast<std::size_t>(std::abs(ky))]);
    const Real* at = &memory.field[static_cast<std::size_t>(ky - tile.ky_begin) * 4];
    double* sum = sums.data();
    for (int kx = tile.kx_begin; kx < end; ++kx, at += 4 * nodes, sum += 4)
      std::copy_n(at, 4, sum);
    if (!sphere.field.empty()) {
      sum = sums.data();
      for (int kx = tile.kx_begin; kx < end; ++kx, sum += 4) {
        const Real* earlier = &sphere.field[(static_cast<std::size_t>(kx) * size + ky + half) * 4];
        for (int n = 0; n < 4; ++n)
          sum[n] += static_cast<double>(earlier[n]);
      }
    }
    if (!sphere.plate_x.empty()) add_plate(sphere, quarter, ky, tile.kx_begin, end, sums.data());
    float* up = &sphere.density(half + ky, half);
    float* down = &sphere.density(half - ky, half);
    sum = sums.data();
    for (int kx = tile.kx_begin; kx < end; ++kx, sum += 4) {
      up[kx] = static_cast<float>(to_density * (sum[0] * sum[0] + sum[1] * sum[1]));
      down[-kx] = static_cast<float>(to_density * (sum[2] * sum[2] + sum[3] * sum[3]));
    }
  }
}

Axes make_axes(const HeightField& surface, const DiskGrid& grid, double shortest,
               const SpectralChoice& choice) {
  // A neighbour more than gridding takes: the image fills all of what interpolation can tell apart.
  const SpectrumLayout layout = {4 * pi / shortest * grid.extent, choice.kernel_width,
                                 choice.kernel_width + 1, kOversampling};
  return {make_spectrum_axis(static_cast<double>(surface.cols() - 1) * surface.dx, layout),
          make_spectrum_axis(static_cast<double>(surface.rows() - 1) * surface.dy, layout)};
}

/// How terms and wavelengths are divided into passes.
struct Passes {
  std::int64_t term_tables;  ///< bytes of one term's tables while they are made
  std::int64_t field;        ///< bytes of one wavelength's partial sums
  int terms;                 ///< of one pass
  std::size_t wavelengths;   ///< of one pass
  TermTables tables;
};

template <typename Real>
Passes plan_passes(const HeightBasis& basis, bool complete, std::size_t wavelengths, const DiskGrid& grid,
                   const Axes& axes, double tolerance) {
  Passes passes{};
  passes.tables = make_tables(basis.phase_reach(), tolerance);
  passes.term_tables = table_bytes(passes.tables, sizeof(Real));
  passes.field = std::int64_t{(grid.size + 1) / 2} * grid.size * 4 * std::int64_t{sizeof(Real)};
  passes.terms =
      terms_of_a_pass(TermSpectra<Real>::bytes_per_term(axes.x, axes.y), passes.term_tables, kSpectraBytes);
  const int terms = basis.terms() + (complete ? 0 : 1);
  passes.wavelengths = terms <= passes.terms
                           ? wavelengths
                           : static_cast<std::size_t>(std::max<std::int64_t>(1, kFieldBytes / passes.field));
  return passes;
}

}  // namespace

std::int64_t least_spectra_bytes(const HeightField& surface, const DiskGrid& grid, double shortest,
                                 const SpectralChoice& choice) {
  const auto [x, y] = make_axes(surface, grid, shortest, choice);
  return kFewestTerms * TermSpectra<double>::bytes_per_term(x, y);
}

template <typename Real>
SpectrumDensity transform_spectrum(const HeightField& surface, const DiskGrid& grid,
                                   const std::vector<double>& lambda_q, const SpectralChoice& choice,
                                   SpectrumMemory<Real>& memory) {
  assert(!lambda_q.empty());
  const double area = kirchhoff_area(surface), radius = 4 * pi / lambda_q.front();
  QuadratureLattice all(surface, choice.subdivision, {}, choice.steepest, choice.highest);
  const Axes axes = make_axes(surface, grid, lambda_q.front(), choice);
  const auto& [x, y] = axes;
  const HeightHistogram heights = height_histogram(surface);
  const WaveRange q = {wave_range(4 * pi / lambda_q.back(), grid).low, radius};
  // |q|²·ψ competes with |q| in the area and with one per length in rims that are never denser than the
  // pitch.
  const double tolerance = choice.basis_tolerance * std::min(1 / radius, std::sqrt(surface.dx * surface.dy));
  const HeightBasis basis(heights, 0, q, tolerance);
  const bool complete = all.complete();
  const LeftOut left_out(all, facet_phases(radius, grid, choice.basis_tolerance));
  const double nodes = static_cast<double>(grid.size) * grid.size * static_cast<double>(lambda_q.size());
  SpectrumDensity result;
  result.work = spectra_work(surface, choice, x, y, left_out.points(), basis.terms() + (complete ? 0 : 1));
  const Passes passes =
      plan_passes<Real>(basis, complete, lambda_q.size(), grid, axes, choice.basis_tolerance);
  // Every pass starts its tables again.
  const double rounds =
      std::ceil(static_cast<double>(lambda_q.size()) / static_cast<double>(passes.wavelengths));
  result.work.tables = rounds * table_work(basis.size(), passes.tables);
  if (!basis.orthonormal())
    result.work.recurrences = rounds * std::ceil(static_cast<double>(basis.terms()) / passes.terms) *
                              basis.terms() * static_cast<double>(passes.tables.coefficients);
  check_work(result.work, nodes, surface, lambda_q.front());
  const NestedTerms terms(basis, q, tolerance);
  const SurfaceQuadrature quadrature(std::move(all), left_out);
  const double to_density = kirchhoff_density(1, area);
  const DiskQuarter quarter(grid);

  result.tables.resize(lambda_q.size());
  const std::vector<TermBatch> batches = make_batches(terms.terms(), !complete, passes.terms);
  result.work.terms = terms.terms() + (complete ? 0 : 1);
  result.work.transforms = 0;
  for (std::size_t first = 0; first < lambda_q.size(); first += passes.wavelengths) {
    std::vector<Sphere<Real>> spheres(std::min(passes.wavelengths, lambda_q.size() - first));
    parallel_for(static_cast<std::int64_t>(spheres.size()), [&](std::int64_t k) {
      const std::size_t index = first + static_cast<std::size_t>(k);
      spheres[k] = make_sphere<Real>(index, lambda_q[index], grid, axes);
      if (complete) make_plates(axes, spheres[k]);
      if (batches.size() > 1)
        spheres[k].field.assign(static_cast<std::size_t>(passes.field) / sizeof(Real), 0);
    });
    for (const TermBatch& batch : batches) {
      const TermSpectra<Real> spectra(quadrature, heights, terms, basis.phase_reach(), batch, x, y,
                                      memory.rows);
      const TermCoefficients<Real> coefficients =
          make_coefficients<Real>(terms, basis.phase_reach(), q, batch, choice.basis_tolerance);
      const Pass<Real> pass(grid, terms, batch, coefficients, spectra, y);
      if (&batch == &batches.back())
        pass(spheres, [&](const auto& tile, auto& tile_memory, auto& sphere) {
          write_tile(tile, tile_memory, quarter, to_density, sphere);
        });
      else
        pass(spheres,
             [](const auto& tile, auto& tile_memory, auto& sphere) { add_tile(tile, tile_memory, sphere); });
      result.work.transforms += spectra.transforms();
      result.work.bytes =
          std::max(result.work.bytes, spectra.source_bytes() + batch.terms() * passes.term_tables);
    }
    for (Sphere<Real>& sphere : spheres)
      result.tables[sphere.index] = std::move(sphere.density);
  }
  result.work.bytes +=
      static_cast<std::int64_t>(memory.rows.size() * sizeof(std::complex<Real>)) +
      (batches.size() > 1
           ? static_cast<std::int64_t>(std::min(passes.wavelengths, lambda_q.size())) * passes.field
           : 0);
  return result;
}

template SpectrumDensity transform_spectrum<float>(const HeightField&, const DiskGrid&,
                                                   const std::vector<double>&, const SpectralChoice&,
                                                   SpectrumMemory<float>&);
template SpectrumDensity transform_spectrum<double>(const HeightField&, const DiskGrid&,
                                                    const std::vector<double>&, const SpectralChoice&,
                                                    SpectrumMemory<double>&);

}  // namespace micro
