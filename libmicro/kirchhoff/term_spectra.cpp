#include "kirchhoff/term_spectra.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/parallel.h"
#include "kirchhoff/term_tables.h"

namespace micro {
namespace {

using std::numbers::pi;

/// Of gridding: points per period of the highest wave number, over two.
constexpr double kGriddingOversampling = 1.25;
/// Patches of a few points are all border, where interpolation is at its worst.
constexpr std::int64_t kSparePoints = 16;
/// Rows of points transformed together, so that their spectra are written by cache lines.
constexpr std::int64_t kRowGroup = 8;
/// Groups of rows handed out together: the lattice rows at either end are spread twice.
constexpr std::int64_t kBandGroups = 8;

/// φ_k at equidistant heights; I[1], where it is among the terms, is that of φ = 1 without a rim.
template <typename Real>
FunctionTable<Real> make_function_table(const NestedTerms& terms, const HeightHistogram& heights,
                                        double phase_reach, const TermBatch& batch) {
  FunctionTable<Real> table;
  table.entries = static_cast<int>(function_entries(phase_reach));
  table.low = heights.low;
  table.per_height = (table.entries - 1) / std::max(heights.high - heights.low, 1e-30);
  table.padded = (batch.terms() + kTermLanes - 1) / kTermLanes * kTermLanes;
  table.data.assign(static_cast<std::size_t>(table.entries) * 2 * table.padded, 0);
  table.on_rim.assign(static_cast<std::size_t>(table.padded), 1);
  const HeightBasis::Functions f = terms.functions(table.entries, batch.first, batch.count);
  const int skipped = batch.with_area ? 1 : 0;
  parallel_blocks(table.entries, kEntryBlock, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t e = begin; e < end; ++e) {
      Real* value = table.data.data() + e * 2 * table.padded;
      for (int k = 0; k < batch.count; ++k) {
        value[skipped + k] = static_cast<Real>(f.value(e, k));
        value[table.padded + skipped + k] = static_cast<Real>(f.derivative(e, k));
      }
      if (batch.with_area) value[0] = 1;
    }
  });
  if (batch.with_area) table.on_rim[0] = 0;
  return table;
}

/// Factor on each point by which images are prepared for interpolation of their spectra.
std::vector<double> preparation(const SpectrumAxis& axis) {
  std::vector<double> factor(static_cast<std::size_t>(axis.points()), 1);
  if (axis.interpolation_width == 0) return factor;
  const GriddingKernel kernel = axis.interpolation();
  for (std::int64_t m = axis.begin; m < axis.end; ++m)
    factor[static_cast<std::size_t>(m - axis.begin)] =
        1 / kernel.spectrum(axis.pitch * static_cast<double>(m - axis.centre));
  return factor;
}

template <typename Real>
GatherTable<Real> prepared(GatherTable<Real> table, const std::vector<double>& factor) {
  for (std::size_t m = 0; m < factor.size(); ++m)
    for (std::size_t t = m * table.taps; t < (m + 1) * table.taps; ++t) {
      table.value[t] *= static_cast<Real>(factor[m]);
      table.derivative[t] *= static_cast<Real>(factor[m]);
    }
  return table;
}

template <typename Real>
ScatterTable<Real> prepared(ScatterTable<Real> table, const std::vector<double>& factor) {
  for (std::size_t l = 0; l < table.start.size(); ++l)
    for (int t = 0; t < table.taps; ++t) {
      const auto f = static_cast<Real>(factor[static_cast<std::size_t>(table.start[l] + t)]);
      table.value[l * table.taps + t] *= f;
      table.derivative[l * table.taps + t] *= f;
    }
  return table;
}

template <typename Real>
SpreadProblem<Real> make_problem(const SurfaceQuadrature& quadrature, const FunctionTable<Real>& functions,
                                 const SpectrumAxis& x, const SpectrumAxis& y) {
  const QuadratureLattice& lattice = quadrature.lattice;
  const std::vector<double> factor_x = preparation(x), factor_y = preparation(y);
  const auto gather = [&](const SpectrumAxis& axis, double spacing, int offset, int step,
                          std::int64_t sources, const std::vector<double>& factor) {
    return prepared(make_gather<Real>(axis.gridding, spacing, offset, step, sources, axis.begin, axis.end),
                    factor);
  };
  SpreadProblem<Real> problem{};
  problem.lattice = &lattice;
  problem.functions = &functions;
  problem.q_squared = 1;
  problem.grid_cols = x.points();
  problem.row_begin = y.begin;
  problem.gather_x = gather(x, lattice.dx(), 0, 1, lattice.cols(), factor_x);
  problem.gather_x_odd = gather(x, lattice.dx(), 1, 2, lattice.cols() / 2, factor_x);
  problem.gather_y = gather(y, lattice.dy(), 0, 1, lattice.rows(), factor_y);
  problem.scatter_x =
      prepared(make_scatter<Real>(x.gridding, lattice.dx(), lattice.cols(), x.begin, x.end), factor_x);
  return problem;
}

