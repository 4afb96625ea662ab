#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kirchhoff/monte_carlo_kernel.cpp"
#include "kirchhoff/monte_carlo_kernel.h"

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef MICRO_KIRCHHOFF_MONTE_CARLO_SHARED_
#define MICRO_KIRCHHOFF_MONTE_CARLO_SHARED_
#include <numbers>
#include <type_traits>
#endif

HWY_BEFORE_NAMESPACE();
namespace micro::detail {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace {

using DU = hn::ScalableTag<std::uint32_t>;
using VU = hn::Vec<DU>;

struct Product {
  VU low, high;
};

/// The 64-bit products of 32-bit words, as low and high halves.
HWY_INLINE Product multiply(DU d, VU a, VU b) {
#if HWY_TARGET == HWY_SCALAR
  const std::uint64_t product = static_cast<std::uint64_t>(hn::GetLane(a)) * hn::GetLane(b);
  return {hn::Set(d, static_cast<std::uint32_t>(product)),
          hn::Set(d, static_cast<std::uint32_t>(product >> 32))};
#else
  const hn::Repartition<std::uint64_t, DU> wide;
  const auto even = hn::MulEven(a, b);
  const auto odd = hn::MulEven(hn::BitCast(d, hn::ShiftRight<32>(hn::BitCast(wide, a))), b);
  return {hn::OddEven(hn::BitCast(d, hn::ShiftLeft<32>(odd)), hn::BitCast(d, even)),
          hn::OddEven(hn::BitCast(d, odd), hn::BitCast(d, hn::ShiftRight<32>(even)))};
#endif
}

/// Philox4x32-10 [Salmon11], the generator of core/random.h, one counter per lane.
struct Words {
  VU w0, w1, w2, w3;
};
HWY_INLINE Words philox(DU d, std::uint64_t seed, std::uint32_t stream, std::uint64_t first) {
  VU c0 = hn::Iota(d, static_cast<std::uint32_t>(first)),
     c1 = hn::Set(d, static_cast<std::uint32_t>(first >> 32)), c2 = hn::Set(d, stream), c3 = hn::Zero(d);
  auto k0 = static_cast<std::uint32_t>(seed), k1 = static_cast<std::uint32_t>(seed >> 32);
  for (int round = 0; round < 10; ++round, k0 += 0x9E3779B9u, k1 += 0xBB67AE85u) {
    const Product p = multiply(d, c0, hn::Set(d, 0xD2511F53u));
    const Product r = multiply(d, c2, hn::Set(d, 0xCD9E8D57u));
    c0 = hn::Xor(hn::Xor(r.high, c1), hn::Set(d, k0));
    c1 = r.low;
    c2 = hn::Xor(hn::Xor(p.high, c3), hn::Set(d, k1));
    c3 = p.low;
  }
  return {c0, c1, c2, c3};
}

void random_block(std::uint64_t seed, std::uint32_t stream, std::uint64_t first, std::size_t count,
                  std::uint32_t* out) {
  const DU d;
  for (std::size_t k = 0; k < count; k += hn::Lanes(d)) {
    const Words w = philox(d, seed, stream, first + k);
    hn::StoreU(w.w0, d, out + k);
    hn::StoreU(w.w1, d, out + count + k);
    hn::StoreU(w.w2, d, out + 2 * count + k);
    hn::StoreU(w.w3, d, out + 3 * count + k);
  }
}

/// Uniform numbers in (0, 1] from 24 bits (float) or 31 bits (double) of 32-bit words.
HWY_INLINE hn::Vec<hn::ScalableTag<float>> uniform(hn::ScalableTag<float> d, const std::uint32_t* words) {
  const hn::RebindToSigned<decltype(d)> di;
  const auto bits = hn::BitCast(di, hn::ShiftRight<8>(hn::LoadU(DU(), words)));
  return hn::MulAdd(hn::ConvertTo(d, bits), hn::Set(d, 0x1p-24f), hn::Set(d, 0x1p-25f));
}
HWY_INLINE hn::Vec<hn::ScalableTag<double>> uniform(hn::ScalableTag<double> d, const std::uint32_t* words) {
  const hn::Rebind<std::uint32_t, decltype(d)> du;
  const hn::Rebind<std::int32_t, decltype(d)> di;
  const auto bits = hn::BitCast(di, hn::ShiftRight<1>(hn::LoadU(du, words)));
  return hn::MulAdd(hn::PromoteTo(d, bits), hn::Set(d, 0x1p-31), hn::Set(d, 0x1p-32));
}

template <typename T>
void draw(const TriangleTile<T>& tile, const Stratum& stratum, PointsPerDraw points, T* out) {
  const hn::ScalableTag<T> d;
  using V = hn::Vec<decltype(d)>;
  const std::size_t lanes = hn::Lanes(d);
  std::vector<std::uint32_t> words(4 * tile.count);
  random_block(stratum.seed, stratum.stream, tile.first_index, tile.count, words.data());
  const auto one = hn::Set(d, static_cast<T>(1)), scale = hn::Set(d, static_cast<T>(stratum.scale)),
             beta0 = hn::Set(d, static_cast<T>(stratum.beta)),
             gamma0 = hn::Set(d, static_cast<T>(stratum.gamma));
  for (std::size_t t = 0; t < tile.count; t += lanes) {
    const auto bx = hn::LoadU(d, &tile.bx[t]), by = hn::LoadU(d, &tile.by[t]), cx = hn::LoadU(d, &tile.cx[t]),
               cy = hn::LoadU(d, &tile.cy[t]), zx = hn::LoadU(d, &tile.zx[t]), zy = hn::LoadU(d, &tile.zy[t]),
               x = hn::LoadU(d, &tile.x[t]), y = hn::LoadU(d, &tile.y[t]), z = hn::LoadU(d, &tile.z[t]);
    const auto store = [&](V beta_in, V gamma_in) HWY_ATTR {
      const auto beta = hn::MulAdd(beta_in, scale, beta0), gamma = hn::MulAdd(gamma_in, scale, gamma0);
      const auto across = hn::MulAdd(beta, bx, hn::Mul(gamma, cx));
      const auto along = hn::MulAdd(beta, by, hn::Mul(gamma, cy));
      hn::StoreU(hn::Add(x, across), d, out);
      hn::StoreU(hn::Add(y, along), d, out + lanes);
      hn::StoreU(hn::Add(z, hn::MulAdd(zx, across, hn::Mul(zy, along))), d, out + 2 * lanes);
      out += 3 * lanes;
    };
    for (std::size_t half = 0; half < 2; ++half) {
      // Uniform in the unit square, its upper triangle folded onto the lower one.
      const auto u = uniform(d, &words[2 * half * tile.count + t]);
      const auto v = uniform(d, &words[(2 * half + 1) * tile.count + t]);
      const auto outside = hn::Gt(hn::Add(u, v), one);
      const auto beta = hn::IfThenElse(outside, hn::Sub(one, u), u);
      const auto gamma = hn::IfThenElse(outside, hn::Sub(one, v), v);
      store(beta, gamma);
      if (points == PointsPerDraw::One) continue;
      const auto alpha = hn::Sub(hn::Sub(one, beta), gamma);
      store(gamma, alpha);
      store(alpha, beta);
    }
  }
}

/// cos πr and sin πr/r for |r| ≤ ½ by minimax polynomials in r²: errors 5e-8 and 3e-9 for float, 2e-10 and
/// 3e-9 for double.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V cos_half_turns(D d, V r2) {
  using T = hn::TFromD<D>;
  const auto c = [d](double value) HWY_ATTR { return hn::Set(d, static_cast<T>(value)); };
  if constexpr (std::is_same_v<T, float>) {
    auto p = hn::MulAdd(c(0.21969679868861758), r2, c(-1.3318801612910596));
    p = hn::MulAdd(p, r2, c(4.058411914173664));
    p = hn::MulAdd(p, r2, c(-4.934792858675598));
    return hn::MulAdd(p, r2, c(0.9999999534666705));
  } else {
    auto p = hn::MulAdd(c(-0.024396716608091666), r2, c(0.2349375589565052));
    p = hn::MulAdd(p, r2, c(-1.3352120566690053));
    p = hn::MulAdd(p, r2, c(4.058709164342983));
    p = hn::MulAdd(p, r2, c(-4.9348021372283775));
    return hn::MulAdd(p, r2, c(0.9999999997806517));
  }
}
template <class D, class V = hn::Vec<D>>
HWY_INLINE V sin_half_turns_over_r(D d, V r2) {
  using T = hn::TFromD<D>;
  const auto c = [d](double value) HWY_ATTR { return hn::Set(d, static_cast<T>(value)); };
  auto p = hn::MulAdd(c(0.07722224911512875), r2, c(-0.5980464505777549));
  p = hn::MulAdd(p, r2, c(2.5500316409380015));
  p = hn::MulAdd(p, r2, c(-5.167706900208309));
  return hn::MulAdd(p, r2, c(3.141592580569334));
}

/// Adds w·e^{−iπt}. Adding and taking away 1.5·2^(mantissa bits) rounds t to the whole number n; the lowest
/// bit of the sum, shifted to the top, is the sign (−1)ⁿ.
template <class D, class V = hn::Vec<D>>
HWY_INLINE void add_phasor(D d, V t, V w, V& re, V& im) {
  using T = hn::TFromD<D>;
  const hn::RebindToUnsigned<D> du;
  const auto magic = hn::Set(d, sizeof(T) == 4 ? static_cast<T>(0x1.8p23) : static_cast<T>(0x1.8p52));
  const auto shifted = hn::Add(t, magic);
  const auto r = hn::Sub(t, hn::Sub(shifted, magic));
  const auto sign = hn::BitCast(d, hn::ShiftLeft<sizeof(T) * 8 - 1>(hn::BitCast(du, shifted)));
  const auto signed_weight = hn::Xor(w, sign);
  const auto r2 = hn::Mul(r, r);
  re = hn::MulAdd(signed_weight, cos_half_turns(d, r2), re);
  im = hn::NegMulAdd(signed_weight, hn::Mul(r, sin_half_turns_over_r(d, r2)), im);
}

template <class V>
struct Phasor {
  V re, im;
};

/// The sum of w·e^{−iπt} over the points of one draw in as many triangles as there are lanes.
template <int kPoints, class D, class V = hn::Vec<D>, typename T = hn::TFromD<D>>
HWY_INLINE Phasor<V> draw_sum(D d, const T* HWY_RESTRICT p, V tx, V ty, V tz, V w) {
  const std::size_t lanes = hn::Lanes(d);
  V re = hn::Zero(d), im = hn::Zero(d);
  for (int point = 0; point < kPoints; ++point, p += 3 * lanes)
    add_phasor(d,
               hn::MulAdd(hn::Load(d, p), tx,
                          hn::MulAdd(hn::Load(d, p + lanes), ty, hn::Mul(hn::Load(d, p + 2 * lanes), tz))),
               w, re, im);
  return {re, im};
}

template <int kPoints, typename T>
void sum(const TriangleTile<T>& tile, const T* HWY_RESTRICT drawn, std::span<const Vec3> q,
         std::span<DrawSums> out) {
  const hn::ScalableTag<T> d;
  const std::size_t lanes = hn::Lanes(d);
  const auto set = [d](double value) HWY_ATTR { return hn::Set(d, static_cast<T>(value)); };
  const auto total = [d](auto v) HWY_ATTR { return static_cast<double>(hn::GetLane(hn::SumOfLanes(d, v))); };
  for (std::size_t k = 0; k < q.size(); ++k) {
    const auto qx = set(q[k].x()), qy = set(q[k].y()), qz = set(q[k].z());
    const Vec3 half_turns = q[k] / std::numbers::pi;
    const auto tx = set(half_turns.x()), ty = set(half_turns.y()), tz = set(half_turns.z());
    auto re0 = hn::Zero(d), im0 = re0, re1 = re0, im1 = re0, re_re = re0, re_im = re0, im_im = re0;
    const T* HWY_RESTRICT p = drawn;
    for (std::size_t t = 0; t < tile.count; t += lanes, p += 2 * kPoints * 3 * lanes) {
      const auto slope =
          hn::NegMulAdd(qx, hn::LoadU(d, &tile.zx[t]), hn::NegMulAdd(qy, hn::LoadU(d, &tile.zy[t]), qz));
      const auto w = hn::Mul(slope, hn::LoadU(d, &tile.weight[t]));
      const auto first = draw_sum<kPoints>(d, p, tx, ty, tz, w);
      const auto second = draw_sum<kPoints>(d, p + kPoints * 3 * lanes, tx, ty, tz, w);
      const auto re = hn::Sub(first.re, second.re), im = hn::Sub(first.im, second.im);
      re0 = hn::Add(re0, first.re);
      im0 = hn::Add(im0, first.im);
      re1 = hn::Add(re1, second.re);
      im1 = hn::Add(im1, second.im);
      re_re = hn::MulAdd(re, re, re_re);
      re_im = hn::MulAdd(re, im, re_im);
      im_im = hn::MulAdd(im, im, im_im);
    }
    out[k] = {{std::complex<double>(total(re0), total(im0)), std::complex<double>(total(re1), total(im1))},
              total(re_re),
              total(re_im),
              total(im_im)};
  }
}

template <typename T>
void sum_any(const TriangleTile<T>& tile, PointsPerDraw points, const T* drawn, std::span<const Vec3> q,
             std::span<DrawSums> out) {
  if (points == PointsPerDraw::One)
    sum<1>(tile, drawn, q, out);
  else
    sum<3>(tile, drawn, q, out);
}

}  // namespace

