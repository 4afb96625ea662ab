#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fit/node_sums.cpp"
#include "fit/node_sums.h"

#include <algorithm>
#include <cmath>
#include <numbers>

// The order is Highway's own: first the loop over targets, last what is compiled for each.
// clang-format off
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include <hwy/contrib/math/math-inl.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace micro {
namespace HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<double, 8>;
using V = hn::Vec<Tag>;
using M = hn::Mask<Tag>;

constexpr int kSums = std::tuple_size_v<NodeSums>;

/// The model at a node without its constant 1/(π det L), or its logarithm, and the factor `pull` in
/// ∂ln D/∂δ = (−pull·v_1·z, −pull·v_2·z, pull·v_1² − 1, pull·v_1·v_2, pull·v_2² − 1).
struct Value {
  V density, pull;
};

template <FitModel kModel, Weighting kWeighting>
HWY_INLINE Value value_of(V vv, V z2) {
  const Tag d;
  constexpr bool kLog = kWeighting == Weighting::Log;
  if constexpr (kModel == FitModel::EllipsoidNdf) {
    const V q = hn::Add(z2, vv), inverse = hn::Div(hn::Set(d, 1.), q);
    const V density = kLog ? hn::Mul(hn::Set(d, -2.), hn::Log(d, q)) : hn::Mul(inverse, inverse);
    return {density, hn::Mul(hn::Set(d, 4.), inverse)};
  } else {
    const V inverse = hn::Div(hn::Set(d, 1.), z2);
    const V exponent = hn::Neg(hn::Mul(vv, inverse));
    const V density =
        kLog ? hn::NegMulAdd(hn::Set(d, 2.), hn::Log(d, z2), exponent)
             : hn::Mul(hn::Exp(d, hn::Max(exponent, hn::Set(d, -700.))), hn::Mul(inverse, inverse));
    return {density, hn::Mul(hn::Set(d, 2.), inverse)};
  }
}

/// Is the model nothing beside its peak at all of these nodes? e^−80 = 2e−35: most of a table around a narrow
/// Gaussian lobe. The ellipsoid NDF's tails never end.
template <FitModel kModel, Weighting kWeighting>
HWY_INLINE bool is_nothing(V vv, V z2) {
  if constexpr (kModel == FitModel::BeckmannNdf && kWeighting == Weighting::SolidAngle) {
    const Tag d;
    return hn::AllTrue(d, hn::Gt(vv, hn::Mul(hn::Set(d, 80.), z2)));
  } else {
    return false;
  }
}

/// The smallest number that a table's float32 holds with all its digits.
constexpr double kLeastDensity = 1.2e-38;

/// The nodes of a row that may lie on the disk.
struct Range {
  std::int64_t begin, end;
};
inline Range on_disk_of(const NodeSpan& nodes, std::int64_t row) {
  const double half = std::sqrt(std::max(0., 1 - nodes.y[row] * nodes.y[row])), first = nodes.x[0];
  const double spacing = nodes.x[1] - first;
  const auto begin = static_cast<std::int64_t>(std::max(0., (-half - first) / spacing)),
             end = static_cast<std::int64_t>((half - first) / spacing) + 2;
  return {begin, std::min(end, nodes.size)};
}

/// What the sums of gram's place take as weight: the plain one, or that of residual_gram.
enum class Sum { Equations, Residuals };

template <FitModel kModel, Weighting kWeighting, Sum kSum>
NodeSums add_up(const NodeSumInput& in) {
  const Tag d;
  constexpr bool kLog = kWeighting == Weighting::Log;
  const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
  const V one = hn::Set(d, 1.), zero = hn::Zero(d), horizon = hn::Set(d, kHorizonMz2);
  const V least_z = hn::Set(d, in.nodes.least_mz);
  const V tx = hn::Set(d, in.frame.centre.x()), ty = hn::Set(d, in.frame.centre.y()),
          i11 = hn::Set(d, 1 / in.frame.l11), i22 = hn::Set(d, 1 / in.frame.l22),
          l21 = hn::Set(d, in.frame.l21);
  const double constant = std::numbers::inv_pi / in.determinant;
  const V scale = hn::Set(d, kLog ? std::log(constant) : constant);
  V sums[kSums];
  for (V& sum : sums)
    sum = zero;
  const bool scattered = in.nodes.layout == NodeSpan::Layout::Scattered;
  for (std::int64_t row = 0; row < in.nodes.rows; ++row) {
    const Range range = scattered ? Range{0, in.nodes.size} : on_disk_of(in.nodes, row);
    for (std::int64_t k = range.begin; k < range.end; k += lanes) {
      const M inside = hn::FirstN(d, static_cast<std::size_t>(range.end - k));
      const V x = hn::MaskedLoad(inside, d, in.nodes.x + k),
              y = scattered ? hn::MaskedLoad(inside, d, in.nodes.y + k) : hn::Set(d, in.nodes.y[row]),
              data = hn::MaskedLoad(inside, d, in.nodes.density + row * in.nodes.size + k);
      const V z2 = hn::NegMulAdd(x, x, hn::NegMulAdd(y, y, one));
      const M on_disk = hn::And(inside, hn::Gt(z2, horizon));
      const M counts = kLog ? hn::And(on_disk, hn::Ge(data, hn::Set(d, kLeastDensity))) : on_disk;
      if (kLog && hn::AllFalse(d, counts)) continue;  // histograms hold many zeros
      const V safe2 = hn::IfThenElse(counts, z2, one), z = hn::Sqrt(safe2);
      const V weight = hn::IfThenElseZero(counts, hn::Div(one, hn::Max(z, least_z)));
      const V v1 = hn::Mul(hn::MulAdd(tx, z, x), i11);
      const V v2 = hn::Mul(hn::NegMulAdd(l21, v1, hn::MulAdd(ty, z, y)), i22);
      const V v11 = hn::Mul(v1, v1), v22 = hn::Mul(v2, v2), vv = hn::Add(v11, v22);
      if (is_nothing<kModel, kWeighting>(vv, safe2)) {
        if constexpr (kSum == Sum::Equations) {
          const V wt = hn::Mul(weight, data);
          sums[20] = hn::MulAdd(wt, data, sums[20]);
          sums[21] = hn::MulAdd(wt, data, sums[21]);
          sums[22] = hn::Add(sums[22], hn::IfThenElseZero(counts, one));
        }
        continue;
      }
      const Value value = value_of<kModel, kWeighting>(vv, safe2);
      const V model = kLog ? hn::Add(scale, value.density) : hn::Mul(scale, value.density);
      const V target = kLog ? hn::Log(d, hn::IfThenElse(counts, data, one)) : data;
      const V r = hn::IfThenElseZero(counts, hn::Sub(target, model));
      const V to_d = kLog ? one : model;  // ∂D = D·∂ln D
      const V pull_z = hn::Mul(value.pull, z);
      V g[5] = {hn::Neg(hn::Mul(pull_z, v1)), hn::Neg(hn::Mul(pull_z, v2)), hn::MulSub(value.pull, v11, one),
                hn::Mul(value.pull, hn::Mul(v1, v2)), hn::MulSub(value.pull, v22, one)};
      for (V& part : g)
        part = hn::Mul(part, to_d);
      V factor = weight;
      if constexpr (kSum == Sum::Residuals) {
        V leverage = zero;
        for (int a = 0; a < 5; ++a) {
          V product = zero;
          for (int b = 0; b < 5; ++b)
            product = hn::MulAdd(hn::Set(d, in.inverse[static_cast<std::size_t>(5 * a + b)]), g[b], product);
          leverage = hn::MulAdd(product, g[a], leverage);
        }
        // A node that alone decides a parameter has leverage 1 and no residual.
        const V free = hn::Max(hn::NegMulAdd(weight, leverage, one), hn::Set(d, 1e-6));
        const V wr = hn::Mul(weight, r);
        factor = hn::Div(hn::Mul(wr, wr), free);
      }
      int s = 0;
      for (int a = 0; a < 5; ++a) {
        const V fg = hn::Mul(factor, g[a]);
        for (int b = 0; b <= a; ++b, ++s)
          sums[s] = hn::MulAdd(fg, g[b], sums[s]);
      }
      if constexpr (kSum == Sum::Equations) {
        const V wr = hn::Mul(weight, r), wt = hn::Mul(weight, target);
        for (int a = 0; a < 5; ++a, ++s)
          sums[s] = hn::MulAdd(wr, g[a], sums[s]);
        sums[20] = hn::MulAdd(wr, r, sums[20]);
        sums[21] = hn::MulAdd(wt, target, sums[21]);
        sums[22] = hn::Add(sums[22], hn::IfThenElseZero(counts, one));
      }
    }
  }
  NodeSums result{};
  for (int s = 0; s < kSums; ++s)
    result[static_cast<std::size_t>(s)] = hn::GetLane(hn::SumOfLanes(d, sums[s]));
  return result;
}

template <Sum kSum>
NodeSums dispatch(const NodeSumInput& in, FitModel model, Weighting weighting) {
  const bool log = weighting == Weighting::Log;
  if (model == FitModel::EllipsoidNdf)
    return log ? add_up<FitModel::EllipsoidNdf, Weighting::Log, kSum>(in)
               : add_up<FitModel::EllipsoidNdf, Weighting::SolidAngle, kSum>(in);
  return log ? add_up<FitModel::BeckmannNdf, Weighting::Log, kSum>(in)
             : add_up<FitModel::BeckmannNdf, Weighting::SolidAngle, kSum>(in);
}

}  // namespace

NodeSums AddUpEquations(const NodeSumInput& in, FitModel model, Weighting weighting) {
  return dispatch<Sum::Equations>(in, model, weighting);
}
NodeSums AddUpResiduals(const NodeSumInput& in, FitModel model, Weighting weighting) {
  return dispatch<Sum::Residuals>(in, model, weighting);
}

}  // namespace HWY_NAMESPACE
}  // namespace micro
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace micro {

HWY_EXPORT(AddUpEquations);
HWY_EXPORT(AddUpResiduals);

NodeSums sum_equations(const NodeSumInput& input, FitModel model, Weighting weighting) {
  return HWY_DYNAMIC_DISPATCH(AddUpEquations)(input, model, weighting);
}
NodeSums sum_residuals(const NodeSumInput& input, FitModel model, Weighting weighting) {
  return HWY_DYNAMIC_DISPATCH(AddUpResiduals)(input, model, weighting);
}

}  // namespace micro
#endif
