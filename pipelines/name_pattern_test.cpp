#include "pipelines/name_pattern.h"

#include <gtest/gtest.h>

#include "core/error.h"

namespace micro {
namespace {

TEST(NamePattern, FindsRowAndColumnInNames) {
  const NamePattern pattern("r{row}_c{col}");
  const auto place = pattern.find("strips/bar_r012_c3.dat");  // an r without a number comes first
  ASSERT_TRUE(place);
  EXPECT_EQ(place->row, 12);
  EXPECT_EQ(place->col, 3);
}

TEST(NamePattern, LeavesWhatItDoesNotAskForAtZero) {
  const auto place = NamePattern("{col}.dat").find("scan17.dat");
  ASSERT_TRUE(place);
  EXPECT_EQ(place->row, 0);
  EXPECT_EQ(place->col, 17);
}

TEST(NamePattern, TakesPunctuationLiterally) {
  const NamePattern pattern("({row}).[{col}]+");
  EXPECT_TRUE(pattern.find("a(1).[2]+"));
  EXPECT_FALSE(pattern.find("a(1)x[2]+"));
  EXPECT_FALSE(pattern.find("a(1).[2"));
}

TEST(NamePattern, FindsNothingInOtherNames) {
  const NamePattern pattern("r{row}_c{col}");
  EXPECT_FALSE(pattern.find(""));
  EXPECT_FALSE(pattern.find("r_c"));
  EXPECT_FALSE(pattern.find("r1_c"));
  EXPECT_FALSE(pattern.find("r-1_c2"));
  EXPECT_FALSE(pattern.find(std::string(1'000'000, 'r')));
}

TEST(NamePattern, RefusesNumbersThatNoIndexHolds) {
  EXPECT_THROW(NamePattern("r{row}").find("r99999999999999999999"), InputError);
}

TEST(NamePattern, RefusesPatternsThatDoNotSayEnough) {
  for (const char* pattern : {"", "r1_c2", "{row}{col}", "{row}0_{col}", "{row}_{col}5", "{row}_{row}"})
    EXPECT_THROW(NamePattern{pattern}, InputError) << pattern;
}

}  // namespace
}  // namespace micro
