#include "pipelines/study.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "height/gaussian_surface.h"
#include "height/make_holes.h"
#include "io/atomic_file.h"
#include "io/zygo_dat.h"
#include "pipelines/result_file.h"
#include "testing/temporary_folder.h"

namespace micro {
namespace {

class StudyTest : public testing::Test {
 protected:
  void SetUp() override {
    HeightField surface = gaussian_surface({120, 120, 0.2, 0.2}, {.rms = 0.3, .tau_x = 2, .tau_y = 2}, 3);
    surface = make_holes(surface, {.fraction = 0.02}, 4);
    surface.z(60, 60) += 40;  // an outlier, as a profilometer leaves them
    write_zygo_dat(folder_.path() / "scan.dat", surface);
    request_.size = 129;
  }
  ScanListing listing() { return list_scans({folder_.path()}); }

  TemporaryFolder folder_;
  NdfRequest request_;
};

TEST_F(StudyTest, WiderWindowsGiveNarrowerLobes) {
  const Study study = study_sigma(listing(), request_, {0.5, 1, 2}, [](const Progress&) {});
  ASSERT_EQ(study.rows.size(), 4u);
  EXPECT_GT(study.rows[1].width_x, study.rows[2].width_x);
  EXPECT_GT(study.rows[2].width_x, study.rows[3].width_x);
  EXPECT_EQ(study.rows[2].difference, 0);
  EXPECT_GT(study.rows[3].difference, 0);
  EXPECT_NE(to_markdown(study).find("filtered_0.5um"), std::string::npos);
  EXPECT_NE(to_csv(study).find("filtered_2um"), std::string::npos);
}

TEST_F(StudyTest, FiltersReportWhatTheyChanged) {
  const Study study = study_filters(listing(), request_, [](const Progress&) {});
  ASSERT_EQ(study.rows.size(), 4u);
  EXPECT_EQ(study.rows[0].rejected, 0);
  EXPECT_GE(study.rows[1].rejected, 1);
  EXPECT_GT(study.rows[2].filled, 0);
  EXPECT_GT(study.rows[3].filled, study.rows[2].filled);
  EXPECT_EQ(study.rows[0].difference, 0);
  EXPECT_TRUE(std::isfinite(study.rows[3].difference));
}

TEST_F(StudyTest, ScansThatFailAreNamed) {
  write_text_file(folder_.path() / "torn.dat", std::string("\x88\x1B\x03\x6F\0\1 and no more", 18));
  for (const Study& study : {study_sigma(listing(), request_, {1}, [](const Progress&) {}),
                             study_filters(listing(), request_, [](const Progress&) {})}) {
    ASSERT_EQ(study.scans.size(), 2u);
    EXPECT_FALSE(study.scans[0].failure);
    EXPECT_EQ(study.scans[1].source, "torn.dat");
    EXPECT_TRUE(study.scans[1].failure);
  }
}

TEST_F(StudyTest, ASigmaThatThePitchDoesNotResolveIsLeftOutWithItsReason) {
  const Study study = study_sigma(listing(), request_, {0.05, 1}, [](const Progress&) {});
  EXPECT_EQ(study.rows.size(), 2u);
  ASSERT_EQ(study.left_out.size(), 1u);
  EXPECT_EQ(study.left_out[0].name, "filtered_0.05um NDF");
  EXPECT_NE(study.left_out[0].reason.find("below half the pitch"), std::string::npos);
}

TEST_F(StudyTest, WithoutItsReferenceNothingIsCompared) {
  EXPECT_TRUE(study_sigma(list_scans({"nowhere"}), request_, {1}, [](const Progress&) {}).rows.empty());
}

/// The same density on all of a disk of that radius.
NdfOfScans disk(double radius) {
  NdfOfScans ndf;
  ndf.density = make_disk_table({129, 1});
  for (Eigen::Index j = 0; j < 129; ++j)
    for (Eigen::Index i = 0; i < 129; ++i)
      if (ndf.density.grid.mz2(j, i) > 1 - radius * radius) ndf.density.density(j, i) = 1;
  return ndf;
}

Eigen::Index lightest(const Picture& sheet) {
  return std::count(sheet.data(), sheet.data() + sheet.size(), Rgb{255, 255, 217});
}

TEST(ComparisonSheet, ShowsWidthsToOneScale) {
  const Eigen::Index wide = lightest(comparison_sheet({disk(0.8)}));
  const Eigen::Index both = lightest(comparison_sheet({disk(0.2), disk(0.8)}));
  constexpr double nodes_on_the_rim = 1;  // of the smaller disk, whose radius is 12.8 nodes
  EXPECT_NEAR(static_cast<double>(wide) / static_cast<double>(both - wide), 16, nodes_on_the_rim);
}

}  // namespace
}  // namespace micro
