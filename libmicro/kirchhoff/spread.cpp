#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kirchhoff/spread.cpp"
#include "kirchhoff/spread.h"

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef MICRO_KIRCHHOFF_SPREAD_SHARED_
#define MICRO_KIRCHHOFF_SPREAD_SHARED_
#include <algorithm>
#include <cassert>

namespace micro {
/// A block's sources take about this many bytes: a quarter of a second-level cache.
constexpr std::size_t kBlockBytes = 96 << 10;

/// Grid columns begin … end−1.
struct SpreadBlock {
  std::int64_t begin, end;
};
}  // namespace micro
#endif

HWY_BEFORE_NAMESPACE();
namespace micro {
namespace HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

template <typename Real>
using Lanes = hn::CappedTag<Real, kTermLanes>;

/// Cubic Hermite interpolation: the entry below a height, and the weights of its value and slope and of the
/// next one's.
template <typename Real>
struct Interpolation {
  const Real* entry;
  Real value0, slope0, value1, slope1;
};

template <typename Real>
HWY_INLINE Interpolation<Real> locate(const FunctionTable<Real>& table, double z, Real factor) {
  const double position = (z - table.low) * table.per_height;
  const int index = std::clamp(static_cast<int>(position), 0, table.entries - 2);
  const Real t = static_cast<Real>(position - index), s = 1 - t;
  return {table.data.data() + std::int64_t{index} * 2 * table.padded, factor * s * s * (1 + 2 * t),
          factor * s * s * t, factor * t * t * (3 - 2 * t), -factor * t * t * s};
}

template <typename Real>
HWY_INLINE hn::Vec<Lanes<Real>> interpolate(const Interpolation<Real>& at, int padded, int k) {
  const Lanes<Real> d;
  auto sum = hn::Mul(hn::Set(d, at.value0), hn::LoadU(d, at.entry + k));
  sum = hn::MulAdd(hn::Set(d, at.slope0), hn::LoadU(d, at.entry + padded + k), sum);
  sum = hn::MulAdd(hn::Set(d, at.value1), hn::LoadU(d, at.entry + 2 * padded + k), sum);
  return hn::MulAdd(hn::Set(d, at.slope1), hn::LoadU(d, at.entry + 3 * padded + k), sum);
}

/// Sources stand on every lattice point of a row, or on every second.
struct SourceColumns {
  int offset, step;
};

/// Q²·area·φ_k of sources first … last−1 of the row.
template <typename Real>
void evaluate_sources(const SpreadProblem<Real>& p, const LatticeRow& row, const SourceColumns& columns,
                      std::int64_t first, std::int64_t last, Real* out) {
  const Lanes<Real> d;
  const FunctionTable<Real>& table = *p.functions;
  const auto q_squared = static_cast<Real>(p.q_squared);
  for (std::int64_t n = first; n < last; ++n, out += table.padded) {
    const std::int64_t x = columns.offset + n * columns.step;
    const auto at = locate<Real>(table, row.z[x], q_squared * static_cast<Real>(row.area[x]));
    for (int k = 0; k < table.padded; k += static_cast<int>(hn::Lanes(d)))
      hn::StoreU(interpolate(at, table.padded, k), d, out + k);
  }
}

/// Grid points begin … end−1, `first` being the source that `in` begins with.
struct GatherRange {
  std::int64_t begin, end, first;
};

/// out[m − begin] = Σ_t value[m, t]·in[start[m] − first + t] for `Width` vectors of terms.
template <int Width, typename Real>
void gather_terms(const GatherTable<Real>& table, const GatherRange& range, int padded, const Real* in,
                  Real* out) {
  const Lanes<Real> d;
  using V = hn::Vec<Lanes<Real>>;
  constexpr int kStep = static_cast<int>(hn::MaxLanes(d));
  const Real* weight = &table.value[static_cast<std::size_t>(range.begin * table.taps)];
  for (std::int64_t m = range.begin; m < range.end; ++m, weight += table.taps) {
    const Real* source = in + (table.start[m] - range.first) * padded;
    V a = hn::Zero(d), b = hn::Zero(d), c = hn::Zero(d), e = hn::Zero(d);
    for (int t = 0; t < table.taps; ++t, source += padded) {
      const V w = hn::Set(d, weight[t]);
      a = hn::MulAdd(w, hn::LoadU(d, source), a);
      if constexpr (Width > 1) b = hn::MulAdd(w, hn::LoadU(d, source + kStep), b);
      if constexpr (Width > 2) c = hn::MulAdd(w, hn::LoadU(d, source + 2 * kStep), c);
      if constexpr (Width > 3) e = hn::MulAdd(w, hn::LoadU(d, source + 3 * kStep), e);
    }
    Real* to = out + (m - range.begin) * padded;
    hn::StoreU(a, d, to);
    if constexpr (Width > 1) hn::StoreU(b, d, to + kStep);
    if constexpr (Width > 2) hn::StoreU(c, d, to + 2 * kStep);
    if constexpr (Width > 3) hn::StoreU(e, d, to + 3 * kStep);
  }
}

template <typename Real>
void gather(const GatherTable<Real>& table, const GatherRange& range, int padded, const Real* in, Real* out) {
  constexpr int kStep = static_cast<int>(hn::MaxLanes(Lanes<Real>()));
  // One vector alone would wait for its own sums: five are three and two.
  for (int k = 0, left = padded / kStep; left > 0;) {
    const int width = left == 5 ? 3 : std::min(left, 4);
    const Real* from = in + k;
    Real* to = out + k;
    if (width == 4) gather_terms<4>(table, range, padded, from, to);
    if (width == 3) gather_terms<3>(table, range, padded, from, to);
    if (width == 2) gather_terms<2>(table, range, padded, from, to);
    if (width == 1) gather_terms<1>(table, range, padded, from, to);
    left -= width;
    k += width * kStep;
  }
}

/// Adds the rim's part to a block: −n_x·φ·∂K/∂x to the rows that K will be applied to along y, −n_y·φ·K to
/// those that ∂K/∂y will.
template <typename Real>
void scatter_rim(const SpreadProblem<Real>& p, const LatticeRow& lattice_row, const SpreadBlock& block,
                 Real* row, Real* rim_row) {
  const Lanes<Real> d;
  const FunctionTable<Real>& table = *p.functions;
  const ScatterTable<Real>& scatter = p.scatter_x;
  const int step = static_cast<int>(hn::Lanes(d));
  const auto reaches = [&](int x, std::int64_t column) { return scatter.start[x] + scatter.taps <= column; };
  auto at_x = std::lower_bound(lattice_row.rim.begin(), lattice_row.rim.end(), block.begin, reaches);
  for (; at_x != lattice_row.rim.end() && scatter.start[*at_x] < block.end; ++at_x) {
    const int x = *at_x;
    const auto at = locate<Real>(table, lattice_row.z[x], Real(-1));
    const auto nx = static_cast<Real>(lattice_row.nx[x]), ny = static_cast<Real>(lattice_row.ny[x]);
    const std::int64_t start = scatter.start[x];
    const int first = static_cast<int>(std::max<std::int64_t>(block.begin - start, 0));
    const int last = static_cast<int>(std::min<std::int64_t>(block.end - start, scatter.taps));
    const Real* value = &scatter.value[static_cast<std::size_t>(x) * scatter.taps];
    const Real* derivative = &scatter.derivative[static_cast<std::size_t>(x) * scatter.taps];
    for (int k = 0; k < table.padded; k += step) {
      const auto phi = hn::Mul(interpolate(at, table.padded, k), hn::LoadU(d, &table.on_rim[k]));
      for (int t = first; t < last; ++t) {
        const std::int64_t to = (start + t - block.begin) * table.padded + k;
        hn::StoreU(hn::MulAdd(hn::Set(d, nx * derivative[t]), phi, hn::LoadU(d, row + to)), d, row + to);
        if (ny == 0) continue;
        hn::StoreU(hn::MulAdd(hn::Set(d, ny * value[t]), phi, hn::LoadU(d, rim_row + to)), d, rim_row + to);
      }
    }
  }
}

/// The area of one lattice row spread along x.
template <typename Real>
void spread_area(RowSpreader<Real>& s, std::int64_t l, const SpreadBlock& block,
                 const LatticeRow& lattice_row, Real* row) {
  const SpreadProblem<Real>& p = s.problem;
  const bool odd = QuadratureLattice::area_on_odd_columns_only(l);
  const GatherTable<Real>& table = odd ? p.gather_x_odd : p.gather_x;
  const std::int64_t first = table.start[block.begin], last = table.start[block.end - 1] + table.taps;
  const auto size = static_cast<std::size_t>((last - first) * p.functions->padded);
  if (s.sources.size() < size) s.sources.resize(size);
  evaluate_sources(p, lattice_row, odd ? SourceColumns{1, 2} : SourceColumns{0, 1}, first, last,
                   s.sources.data());
  gather(table, {block.begin, block.end, first}, p.functions->padded, s.sources.data(), row);
}

/// One lattice row spread along x onto a block of grid columns.
template <typename Real>
void spread_along_x(RowSpreader<Real>& s, std::int64_t l, const SpreadBlock& block, int index) {
  const SpreadProblem<Real>& p = s.problem;
  const LatticeRow& lattice_row = s.lattice_rows[index];
  Real* row = s.block_rows[index].data();
  if (p.sources == SpreadSources::Rim)
    std::fill_n(row, (block.end - block.begin) * p.functions->padded, Real(0));
  else
    spread_area(s, l, block, lattice_row, row);
  if (p.sources == SpreadSources::Area || lattice_row.rim.empty()) return;
  Real* rim_row = s.block_rim_rows[index].data();
  if (s.rim[index]) std::fill_n(rim_row, (block.end - block.begin) * p.functions->padded, Real(0));
  scatter_rim(p, lattice_row, block, row, rim_row);
}

/// One row that a grid row takes a share of.
template <typename Real>
struct Share {
  const Real* row;
  Real weight;
};

/// to[i] += Σ share.weight·share.row[i]
template <typename Real>
void add_shares(const std::vector<Share<Real>>& shares, std::int64_t size, Real* to) {
  const Lanes<Real> d;
  const int step = static_cast<int>(hn::Lanes(d));
  const std::size_t count = shares.size();
  std::int64_t i = 0;
  for (; i + 2 * step <= size; i += 2 * step) {
    auto a = hn::LoadU(d, to + i), b = hn::LoadU(d, to + i + step);
    for (std::size_t n = 0; n < count; ++n) {
      const auto w = hn::Set(d, shares[n].weight);
      a = hn::MulAdd(w, hn::LoadU(d, shares[n].row + i), a);
      b = hn::MulAdd(w, hn::LoadU(d, shares[n].row + i + step), b);
    }
    hn::StoreU(a, d, to + i);
    hn::StoreU(b, d, to + i + step);
  }
  for (; i < size; i += step) {
    auto a = hn::LoadU(d, to + i);
    for (const Share<Real>& share : shares)
      a = hn::MulAdd(hn::Set(d, share.weight), hn::LoadU(d, share.row + i), a);
    hn::StoreU(a, d, to + i);
  }
}

/// Lattice rows first … last−1, at most kBatchRows, spread into all open grid rows: block by block, so that
/// what is added up stays in the cache.
template <typename Real>
void spread_batch(RowSpreader<Real>& s, std::int64_t first, std::int64_t last) {
  const SpreadProblem<Real>& p = s.problem;
  const GatherTable<Real>& y = p.gather_y;
  for (std::int64_t l = first; l < last; ++l) {
    LatticeRow& row = s.lattice_rows[l - first];
    p.lattice->fill(l, row);
    s.rim[l - first] = p.sources != SpreadSources::Area &&
                       std::any_of(row.rim.begin(), row.rim.end(), [&](int x) { return row.ny[x] != 0; });
  }
  const std::int64_t open_end =
      std::min<std::int64_t>(s.open_begin + s.open_rows, static_cast<std::int64_t>(y.start.size()));
  std::vector<Share<Real>> shares;
  for (SpreadBlock block{0, 0}; block.begin < p.grid_cols; block.begin = block.end) {
    block.end = std::min(block.begin + s.block_cols, p.grid_cols);
    for (std::int64_t l = first; l < last; ++l)
      spread_along_x(s, l, block, static_cast<int>(l - first));
    for (std::int64_t entry = s.open_begin; entry < open_end; ++entry) {
      shares.clear();
      const std::int64_t start = y.start[entry];
      for (std::int64_t l = std::max(first, start); l < std::min(last, start + y.taps); ++l) {
        const std::int64_t at = entry * y.taps + l - start;
        shares.push_back({s.block_rows[l - first].data(), y.value[at]});
        if (s.rim[l - first]) shares.push_back({s.block_rim_rows[l - first].data(), y.derivative[at]});
      }
      if (!shares.empty())
        add_shares(shares, (block.end - block.begin) * p.functions->padded,
                   s.open_row(entry) + block.begin * p.functions->padded);
    }
  }
}

/// What a point is a source of: Q²·area·φ_k, or on the rim −n·φ_k.
template <typename Real>
void evaluate_point(const SpreadProblem<Real>& p, const PointScatter<Real>& points, std::size_t n,
                    SpreadSources sources, Real* out) {
  const Lanes<Real> d;
  const FunctionTable<Real>& table = *p.functions;
  const bool rim = sources == SpreadSources::Rim;
  const Real factor = rim ? Real(-1) : static_cast<Real>(p.q_squared);
  const auto at = locate<Real>(table, points.z[n], factor * static_cast<Real>(points.weight[n]));
  for (int k = 0; k < table.padded; k += static_cast<int>(hn::Lanes(d))) {
    const auto phi = interpolate(at, table.padded, k);
    hn::StoreU(rim ? hn::Mul(phi, hn::LoadU(d, &table.on_rim[k])) : phi, d, out + k);
  }
}

/// Adds the points from the `next` on whose first grid row is `entry` or, if they are still to be spread, an
/// earlier one; returns the one that then is next. `sources`: the area's or the rim's.
template <typename Real>
std::size_t spread_points(RowSpreader<Real>& s, std::int64_t entry, const PointScatter<Real>& points,
                          SpreadSources sources, std::size_t next) {
  const Lanes<Real> d;
  const int step = static_cast<int>(hn::Lanes(d));
  const int padded = s.problem.functions->padded, taps = points.taps;
  if (s.sources.size() < static_cast<std::size_t>(padded)) s.sources.resize(static_cast<std::size_t>(padded));
  Real* phi = s.sources.data();
  for (; next < points.size() && points.row[next] <= entry; ++next) {
    const std::int64_t row = points.row[next];
    if (row + taps <= entry) continue;
    evaluate_point(s.problem, points, next, sources, phi);
    const Real *kx = &points.x[next * taps], *ky = &points.y[next * taps];
    for (int j = static_cast<int>(std::max<std::int64_t>(entry - row, 0)); j < taps; ++j) {
      Real* to = s.open_row(row + j) + std::int64_t{points.col[next]} * padded;
      for (int i = 0; i < taps; ++i, to += padded) {
        const auto weight = hn::Set(d, kx[i] * ky[j]);
        for (int k = 0; k < padded; k += step)
          hn::StoreU(hn::MulAdd(weight, hn::LoadU(d, phi + k), hn::LoadU(d, to + k)), d, to + k);
      }
    }
  }
  return next;
}

/// The points of what the lattice leaves out.
template <typename Real>
void spread_steep(RowSpreader<Real>& s, std::int64_t entry) {
  const SpreadProblem<Real>& p = s.problem;
  if (p.sources != SpreadSources::Rim)
    s.next_steep = spread_points(s, entry, p.steep, SpreadSources::Area, s.next_steep);
  if (p.sources == SpreadSources::Area) return;
  for (std::size_t axis = 0; axis < 2; ++axis)
    s.next_steep_rim[axis] =
        spread_points(s, entry, p.steep_rim[axis], SpreadSources::Rim, s.next_steep_rim[axis]);
}

template <typename Real>
void spread_row(RowSpreader<Real>& s, std::int64_t m) {
  const GatherTable<Real>& y = s.problem.gather_y;
  const std::int64_t entry = m - s.problem.row_begin;
  for (std::int64_t done = s.open_begin; done < std::min(entry, s.open_begin + s.open_rows); ++done)
    std::fill_n(s.open_row(done), s.row_size(), Real(0));
  s.open_begin = entry;
  const std::int64_t end = y.start[entry] + y.taps;
  for (s.next = std::max<std::int64_t>(s.next, y.start[entry]); s.next < end;) {
    const std::int64_t last = std::min<std::int64_t>(s.next + kBatchRows, end);
    spread_batch(s, s.next, last);
    s.next = last;
  }
  spread_steep(s, entry);
}

}  // namespace

