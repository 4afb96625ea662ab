#include "tools/spectrum_options.h"

#include <gtest/gtest.h>

namespace micro::tools {
namespace {

TEST(LambdaQ, ReadsRanges) {
  const auto range = [](const char* text) { return std::get<std::vector<double>>(parse_lambda_q(text)); };
  const std::vector<double> visible = range("0.38..0.78/0.01");
  ASSERT_EQ(visible.size(), 41u);
  EXPECT_DOUBLE_EQ(visible.front(), 0.38);
  EXPECT_DOUBLE_EQ(visible.back(), 0.78);
  EXPECT_EQ(range("380nm..780nm/10nm").size(), 41u);
  EXPECT_EQ(range("0.4..0.45/0.02").size(), 3u);  // the end is between steps
  EXPECT_EQ(range("0.4..0.4/1nm").size(), 1u);
  EXPECT_DOUBLE_EQ(std::get<double>(parse_lambda_q("555nm")), 0.555);
  EXPECT_TRUE(std::holds_alternative<AsManyAsNeeded>(parse_lambda_q("auto")));
}

TEST(LambdaQ, RefusesWhatIsNone) {
  for (const char* text : {"", "0", "-0.5", "nan", "automatic", "0.4..", "..0.5/1nm", "0.4..0.5", "0.4..0.5/",
                           "0.5..0.4/0.01", "0.4..0.5/0", "0.4..0.5/-1nm", "0.4..0.5/1e-6", "0..0.5/0.1",
                           "0.4..0.5/0.1/0.1", "0.4...0.5/0.1", "0.4..inf/0.1", "0.4..0.5/1deg"})
    EXPECT_THROW(parse_lambda_q(text), CLI::ValidationError) << text;
}

}  // namespace
}  // namespace micro::tools
