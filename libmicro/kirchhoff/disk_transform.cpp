#include "kirchhoff/disk_transform.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/fft.h"
#include "core/parallel.h"
#include "kirchhoff/disk_geometry.h"
#include "kirchhoff/height_basis.h"
#include "kirchhoff/kirchhoff.h"
#include "kirchhoff/spread.h"
#include "kirchhoff/surface_quadrature.h"

namespace micro {
namespace {

/// Groups of rows handed out together: the lattice rows at either end are spread twice.
constexpr std::int64_t kBandGroups = 8;

/// Terms of one pass over the surface: φ_k first … first+count−1 of the basis and, in the last pass over a
/// surface with missing triangles, I[1] as one more term.
struct Batch {
  int first, count;
  bool with_area;
  int terms() const { return count + (with_area ? 1 : 0); }
  int fields() const { return (terms() + 1) / 2; }
};

/// The q_z of the entries of a table of c_k.
template <typename Real>
struct CoefficientEntries {
  typename CoefficientTable<Real>::Entries kind;
  double step;  ///< between equidistant ones, rad/µm
  Eigen::ArrayXd qz;
};

template <typename Real>
CoefficientEntries<Real> make_entries(const DiskGeometry& g, const WaveRange& q, const TermTables& tables) {
  using Kind = typename CoefficientTable<Real>::Entries;
  const auto n = static_cast<Eigen::Index>(tables.coefficients);
  if (static_cast<double>(n) == distances(g)) {
    const Eigen::ArrayXd k2 = Eigen::ArrayXd::LinSpaced(n, 0, static_cast<double>(n - 1));
    return {Kind::OfNodes, 0, (g.sphere - g.step * g.step * k2).max(q.low * q.low).sqrt()};
  }
  const double intervals = static_cast<double>(n - 1),
               step = std::max(q.high - q.low, 1e-9 * q.high) / intervals;
  return {Kind::Equidistant, step, Eigen::ArrayXd::LinSpaced(n, q.low, q.low + step * intervals)};
}

std::vector<Batch> make_batches(int terms, bool with_area, int most) {
  std::vector<Batch> batches;
  for (int first = 0; first < terms; first += most)
    batches.push_back({first, std::min(most, terms - first), false});
  if (with_area) {
    if (batches.empty() || batches.back().count == most) batches.push_back({terms, 0, false});
    batches.back().with_area = true;
  }
  return batches;
}

template <typename Real>
FunctionTable<Real> make_function_table(const HeightBasis& basis, const HeightHistogram& heights,
                                        const Batch& batch, double sphere) {
  FunctionTable<Real> table;
  table.entries = static_cast<int>(function_entries(basis.phase_reach()));
  const double height = std::max(heights.high - heights.low, 1e-30);
  table.low = heights.low;
  table.per_height = (table.entries - 1) / height;
  table.padded = (batch.terms() + kTermLanes - 1) / kTermLanes * kTermLanes;
  table.data.assign(static_cast<std::size_t>(table.entries) * 2 * table.padded, 0);
  table.on_rim.assign(static_cast<std::size_t>(table.padded), 1);
  const HeightBasis::Functions f = basis.functions(table.entries, batch.first, batch.count);
  parallel_blocks(table.entries, kEntryBlock, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t e = begin; e < end; ++e) {
      Real* value = table.data.data() + e * 2 * table.padded;
      for (int k = 0; k < batch.count; ++k) {
        value[k] = static_cast<Real>(f.value(e, k));
        value[table.padded + k] = static_cast<Real>(f.derivative(e, k));
      }
      if (batch.with_area) value[batch.count] = static_cast<Real>(1 / sphere);
    }
  });
  if (batch.with_area) table.on_rim[batch.count] = 0;
  return table;
}

