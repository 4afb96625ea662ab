// Per-target include guard of Highway: this file is compiled once for every instruction set.
#if defined(MICRO_KIRCHHOFF_SINCOS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef MICRO_KIRCHHOFF_SINCOS_INL_H_
#undef MICRO_KIRCHHOFF_SINCOS_INL_H_
#else
#define MICRO_KIRCHHOFF_SINCOS_INL_H_
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace micro {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// A vector of complex numbers.
template <typename V>
struct ComplexLanes {
  V re, im;
};

template <typename V>
HWY_INLINE ComplexLanes<V> operator-(const ComplexLanes<V>& a, const ComplexLanes<V>& b) {
  return {hn::Sub(a.re, b.re), hn::Sub(a.im, b.im)};
}

template <typename V>
HWY_INLINE ComplexLanes<V> operator*(const ComplexLanes<V>& a, const ComplexLanes<V>& b) {
  return {hn::NegMulAdd(a.im, b.im, hn::Mul(a.re, b.re)), hn::MulAdd(a.im, b.re, hn::Mul(a.re, b.im))};
}

/// cos x (re) and sin x (im) in double, to about one unit in the last place of 1 for |x| ≤ 1.6e6 rad:
/// Cody–Waite reduction by π/2 in three parts of 33 bits (so that n·part is exact even without FMA), then the
/// minimax polynomials of Moshier's Cephes on [−π/4, π/4].
template <class D, class V = hn::Vec<D>>
HWY_INLINE ComplexLanes<V> cos_sin(D d, V x) {
  const auto n = hn::Round(hn::Mul(x, hn::Set(d, 0.63661977236758134308)));
  auto r = hn::NegMulAdd(n, hn::Set(d, 1.57079632673412561417e+00), x);
  r = hn::NegMulAdd(n, hn::Set(d, 6.07710050630396597660e-11), r);
  r = hn::NegMulAdd(n, hn::Set(d, 2.02226624879595063154e-21), r);
  const auto r2 = hn::Mul(r, r);
  auto s = hn::Set(d, 1.58962301576546568060e-10);
  s = hn::MulAdd(s, r2, hn::Set(d, -2.50507477628578072866e-8));
  s = hn::MulAdd(s, r2, hn::Set(d, 2.75573136213857245213e-6));
  s = hn::MulAdd(s, r2, hn::Set(d, -1.98412698295895385996e-4));
  s = hn::MulAdd(s, r2, hn::Set(d, 8.33333333332211858878e-3));
  s = hn::MulAdd(s, r2, hn::Set(d, -1.66666666666666307295e-1));
  s = hn::MulAdd(hn::Mul(s, r2), r, r);
  auto c = hn::Set(d, -1.13585365213876817300e-11);
  c = hn::MulAdd(c, r2, hn::Set(d, 2.08757008419747316778e-9));
  c = hn::MulAdd(c, r2, hn::Set(d, -2.75573141792967388112e-7));
  c = hn::MulAdd(c, r2, hn::Set(d, 2.48015872888517045348e-5));
  c = hn::MulAdd(c, r2, hn::Set(d, -1.38888888888730564116e-3));
  c = hn::MulAdd(c, r2, hn::Set(d, 4.16666666666665929218e-2));
  c = hn::MulAdd(hn::Mul(c, r2), r2, hn::NegMulAdd(hn::Set(d, 0.5), r2, hn::Set(d, 1.0)));
  // Quadrant n mod 4: odd ones swap sine and cosine; 2, 3 negate the sine and 1, 2 the cosine.
  const auto quadrant = hn::NegMulAdd(hn::Floor(hn::Mul(n, hn::Set(d, 0.25))), hn::Set(d, 4.0), n);
  const auto one = hn::Eq(quadrant, hn::Set(d, 1.0)), two = hn::Eq(quadrant, hn::Set(d, 2.0)),
             three = hn::Eq(quadrant, hn::Set(d, 3.0));
  const auto swap = hn::Or(one, three);
  const auto sine = hn::IfThenElse(swap, c, s), cosine = hn::IfThenElse(swap, s, c);
  return {hn::IfThenElse(hn::Or(one, two), hn::Neg(cosine), cosine),
          hn::IfThenElse(hn::Or(two, three), hn::Neg(sine), sine)};
}

}  // namespace HWY_NAMESPACE
}  // namespace micro
HWY_AFTER_NAMESPACE();

#endif
