#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kirchhoff/exact.cpp"
#include "kirchhoff/exact.h"

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "kirchhoff/sincos-inl.h"

// What every instruction set shares; defined once.
#ifndef MICRO_KIRCHHOFF_EXACT_SHARED_
#define MICRO_KIRCHHOFF_EXACT_SHARED_
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "height/triangles.h"

namespace micro {
namespace {

using Complex = std::complex<double>;

/// Amplitudes of the lower and the upper triangle of each cell of one row of cells (real and imaginary
/// parts).
struct RowWeights {
  const double *lower_re, *lower_im, *upper_re, *upper_im;
};

/// One direction on one surface.
struct ExactProblem {
  const HeightField& surface;
  Vec3 q;
  const double *x_re, *x_im;            ///< e^{−i q_x x} for every column, padded by kPadding
  const FacetReflectance* reflectance;  ///< or nullptr: 1
  const Grid<float>* taper;             ///< [rows−1, cols−1], or nullptr: 1
  bool weighted() const { return reflectance || taper; }
};

/// At least as many as a vector has lanes; rows are padded with missing points.
constexpr Eigen::Index kPadding = 64;

}  // namespace
}  // namespace micro
#endif

HWY_BEFORE_NAMESPACE();
namespace micro {
namespace HWY_NAMESPACE {
namespace {

using D = hn::ScalableTag<double>;
using V = hn::Vec<D>;
using C = ComplexLanes<V>;

/// Below this spread of phases the Taylor series is used. Above it the divided difference loses at most
/// ε/spread of the envelope, ε = 2.2e-16; below it eight terms leave 0.05⁸/8! = 1e-15.
constexpr double kSeriesSpread = 0.05;

/// An edge of the surface: the difference u of phase between its ends, and the mean of e^{−iφ} along it,
/// e^{−iφ₀}·(1 − e^{−iu})/(iu), φ₀ the phase of its first end.
struct Edge {
  V u;
  C mean;
};

HWY_INLINE Edge make_edge(D d, C first_end, V u) {
  const auto half = cos_sin(d, hn::Mul(u, hn::Set(d, 0.5)));
  const auto zero = hn::Eq(u, hn::Zero(d));
  const auto sinc = hn::IfThenElse(zero, hn::Set(d, 1.0), hn::Div(hn::Add(half.im, half.im), u));
  return {u, first_end * C{hn::Mul(sinc, half.re), hn::Neg(hn::Mul(sinc, half.im))}};
}

/// mean_T(e^{−iφ}) of a triangle v₀ → v₁ → v₂ with edges `first` (v₀v₁), `second` (v₁v₂) and `diagonal`
/// (v₀v₂): the difference of the means along two edges over the difference of phase along the third, times
/// 2i, where the third is the one with the largest difference of phase.
HWY_INLINE C divided_difference(D d, const Edge& first, const Edge& second, const Edge& diagonal) {
  const auto a = hn::Abs(first.u), b = hn::Abs(second.u), c = hn::Abs(diagonal.u);
  const auto by_first = hn::And(hn::Ge(a, b), hn::Ge(a, c));
  const auto by_diagonal = hn::Ge(c, b);
  const auto u = hn::IfThenElse(by_first, first.u, hn::IfThenElse(by_diagonal, diagonal.u, second.u));
  const auto not_second = hn::Or(by_first, by_diagonal);
  const C plus = {hn::IfThenElse(not_second, second.mean.re, diagonal.mean.re),
                  hn::IfThenElse(not_second, second.mean.im, diagonal.mean.im)};
  const C minus = {hn::IfThenElse(by_first, diagonal.mean.re, first.mean.re),
                   hn::IfThenElse(by_first, diagonal.mean.im, first.mean.im)};
  const C difference = plus - minus;
  const auto scale = hn::Div(hn::Set(d, 2.0), u);
  return {hn::Neg(hn::Mul(difference.im, scale)), hn::Mul(difference.re, scale)};
}

/// The same for small spreads: e^{−iφ₀} Σ_k (−i)^k h_k(a, b)·2/(k+2)!, h_k = Σ a^i b^{k−i} the complete
/// homogeneous polynomial of the differences of phase a = φ₁ − φ₀, b = φ₂ − φ₀.
HWY_INLINE C series(D d, C corner, V a, V b) {
  const auto b2 = hn::Mul(b, b), b3 = hn::Mul(b2, b), b4 = hn::Mul(b2, b2);
  const auto h1 = hn::Add(a, b);
  const auto h2 = hn::MulAdd(a, h1, b2);
  const auto h3 = hn::MulAdd(a, h2, b3);
  const auto h4 = hn::MulAdd(a, h3, b4);
  const auto h5 = hn::MulAdd(a, h4, hn::Mul(b4, b));
  const auto h6 = hn::MulAdd(a, h5, hn::Mul(b4, b2));
  const auto h7 = hn::MulAdd(a, h6, hn::Mul(b4, b3));
  auto re = hn::MulAdd(h2, hn::Set(d, -2.0 / 24), hn::Set(d, 1.0));
  re = hn::MulAdd(h4, hn::Set(d, 2.0 / 720), re);
  re = hn::MulAdd(h6, hn::Set(d, -2.0 / 40320), re);
  auto im = hn::MulAdd(h1, hn::Set(d, -2.0 / 6), hn::Mul(h3, hn::Set(d, 2.0 / 120)));
  im = hn::MulAdd(h5, hn::Set(d, -2.0 / 5040), im);
  im = hn::MulAdd(h7, hn::Set(d, 2.0 / 362880), im);
  return corner * C{re, im};
}

HWY_INLINE C triangle_mean(D d, C corner, const Edge& first, const Edge& second, const Edge& diagonal) {
  const auto spread = hn::Max(hn::Abs(first.u), hn::Max(hn::Abs(second.u), hn::Abs(diagonal.u)));
  const auto close = hn::Lt(spread, hn::Set(d, kSeriesSpread));
  const C far = divided_difference(d, first, second, diagonal);
  if (hn::AllFalse(d, close)) return far;
  const C near = series(d, corner, first.u, diagonal.u);
  return {hn::IfThenElse(close, near.re, far.re), hn::IfThenElse(close, near.im, far.im)};
}

/// A row of vertices: heights, e^{−i(q_x x + q_z z)}, and the edges from each vertex to the next one.
struct VertexRow {
  std::vector<double> z, re, im, u, edge_re, edge_im;
  explicit VertexRow(std::size_t padded)
      : z(padded, NAN), re(padded), im(padded), u(padded), edge_re(padded), edge_im(padded) {}

