#include "io/printable.h"

#include <gtest/gtest.h>

namespace micro {
namespace {

TEST(Printable, WordsStayAndControlsBecomeQuestionMarks) {
  EXPECT_EQ(printable("5 µm, 3°", 40), "5 µm, 3°");
  EXPECT_EQ(printable("a\nb\x1b[31m\x7f", 40), "a?b?[31m?");
  EXPECT_EQ(printable("a\xC2\x9B"
                      "31m\xC2\x85",
                      40),
            "a?31m?");
  EXPECT_EQ(printable("", 40), "");
}

TEST(Printable, CutsBetweenCharacters) {
  EXPECT_EQ(printable("abc", 3), "abc");
  EXPECT_EQ(printable("abcd", 3), "abc…");
  EXPECT_EQ(printable("abµm", 3), "ab…");  // µ has two bytes
  EXPECT_EQ(printable("\x80\x80\x80\x80", 2), "…");
  EXPECT_EQ(in_quotes(std::string(100, 'x')), "\"" + std::string(40, 'x') + "…\"");
}

}  // namespace
}  // namespace micro
