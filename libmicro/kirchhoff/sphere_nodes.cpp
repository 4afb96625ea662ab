#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kirchhoff/sphere_nodes.cpp"
#include "kirchhoff/sphere_nodes.h"

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef MICRO_KIRCHHOFF_SPHERE_NODES_SHARED_
#define MICRO_KIRCHHOFF_SPHERE_NODES_SHARED_
#include <algorithm>
#include <cmath>
#endif

HWY_BEFORE_NAMESPACE();
namespace micro {
namespace HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

template <typename Real>
using Lanes = hn::CappedTag<Real, kTermLanes>;

/// One row of |q|² Â + R̂ in the columns that the tile reads: [columns, 2, terms].
template <typename Real>
void combine_row(const SphereTile<Real>& tile, std::int64_t row, std::int64_t first, std::int64_t last,
                 Real* out) {
  const Lanes<Real> d;
  const int lanes = static_cast<int>(hn::Lanes(d)), padded = tile.columns->padded;
  for (std::int64_t column = first; column < last; ++column, out += 2 * tile.terms) {
    const Real* in = tile.columns->at(column, row);
    for (int k = 0; k < tile.terms; k += lanes) {
      const auto scale = hn::LoadU(d, tile.scale + k);
      hn::StoreU(hn::MulAdd(scale, hn::LoadU(d, in + k), hn::LoadU(d, in + 2 * padded + k)), d, out + k);
      hn::StoreU(hn::MulAdd(scale, hn::LoadU(d, in + padded + k), hn::LoadU(d, in + 3 * padded + k)), d,
                 out + tile.terms + k);
    }
  }
}

/// out[0 … Width vectors) = Σ_t weight[t]·in[t·stride …).
template <int Width, typename Real>
HWY_INLINE void weigh(const Real* weight, int taps, const Real* in, std::int64_t stride, Real* out) {
  const Lanes<Real> d;
  constexpr int kLanes = static_cast<int>(hn::MaxLanes(d));
  auto a = hn::Zero(d), b = a, c = a, e = a;
  for (int t = 0; t < taps; ++t, in += stride) {
    const auto w = hn::Set(d, weight[t]);
    a = hn::MulAdd(w, hn::LoadU(d, in), a);
    b = hn::MulAdd(w, hn::LoadU(d, in + kLanes), b);
    if constexpr (Width == 4) {
      c = hn::MulAdd(w, hn::LoadU(d, in + 2 * kLanes), c);
      e = hn::MulAdd(w, hn::LoadU(d, in + 3 * kLanes), e);
    }
  }
  hn::StoreU(a, d, out);
  hn::StoreU(b, d, out + kLanes);
  if constexpr (Width == 4) {
    hn::StoreU(c, d, out + 2 * kLanes);
    hn::StoreU(e, d, out + 3 * kLanes);
  }
}

template <typename Real>
void interpolate_along_x(const SphereTile<Real>& tile, std::int64_t rows, TileMemory<Real>& memory) {
  constexpr int kLanes = static_cast<int>(hn::MaxLanes(Lanes<Real>()));
  const int width = tile.x->width, numbers = 2 * tile.terms;
  const std::int64_t first = tile.x->start[tile.kx_begin], last = tile.x->start[tile.kx_end - 1] + width;
  const std::int64_t first_row = tile.y->start[tile.ky_begin + tile.half] + tile.y_reach;
  for (std::int64_t row = 0; row < rows; ++row) {
    combine_row(tile, first_row + row, first, last, memory.row.data());
    for (int kx = tile.kx_begin; kx < tile.kx_end; ++kx) {
      const Real* in = memory.row.data() + (tile.x->start[kx] - first) * numbers;
      const Real* weight = &tile.x->weight[static_cast<std::size_t>(kx) * width];
      Real* out = memory.along_x.data() + ((kx - tile.kx_begin) * rows + row) * numbers;
      int k = 0;
      for (; k + 4 * kLanes <= numbers; k += 4 * kLanes)
        weigh<4>(weight, width, in + k, numbers, out + k);
      for (; k < numbers; k += 2 * kLanes)
        weigh<2>(weight, width, in + k, numbers, out + k);
    }
  }
}

template <typename Real>
void sum_node(const SphereTile<Real>& tile, double qz, const Real* weight, const Real* in, Real* out) {
  const Lanes<Real> d;
  const int lanes = static_cast<int>(hn::Lanes(d)), width = tile.y->width, terms = tile.terms;
  const TermCoefficients<Real>& table = *tile.coefficients;
  const double position = (qz - table.low) * table.per_q;
  const int entry = std::clamp(static_cast<int>(position), 0, table.entries - 2);
  const auto t = hn::Set(d, static_cast<Real>(position - entry));
  const Real* c = table.data.data() + std::int64_t{entry} * 2 * table.padded;
  auto rr = hn::Zero(d), ii = rr, ri = rr, ir = rr;
  for (int k = 0; k < terms; k += lanes) {
    auto re = hn::Zero(d), im = re;
    const Real* from = in + k;
    for (int tap = 0; tap < width; ++tap, from += 2 * terms) {
      const auto w = hn::Set(d, weight[tap]);
      re = hn::MulAdd(w, hn::LoadU(d, from), re);
      im = hn::MulAdd(w, hn::LoadU(d, from + terms), im);
    }
    const auto c_re0 = hn::LoadU(d, c + k), c_im0 = hn::LoadU(d, c + table.padded + k);
    const auto c_re = hn::MulAdd(t, hn::Sub(hn::LoadU(d, c + 2 * table.padded + k), c_re0), c_re0);
    const auto c_im = hn::MulAdd(t, hn::Sub(hn::LoadU(d, c + 3 * table.padded + k), c_im0), c_im0);
    rr = hn::MulAdd(c_re, re, rr);
    ii = hn::MulAdd(c_im, im, ii);
    ri = hn::MulAdd(c_re, im, ri);
    ir = hn::MulAdd(c_im, re, ir);
  }
  // Real images: the spectrum at −q_⊥ is the conjugate.
  out[0] = hn::GetLane(hn::SumOfLanes(d, hn::Sub(rr, ii)));
  out[1] = hn::GetLane(hn::SumOfLanes(d, hn::Add(ri, ir)));
  out[2] = hn::GetLane(hn::SumOfLanes(d, hn::Add(rr, ii)));
  out[3] = hn::GetLane(hn::SumOfLanes(d, hn::Sub(ir, ri)));
}

template <typename Real>
void evaluate(const SphereTile<Real>& tile, TileMemory<Real>& memory) {
  const int width = tile.y->width, numbers = 2 * tile.terms;
  const auto start_y = [&](int ky) { return tile.y->start[ky + tile.half]; };
  const std::int64_t rows = start_y(tile.ky_end - 1) + width - start_y(tile.ky_begin);
  const auto columns = static_cast<std::size_t>(tile.kx_end - tile.kx_begin),
             nodes = static_cast<std::size_t>(tile.ky_end - tile.ky_begin);
  const auto grow = [](FftVector<Real>& vector, std::size_t size) {
    if (vector.size() < size) vector.resize(size);
  };
  grow(memory.row, static_cast<std::size_t>(tile.x->start[tile.kx_end - 1] + tile.x->width -
                                            tile.x->start[tile.kx_begin]) *
                       numbers);
  grow(memory.along_x, columns * static_cast<std::size_t>(rows) * numbers);
  grow(memory.field, columns * nodes * 4);
  interpolate_along_x(tile, rows, memory);
  for (int kx = tile.kx_begin; kx < tile.kx_end; ++kx) {
    const Real* column = memory.along_x.data() + (kx - tile.kx_begin) * rows * numbers;
    Real* out = &memory.field[static_cast<std::size_t>(kx - tile.kx_begin) * nodes * 4];
    for (int ky = tile.ky_begin; ky < tile.ky_end; ++ky, out += 4) {
      const double qx = kx * tile.spacing, qy = ky * tile.spacing;
      const double qz2 = tile.sphere - qx * qx - qy * qy;
      // Nodes on the horizon, to rounding, are the caller's to take or leave.
      if (qz2 > -1e-9 * tile.sphere)
        sum_node(tile, std::sqrt(std::max(0.0, qz2)),
                 &tile.y->weight[static_cast<std::size_t>(ky + tile.half) * static_cast<std::size_t>(width)],
                 column + (start_y(ky) - start_y(tile.ky_begin)) * numbers, out);
    }
  }
}

}  // namespace