template <typename Real>
CoefficientTable<Real> make_coefficient_table(const HeightBasis& basis,
                                              const CoefficientEntries<Real>& entries, const Batch& batch) {
  CoefficientTable<Real> table;
  table.kind = entries.kind;
  table.entries = static_cast<int>(entries.qz.size());
  table.low = entries.qz[0];
  table.per_q = entries.step > 0 ? 1 / entries.step : 0;
  table.fields = batch.fields();
  table.data.assign(static_cast<std::size_t>(table.fields) * table.entries * 4, 0);
  const Grid<std::complex<double>> c = basis.coefficients(entries.qz, batch.first, batch.count);
  parallel_blocks(table.entries, kEntryBlock, [&](std::int64_t begin, std::int64_t end) {
    for (int k = 0; k < batch.terms(); ++k)
      for (std::int64_t e = begin; e < end; ++e) {
        const std::complex<double> value = k < batch.count ? c(e, k) : entries.qz[e];
        Real* at = &table.data[(static_cast<std::size_t>(k / 2) * table.entries + e) * 4 + k % 2 * 2];
        at[0] = static_cast<Real>(value.real() / 2);
        at[1] = static_cast<Real>(value.imag() / 2);
      }
  });
  return table;
}

/// Spectra along x of the folded grid rows: [2c+1 (k_x), fields, rows padded].
template <typename Real>
struct RowSpectra {
  std::int64_t padded_rows;
  int fields;
  FftVector<std::complex<Real>>& data;
  std::complex<Real>* at(std::int64_t column, int field) {
    return &data[static_cast<std::size_t>((column * fields + field) * padded_rows)];
  }
};

/// One group of grid rows: folds each into a period, field by field, transforms it and hands out its
/// spectrum.
template <typename Real>
class RowGroup {
 public:
  RowGroup(const DiskGeometry& g, const SpreadProblem<Real>& problem)
      : g_(g),
        problem_(problem),
        rows_(static_cast<std::size_t>(kRowGroup * problem.grid_cols * problem.functions->padded)),
        buffers_(static_cast<std::size_t>(kRowGroup * g.length)) {}

  void clear() { std::fill(rows_.begin(), rows_.end(), Real(0)); }

  void add(std::int64_t row, const Real* values) {
    const std::int64_t size = problem_.grid_cols * problem_.functions->padded;
    Real* to = &rows_[static_cast<std::size_t>(row * size)];
    for (std::int64_t i = 0; i < size; ++i)
      to[i] += values[i];
  }

  void transform(const ComplexFft<Real>& fft, std::int64_t first_row, RowSpectra<Real>& spectra) {
    const int padded = problem_.functions->padded;
    for (int f = 0; f < spectra.fields; ++f) {
      std::fill(buffers_.begin(), buffers_.end(), std::complex<Real>(0));
      for (std::int64_t row = 0; row < kRowGroup; ++row) {
        std::complex<Real>* buffer = &buffers_[static_cast<std::size_t>(row * g_.length)];
        const Real* from = &rows_[static_cast<std::size_t>(row * problem_.grid_cols * padded)] + 2 * f;
        std::int64_t to = g_.wrap(g_.x_begin);
        for (std::int64_t m = 0; m < problem_.grid_cols; ++m, from += padded) {
          buffer[to] += std::complex<Real>(from[0], from[1]);
          if (++to == g_.length) to = 0;
        }
        fft(buffer);
      }
      for (int column = 0; column <= 2 * g_.half; ++column) {
        const std::complex<Real>* from = &buffers_[static_cast<std::size_t>(g_.wrap(column - g_.half))];
        std::complex<Real>* to = spectra.at(column, f) + first_row;
        for (std::int64_t row = 0; row < kRowGroup; ++row)
          to[row] = from[row * g_.length];
      }
    }
  }

 private:
  const DiskGeometry& g_;
  const SpreadProblem<Real>& problem_;
  FftVector<Real> rows_;
  FftVector<std::complex<Real>> buffers_;
};