  C vertex(D d, Eigen::Index i) const { return {hn::LoadU(d, &re[i]), hn::LoadU(d, &im[i])}; }
  Edge edge(D d, Eigen::Index i) const {
    return {hn::LoadU(d, &u[i]), {hn::LoadU(d, &edge_re[i]), hn::LoadU(d, &edge_im[i])}};
  }

  void fill(const ExactProblem& problem, Eigen::Index j) {
    const D d;
    const Eigen::Index cols = problem.surface.cols();
    const float* heights = &problem.surface.z(j, 0);
    for (Eigen::Index i = 0; i < cols; ++i)
      z[i] = heights[i];
    const auto qz = hn::Set(d, problem.q.z()), step = hn::Set(d, problem.q.x() * problem.surface.dx);
    for (Eigen::Index i = 0; i < cols; i += static_cast<Eigen::Index>(hn::Lanes(d))) {
      const auto here = hn::LoadU(d, &z[i]);
      const auto turn = cos_sin(d, hn::Mul(qz, here));
      const C phasor =
          C{hn::LoadU(d, problem.x_re + i), hn::LoadU(d, problem.x_im + i)} * C{turn.re, hn::Neg(turn.im)};
      const Edge next = make_edge(d, phasor, hn::MulAdd(qz, hn::Sub(hn::LoadU(d, &z[i + 1]), here), step));
      hn::StoreU(phasor.re, d, &re[i]);
      hn::StoreU(phasor.im, d, &im[i]);
      hn::StoreU(next.u, d, &u[i]);
      hn::StoreU(next.mean.re, d, &edge_re[i]);
      hn::StoreU(next.mean.im, d, &edge_im[i]);
    }
  }
};

/// The edges between two rows of vertices, from each vertex of the first to its neighbour in the second.
struct RisingEdges {
  std::vector<double> u, re, im;
  explicit RisingEdges(std::size_t padded) : u(padded, NAN), re(padded), im(padded) {}

  Edge edge(D d, Eigen::Index i) const {
    return {hn::LoadU(d, &u[i]), {hn::LoadU(d, &re[i]), hn::LoadU(d, &im[i])}};
  }