void EvaluateFloat(const SphereTile<float>& tile, TileMemory<float>& memory) {
  evaluate(tile, memory);
}
void EvaluateDouble(const SphereTile<double>& tile, TileMemory<double>& memory) {
  evaluate(tile, memory);
}

}  // namespace HWY_NAMESPACE
}  // namespace micro
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace micro {

HWY_EXPORT(EvaluateFloat);
HWY_EXPORT(EvaluateDouble);

void evaluate_tile(const SphereTile<float>& tile, TileMemory<float>& memory) {
  HWY_DYNAMIC_DISPATCH(EvaluateFloat)(tile, memory);
}

void evaluate_tile(const SphereTile<double>& tile, TileMemory<double>& memory) {
  HWY_DYNAMIC_DISPATCH(EvaluateDouble)(tile, memory);
}

template <typename Real>
NodeStencils<Real> make_node_stencils(const SpectrumAxis& axis, double spacing, int first, int last) {
  const GriddingKernel kernel = axis.interpolation();
  NodeStencils<Real> stencils;
  stencils.width = axis.interpolation_width;
  for (int k = first; k <= last; ++k) {
    const double q = spacing * k, u = q / axis.step;
    const auto start = static_cast<std::int32_t>(std::ceil(u - stencils.width / 2.0));
    stencils.start.push_back(start);
    const double gridding = axis.gridding.spectrum(q);
    for (int t = 0; t < stencils.width; ++t)
      stencils.weight.push_back(static_cast<Real>(kernel(q - (start + t) * axis.step).k / gridding));
  }
  return stencils;
}

template NodeStencils<float> make_node_stencils(const SpectrumAxis&, double, int, int);
template NodeStencils<double> make_node_stencils(const SpectrumAxis&, double, int, int);

}  // namespace micro
#endif
