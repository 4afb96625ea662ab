#include "io/exr_texture.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfStringAttribute.h>
#include <ImfTiledInputFile.h>
#include <gtest/gtest.h>

#include <cmath>

#include "testing/temporary_folder.h"

namespace micro {
namespace {

Grid<float> level_of(const std::filesystem::path& path, const std::string& channel, int level) {
  Imf::TiledInputFile file(path.c_str());
  Grid<float> values(file.levelHeight(level), file.levelWidth(level));
  Imf::FrameBuffer frame;
  frame.insert(channel, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(values.data()), sizeof(float),
                                   sizeof(float) * static_cast<std::size_t>(values.cols())));
  file.setFrameBuffer(frame);
  file.readTiles(0, file.numXTiles(level) - 1, 0, file.numYTiles(level) - 1, level);
  return values;
}

TEST(ExrTexture, ComesBackPartByPartAndLevelByLevel) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "t.exr";
  const std::vector<Grid<float>> whole = {Grid<float>::Random(70, 101).abs(), Grid<float>::Random(70, 101)};
  ExrTextureWriter writer(path, {.rows = 70,
                                 .cols = 101,
                                 .channels = {"alpha.x", "theta.x"},
                                 .positive = {"alpha.x"},
                                 .attributes = {{"seed", "7"}}});
  ASSERT_EQ(writer.levels(), 8);
  // Tiles in no order.
  const auto part = [&](Eigen::Index j, Eigen::Index i, Eigen::Index rows, Eigen::Index cols) {
    writer.write(0, j, i, {whole[0].block(j, i, rows, cols), whole[1].block(j, i, rows, cols)});
  };
  part(64, 64, 6, 37);
  part(0, 0, 64, 101);
  part(64, 0, 6, 64);
  EXPECT_FALSE(std::filesystem::exists(path));
  for (int level = 1; level < 8; ++level) {
    const Grid<float> flat =
        Grid<float>::Constant(((70 - 1) >> level) + 1, ((101 - 1) >> level) + 1, static_cast<float>(level));
    writer.write(level, 0, 0, {flat, flat});
  }
  writer.finish();
  EXPECT_TRUE((level_of(path, "alpha.x", 0) == whole[0]).all());
  EXPECT_TRUE((level_of(path, "theta.x", 0) == whole[1]).all());
  EXPECT_EQ(level_of(path, "theta.x", 1).rows(), 35);
  EXPECT_EQ(level_of(path, "theta.x", 1).cols(), 51);
  EXPECT_EQ(level_of(path, "theta.x", 7)(0, 0), 7);
  const Imf::TiledInputFile file(path.c_str());
  EXPECT_EQ(file.header().typedAttribute<Imf::StringAttribute>("seed").value(), "7");
}

TEST(ExrTexture, KeepsWidthsPositiveInHalf) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "t.exr";
  ExrTextureWriter writer(path, {.rows = 1,
                                 .cols = 3,
                                 .channels = {"alpha.x", "theta.x"},
                                 .positive = {"alpha.x"},
                                 .pixel = ExrPixel::Half,
                                 .levels = ExrTextureWriter::Levels::Finest,
                                 .attributes = {}});
  Grid<float> values(1, 3);
  values << 1e-9F, 0.125F, 1e6F;
  writer.write(0, 0, 0, {values, -values});
  writer.finish();
  const Grid<float> alpha = level_of(path, "alpha.x", 0), theta = level_of(path, "theta.x", 0);
  EXPECT_EQ(alpha(0, 0), 0x1p-14F);
  EXPECT_EQ(alpha(0, 1), 0.125F);
  EXPECT_EQ(alpha(0, 2), 65504.F);
  EXPECT_EQ(theta(0, 2), -65504.F);
}

}  // namespace
}  // namespace micro
