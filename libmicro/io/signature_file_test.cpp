#include "io/signature_file.h"

#include <gtest/gtest.h>

#include <fstream>
#include <numbers>

#include "core/error.h"
#include "testing/temporary_folder.h"

namespace micro {
namespace {

Signature read_text(const char* text) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "mirror.txt";
  std::ofstream(path) << text;
  return read_signature(path);
}

TEST(SignatureFile, ReadsDegrees) {
  const Signature signature = read_text("# from a mirror\n0 2\n\n90 0.5 # far off\n");
  ASSERT_EQ(signature.angle.size(), 2u);
  EXPECT_DOUBLE_EQ(signature.angle[1], std::numbers::pi / 2);
  EXPECT_DOUBLE_EQ(signature.response[1], 0.5);
}

TEST(SignatureFile, NamesTheLineThatIsNone) {
  try {
    read_text("0 1\n1 x\n");
    FAIL();
  } catch (const FileError& error) {
    EXPECT_NE(std::string(error.what()).find("line 2"), std::string::npos);
  }
  EXPECT_THROW(read_text(""), FileError);
  EXPECT_THROW(read_text("0 1 1\n2 1\n"), FileError);
  EXPECT_THROW(read_text("1 1\n2 1\n"), FileError);
  EXPECT_THROW(read_signature("nowhere"), FileError);
}

}  // namespace
}  // namespace micro
