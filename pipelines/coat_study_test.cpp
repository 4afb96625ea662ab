#include "pipelines/coat_study.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "testing/temporary_folder.h"

namespace micro {
namespace {

TEST(CoatStudy, FurnaceTellsCorrectedFromPrinted) {
  const std::vector<FurnaceRow> rows = study_coat_furnace(2e-2);
  double most_printed = 0;
  for (const FurnaceRow& row : rows) {
    EXPECT_LE(row.sun.value - row.sun.error, 1) << row.s << ' ' << row.theta_deg;
    EXPECT_LE(row.coat.value - row.coat.error, 1) << row.s << ' ' << row.theta_deg;
    most_printed = std::max(most_printed, row.coat_printed.value);
  }
  EXPECT_GT(most_printed, 2);
  const std::string text = to_markdown(rows), csv = to_csv(rows);
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), static_cast<std::ptrdiff_t>(rows.size() + 2));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), static_cast<std::ptrdiff_t>(rows.size() + 1));
}

TEST(CoatStudy, DrawsFourFigures) {
  const TemporaryFolder folder;
  write_coat_figures(folder.path());
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 4);
}

}  // namespace
}  // namespace micro
