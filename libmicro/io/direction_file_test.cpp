#include "io/direction_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <string>

#include "core/error.h"

namespace micro {
namespace {

std::filesystem::path written(const std::string& text) {
  const std::filesystem::path path =
      std::filesystem::path(::testing::TempDir()) / "microbrdf_direction_file_test.txt";
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

TEST(DirectionFile, TwoOrThreeNumbersALine) {
  const auto h = read_directions(written("# hx hy\n0.1 0.2\r\n\n 0.6,0,0.8 # three\n-1\t0\n0 0 1.005"));
  ASSERT_EQ(h.size(), 4u);
  EXPECT_NEAR(h[0].z(), std::sqrt(1 - 0.01 - 0.04), 1e-15);
  EXPECT_EQ(h[1], Vec3(0.6, 0, 0.8));
  EXPECT_EQ(h[2], Vec3(-1, 0, 0));
  EXPECT_EQ(h[3], Vec3(0, 0, 1));
}

TEST(DirectionFile, RefusesWithTheLine) {
  for (const char* text : {"0.1\n", "0.1 0.2 0.3 0.4\n", "0.9 0.9\n", "0 0 2\n", "0 0 -1\n", "a b\n",
                           "0.1 0.2x\n", "nan 0\n", "inf 0\n", "1e999 0\n"})
    try {
      read_directions(written(std::string("0 0\n") + text));
      ADD_FAILURE() << text;
    } catch (const FileError& error) {
      EXPECT_NE(std::string(error.what()).find("line 2: "), std::string::npos) << error.what();
    }
  EXPECT_THROW(read_directions(written("")), FileError);
  EXPECT_THROW(read_directions(written("# nothing\n")), FileError);
  EXPECT_THROW(read_directions(written(std::string(100000, '1'))), FileError);
  EXPECT_THROW(read_directions(std::string(::testing::TempDir()) + "/no such file"), FileError);
  EXPECT_THROW(read_directions(::testing::TempDir()), FileError);
}

}  // namespace
}  // namespace micro
