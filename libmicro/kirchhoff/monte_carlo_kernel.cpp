#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kirchhoff/monte_carlo_kernel.cpp"
#include "kirchhoff/monte_carlo_kernel.h"

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef MICRO_KIRCHHOFF_MONTE_CARLO_SHARED_
#define MICRO_KIRCHHOFF_MONTE_CARLO_SHARED_
#include <numbers>
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
  std::array<std::uint32_t, 4 * kTileTriangles> words;
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

/// Minimax polynomials in r² of cos πr and of sin πr/r for |r| ≤ ½, highest power first: errors 5e-8 and
/// 3e-9.
constexpr double kCosine[] = {0.21969679868861758, -1.3318801612910596, 4.058411914173664, -4.934792858675598,
                              0.9999999534666705};
constexpr double kSine[] = {0.07722224911512875, -0.5980464505777549, 2.5500316409380015, -5.167706900208309,
                            3.141592580569334};

template <class V>
struct Phasor {
  V re, im;
};

/// Σ w·e^{−iπt} over the points of one draw in as many triangles as there are lanes. Adding and taking away
/// 1.5·2^(mantissa bits) rounds t to the whole number n; the lowest bit of the sum, shifted to the top, is
/// the sign (−1)ⁿ. The points go through each step together, so that the steps of one fill the waits of the
/// other.
template <int kPoints, class D, class V = hn::Vec<D>, typename T = hn::TFromD<D>>
HWY_INLINE Phasor<V> draw_sum(D d, const T* HWY_RESTRICT p, V tx, V ty, V tz, V w) {
  const hn::RebindToUnsigned<D> du;
  const std::size_t lanes = hn::Lanes(d);
  const auto set = [d](double value) HWY_ATTR { return hn::Set(d, static_cast<T>(value)); };
  const V magic = set(sizeof(T) == 4 ? 0x1.8p23 : 0x1.8p52);
  const auto each = [](auto&& step) HWY_ATTR {
    step(0);
    if constexpr (kPoints == 3) {
      step(1);
      step(2);
    }
  };
  V r[kPoints], r2[kPoints], weight[kPoints], cosine[kPoints], sine[kPoints];
  each([&](int k) HWY_ATTR {
    const T* point = p + 3 * k * lanes;
    r[k] =
        hn::MulAdd(hn::Load(d, point), tx,
                   hn::MulAdd(hn::Load(d, point + lanes), ty, hn::Mul(hn::Load(d, point + 2 * lanes), tz)));
  });
  each([&](int k) HWY_ATTR {
    const V shifted = hn::Add(r[k], magic);
    weight[k] = hn::Xor(w, hn::BitCast(d, hn::ShiftLeft<sizeof(T) * 8 - 1>(hn::BitCast(du, shifted))));
    r[k] = hn::Sub(r[k], hn::Sub(shifted, magic));
  });
  each([&](int k) HWY_ATTR { r2[k] = hn::Mul(r[k], r[k]); });
  each([&](int k) HWY_ATTR {
    cosine[k] = hn::MulAdd(set(kCosine[0]), r2[k], set(kCosine[1]));
    sine[k] = hn::MulAdd(set(kSine[0]), r2[k], set(kSine[1]));
  });
  for (int power = 2; power < 5; ++power)
    each([&](int k) HWY_ATTR {
      cosine[k] = hn::MulAdd(cosine[k], r2[k], set(kCosine[power]));
      sine[k] = hn::MulAdd(sine[k], r2[k], set(kSine[power]));
    });
  V re = hn::Mul(weight[0], cosine[0]), im = hn::Mul(hn::Mul(weight[0], r[0]), sine[0]);
  for (int k = 1; k < kPoints; ++k) {
    re = hn::MulAdd(weight[k], cosine[k], re);
    im = hn::MulAdd(hn::Mul(weight[k], r[k]), sine[k], im);
  }
  return {re, hn::Neg(im)};
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
