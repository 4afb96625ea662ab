#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kirchhoff/combine.cpp"
#include "kirchhoff/combine.h"

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace micro {
namespace HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

/// At most 16 numbers, as many as a column's padding.
template <typename Real>
using Tag = hn::CappedTag<Real, kColumnPadding>;

/// A term's four products with its coefficient, summed over terms: F(q) = (rr − ii) + i(ri + ir),
/// F(−q) = (rr + ii) + i(ir − ri).
template <typename V>
struct Products {
  V rr, ii, ri, ir;
};

template <typename V>
HWY_INLINE void add_term(Products<V>& p, V c_re, V c_im, V re, V im) {
  p.rr = hn::MulAdd(c_re, re, p.rr);
  p.ii = hn::MulAdd(c_im, im, p.ii);
  p.ri = hn::MulAdd(c_re, im, p.ri);
  p.ir = hn::MulAdd(c_im, re, p.ir);
}

/// Both terms of a field from Z(q) = a + ib and Z(−q) = c + id, each twice as large as it is.
template <typename V>
HWY_INLINE void add_field(Products<V>& p, V x_re, V x_im, V y_re, V y_im, V a, V b, V c, V d) {
  add_term(p, x_re, x_im, hn::Add(a, c), hn::Sub(b, d));
  add_term(p, y_re, y_im, hn::Add(b, d), hn::Sub(c, a));
}

template <typename Real>
void combine(const CoefficientTable<Real>& table, const ColumnPair<Real>& columns, int kx, double sphere,
             double step, DiskField<Real>& field) {
  const Tag<Real> d;
  const hn::RebindToSigned<Tag<Real>> di;
  using V = hn::Vec<Tag<Real>>;
  const auto lanes = static_cast<int>(hn::Lanes(d));
  const Real kx2 = static_cast<Real>(static_cast<double>(kx) * kx);
  const bool of_nodes = table.kind == CoefficientTable<Real>::Entries::OfNodes;
  const auto to_entry = hn::Set(d, static_cast<Real>(table.per_q)),
             low = hn::Set(d, static_cast<Real>(table.low));
  for (int ky = 0; ky <= field.half; ky += lanes) {
    const auto k = hn::Iota(d, static_cast<Real>(ky));
    const auto k2 = hn::MulAdd(k, k, hn::Set(d, kx2));
    const auto qz2 =
        hn::NegMulAdd(hn::Set(d, static_cast<Real>(step * step)), k2, hn::Set(d, static_cast<Real>(sphere)));
    if (hn::AllTrue(d, hn::Le(qz2, hn::Zero(d)))) break;
    const auto qz = hn::Sqrt(hn::Max(qz2, hn::Zero(d)));
    const auto place = of_nodes ? k2 : hn::Max(hn::Mul(hn::Sub(qz, low), to_entry), hn::Zero(d));
    const auto position = hn::Min(place, hn::Set(d, static_cast<Real>(table.entries - 1)));
    const auto whole = hn::Min(hn::Floor(position), hn::Set(d, static_cast<Real>(table.entries - 2)));
    const auto t = hn::Sub(position, whole);
    const auto index = hn::ShiftLeft<2>(hn::ConvertTo(di, whole));
    const auto coefficient = [&](const Real* at, int part) HWY_ATTR {
      const auto here = hn::GatherIndex(d, at + part, index), next = hn::GatherIndex(d, at + 4 + part, index);
      return hn::MulAdd(t, hn::Sub(next, here), here);
    };
    const auto zero = hn::Zero(d);
    Products<V> along = {zero, zero, zero, zero}, across = along;
    for (int f = 0; f < table.fields; ++f) {
      const Real* at = &table.data[static_cast<std::size_t>(f) * table.entries * 4];
      const V x_re = coefficient(at, 0), x_im = coefficient(at, 1), y_re = coefficient(at, 2),
              y_im = coefficient(at, 3);
      const auto* plus = reinterpret_cast<const Real*>(columns.plus + f * columns.stride);
      const auto* minus = reinterpret_cast<const Real*>(columns.minus + f * columns.stride);
      const std::int64_t up = 2 * static_cast<std::int64_t>(ky), down = 2 * (columns.length - ky - lanes + 1);
      V pa, pb, ma, mb, pc, pd, mc, md;
      hn::LoadInterleaved2(d, plus + up, pa, pb);
      hn::LoadInterleaved2(d, minus + up, ma, mb);
      hn::LoadInterleaved2(d, plus + down, pc, pd);
      hn::LoadInterleaved2(d, minus + down, mc, md);
      add_field(along, x_re, x_im, y_re, y_im, pa, pb, hn::Reverse(d, mc), hn::Reverse(d, md));
      add_field(across, x_re, x_im, y_re, y_im, hn::Reverse(d, pc), hn::Reverse(d, pd), ma, mb);
    }
    const std::int64_t to = kx * field.stride + ky;
    const auto add = [&](QuadrantField<Real>& quadrant, V re, V im) HWY_ATTR {
      hn::StoreU(hn::Add(hn::LoadU(d, &quadrant.re[to]), re), d, &quadrant.re[to]);
      hn::StoreU(hn::Add(hn::LoadU(d, &quadrant.im[to]), im), d, &quadrant.im[to]);
    };
    add(field.quadrants[0], hn::Sub(along.rr, along.ii), hn::Add(along.ri, along.ir));
    add(field.quadrants[1], hn::Add(along.rr, along.ii), hn::Sub(along.ir, along.ri));
    add(field.quadrants[2], hn::Sub(across.rr, across.ii), hn::Add(across.ri, across.ir));
    add(field.quadrants[3], hn::Add(across.rr, across.ii), hn::Sub(across.ir, across.ri));
  }
}

}  // namespace

void CombineFloat(const CoefficientTable<float>& c, const ColumnPair<float>& columns, int kx, double sphere,
                  double step, DiskField<float>& field) {
  combine(c, columns, kx, sphere, step, field);
}
void CombineDouble(const CoefficientTable<double>& c, const ColumnPair<double>& columns, int kx,
                   double sphere, double step, DiskField<double>& field) {
  combine(c, columns, kx, sphere, step, field);
}

}  // namespace HWY_NAMESPACE
}  // namespace micro
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace micro {

HWY_EXPORT(CombineFloat);
HWY_EXPORT(CombineDouble);

void combine_columns(const CoefficientTable<float>& c, const ColumnPair<float>& columns, int kx,
                     double sphere, double step, DiskField<float>& field) {
  HWY_DYNAMIC_DISPATCH(CombineFloat)(c, columns, kx, sphere, step, field);
}

void combine_columns(const CoefficientTable<double>& c, const ColumnPair<double>& columns, int kx,
                     double sphere, double step, DiskField<double>& field) {
  HWY_DYNAMIC_DISPATCH(CombineDouble)(c, columns, kx, sphere, step, field);
}

}  // namespace micro
#endif