std::int64_t padded_rows_of(const SpectrumAxis& y) {
  return (y.points() + kRowGroup - 1) / kRowGroup * kRowGroup;
}

/// Fills in the points of what the lattice leaves out.
template <typename Real>
void scatter_steep(const SurfaceQuadrature& quadrature, const SpectrumAxis& x, const SpectrumAxis& y,
                   SpreadProblem<Real>& area, SpreadProblem<Real>& rim) {
  const std::vector<double> factor_x = preparation(x), factor_y = preparation(y);
  const ScatterAxis along_x = {x.gridding, x.begin, x.end, factor_x},
                    along_y = {y.gridding, y.begin, y.end, factor_y};
  area.steep = make_point_scatter<Real>(quadrature.steep, along_x, along_y);
  rim.steep_rim = make_rim_scatter<Real>(quadrature.steep_rim, along_x, along_y);
}

/// Index of a point in a transform whose origin is the surface's middle.
std::int64_t wrapped(const SpectrumAxis& axis, std::int64_t point) {
  const std::int64_t m = point - axis.centre;
  return m < 0 ? m + axis.length : m;
}

}  // namespace

SpectrumAxis make_spectrum_axis(double side, const SpectrumLayout& layout) {
  const double spare = layout.interpolation_width / 2.0 + 1;
  const double q_all = layout.q_high + spare * 2 * pi / (layout.oversampling * side);
  const double half = side / 2;
  const auto centre = static_cast<std::int64_t>(std::ceil(half * kGriddingOversampling * q_all / pi));
  const double pitch = half / static_cast<double>(centre), reach = layout.gridding_width / 2.0;
  const auto begin = static_cast<std::int64_t>(std::ceil(-reach)),
             end = static_cast<std::int64_t>(std::floor(2 * static_cast<double>(centre) + reach)) + 1;
  const auto points = static_cast<double>(end - begin);
  const std::int64_t length =
      fast_fft_size(static_cast<std::int64_t>(std::ceil(layout.oversampling * points)) + kSparePoints);
  const double step = 2 * pi / (static_cast<double>(length) * pitch);
  return {.side = side,
          .pitch = pitch,
          .begin = begin,
          .end = end,
          .centre = centre,
          .length = length,
          .step = step,
          .reach = static_cast<std::int64_t>(std::floor(layout.q_high / step + spare)),
          .gridding = GriddingKernel(layout.gridding_width, kGriddingOversampling, pitch),
          .interpolation_width = layout.interpolation_width,
          .oversampling = static_cast<double>(length) / points};
}

template <typename Real>
std::int64_t TermSpectra<Real>::bytes_per_term(const SpectrumAxis& x, const SpectrumAxis& y) {
  return x.count() * padded_rows_of(y) * static_cast<std::int64_t>(sizeof(std::complex<Real>));
}

SpectralWork spectra_work(const HeightField& surface, const SpectralChoice& choice, const SpectrumAxis& x,
                          const SpectrumAxis& y, std::int64_t steep_points, int terms) {
  SpectralWork work;
  work.terms = terms;
  work.fft_length = x.length;
  work.transforms = (std::int64_t{terms} + 1) / 2 * 2 * (y.points() + x.count());
  work.spread = spread_work(surface, choice, x.points(), steep_points, terms);
  work.steep_points = steep_points;
  work.sums = choice.sums;
  return work;
}

template <typename Real>
TermSpectra<Real>::TermSpectra(const SurfaceQuadrature& quadrature, const HeightHistogram& heights,
                               const NestedTerms& terms, double phase_reach, const TermBatch& batch,
                               const SpectrumAxis& x, const SpectrumAxis& y,
                               FftVector<std::complex<Real>>& memory)
    : x_(x),
      y_(y),
      padded_((batch.terms() + kTermLanes - 1) / kTermLanes * kTermLanes),
      fields_((batch.terms() + 1) / 2),
      padded_rows_(padded_rows_of(y)),
      row_fft_({1, x.length, 1}, FftDirection::Forward),
      column_fft_({1, y.length, 1}, FftDirection::Forward),
      memory_(memory) {
  const auto size = static_cast<std::size_t>(x_.count() * 2 * fields_ * padded_rows_);
  if (memory_.size() < size) memory_.resize(size);
  transform_rows(quadrature, make_function_table<Real>(terms, heights, phase_reach, batch));
}

