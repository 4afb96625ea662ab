#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfStringAttribute.h>
#include <gtest/gtest.h>
#include <png.h>

#include <fstream>

#include "core/error.h"
#include "io/exr.h"
#include "io/png.h"
#include "io/sha256.h"
#include "testing/temporary_folder.h"

namespace micro {
namespace {

TEST(Exr, ReadsBackWhatWasWritten) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "table.exr";
  Grid<float> values(3, 5);
  for (int k = 0; k < 15; ++k)
    values.data()[k] = 0.1f * static_cast<float>(k);
  write_exr(path, {{"Y", values}, {"alpha.x", 2 * values}}, {{"unit", "1/sr"}});

  Imf::InputFile file(path.c_str());
  EXPECT_EQ(file.header().typedAttribute<Imf::StringAttribute>("unit").value(), "1/sr");
  Grid<float> read(3, 5);
  Imf::FrameBuffer frame;
  frame.insert("alpha.x", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(read.data()), 4, 20));
  file.setFrameBuffer(frame);
  file.readPixels(0, 2);
  EXPECT_TRUE((read == 2 * values).all());
}

TEST(Png, ReadsBackWhatWasWritten) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "picture.png";
  Picture picture(2, 3);
  for (int k = 0; k < 6; ++k)
    picture.data()[k] = {static_cast<std::uint8_t>(k), 100, static_cast<std::uint8_t>(255 - k)};
  write_png(path, picture);

  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  ASSERT_TRUE(png_image_begin_read_from_file(&image, path.c_str()));
  ASSERT_EQ(image.width, 3u);
  ASSERT_EQ(image.height, 2u);
  image.format = PNG_FORMAT_RGB;
  Picture read(2, 3);
  ASSERT_TRUE(png_image_finish_read(&image, nullptr, read.data(), 0, nullptr));
  for (int k = 0; k < 6; ++k)
    EXPECT_EQ(read.data()[k], picture.data()[k]);
}

TEST(Pictures, AFolderThatIsNotThereIsNamed) {
  EXPECT_THROW(write_exr("nowhere/at/all.exr", {{"Y", Grid<float>::Zero(2, 2)}}, {}), FileError);
  EXPECT_THROW(write_png("nowhere/at/all.png", Picture(2, 2)), FileError);
}

// FIPS 180-2, example B.1.
TEST(Sha256, OfAbc) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "abc";
  std::ofstream(path) << "abc";
  EXPECT_EQ(sha256_of_file(path), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_THROW(sha256_of_file(folder.path() / "missing"), FileError);
}

}  // namespace
}  // namespace micro
