#include "pipelines/brdf_model.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "distribution/beckmann.h"
#include "distribution/tabulate.h"
#include "io/hdf5_writer.h"
#include "pipelines/brdf_report.h"
#include "testing/brdf_sampling.h"
#include "testing/temporary_folder.h"

namespace micro {
namespace {

/// Waves are n times shorter under a coat: D_K there is that of λ/n. Its tangential q is that outside.
TEST(BrdfModels, WavesUnderACoatAreShorter) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "spectrum.h5";
  const std::vector<double> lambda_q = {0.3, 0.9};
  Hdf5Writer writer(path);
  writer.write_slices("/ndf/kirchhoff_spectrum/density", {2, 129, 129}, 0, [](std::size_t k) {
    const double alpha = k == 0 ? 0.2 : 0.4;
    return Grid<float>(tabulate(Beckmann({{0, 0}, alpha, 0, alpha}), {129, 1}).density.cast<float>());
  });
  writer.write<double>("/ndf/kirchhoff_spectrum/lambda_q_um", lambda_q, {2});
  writer.set_attribute("/ndf/kirchhoff_spectrum", "extent", 1.0);
  writer.finish();

  constexpr double kIndex = 1.5, kLambda = 0.6;
  ResultModelRequest request{path, "kirchhoff_spectrum"};
  const BrdfModel outside = result_model(request, Fresnel());
  request.medium = kIndex;
  const BrdfModel inside = result_model(request, Fresnel());
  const Vec3 wi = testing::direction(30), wo = testing::direction(10, 2);
  const double under_coat = inside.mirror.f(wi, wo, kLambda);
  EXPECT_NEAR(under_coat / outside.mirror.f(wi, wo, kLambda / kIndex), 1, 1e-12);
  EXPECT_GT(std::abs(under_coat / outside.mirror.f(wi, wo, kLambda) - 1), 0.05);

  // Light that no table is for is refused: from 0.3 to 0.9 µm, in the coat from 0.45 to 1.35.
  const auto evaluated = [](const BrdfModel& model, double lambda) {
    BrdfRequest asked{.lambda_um = {lambda}, .wi = {Vec3(0, 0, 1)}};
    return evaluate_brdf(model, "mirror", asked);
  };
  for (const double lambda : {0.3, 0.6, 0.9})
    EXPECT_EQ(evaluated(outside, lambda).slices.size(), 1u) << lambda;
  EXPECT_THROW(evaluated(outside, 0.29), InputError);
  EXPECT_THROW(evaluated(outside, 0.91), InputError);
  const BrdfModel coated = coated_model(inside, {kIndex, 100}, SunForm::Corrected);
  EXPECT_EQ(evaluated(coated, 1.3).slices.size(), 1u);
  EXPECT_THROW(evaluated(coated, 0.44), InputError);
}

}  // namespace
}  // namespace micro
