#include "pipelines/textures.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "core/random.h"
#include "distribution/ellipsoid.h"
#include "distribution/tabulate.h"
#include "height/brushed_surface.h"
#include "io/hdf5_reader.h"
#include "ndf/local_planes.h"
#include "ndf/normal_counts.h"
#include "testing/temporary_folder.h"

namespace micro {
namespace {

double relative_rms(const DiskTable& model, const DiskTable& table) {
  return std::sqrt((model.density - table.density).square().sum() / table.density.square().sum());
}

TEST(Textures, CoarsestLevelIsTheLargeAreasDistribution) {
  // 10 × 10 texels of 25 µm on brushed metal: one lobe refitted from the texels' against the filtered NDF of
  // the whole area, beside the best that any ellipsoid could do, and averaged parameters.
  constexpr double kAsGoodAs = 1.05, kWorse = 1.3;  // measured: 1.0006 and 1.46
  const HeightField surface = brushed_surface(
      {1000, 1000, 0.25, 0.25}, {.rms = 0.3, .length = 30, .width = 6, .coverage = 3, .spread = 0.3}, 1);
  const SurfaceTexels texels = texels_of_surface(surface, {100, 100, 1, 0});
  std::vector<SlopeFrame> lobes;
  for (const Texel& texel : texels.texels)
    lobes.push_back(texel.fit.frame);
  const DiskTable large = density(filtered_counts(local_planes(surface, 1), {257, 0.6}));
  const auto judged = [&](const SlopeFrame& frame) {
    return relative_rms(tabulate(Ellipsoid(frame), large.grid), large);
  };
  const double best = fit(large, FitModel::EllipsoidNdf).rel_rms;
  const double refitted = judged(minified(lobes)), averaged = judged(naive_average(lobes));
  EXPECT_LE(refitted, kAsGoodAs * best);
  EXPECT_GT(averaged, kWorse * refitted);
}

/// Texels of made-up lobes that vary.
Texels made_texels(Eigen::Index rows, Eigen::Index cols) {
  Texels texels;
  texels.rows = rows;
  texels.cols = cols;
  texels.width = 70;
  texels.height = 53;
  texels.texels.resize(static_cast<std::size_t>(rows * cols));
  texels.states.assign(texels.texels.size(), TexelState::Fitted);
  texels.places.resize(texels.texels.size());
  std::iota(texels.places.begin(), texels.places.end(), 0);
  for (std::size_t k = 0; k < texels.texels.size(); ++k) {
    const auto [a, b] = random_normal(1, 0, k);
    const auto [c, d] = random_normal(1, 1, k);
    texels.texels[k].fit.frame =
        frame_of({0.02 * a, 0.005 * b, std::log(0.2) + 0.4 * c, 0.3 * d, std::log(0.03)});
  }
  return texels;
}

TEST(Textures, WriteEveryTexelValid) {
  const TemporaryFolder folder;
  for (const Recipe recipe : {Recipe::Separable, Recipe::Joint}) {
    TextureRequest request;
    request.recipe = recipe;
    request.size = {33, 130};
    const auto path = folder.path() / (std::string(name_of(recipe)) + ".h5");
    Hdf5Writer file(path);
    const TextureSummary summary =
        write_texture(made_texels(1, 60), request, file, folder.path() / "t.exr", "test");
    file.finish();
    EXPECT_FALSE(summary.in_parts);
    EXPECT_EQ(summary.misfits.size(), 8U);
    for (const LevelMisfit& level : summary.misfits)
      EXPECT_LE(level.refitted.divergence, level.averaged.divergence + 1e-3) << level.level;
    const Hdf5Reader reader(path);
    const std::vector<float> p = reader.read<float>("/texture/parameters"),
                             location = reader.read<float>("/texture/location"),
                             scale = reader.read<float>("/texture/scale");
    ASSERT_EQ(p.size(), 33U * 130 * 5);
    for (std::size_t k = 0; k < p.size() / 5; ++k) {
      ASSERT_GT(p[5 * k + 1], 0);
      ASSERT_GE(p[5 * k], p[5 * k + 1]);
      // Location and scale are the same lobe.
      const SlopeFrame frame =
          slope_frame({p[5 * k], p[5 * k + 1], p[5 * k + 2], p[5 * k + 3], p[5 * k + 4]});
      ASSERT_NEAR(frame.centre.x(), location[2 * k], 1e-5);
      ASSERT_NEAR(frame.scale()(0, 1), scale[3 * k + 1], 1e-4 * (scale[3 * k] + scale[3 * k + 2]));
    }
  }
}

TEST(Textures, SayWhatHalfCannotHold) {
  const TemporaryFolder folder;
  TextureRequest request;
  request.size = {8, 8};
  request.marginals = TextureRequest::Marginals::Gaussian;
  Texels texels = made_texels(4, 4);
  const auto stage = [&](ExrPixel pixel) -> std::string {
    request.pixel = pixel;
    Hdf5Writer file(folder.path() / "t.h5");
    for (const Stage& s : write_texture(texels, request, file, folder.path() / "t.exr", "test").plan)
      if (s.name == "half") return s.reason;
    return "";
  };
  EXPECT_EQ(stage(ExrPixel::Half), "");
  for (Texel& texel : texels.texels)
    texel.fit.frame.l22 = 1e-5;
  EXPECT_EQ(stage(ExrPixel::Half).find("64 texels narrower"), 0u) << stage(ExrPixel::Half);
  EXPECT_EQ(stage(ExrPixel::Float), "");
}

TEST(Textures, GoByPartsWhereTheyAreLarge) {
  const TemporaryFolder folder;
  TextureRequest request;
  request.size = {40, 4100};
  request.recipe = Recipe::Separable;
  request.marginals = TextureRequest::Marginals::Gaussian;
  const auto path = folder.path() / "t.h5";
  Hdf5Writer file(path);
  const TextureSummary summary =
      write_texture(made_texels(8, 8), request, file, folder.path() / "t.exr", "test");
  file.finish();
  EXPECT_TRUE(summary.in_parts);
  ASSERT_TRUE(summary.coarsest);
  EXPECT_GT(summary.coarsest->l11, 0.1);
  const std::vector<float> location = Hdf5Reader(path).read<float>("/texture/location");
  double sum = 0, squares = 0;
  const std::size_t texels = location.size() / 2;
  for (std::size_t k = 0; k < texels; ++k) {
    sum += location[2 * k];
    squares += location[2 * k] * location[2 * k];
  }
  const Covariance covariance = moments_of(exemplar_of(made_texels(8, 8))).covariance;
  const double variance =
      squares / static_cast<double>(texels) - std::pow(sum / static_cast<double>(texels), 2);
  EXPECT_NEAR(variance / covariance(0, 0), 1, 0.1);
}

}  // namespace
}  // namespace micro
