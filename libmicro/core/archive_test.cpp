#include "core/archive.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/grid.h"

namespace micro {
namespace {

struct Empty {};
enum class Colour { Red, Green };
struct Everything {
  int number = 0;
  double real = 0;
  bool flag = false;
  Colour colour = Colour::Red;
  std::string text;
  std::vector<std::string> texts;
  std::optional<double> maybe, never;
  std::map<std::string, std::int64_t> counts;
  std::variant<Empty, int, std::vector<Vec3>> choice;
  Grid<double> grid;
  Grid<std::array<std::uint8_t, 3>> picture;

  template <typename Archive>
  void persist(Archive& archive) {
    archive(number, real, flag, colour, text, texts, maybe, never, counts, choice, grid, picture);
  }
};

Everything example() {
  Everything value;
  value.number = -7;
  value.real = 0.1;
  value.flag = true;
  value.colour = Colour::Green;
  value.text = "µm";
  value.texts = {"", "two"};
  value.maybe = std::numeric_limits<double>::infinity();
  value.counts = {{"a", 1}, {"b", -2}};
  value.choice = std::vector<Vec3>{{1, 2, 3}, {4, 5, 6}};
  value.grid = Grid<double>::Random(3, 5);
  value.picture = Grid<std::array<std::uint8_t, 3>>::Constant(2, 2, {1, 2, 3});
  return value;
}

std::vector<std::uint8_t> bytes_of(Everything value) {
  ArchiveWriter archive;
  archive(value);
  return archive.bytes();
}

TEST(Archive, GivesBackWhatItWasGiven) {
  const Everything value = example();
  const std::vector<std::uint8_t> bytes = bytes_of(value);
  ArchiveReader archive(bytes);
  Everything read;
  archive(read);
  EXPECT_TRUE(archive.at_end());
  EXPECT_EQ(read.number, value.number);
  EXPECT_EQ(read.real, value.real);
  EXPECT_EQ(read.flag, value.flag);
  EXPECT_EQ(read.colour, value.colour);
  EXPECT_EQ(read.text, value.text);
  EXPECT_EQ(read.texts, value.texts);
  EXPECT_EQ(read.maybe, value.maybe);
  EXPECT_EQ(read.never, value.never);
  EXPECT_EQ(read.counts, value.counts);
  EXPECT_EQ(std::get<2>(read.choice), std::get<2>(value.choice));
  EXPECT_TRUE((read.grid == value.grid).all());
  EXPECT_EQ(read.picture(1, 1), value.picture(1, 1));
  EXPECT_EQ(bytes_of(read), bytes);
}

TEST(Archive, RefusesBytesThatEndTooSoon) {
  const std::vector<std::uint8_t> bytes = bytes_of(example());
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    const std::vector<std::uint8_t> cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length));
    ArchiveReader archive(cut);
    Everything read;
    EXPECT_THROW(archive(read), BrokenArchive) << length;
  }
}

TEST(Archive, TakesNoMemoryForWhatIsNotThere) {
  const std::vector<std::uint8_t> bytes(64, 0xff);
  ArchiveReader text(bytes), grid(bytes), choice(bytes);
  std::string s;
  Grid<double> g;
  std::variant<int, double> v;
  EXPECT_THROW(text(s), BrokenArchive);
  EXPECT_THROW(grid(g), BrokenArchive);
  EXPECT_THROW(choice(v), BrokenArchive);
}

}  // namespace
}  // namespace micro
