#include "ndf/gaussian_passes.h"

#include <algorithm>
#include <cassert>
#include <cmath>

// Highway compiles this file once for each instruction set and picks the best one at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "ndf/gaussian_passes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace micro::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::ScalableTag<double>;
using V = hn::Vec<D>;

constexpr std::size_t kVectors = 4;  // of outputs at a time
static_assert(kStripColumns % (kVectors * hn::MaxLanes(D())) == 0);

// Four vectors of outputs at a time: 4·2 independent sums hide the latency of the multiply-adds, and one
// load of the input serves both moments.
void AlongRow(const double* values, const GaussianTaps& taps, double* const* out) {
  const D d;
  constexpr std::size_t kMoments = 2;
  const std::size_t lanes = hn::Lanes(d);
  for (std::size_t i = 0; i < kStripColumns; i += kVectors * lanes) {
    V sum[kMoments][kVectors];
    for (auto& sums : sum)
      for (V& s : sums)
        s = hn::Zero(d);
    const double* in = values + i;
    for (std::size_t t = 0; t < taps.size(); ++t) {
      V z[kVectors];
      for (std::size_t v = 0; v < kVectors; ++v)
        z[v] = hn::LoadU(d, in + t + v * lanes);
      for (std::size_t m = 0; m < kMoments; ++m) {
        const V weight = hn::Set(d, taps.moment(m)[t]);
        for (std::size_t v = 0; v < kVectors; ++v)
          sum[m][v] = hn::MulAdd(weight, z[v], sum[m][v]);
      }
    }
    for (std::size_t m = 0; m < kMoments; ++m)
      for (std::size_t v = 0; v < kVectors; ++v)
        hn::StoreU(sum[m][v], d, out[m] + i + v * lanes);
  }
}

// Moments are even or odd: moment(m)[p − i] = (−1)^m moment(m)[2·radius − (p − i)], which ascends with i.
void AddAlongRow(const std::vector<std::size_t>& places, double factor, const GaussianTaps& taps,
                 double* const* out) {
  const D d;
  const std::size_t lanes = hn::Lanes(d);
  for (std::size_t i = 0; i < kStripColumns; i += kVectors * lanes)
    for (std::size_t m = 0; m < 3; ++m) {
      V sum[kVectors];
      for (V& s : sum)
        s = hn::Zero(d);
      const double* end = taps.moment(m) + 2 * taps.radius() + i;
      for (const std::size_t place : places)
        for (std::size_t v = 0; v < kVectors; ++v)
          sum[v] = hn::Add(sum[v], hn::LoadU(d, end - place + v * lanes));
      const V scale = hn::Set(d, m == 1 ? -factor : factor);
      for (std::size_t v = 0; v < kVectors; ++v) {
        double* to = out[m] + i + v * lanes;
        hn::StoreU(hn::MulAdd(scale, sum[v], hn::LoadU(d, to)), d, to);
      }
    }
}

// Two vectors × Rows outputs × Moments sums share each pair of loads.
template <std::size_t Moments, std::size_t Rows>
void AcrossRows(const Strip& in, const GaussianTaps& taps, std::size_t row, std::size_t first,
                StripBlock* out) {
  const D d;
  constexpr std::size_t kPair = 2;
  static_assert(kBlockRows % Rows == 0 && Rows <= GaussianTaps::kPad);
  const std::size_t lanes = hn::Lanes(d), step = kPair * lanes;
  const std::ptrdiff_t radius = static_cast<std::ptrdiff_t>(taps.radius());
  for (std::size_t r0 = 0; r0 < kBlockRows; r0 += Rows) {
    const std::ptrdiff_t j = static_cast<std::ptrdiff_t>(row + r0);
    const std::ptrdiff_t begin = std::max<std::ptrdiff_t>(0, j - radius);
    const std::ptrdiff_t end =
        std::min(static_cast<std::ptrdiff_t>(in.rows()), j + radius + static_cast<std::ptrdiff_t>(Rows));
    for (std::size_t i = 0; i < kStripColumns; i += step) {
      V sum[Moments][Rows][kPair];
      for (auto& rows : sum)
        for (auto& sums : rows)
          for (V& s : sums)
            s = hn::Zero(d);
      const double* source = in.at(0) + i;
      for (std::ptrdiff_t k = begin; k < end; ++k) {
        V z[kPair];
        for (std::size_t v = 0; v < kPair; ++v)
          z[v] = hn::LoadU(d, source + static_cast<std::size_t>(k) * kStripColumns + v * lanes);
        for (std::size_t m = 0; m < Moments; ++m) {
          const double* weights = taps.moment(first + m) + (k - j + radius);
          for (std::size_t r = 0; r < Rows; ++r) {
            const V weight = hn::Set(d, *(weights - r));
            for (std::size_t v = 0; v < kPair; ++v)
              sum[m][r][v] = hn::MulAdd(weight, z[v], sum[m][r][v]);
          }
        }
      }
      for (std::size_t m = 0; m < Moments; ++m)
        for (std::size_t r = 0; r < Rows; ++r)
          for (std::size_t v = 0; v < kPair; ++v)
            hn::StoreU(sum[m][r][v], d, out[m][r0 + r] + i + v * lanes);
    }
  }
}

void AcrossRowsDispatch(const Strip& in, const GaussianTaps& taps, std::size_t row, std::size_t first,
                        std::size_t moments, StripBlock* out) {
  if (moments == 1) return AcrossRows<1, 4>(in, taps, row, first, out);
  if (moments == 2) return AcrossRows<2, 2>(in, taps, row, first, out);
  return AcrossRows<3, 2>(in, taps, row, first, out);
}

}  // namespace micro::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace micro {
HWY_EXPORT(AlongRow);
HWY_EXPORT(AddAlongRow);
HWY_EXPORT(AcrossRowsDispatch);

GaussianTaps::GaussianTaps(double pitch, double sigma, std::size_t longest)
    : radius_(std::min(static_cast<std::size_t>(std::ceil(std::min(kReach * sigma / pitch, 1e9))), longest)),
      taps_(3 * stride()) {
  for (std::size_t t = 0; t < size(); ++t) {
    const double x = (static_cast<double>(t) - static_cast<double>(radius_)) * pitch / sigma;
    const double w = std::exp(-x * x / 2);
    double* taps = taps_.data() + kPad + t;
    taps[0] = w;
    taps[stride()] = x * w;
    taps[2 * stride()] = x * x * w;
  }
}

void pass_along_row(const double* values, const GaussianTaps& taps, double* const (&out)[2]) {
  HWY_DYNAMIC_DISPATCH(AlongRow)(values, taps, out);
}

void add_along_row(const std::vector<std::size_t>& places, double factor, const GaussianTaps& taps,
                   double* const (&out)[3]) {
  HWY_DYNAMIC_DISPATCH(AddAlongRow)(places, factor, taps, out);
}

void pass_across_rows(const Strip& in, const GaussianTaps& taps, std::size_t row, std::size_t first,
                      std::size_t moments, StripBlock* out) {
  assert(moments >= 1 && first + moments <= 3);
  HWY_DYNAMIC_DISPATCH(AcrossRowsDispatch)(in, taps, row, first, moments, out);
}

}  // namespace micro
#endif