template <typename Real>
void transform_rows(const DiskGeometry& g, const SpreadProblem<Real>& problem, const ComplexFft<Real>& fft,
                    RowSpectra<Real>& spectra) {
  const std::int64_t groups = spectra.padded_rows / kRowGroup;
  parallel_blocks(groups, kBandGroups, [&](std::int64_t begin, std::int64_t end) {
    RowGroup<Real> group(g, problem);
    // One spreader for each period that the surface reaches into.
    std::vector<RowSpreader<Real>> spreaders;
    for (std::int64_t m = g.y_begin; m < g.y_end; m += g.length)
      spreaders.emplace_back(problem);
    for (std::int64_t index = begin; index < end; ++index) {
      group.clear();
      for (std::int64_t row = 0; row < kRowGroup; ++row)
        for (std::size_t period = 0; period < spreaders.size(); ++period) {
          const std::int64_t folded = index * kRowGroup + row;
          const std::int64_t m = g.y_begin + folded + static_cast<std::int64_t>(period) * g.length;
          if (folded < g.rows() && m < g.y_end) group.add(row, spreaders[period].row(m));
        }
      group.transform(fft, index * kRowGroup, spectra);
    }
  });
}

template <typename Real>
void transform_columns(const DiskGeometry& g, const CoefficientTable<Real>& c, const ComplexFft<Real>& fft,
                       RowSpectra<Real>& spectra, DiskField<Real>& field) {
  const std::int64_t stride = g.length + kColumnPadding;
  parallel_blocks(g.half + 1, 8, [&](std::int64_t begin, std::int64_t end) {
    FftVector<std::complex<Real>> buffers[2];
    for (auto& buffer : buffers)
      buffer.resize(static_cast<std::size_t>(stride * spectra.fields));
    for (std::int64_t kx = begin; kx < end; ++kx) {
      for (int side = 0; side < 2; ++side)
        for (int f = 0; f < spectra.fields; ++f) {
          std::complex<Real>* buffer = &buffers[side][static_cast<std::size_t>(f * stride)];
          const std::complex<Real>* rows = spectra.at(g.half + (side == 0 ? kx : -kx), f);
          std::fill_n(buffer, g.length, std::complex<Real>(0));
          const std::int64_t start = g.wrap(g.y_begin), head = std::min(g.rows(), g.length - start);
          std::copy_n(rows, head, buffer + start);
          std::copy_n(rows + head, g.rows() - head, buffer);
          fft(buffer);
          std::copy_n(buffer, kColumnPadding, buffer + g.length);
        }
      combine_columns(c, {buffers[0].data(), buffers[1].data(), g.length, stride}, static_cast<int>(kx),
                      g.sphere, g.step, field);
    }
  });
}

/// ∫e^{−iqx}dx over [0, length].
std::complex<double> segment_spectrum(double q, double length) {
  const double half = q * length / 2;
  return length * (std::abs(half) < 1e-8 ? 1 : std::sin(half) / half) * std::polar(1.0, -half);
}

/// What finish() needs along one axis, for k = 0 … c.
struct AxisSpectra {
  std::vector<double> deconvolve;          ///< 1/kernel
  std::vector<double> plate_re, plate_im;  ///< ∫e^{−iqx}dx over the surface's side
};

AxisSpectra make_axis(const DiskGeometry& g, const GriddingKernel& kernel, double side) {
  AxisSpectra axis;
  for (int k = 0; k <= g.half; ++k) {
    const double q = g.step * k;
    const std::complex<double> plate = segment_spectrum(q, side);
    axis.deconvolve.push_back(1 / kernel.spectrum(q));
    axis.plate_re.push_back(plate.real());
    axis.plate_im.push_back(plate.imag());
  }
  return axis;
}