void RandomBlock(std::uint64_t seed, std::uint32_t stream, std::uint64_t first, std::size_t count,
                 std::uint32_t* out) {
  random_block(seed, stream, first, count, out);
}
void DrawFloat(const TriangleTile<float>& tile, const Stratum& s, PointsPerDraw points, float* out) {
  draw(tile, s, points, out);
}
void DrawDouble(const TriangleTile<double>& tile, const Stratum& s, PointsPerDraw points, double* out) {
  draw(tile, s, points, out);
}
void SumFloat(const TriangleTile<float>& tile, PointsPerDraw points, const float* drawn,
              std::span<const Vec3> q, std::span<DrawSums> out) {
  sum_any(tile, points, drawn, q, out);
}
void SumDouble(const TriangleTile<double>& tile, PointsPerDraw points, const double* drawn,
               std::span<const Vec3> q, std::span<DrawSums> out) {
  sum_any(tile, points, drawn, q, out);
}

}  // namespace HWY_NAMESPACE
}  // namespace micro::detail
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace micro::detail {

HWY_EXPORT(RandomBlock);
HWY_EXPORT(DrawFloat);
HWY_EXPORT(DrawDouble);
HWY_EXPORT(SumFloat);
HWY_EXPORT(SumDouble);

void random_word_block(std::uint64_t seed, std::uint32_t stream, std::uint64_t first, std::size_t count,
                       std::uint32_t* out) {
  HWY_DYNAMIC_DISPATCH(RandomBlock)(seed, stream, first, count, out);
}
void draw_points(const TriangleTile<float>& tile, const Stratum& stratum, PointsPerDraw points, float* out) {
  HWY_DYNAMIC_DISPATCH(DrawFloat)(tile, stratum, points, out);
}
void draw_points(const TriangleTile<double>& tile, const Stratum& stratum, PointsPerDraw points,
                 double* out) {
  HWY_DYNAMIC_DISPATCH(DrawDouble)(tile, stratum, points, out);
}
void sum_points(const TriangleTile<float>& tile, PointsPerDraw points, const float* drawn,
                std::span<const Vec3> q, std::span<DrawSums> out) {
  HWY_DYNAMIC_DISPATCH(SumFloat)(tile, points, drawn, q, out);
}
void sum_points(const TriangleTile<double>& tile, PointsPerDraw points, const double* drawn,
                std::span<const Vec3> q, std::span<DrawSums> out) {
  HWY_DYNAMIC_DISPATCH(SumDouble)(tile, points, drawn, q, out);
}

}  // namespace micro::detail
#endif
