#include "brdf/microfacet.h"

#include <gtest/gtest.h>

#include "brdf/albedo.h"
#include "distribution/beckmann.h"
#include "distribution/ellipsoid.h"

namespace micro {
namespace {

constexpr double kRounding = 1e-13;
constexpr double kLambda = 0.55;

static_assert(Brdf<Microfacet<Ellipsoid>>);

/// Widths from polished to bristling, round, brushed and leaning.
std::vector<SlopeFrame> frames() {
  return {{{0, 0}, 1e-4, 0, 1e-4}, {{0, 0}, 0.01, 0, 0.01},      {{0, 0}, 0.2, 0, 0.2},
          {{0, 0}, 0.5, 0, 0.05},  {{0.3, -0.1}, 0.3, 0.1, 0.2}, {{0, 0}, 1, 0, 1},
          {{0, 0}, 10, 0, 10},     {{2, 0}, 0.2, 0, 0.1}};
}

template <typename Lobe>
class MicrofacetModels : public ::testing::Test {};
using Lobes = ::testing::Types<Ellipsoid, Beckmann>;
TYPED_TEST_SUITE(MicrofacetModels, Lobes);

TYPED_TEST(MicrofacetModels, AreReciprocal) {
  for (const SlopeFrame& frame : frames()) {
    const Reciprocity found =
        reciprocity(Microfacet(TypeParam(frame), Fresnel(std::complex(0.2, 3.))), kLambda);
    EXPECT_LE(found.difference, kRounding) << frame.l11 << " at " << found.wi.transpose();
  }
}

TYPED_TEST(MicrofacetModels, ReflectNoMoreThanComes) {
  constexpr double kTolerance = 1e-2;
  for (const SlopeFrame& frame : frames())
    EXPECT_LE(white_furnace(Microfacet(TypeParam(frame)), kLambda, kTolerance).most(), 1) << frame.l11;
}

}  // namespace
}  // namespace micro