/// D_K at all nodes from the sums over terms: takes the gridding kernel out, and adds q_z·I[1] where that is
/// a complete rectangle's.
template <typename Real>
DiskTable finish(const DiskGeometry& g, const DiskGrid& grid, const GriddingKernel& kernel,
                 const DiskField<Real>& field, const QuadratureLattice& lattice, double area) {
  constexpr std::int64_t kTileRows = 16, kTileCols = 16;
  DiskTable table = make_disk_table(grid);
  const AxisSpectra x = make_axis(g, kernel, static_cast<double>(lattice.cols() - 1) * lattice.dx());
  const AxisSpectra y = make_axis(g, kernel, static_cast<double>(lattice.rows() - 1) * lattice.dy());
  const double plate = lattice.complete() ? 1 : 0, to_density = kirchhoff_density(1, area);
  const std::int64_t n = g.half + 1;
  parallel_blocks(n, kTileRows, [&](std::int64_t begin, std::int64_t end) {
    std::array<std::array<std::array<double, kTileCols>, kTileRows>, 4> tile;
    for (std::int64_t first = 0; first < n; first += kTileCols) {
      const std::int64_t last = std::min(first + kTileCols, n);
      for (std::int64_t kx = first; kx < last; ++kx)
        for (std::int64_t ky = begin; ky < end; ++ky) {
          const std::int64_t at = kx * field.stride + ky;
          const double mz2 = grid.mz2(g.half + ky, g.half + kx);
          const double scale = x.deconvolve[kx] * y.deconvolve[ky];
          const double qz = plate * std::sqrt(g.sphere * std::max(mz2, 0.0)),
                       inside = mz2 > 0 ? to_density : 0;
          // (a + ib)(c ± id), the spectra of the sides, for k_y of either sign
          const double ac = x.plate_re[kx] * y.plate_re[ky], bd = x.plate_im[kx] * y.plate_im[ky];
          const double bc = x.plate_im[kx] * y.plate_re[ky], ad = x.plate_re[kx] * y.plate_im[ky];
          const auto density = [&](int quadrant, double plate_re, double plate_im) {
            const double re = scale * static_cast<double>(field.quadrants[quadrant].re[at]) + qz * plate_re;
            const double im = scale * static_cast<double>(field.quadrants[quadrant].im[at]) + qz * plate_im;
            tile[quadrant][ky - begin][kx - first] = inside * (re * re + im * im);
          };
          density(0, ac - bd, bc + ad);
          density(1, ac - bd, -bc - ad);
          density(2, ac + bd, bc - ad);
          density(3, ac + bd, ad - bc);
        }
      for (std::int64_t ky = begin; ky < end; ++ky) {
        double* up = &table.density(g.half + ky, g.half);
        double* down = &table.density(g.half - ky, g.half);
        for (std::int64_t kx = first; kx < last; ++kx) {
          up[kx] = tile[0][ky - begin][kx - first];
          down[-kx] = tile[1][ky - begin][kx - first];
          down[kx] = tile[2][ky - begin][kx - first];
          up[-kx] = tile[3][ky - begin][kx - first];
        }
      }
    }
  });
  return table;
}

template <typename Real>
void clear_field(const DiskGeometry& g, DiskField<Real>& field) {
  field.half = g.half;
  field.stride = g.half + 1 + kColumnPadding;
  for (auto& quadrant : field.quadrants)
    for (auto* part : {&quadrant.re, &quadrant.im})
      part->assign(static_cast<std::size_t>((g.half + 1) * field.stride), Real(0));
}

}  // namespace