void SpreadRowFloat(RowSpreader<float>& s, std::int64_t m) {
  spread_row(s, m);
}
void SpreadRowDouble(RowSpreader<double>& s, std::int64_t m) {
  spread_row(s, m);
}

}  // namespace HWY_NAMESPACE
}  // namespace micro
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace micro {

HWY_EXPORT(SpreadRowFloat);
HWY_EXPORT(SpreadRowDouble);

namespace {

/// Grid rows that one source row reaches at most.
template <typename Real>
std::int64_t reached_rows(const GatherTable<Real>& y) {
  std::int64_t most = 0;
  std::size_t first = 0;
  for (std::size_t m = 0; m < y.start.size(); ++m) {
    while (y.start[first] + y.taps <= y.start[m])
      ++first;
    most = std::max(most, static_cast<std::int64_t>(m - first) + 1);
  }
  return most;
}

}  // namespace

template <typename Real>
RowSpreader<Real>::RowSpreader(const SpreadProblem<Real>& p)
    : problem(p),
      open_rows(std::max<std::int64_t>(reached_rows(p.gather_y),
                                       std::max({p.steep.taps, p.steep_rim[0].taps, p.steep_rim[1].taps}))) {
  const double sources_per_col =
      static_cast<double>(p.lattice->cols()) / static_cast<double>(std::max<std::int64_t>(p.grid_cols, 1));
  const double col_bytes =
      std::max(sources_per_col, 1.) * static_cast<double>(p.functions->padded) * sizeof(Real);
  constexpr double kFewestCols = 32, kMostCols = 256;
  block_cols = static_cast<std::int64_t>(std::clamp(kBlockBytes / col_bytes, kFewestCols, kMostCols));
  const auto block = static_cast<std::size_t>(block_cols * p.functions->padded);
  for (int b = 0; b < kBatchRows; ++b) {
    block_rows[b].resize(block);
    block_rim_rows[b].resize(block);
  }
  open.assign(static_cast<std::size_t>(open_rows * row_size()), Real(0));
}

template <>
const float* RowSpreader<float>::row(std::int64_t m) {
  HWY_DYNAMIC_DISPATCH(SpreadRowFloat)(*this, m);
  return open_row(m - problem.row_begin);
}

template <>
const double* RowSpreader<double>::row(std::int64_t m) {
  HWY_DYNAMIC_DISPATCH(SpreadRowDouble)(*this, m);
  return open_row(m - problem.row_begin);
}

template class RowSpreader<float>;
template class RowSpreader<double>;

}  // namespace micro
#endif
