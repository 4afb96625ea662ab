#include "fit/overlap.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/random.h"
#include "distribution/beckmann.h"
#include "distribution/ellipsoid.h"
#include "distribution/tabulate.h"

namespace micro {
namespace {

constexpr double kWide = 100, kNarrow = 4;  // nodes across: summed over blocks, node by node

// A quarter of an ellipsoid's energy lies in each ring of its own, and v²/(1 + v²) of it within |v|: rings of
// α = 0.2 hold that at v² = 1/3, 1, 3 times (0.2/0.3)² of a lobe of α = 0.3.
TEST(Overlap, OfConcentricLobesIsThatOfTheirRings) {
  const DiskGrid grid{513, 1};
  const DiskTable table = tabulate(ggx(0.3), grid);
  double expected = 0, below = 0;
  for (const double vv : {1. / 3, 1., 3., 1e12}) {
    const double scaled = vv * (0.2 * 0.2) / (0.3 * 0.3), within = scaled / (1 + scaled);
    expected += std::min(0.25, within - below);
    below = within;
  }
  constexpr double kNodes = 5e-3;  // rings are cut by nodes and blocks
  for (const double across : {kNarrow, kWide})
    EXPECT_NEAR(overlap(table, ggx(0.2).frame(), FitModel::EllipsoidNdf, across), expected, kNodes);
}

TEST(Overlap, IsOneForTheLobeItself) {
  const SlopeFrame frame = slope_frame({0.3, 0.1, 0.2, -0.1, 0.5});
  const DiskGrid grid{513, 1};
  constexpr double kBlocks = 5e-3;
  for (const double across : {kNarrow, kWide}) {
    EXPECT_NEAR(overlap(tabulate(Ellipsoid(frame), grid), frame, FitModel::EllipsoidNdf, across), 1, kBlocks);
    EXPECT_NEAR(overlap(tabulate(Beckmann(frame), grid), frame, FitModel::BeckmannNdf, across), 1, kBlocks);
  }
}

// Most of such lobes' energy is within a node of the horizon.
TEST(Overlap, IsOneForALobeThatIsWiderThanTheHemisphere) {
  const DiskGrid grid{129, 1};
  for (const EllipsoidParameters& lobe :
       {EllipsoidParameters{100, 0.12, 0, 0, 0.3}, EllipsoidParameters{1000, 1000, 0, 0, 0}})
    for (const double across : {kNarrow, kWide})
      EXPECT_NEAR(overlap(tabulate(Ellipsoid(slope_frame(lobe)), grid), slope_frame(lobe),
                          FitModel::EllipsoidNdf, across),
                  1, 1e-2)
          << lobe.alpha_x;
}

TEST(Overlap, IsThePartOfTheEnergyAndNothingElsewhere) {
  DiskTable part = tabulate(ggx(0.1), {257, 1});
  part.density *= 0.3;
  EXPECT_NEAR(overlap(part, ggx(0.1).frame(), FitModel::EllipsoidNdf, kNarrow), 0.3, 1e-3);
  const SlopeFrame aside = slope_frame({0.02, 0.02, 0.8, 0, 0});
  constexpr double kBeyond = 2. / 16 + 0.01;  // two of the outer parts hold all that lies on that side of it
  EXPECT_LE(overlap(part, aside, FitModel::BeckmannNdf, kNarrow), kBeyond);
}

// The energy of single nodes is noise: here exponential, as of one patch's speckle.
TEST(Overlap, SpeckleAveragesOut) {
  DiskTable table = tabulate(ggx(0.2), {257, 1});
  for (Eigen::Index k = 0; k < table.density.size(); ++k)
    table.density.data()[k] *= -std::log1p(-random_uniform(1, 0, static_cast<std::uint64_t>(k))[0]);
  EXPECT_GE(overlap(table, ggx(0.2).frame(), FitModel::EllipsoidNdf, kNarrow), 0.95);
}

}  // namespace
}  // namespace micro