  void fill(const ExactProblem& problem, const VertexRow& low, const VertexRow& high) {
    const D d;
    const auto qz = hn::Set(d, problem.q.z()), step = hn::Set(d, problem.q.y() * problem.surface.dy);
    for (Eigen::Index i = 0; i < problem.surface.cols(); i += static_cast<Eigen::Index>(hn::Lanes(d))) {
      const auto rise = hn::Sub(hn::LoadU(d, &high.z[i]), hn::LoadU(d, &low.z[i]));
      const Edge up = make_edge(d, low.vertex(d, i), hn::MulAdd(qz, rise, step));
      hn::StoreU(up.u, d, &u[i]);
      hn::StoreU(up.mean.re, d, &re[i]);
      hn::StoreU(up.mean.im, d, &im[i]);
    }
  }
};

/// Σ (2/(dx·dy))·(q·a_T)·R_T·mean_T over one row of cells, without the phase q_y·y of its first row of
/// vertices.
Complex cell_row_sum(const ExactProblem& problem, const VertexRow& low, const VertexRow& high,
                     const RisingEdges& rising, const RowWeights* weights) {
  const D d;
  const HeightField& surface = problem.surface;
  const Vec3& q = problem.q;
  const auto qz = hn::Set(d, q.z()), to_corner = hn::Set(d, q.x() * surface.dx + q.y() * surface.dy);
  const auto qx_slope = hn::Set(d, q.x() / surface.dx), qy_slope = hn::Set(d, q.y() / surface.dy);
  const double turn = q.y() * surface.dy;
  const C up = {hn::Set(d, std::cos(turn)), hn::Set(d, -std::sin(turn))};
  auto sum_re = hn::Zero(d), sum_im = hn::Zero(d);
  const auto add = [&](C mean, V flux, const double* re, const double* im, Eigen::Index i) HWY_ATTR {
    if (weights) mean = mean * C{hn::LoadU(d, re + i), hn::LoadU(d, im + i)};
    const auto there = hn::Eq(flux, flux);
    sum_re = hn::Add(sum_re, hn::IfThenElseZero(there, hn::Mul(mean.re, flux)));
    sum_im = hn::Add(sum_im, hn::IfThenElseZero(there, hn::Mul(mean.im, flux)));
  };
  for (Eigen::Index i = 0; i + 1 < surface.cols(); i += static_cast<Eigen::Index>(hn::Lanes(d))) {
    const auto z00 = hn::LoadU(d, &low.z[i]), z01 = hn::LoadU(d, &low.z[i + 1]);
    const auto z10 = hn::LoadU(d, &high.z[i]), z11 = hn::LoadU(d, &high.z[i + 1]);
    const C corner = low.vertex(d, i);
    const Edge diagonal = make_edge(d, corner, hn::MulAdd(qz, hn::Sub(z11, z00), to_corner));
    const Edge top = high.edge(d, i);
    const C lower = triangle_mean(d, corner, low.edge(d, i), rising.edge(d, i + 1), diagonal);
    const C upper = triangle_mean(d, corner, rising.edge(d, i), Edge{top.u, top.mean * up}, diagonal);
    const auto lower_flux =
        hn::NegMulAdd(qx_slope, hn::Sub(z01, z00), hn::NegMulAdd(qy_slope, hn::Sub(z11, z01), qz));
    const auto upper_flux =
        hn::NegMulAdd(qx_slope, hn::Sub(z11, z10), hn::NegMulAdd(qy_slope, hn::Sub(z10, z00), qz));
    add(lower, lower_flux, weights ? weights->lower_re : nullptr, weights ? weights->lower_im : nullptr, i);
    add(upper, upper_flux, weights ? weights->upper_re : nullptr, weights ? weights->upper_im : nullptr, i);
  }
  return {hn::GetLane(hn::SumOfLanes(d, sum_re)), hn::GetLane(hn::SumOfLanes(d, sum_im))};
}

/// The amplitudes of one row of cells, in the layout that cell_row_sum reads; 0 where a triangle is missing.
struct WeightBuffer {
  std::vector<double> lower_re, lower_im, upper_re, upper_im;
  explicit WeightBuffer(std::size_t padded)
      : lower_re(padded), lower_im(padded), upper_re(padded), upper_im(padded) {}