template <typename Real>
void TermSpectra<Real>::transform_rows(const SurfaceQuadrature& quadrature,
                                       const FunctionTable<Real>& functions) {
  SpreadProblem<Real> rim = make_problem(quadrature, functions, x_, y_);
  rim.sources = SpreadSources::Rim;
  SpreadProblem<Real> area = rim;
  area.sources = SpreadSources::Area;
  scatter_steep(quadrature, x_, y_, area, rim);
  source_bytes_ = quadrature.bytes() + area.point_bytes() + rim.point_bytes();
  parallel_blocks(padded_rows_ / kRowGroup, kBandGroups, [&](std::int64_t begin, std::int64_t end) {
    RowSpreader<Real> spread_area(area), spread_rim(rim);
    const std::int64_t row_size = x_.points() * padded_;
    FftVector<Real> rows(static_cast<std::size_t>(2 * kRowGroup * row_size));
    FftVector<std::complex<Real>> buffers(static_cast<std::size_t>(kRowGroup * x_.length));
    for (std::int64_t group = begin; group < end; ++group) {
      std::fill(rows.begin(), rows.end(), Real(0));
      for (std::int64_t row = 0; row < kRowGroup && group * kRowGroup + row < y_.points(); ++row) {
        const std::int64_t m = y_.begin + group * kRowGroup + row;
        std::copy_n(spread_area.row(m), row_size, rows.data() + row * row_size);
        std::copy_n(spread_rim.row(m), row_size, rows.data() + (kRowGroup + row) * row_size);
      }
      for (int field = 0; field < 2 * fields_; ++field) {
        std::fill(buffers.begin(), buffers.end(), std::complex<Real>(0));
        const int term = 2 * (field % fields_);
        for (std::int64_t row = 0; row < kRowGroup; ++row) {
          std::complex<Real>* buffer = &buffers[static_cast<std::size_t>(row * x_.length)];
          const Real* from =
              &rows[static_cast<std::size_t>((field / fields_ * kRowGroup + row) * row_size)] + term;
          std::int64_t to = wrapped(x_, x_.begin);
          for (std::int64_t m = 0; m < x_.points(); ++m, from += padded_) {
            buffer[to] = std::complex<Real>(from[0], from[1]);
            if (++to == x_.length) to = 0;
          }
          row_fft_(buffer);
        }
        for (std::int64_t column = -x_.reach; column <= x_.reach; ++column) {
          const std::complex<Real>* from =
              &buffers[static_cast<std::size_t>(column < 0 ? column + x_.length : column)];
          std::complex<Real>* to = row_spectra(column, field) + group * kRowGroup;
          for (std::int64_t row = 0; row < kRowGroup; ++row)
            to[row] = from[row * x_.length];
        }
      }
    }
  });
}

template <typename Real>
void TermSpectra<Real>::transform_column(std::int64_t column, std::complex<Real>* buffer) const {
  const std::int64_t start = wrapped(y_, y_.begin), head = y_.length - start;
  for (int field = 0; field < 2 * fields_; ++field, buffer += y_.length) {
    const std::complex<Real>* rows = row_spectra(column, field);
    std::copy_n(rows, head, buffer + start);
    std::copy_n(rows + head, y_.points() - head, buffer);
    std::fill(buffer + y_.points() - head, buffer + start, std::complex<Real>(0));
    column_fft_(buffer);
  }
}

template <typename Real>
void TermSpectra<Real>::unpack(const std::complex<Real>* plus, const std::complex<Real>* minus,
                               std::int64_t column, TermColumns<Real>& result) const {
  constexpr std::int64_t kRowsAtOnce = 8;
  constexpr auto kHalf = static_cast<Real>(0.5);
  for (std::int64_t first = -y_.reach; first <= y_.reach; first += kRowsAtOnce)
    for (int field = 0; field < 2 * fields_; ++field)
      for (std::int64_t row = first; row < std::min(first + kRowsAtOnce, y_.reach + 1); ++row) {
        const std::int64_t at = field * y_.length;
        const std::complex<Real> z = plus[at + (row < 0 ? row + y_.length : row)],
                                 opposite = minus[at + (row > 0 ? y_.length - row : -row)];
        // T̂_2f = (Z(q) + Z*(−q))/2, T̂_2f+1 = (Z(q) − Z*(−q))/2i
        Real* to = &result.data[static_cast<std::size_t>(
            ((column - result.first_column) * result.rows + row + y_.reach) * 4 * padded_ +
            field / fields_ * 2 * padded_ + 2 * (field % fields_))];
        to[0] = kHalf * (z.real() + opposite.real());
        to[1] = kHalf * (z.imag() + opposite.imag());
        to[padded_] = kHalf * (z.imag() - opposite.imag());
        to[padded_ + 1] = kHalf * (opposite.real() - z.real());
      }
}

template <typename Real>
void TermSpectra<Real>::columns(std::int64_t first, std::int64_t columns, TermColumns<Real>& result) const {
  // What pads the terms stays zero.
  if (result.rows != y_.count() || result.padded != padded_) result.data.clear();
  result.first_column = first;
  result.columns = columns;
  result.rows = y_.count();
  result.padded = padded_;
  const auto size = static_cast<std::size_t>(columns * result.rows * 4 * padded_);
  if (result.data.size() < size) result.data.resize(size);
  const auto column_size = static_cast<std::size_t>(2 * fields_ * y_.length);
  result.transforms.resize(2 * column_size);
  std::complex<Real>*plus = result.transforms.data(), *minus = plus + column_size;
  for (std::int64_t column = first; column < first + columns; ++column) {
    transform_column(column, plus);
    transform_column(-column, minus);
    unpack(plus, minus, column, result);
  }
}

template class TermSpectra<float>;
template class TermSpectra<double>;

}  // namespace micro
