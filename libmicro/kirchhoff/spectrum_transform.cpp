#include "kirchhoff/spectrum_transform.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

#include "core/parallel.h"
#include "kirchhoff/disk_geometry.h"
#include "kirchhoff/kirchhoff.h"
#include "kirchhoff/sphere_nodes.h"

namespace micro {
namespace {

using std::numbers::pi;

/// Bytes of spectra along x and of tables of φ_k and c_k that are held at once, and terms of one pass.
constexpr std::int64_t kSpectraBytes = std::int64_t{1} << 28, kTableBytes = std::int64_t{1} << 28;
constexpr std::int64_t kFewestTerms = 8, kMostTerms = 96;
/// Bytes of partial sums that are held at once where there is more than one pass: decides how many
/// wavelengths go together.
constexpr std::int64_t kFieldBytes = std::int64_t{1} << 29;
/// Transform length over points: each wave number's neighbours are a third closer than the patch asks.
constexpr double kOversampling = 1.5;
/// Columns and rows of wave numbers of one tile, so that it stays in the caches; nodes along x of one.
constexpr std::int64_t kTileColumns = 24, kTileRows = 24;
constexpr int kTileNodes = 32;

/// All that belongs to one wavelength.
template <typename Real>
struct Sphere {
  std::size_t index;                     ///< of the wavelength
  double radius, spacing;                ///< |q| and the nodes' distance, rad/µm
  NodeStencils<Real> x, y;               ///< of k_x = 0 … c and k_y = −c … c
  std::vector<double> plate_x, plate_y;  ///< ∫e^{−iqx}dx over the surface's sides about its middle
  Grid<float> density;
  FftVector<Real> field;  ///< [k_x, k_y, 4] partial sums (sphere_nodes.h) between passes, or none
};

/// ∫e^{−iqx}dx over [−side/2, side/2].
double plate_spectrum(double q, double side) {
  const double half = q * side / 2;
  return side * (std::abs(half) < 1e-8 ? 1 : std::sin(half) / half);
}

template <typename Real>
Sphere<Real> make_sphere(std::size_t index, double lambda_q, const DiskGrid& grid, const SpectrumAxis& x,
                         const SpectrumAxis& y) {
  Sphere<Real> sphere{};
  sphere.index = index;
  sphere.radius = 4 * pi / lambda_q;
  sphere.spacing = sphere.radius * grid.spacing();
  const int half = (grid.size - 1) / 2;
  sphere.x = make_node_stencils<Real>(x, sphere.spacing, 0, half);
  sphere.y = make_node_stencils<Real>(y, sphere.spacing, -half, half);
  for (int k = 0; k <= half; ++k) {
    sphere.plate_x.push_back(plate_spectrum(sphere.spacing * k, x.side));
    sphere.plate_y.push_back(plate_spectrum(sphere.spacing * k, y.side));
  }
  sphere.density = Grid<float>::Zero(grid.size, grid.size);
  return sphere;
}

/// Entries of a table of c_k.
int coefficient_entries(double phase_reach, double tolerance) {
  // The error of linear interpolation is (phase step)²/8; densities are float in the end.
  constexpr double kFinest = 1e-8, kMost = 1e9;
  const double wanted = phase_reach / std::sqrt(8 * std::max(tolerance, kFinest) / 10);
  return static_cast<int>(std::min(std::ceil(wanted), kMost)) + 16;
}

template <typename Real>
TermCoefficients<Real> make_coefficients(const NestedTerms& terms, double phase_reach, const WaveRange& q,
                                         const TermBatch& batch, double tolerance) {
  TermCoefficients<Real> table;
  table.entries = coefficient_entries(phase_reach, tolerance);
  table.low = q.low;
  table.per_q = (table.entries - 1) / std::max(q.high - q.low, 1e-9 * q.high);
  table.padded = (batch.terms() + kTermLanes - 1) / kTermLanes * kTermLanes;
  table.data.assign(static_cast<std::size_t>(table.entries) * 2 * table.padded, 0);
  const Eigen::ArrayXXcd c = terms.coefficients(table.entries, batch.first, batch.count);
  const int skipped = batch.with_area ? 1 : 0;
  for (int e = 0; e < table.entries; ++e) {
    Real* at = table.data.data() + std::int64_t{e} * 2 * table.padded;
    for (int k = 0; k < batch.count; ++k) {
      at[skipped + k] = static_cast<Real>(c(e, k).real());
      at[table.padded + skipped + k] = static_cast<Real>(c(e, k).imag());
    }
    if (batch.with_area) at[0] = static_cast<Real>(q.low + e / table.per_q);
  }
  return table;
}

/// Terms of one pass. `term_bytes`, `term_tables`: of one term's spectra, and of its tables while they are
/// made.
int terms_at_once(std::int64_t term_bytes, std::int64_t term_tables) {
  return static_cast<int>(
      std::clamp(std::min(kSpectraBytes / term_bytes, kTableBytes / term_tables), kFewestTerms, kMostTerms));
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
    parallel_blocks(last - first, kTileColumns, [&](std::int64_t begin, std::int64_t end) {
      const TermColumns<Real> columns =
          spectra_.columns(first + begin, end - begin + spheres.front().x.width - 1);
      TileMemory<Real> memory;
      for (std::int64_t row = first_row; row < last_row; row += kTileRows)
        for (Sphere<Real>& sphere : spheres)
          visit(sphere, columns, first + begin, first + end, row, row + kTileRows, memory, flush);
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

/// Writes a tile's densities. `plate`: of a complete rectangle, q_z·I[1] is still to be added.
template <typename Real>
void write_tile(const SphereTile<Real>& tile, const TileMemory<Real>& memory, const DiskGrid& grid,
                double plate, double to_density, Sphere<Real>& sphere) {
  const int nodes = tile.ky_end - tile.ky_begin, size = grid.size, half = tile.half;
  for (int ky = tile.ky_begin; ky < tile.ky_end; ++ky) {
    float* up = &sphere.density(half + ky, half);
    float* down = &sphere.density(half - ky, half);
    for (int kx = tile.kx_begin; kx < tile.kx_end; ++kx) {
      const double mz2 = grid.mz2(half + ky, half + kx);
      if (!(mz2 > 0)) continue;
      const double add = plate * sphere.radius * std::sqrt(mz2) *
                         sphere.plate_x[static_cast<std::size_t>(kx)] *
                         sphere.plate_y[static_cast<std::size_t>(std::abs(ky))];
      const std::size_t at = (static_cast<std::size_t>(kx - tile.kx_begin) * nodes + ky - tile.ky_begin) * 4;
      double sum[4];
      for (int n = 0; n < 4; ++n)
        sum[n] = static_cast<double>(memory.field[at + n]);
      if (!sphere.field.empty()) {
        const Real* earlier = &sphere.field[(static_cast<std::size_t>(kx) * size + ky + half) * 4];
        for (int n = 0; n < 4; ++n)
          sum[n] += static_cast<double>(earlier[n]);
      }
      sum[0] += add;
      sum[2] += add;
      up[kx] = static_cast<float>(to_density * (sum[0] * sum[0] + sum[1] * sum[1]));
      down[-kx] = static_cast<float>(to_density * (sum[2] * sum[2] + sum[3] * sum[3]));
    }
  }
}

/// The grids of wave numbers that serve all |q| up to that of the shortest wavelength.
struct Axes {
  SpectrumAxis x, y;
};

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
  double recurrences;        ///< of all of them (SpectralWork)
};

template <typename Real>
Passes plan_passes(const HeightBasis& basis, bool complete, std::size_t wavelengths, const DiskGrid& grid,
                   const Axes& axes, double tolerance) {
  const int entries = coefficient_entries(basis.phase_reach(), tolerance);
  Passes passes{};
  passes.term_tables = TermSpectra<Real>::table_bytes_per_term(basis.phase_reach()) +
                       entries * 2 * std::int64_t{sizeof(double) + sizeof(Real)};
  passes.field = std::int64_t{(grid.size + 1) / 2} * grid.size * 4 * std::int64_t{sizeof(Real)};
  passes.terms = terms_at_once(TermSpectra<Real>::bytes_per_term(axes.x, axes.y), passes.term_tables);
  const int terms = basis.terms() + (complete ? 0 : 1);
  passes.wavelengths = terms <= passes.terms
                           ? wavelengths
                           : static_cast<std::size_t>(std::max<std::int64_t>(1, kFieldBytes / passes.field));
  passes.recurrences = basis.recurrences(entries) * std::ceil(static_cast<double>(terms) / passes.terms) *
                       std::ceil(static_cast<double>(wavelengths) / static_cast<double>(passes.wavelengths));
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
  result.work.recurrences = passes.recurrences;
  check_work(result.work, nodes, surface, lambda_q.front());
  const NestedTerms terms(basis, q, tolerance);
  const SurfaceQuadrature quadrature(std::move(all), left_out);
  const double plate = complete ? 1 : 0, to_density = kirchhoff_density(1, area);

  result.tables.resize(lambda_q.size());
  const std::vector<TermBatch> batches = make_batches(terms.terms(), !complete, passes.terms);
  result.work.terms = terms.terms() + (complete ? 0 : 1);
  result.work.transforms = 0;
  for (std::size_t first = 0; first < lambda_q.size(); first += passes.wavelengths) {
    std::vector<Sphere<Real>> spheres;
    for (std::size_t k = first; k < std::min(first + passes.wavelengths, lambda_q.size()); ++k) {
      spheres.push_back(make_sphere<Real>(k, lambda_q[k], grid, x, y));
      if (batches.size() > 1)
        spheres.back().field.assign(static_cast<std::size_t>(passes.field) / sizeof(Real), 0);
    }
    for (const TermBatch& batch : batches) {
      const TermSpectra<Real> spectra(quadrature, heights, terms, basis.phase_reach(), batch, x, y,
                                      memory.rows);
      const TermCoefficients<Real> coefficients =
          make_coefficients<Real>(terms, basis.phase_reach(), q, batch, choice.basis_tolerance);
      const Pass<Real> pass(grid, terms, batch, coefficients, spectra, y);
      if (&batch == &batches.back())
        pass(spheres, [&](const auto& tile, auto& tile_memory, auto& sphere) {
          write_tile(tile, tile_memory, grid, plate, to_density, sphere);
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