  RowWeights fill(const ExactProblem& problem, Eigen::Index j) {
    for_each_triangle(problem.surface, j, [&](const Triangle& t) {
      Complex r = 1;
      if (problem.reflectance) r = (*problem.reflectance)(Vec3(-t.zx, -t.zy, 1).normalized());
      if (problem.taper) r *= (*problem.taper)(t.a.y(), t.a.x());
      const bool lower = t.b.y() == t.a.y();
      (lower ? lower_re : upper_re)[t.a.x()] = r.real();
      (lower ? lower_im : upper_im)[t.a.x()] = r.imag();
    });
    return {lower_re.data(), lower_im.data(), upper_re.data(), upper_im.data()};
  }
};

/// F over rows of cells [begin, end).
Complex cell_block_sum(const ExactProblem& problem, Eigen::Index begin, Eigen::Index end) {
  const auto padded = static_cast<std::size_t>(problem.surface.cols() + kPadding);
  VertexRow low(padded), high(padded);
  RisingEdges rising(padded);
  WeightBuffer buffer(problem.weighted() ? padded : 0);
  Complex sum = 0;
  high.fill(problem, begin);
  for (Eigen::Index j = begin; j < end; ++j) {
    std::swap(low, high);
    high.fill(problem, j + 1);
    rising.fill(problem, low, high);
    RowWeights weights{};
    if (problem.weighted()) weights = buffer.fill(problem, j);
    const Complex row = cell_row_sum(problem, low, high, rising, problem.weighted() ? &weights : nullptr);
    sum += row * std::polar(1.0, -problem.q.y() * problem.surface.dy * static_cast<double>(j));
  }
  return sum * (problem.surface.dx * problem.surface.dy / 2);
}

}  // namespace

Complex CellBlockSum(const ExactProblem& problem, Eigen::Index begin, Eigen::Index end) {
  return cell_block_sum(problem, begin, end);
}

}  // namespace HWY_NAMESPACE
}  // namespace micro
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace micro {
namespace {

HWY_EXPORT(CellBlockSum);

/// Rows of cells handed out together.
constexpr Eigen::Index kBlockRows = 32;

std::vector<Complex> field(const HeightField& surface, std::span<const Vec3> q,
                           const FacetReflectance* reflectance, const Grid<float>* taper) {
  const Eigen::Index cell_rows = surface.rows() - 1;
  std::vector<Complex> result(q.size());
  if (cell_rows < 1 || surface.cols() < 2) return result;
  const Eigen::Index blocks = (cell_rows + kBlockRows - 1) / kBlockRows;
  const std::size_t padded = static_cast<std::size_t>(surface.cols() + kPadding);
  std::vector<Complex> partial(static_cast<std::size_t>(blocks) * q.size());
  parallel_for(static_cast<std::int64_t>(partial.size()), [&](std::int64_t task) {
    const Vec3& direction = q[static_cast<std::size_t>(task / blocks)];
    const Eigen::Index begin = (task % blocks) * kBlockRows;
    std::vector<double> x_re(padded), x_im(padded);
    for (Eigen::Index i = 0; i < surface.cols(); ++i) {
      const double phase = direction.x() * surface.dx * static_cast<double>(i);
      x_re[i] = std::cos(phase);
      x_im[i] = -std::sin(phase);
    }
    const ExactProblem problem{surface, direction, x_re.data(), x_im.data(), reflectance, taper};
    partial[task] =
        HWY_DYNAMIC_DISPATCH(CellBlockSum)(problem, begin, std::min(begin + kBlockRows, cell_rows));
  });
  for (std::size_t task = 0; task < partial.size(); ++task)
    result[task / static_cast<std::size_t>(blocks)] += partial[task];
  return result;
}

}  // namespace

std::complex<double> exact_field(const HeightField& surface, const Vec3& q) {
  return field(surface, {&q, 1}, nullptr, nullptr).front();
}

std::vector<std::complex<double>> exact_field(const HeightField& surface, std::span<const Vec3> q) {
  return field(surface, q, nullptr, nullptr);
}

std::vector<std::complex<double>> exact_field(const Window& window, std::span<const Vec3> q) {
  return field(window.surface, q, nullptr, window.taper.size() ? &window.taper : nullptr);
}

std::complex<double> exact_field(const HeightField& surface, const Vec3& q,
                                 const FacetReflectance& reflectance) {
  return field(surface, {&q, 1}, &reflectance, nullptr).front();
}

double exact_density(const HeightField& surface, const Vec3& q) {
  const double area = kirchhoff_area(surface);
  return kirchhoff_density(exact_field(surface, q), area);
}

}  // namespace micro
#endif
