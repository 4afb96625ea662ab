#include "tools/units.h"

#include <gtest/gtest.h>

#include <numbers>

namespace micro::tools {
namespace {

TEST(Units, LengthsAreMicrometres) {
  EXPECT_DOUBLE_EQ(parse_length("550nm"), 0.55);
  EXPECT_DOUBLE_EQ(parse_length("1um"), 1);
  EXPECT_DOUBLE_EQ(parse_length("1µm"), 1);
  EXPECT_DOUBLE_EQ(parse_length("0.2mm"), 200);
  EXPECT_DOUBLE_EQ(parse_length("1m"), 1e6);
  EXPECT_DOUBLE_EQ(parse_length("0.555"), 0.555);
}

TEST(Units, AnglesAreRadians) {
  EXPECT_DOUBLE_EQ(parse_angle("180deg"), std::numbers::pi);
  EXPECT_DOUBLE_EQ(parse_angle("90"), std::numbers::pi / 2);
  EXPECT_DOUBLE_EQ(parse_angle("0.1rad"), 0.1);
}

TEST(Units, RefusesWhatIsNoLength) {
  for (const char* text : {"", "nm", "1 furlong", "nan", "inf", "1e999", "1um2", "0x10"})
    EXPECT_THROW(parse_length(text), CLI::ValidationError) << text;
  EXPECT_THROW(parse_angle("1um"), CLI::ValidationError);
}

TEST(Units, ChecksNumbersWithASentence) {
  for (const char* text : {"1", "1e-9", "3.5"}) {
    EXPECT_EQ(positive_number()(std::string(text)), "") << text;
    EXPECT_EQ(number_from_zero()(std::string(text)), "") << text;
  }
  EXPECT_EQ(number_from_zero()(std::string("0")), "");
  for (const char* text : {"0", "-1", "nan", "inf", "1e999", "", "1um"})
    EXPECT_NE(positive_number()(std::string(text)), "") << text;
  for (const char* text : {"-1", "nan", "inf", "", "one"})
    EXPECT_NE(number_from_zero()(std::string(text)), "") << text;
  for (const char* text : {"0", "18446744073709551615"})
    EXPECT_EQ(seed_number()(std::string(text)), "") << text;
  for (const char* text : {"-1", "1.5", "18446744073709551616", "", "x"})
    EXPECT_NE(seed_number()(std::string(text)), "") << text;
}

}  // namespace
}  // namespace micro::tools
