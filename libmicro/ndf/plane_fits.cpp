#include "ndf/plane_fits.h"

#include <Eigen/Eigenvalues>

// Highway compiles this file once for each instruction set and picks the best one at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "ndf/plane_fits.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace micro::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void FitPlanes(const BlockMoments& moments, BlockFits& fits) {
  const hn::ScalableTag<double> d;
  const std::size_t lanes = hn::Lanes(d);
  const auto one = hn::Set(d, 1), twice_least = hn::Set(d, 2 * kLeastCondition);
  for (std::size_t r = 0; r < kBlockRows; ++r)
    for (std::size_t i = 0; i < kStripColumns; i += lanes) {
      const auto at = [&](const StripBlock& block) { return hn::LoadU(d, block[r] + i); };
      const auto m = at(moments.m[0]), mx = at(moments.mx[0]), my = at(moments.m[1]);
      const auto mxx = at(moments.mxx), mxy = at(moments.mx[1]), myy = at(moments.m[2]);
      const auto z = at(moments.z[0]);
      const auto inverse = hn::Div(one, m);
      const auto mu_x = hn::Mul(mx, inverse), mu_y = hn::Mul(my, inverse);
      const auto sxx = hn::NegMulAdd(mu_x, mx, mxx), sxy = hn::NegMulAdd(mu_x, my, mxy),
                 syy = hn::NegMulAdd(mu_y, my, myy);
      const auto szx = hn::NegMulAdd(mu_x, z, at(moments.zx)), szy = hn::NegMulAdd(mu_y, z, at(moments.z[1]));
      const auto determinant = hn::NegMulAdd(sxy, sxy, hn::Mul(sxx, syy));
      const auto per_determinant = hn::Div(one, determinant);
      hn::StoreU(hn::Mul(hn::NegMulAdd(szy, sxy, hn::Mul(szx, syy)), per_determinant), d, fits.zx[r] + i);
      hn::StoreU(hn::Mul(hn::NegMulAdd(szx, sxy, hn::Mul(szy, sxx)), per_determinant), d, fits.zy[r] + i);
      // min(⟨1⟩, |S|/tr S)/(2(1 + µ²)) ≥ least·tr M
      const auto norm = hn::MulAdd(mu_x, mu_x, hn::MulAdd(mu_y, mu_y, one));
      const auto least = hn::Mul(hn::Mul(twice_least, norm), hn::Add(m, hn::Add(mxx, myy)));
      const auto trace = hn::Add(sxx, syy), of_s = hn::NegMulAdd(least, trace, determinant);
      hn::StoreU(hn::Min(hn::Sub(m, least), hn::Min(of_s, trace)), d, fits.margin[r] + i);
    }
}

}  // namespace micro::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace micro {
HWY_EXPORT(FitPlanes);

BlockFits fit_planes(const BlockMoments& moments) {
  BlockFits fits;
  HWY_DYNAMIC_DISPATCH(FitPlanes)(moments, fits);
  return fits;
}

bool well_conditioned(const BlockMoments& moments, std::size_t row, std::size_t column) {
  const auto at = [&](const StripBlock& block) { return block[row][column]; };
  Eigen::Matrix3d matrix;
  matrix << at(moments.m[0]), at(moments.mx[0]), at(moments.m[1]),  //
      at(moments.mx[0]), at(moments.mxx), at(moments.mx[1]),        //
      at(moments.m[1]), at(moments.mx[1]), at(moments.m[2]);
  const Eigen::Vector3d eigenvalues = matrix.selfadjointView<Eigen::Lower>().eigenvalues();
  return eigenvalues[0] >= kLeastCondition * eigenvalues[2];
}

}  // namespace micro
#endif