template <typename Real>
DiskDensity transform_disk(const Window& window, const DiskGrid& grid, double lambda_q,
                           const SpectralChoice& choice, DiskMemory<Real>& memory) {
  const HeightField& surface = window.surface;
  kirchhoff_area(surface);
  const double area = effective_area(window);
  QuadratureLattice all(surface, choice.subdivision, window.taper, choice.steepest, choice.highest);
  const DiskGeometry g = make_disk_geometry(surface, grid, lambda_q, choice);
  const GriddingKernel kernel(choice.kernel_width, static_cast<double>(g.length) / grid.size, g.pitch);
  const HeightHistogram heights = height_histogram(surface);
  const double radius = std::sqrt(g.sphere);
  const WaveRange q = wave_range(radius, grid);
  // |q|²·ψ competes with |q| in the area and with one per length in rims that are never denser than the
  // pitch.
  const double scale = std::min(1 / radius, std::sqrt(surface.dx * surface.dy));
  const HeightBasis basis(heights, 0, q, choice.basis_tolerance * scale);

  DiskDensity result;
  const LeftOut left_out(all, facet_phases(radius, grid, choice.basis_tolerance));
  BasisSize size = basis.size();
  if (!all.complete()) ++size.terms;
  result.work = disk_work(g, surface, choice, left_out.points(), size);
  const TermTables tables = disk_tables(g, size.phase_reach, choice.basis_tolerance);
  const auto entries = make_entries<Real>(g, q, tables);
  const std::int64_t padded_rows = g.padded_rows(), term_tables = table_bytes(tables, sizeof(Real));
  const int most = disk_pass(g, tables, sizeof(Real) == sizeof(float) ? Sums::Single : Sums::Double);
  check_work(result.work, static_cast<double>(grid.size) * grid.size, surface, lambda_q);
  const SurfaceQuadrature quadrature(std::move(all), left_out);
  const QuadratureLattice& lattice = quadrature.lattice;

  const ComplexFft<Real> fft({1, g.length, 1}, FftDirection::Forward);
  SpreadProblem<Real> problem{};
  problem.lattice = &lattice;
  problem.q_squared = g.sphere;
  problem.grid_cols = g.x_end - g.x_begin;
  problem.row_begin = g.y_begin;
  problem.gather_x = make_gather<Real>(kernel, lattice.dx(), 0, 1, lattice.cols(), g.x_begin, g.x_end);
  problem.gather_x_odd =
      make_gather<Real>(kernel, lattice.dx(), 1, 2, lattice.cols() / 2, g.x_begin, g.x_end);
  problem.gather_y = make_gather<Real>(kernel, lattice.dy(), 0, 1, lattice.rows(), g.y_begin, g.y_end);
  problem.scatter_x = make_scatter<Real>(kernel, lattice.dx(), lattice.cols(), g.x_begin, g.x_end);
  const ScatterAxis x = {kernel, g.x_begin, g.x_end}, y = {kernel, g.y_begin, g.y_end};
  problem.steep = make_point_scatter<Real>(quadrature.steep, x, y);
  problem.steep_rim = make_rim_scatter<Real>(quadrature.steep_rim, x, y);

  clear_field(g, memory.field);
  result.work.transforms = 0;
  for (const Batch& batch : make_batches(basis.terms(), !lattice.complete(), most)) {
    const FunctionTable<Real> functions = make_function_table<Real>(basis, heights, batch, g.sphere);
    const CoefficientTable<Real> coefficients = make_coefficient_table<Real>(basis, entries, batch);
    problem.functions = &functions;
    RowSpectra<Real> spectra{padded_rows, batch.fields(), memory.spectra};
    const auto numbers = static_cast<std::size_t>((2 * g.half + 1) * spectra.fields * spectra.padded_rows);
    if (memory.spectra.size() < numbers) memory.spectra.resize(numbers);
    transform_rows(g, problem, fft, spectra);
    transform_columns(g, coefficients, fft, spectra, memory.field);
    result.work.transforms += batch.fields() * (g.rows() + 2 * g.half + 1);
    result.work.bytes = std::max<std::int64_t>(
        result.work.bytes, static_cast<std::int64_t>(numbers * sizeof(std::complex<Real>) +
                                                     8 * memory.field.quadrants[0].re.size() * sizeof(Real)) +
                               batch.terms() * term_tables + quadrature.bytes() + problem.point_bytes());
  }
  result.table = finish(g, grid, kernel, memory.field, lattice, area);
  return result;
}

template DiskDensity transform_disk<float>(const Window&, const DiskGrid&, double, const SpectralChoice&,
                                           DiskMemory<float>&);
template DiskDensity transform_disk<double>(const Window&, const DiskGrid&, double, const SpectralChoice&,
                                            DiskMemory<double>&);

}  // namespace micro
