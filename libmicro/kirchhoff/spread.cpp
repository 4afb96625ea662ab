#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kirchhoff/spread.cpp"
#include "kirchhoff/spread.h"

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef MICRO_KIRCHHOFF_SPREAD_SHARED_
#define MICRO_KIRCHHOFF_SPREAD_SHARED_
#include <algorithm>
#include <cassert>
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
HWY_INLINE Interpolation<Real> locate(const FunctionTable<Real>& table, float z, Real factor) {
  const double position = (static_cast<double>(z) - table.low) * table.per_height;
  const int index = std::clamp(static_cast<int>(position), 0, table.entries - 2);
  const Real t = static_cast<Real>(position - index), s = 1 - t;
  return {&table.data[static_cast<std::size_t>(index) * 2 * table.padded], factor * s * s * (1 + 2 * t),
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

/// Q²·area·φ_k of every second (step 2, from column 1) or every lattice point.
template <typename Real>
void evaluate_sources(RowSpreader<Real>& s, int offset, int step) {
  const Lanes<Real> d;
  const FunctionTable<Real>& table = *s.problem.functions;
  const auto q_squared = static_cast<Real>(s.problem.q_squared);
  Real* out = s.sources.data();
  for (std::int64_t x = offset; x < s.problem.lattice->cols(); x += step, out += table.padded) {
    const auto at =
        locate<Real>(table, s.lattice_row.z[x], q_squared * static_cast<Real>(s.lattice_row.area[x]));
    for (int k = 0; k < table.padded; k += static_cast<int>(hn::Lanes(d)))
      hn::StoreU(interpolate(at, table.padded, k), d, out + k);
  }
}

/// out[m] = Σ_t value[m, t]·in[start[m] + t] for `Width` vectors of terms.
template <int Width, typename Real>
void gather_terms(const GatherTable<Real>& table, std::int64_t targets, int padded, const Real* in,
                  Real* out) {
  const Lanes<Real> d;
  constexpr int kStep = static_cast<int>(hn::MaxLanes(d));
  const Real* weight = table.value.data();
  for (std::int64_t m = 0; m < targets; ++m, weight += table.taps) {
    const Real* source = in + static_cast<std::int64_t>(table.start[m]) * padded;
    hn::Vec<Lanes<Real>> a = hn::Zero(d), b = hn::Zero(d);
    for (int t = 0; t < table.taps; ++t, source += padded) {
      const auto w = hn::Set(d, weight[t]);
      a = hn::MulAdd(w, hn::LoadU(d, source), a);
      if constexpr (Width == 2) b = hn::MulAdd(w, hn::LoadU(d, source + kStep), b);
    }
    hn::StoreU(a, d, out + m * padded);
    if constexpr (Width == 2) hn::StoreU(b, d, out + m * padded + kStep);
  }
}

template <typename Real>
void gather_row(const GatherTable<Real>& table, std::int64_t targets, int padded, const Real* in, Real* out) {
  constexpr int kStep = static_cast<int>(hn::MaxLanes(Lanes<Real>()));
  int k = 0;
  for (; k + 2 * kStep <= padded; k += 2 * kStep)
    gather_terms<2>(table, targets, padded, in + k, out + k);
  for (; k < padded; k += kStep)
    gather_terms<1>(table, targets, padded, in + k, out + k);
}

/// Adds the rim's part: −n_x·φ·∂K/∂x to the row itself, −n_y·φ·K to the row that ∂K/∂y will be applied to.
template <typename Real>
void scatter_rim(RowSpreader<Real>& s, Real* row, Real* rim_row) {
  const Lanes<Real> d;
  const FunctionTable<Real>& table = *s.problem.functions;
  const ScatterTable<Real>& scatter = s.problem.scatter_x;
  const int step = static_cast<int>(hn::Lanes(d));
  for (const int x : s.lattice_row.rim) {
    const auto at = locate<Real>(table, s.lattice_row.z[x], Real(-1));
    const auto nx = static_cast<Real>(s.lattice_row.nx[x]), ny = static_cast<Real>(s.lattice_row.ny[x]);
    const std::int64_t start = static_cast<std::int64_t>(scatter.start[x]) * table.padded;
    const Real* value = &scatter.value[static_cast<std::size_t>(x) * scatter.taps];
    const Real* derivative = &scatter.derivative[static_cast<std::size_t>(x) * scatter.taps];
    for (int k = 0; k < table.padded; k += step) {
      const auto phi = hn::Mul(interpolate(at, table.padded, k), hn::LoadU(d, &table.on_rim[k]));
      for (int t = 0; t < scatter.taps; ++t) {
        Real* to = row + start + t * table.padded + k;
        hn::StoreU(hn::MulAdd(hn::Set(d, nx * derivative[t]), phi, hn::LoadU(d, to)), d, to);
        if (ny == 0) continue;
        Real* rim_to = rim_row + start + t * table.padded + k;
        hn::StoreU(hn::MulAdd(hn::Set(d, ny * value[t]), phi, hn::LoadU(d, rim_to)), d, rim_to);
      }
    }
  }
}

template <typename Real>
void spread_lattice_row(RowSpreader<Real>& s, std::int64_t l) {
  const SpreadProblem<Real>& p = s.problem;
  const int padded = p.functions->padded;
  const std::int64_t slot = l % p.gather_y.taps, row_size = p.grid_cols * padded;
  Real* row = s.ring.data() + slot * row_size;
  Real* rim_row = s.rim_ring.data() + slot * row_size;
  p.lattice->fill(l, s.lattice_row);
  const bool odd = QuadratureLattice::area_on_odd_columns_only(l);
  evaluate_sources(s, odd ? 1 : 0, odd ? 2 : 1);
  gather_row(odd ? p.gather_x_odd : p.gather_x, p.grid_cols, padded, s.sources.data(), row);
  const auto has_y = [&](int x) { return s.lattice_row.ny[x] != 0; };
  s.rim[slot] = std::any_of(s.lattice_row.rim.begin(), s.lattice_row.rim.end(), has_y);
  if (s.rim[slot]) std::fill_n(rim_row, row_size, Real(0));
  scatter_rim(s, row, rim_row);
}

template <typename Real>
void spread_row(RowSpreader<Real>& s, std::int64_t m) {
  const SpreadProblem<Real>& p = s.problem;
  const GatherTable<Real>& y = p.gather_y;
  const std::int64_t entry = m - p.row_begin, start = y.start[entry],
                     row_size = p.grid_cols * p.functions->padded;
  for (s.next = std::max(s.next, start); s.next < start + y.taps; ++s.next)
    spread_lattice_row(s, s.next);
  const Lanes<Real> d;
  const int step = static_cast<int>(hn::Lanes(d));
  const Real* value = &y.value[static_cast<std::size_t>(entry) * y.taps];
  const Real* derivative = &y.derivative[static_cast<std::size_t>(entry) * y.taps];
  std::vector<const Real*> rows;
  for (int t = 0; t < y.taps; ++t)
    rows.push_back(s.ring.data() + (start + t) % y.taps * row_size);
  for (std::int64_t i = 0; i < row_size; i += step) {
    auto sum = hn::Zero(d);
    for (int t = 0; t < y.taps; ++t)
      sum = hn::MulAdd(hn::Set(d, value[t]), hn::LoadU(d, rows[t] + i), sum);
    hn::StoreU(sum, d, &s.result[i]);
  }
  for (int t = 0; t < y.taps; ++t) {
    const std::int64_t slot = (start + t) % y.taps;
    if (!s.rim[slot]) continue;
    const Real* rim_row = s.rim_ring.data() + slot * row_size;
    const auto w = hn::Set(d, derivative[t]);
    for (std::int64_t i = 0; i < row_size; i += step)
      hn::StoreU(hn::MulAdd(w, hn::LoadU(d, rim_row + i), hn::LoadU(d, &s.result[i])), d, &s.result[i]);
  }
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

template <typename Real>
RowSpreader<Real>::RowSpreader(const SpreadProblem<Real>& p)
    : problem(p),
      sources(static_cast<std::size_t>(p.lattice->cols() * p.functions->padded)),
      ring(static_cast<std::size_t>(p.gather_y.taps * p.grid_cols * p.functions->padded)),
      rim_ring(ring.size()),
      rim(static_cast<std::size_t>(p.gather_y.taps)),
      result(static_cast<std::size_t>(p.grid_cols * p.functions->padded)) {}

template <>
const float* RowSpreader<float>::row(std::int64_t m) {
  HWY_DYNAMIC_DISPATCH(SpreadRowFloat)(*this, m);
  return result.data();
}

template <>
const double* RowSpreader<double>::row(std::int64_t m) {
  HWY_DYNAMIC_DISPATCH(SpreadRowDouble)(*this, m);
  return result.data();
}

template class RowSpreader<float>;
template class RowSpreader<double>;

}  // namespace micro
#endif
