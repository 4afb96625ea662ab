#include "fit/quadric_start.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/random.h"
#include "distribution/beckmann.h"
#include "distribution/ellipsoid.h"
#include "distribution/tabulate.h"
#include "testing/step_between.h"

namespace micro {
namespace {

using testing::step_between;

const FitModel kModels[] = {FitModel::EllipsoidNdf, FitModel::BeckmannNdf};
const Weighting kWeightings[] = {Weighting::SolidAngle, Weighting::Log};

TableNodes nodes_of(const SlopeFrame& frame, FitModel model, const DiskGrid& grid) {
  return core_nodes(
      model == FitModel::EllipsoidNdf ? tabulate(Ellipsoid(frame), grid) : tabulate(Beckmann(frame), grid),
      4096);
}

// Round, stretched, turned and skewed lobes, solved in the coordinates of a frame that is far off.
TEST(QuadricStart, IsTheAnswerOnAnExactTable) {
  const EllipsoidParameters lobes[] = {
      {0.2, 0.2, 0, 0, 0}, {0.5, 0.05, 0.3, -0.2, 0.6}, {0.3, 0.1, 0.9, 0, 0.2}, {0.05, 0.02, -0.4, 0.5, 1}};
  for (const EllipsoidParameters& lobe : lobes)
    for (const FitModel model : kModels)
      for (const Weighting weighting : kWeightings) {
        const SlopeFrame frame = slope_frame(lobe);
        SlopeFrame near = frame;
        near.centre += Vec2(1.5 * frame.l11, -frame.l22);
        near.l11 *= 3;
        near.l22 *= 0.4;
        const auto start = quadric_start(nodes_of(frame, model, {129, 1}), near, model, weighting);
        ASSERT_TRUE(start);
        EXPECT_LE(step_between(frame, *start).cwiseAbs().maxCoeff(), 1e-9) << lobe.alpha_x;
      }
}

TEST(QuadricStart, DoesNotMindAPartOfTheEnergyOrAnyUnit) {
  const SlopeFrame frame = slope_frame({0.5, 0.05, 0.3, -0.2, 0.6});
  for (const double part : {0.3, 1e-200, 1e200})
    for (const Weighting weighting : kWeightings) {
      TableNodes nodes = nodes_of(frame, FitModel::EllipsoidNdf, {129, 1});
      for (double& density : nodes.density)
        density *= part;
      const auto start = quadric_start(nodes, frame, FitModel::EllipsoidNdf, weighting);
      ASSERT_TRUE(start);
      EXPECT_LE(step_between(frame, *start).cwiseAbs().maxCoeff(), 1e-9);
    }
}

TEST(QuadricStart, HasNoneWhereTheQuadricIsNoLobe) {
  const SlopeFrame near = slope_frame({0.2, 0.2, 0, 0, 0});
  TableNodes nodes;
  for (const FitModel model : kModels) {
    EXPECT_FALSE(quadric_start(nodes, near, model, Weighting::SolidAngle));
  }
  // A ring: its density grows from the middle outwards.
  const DiskGrid grid{65, 1};
  for (Eigen::Index j = 0; j < grid.size; ++j)
    for (Eigen::Index i = 0; i < grid.size; ++i)
      if (const double r2 = 1 - grid.mz2(j, i); r2 < 0.25) {
        nodes.x.push_back(grid.coordinate(i));
        nodes.y.push_back(grid.coordinate(j));
        nodes.density.push_back(0.1 + r2);
      }
  for (const FitModel model : kModels)
    for (const Weighting weighting : kWeightings)
      EXPECT_FALSE(quadric_start(nodes, near, model, weighting));
  // Nothing but zeros.
  std::fill(nodes.density.begin(), nodes.density.end(), 0);
  EXPECT_FALSE(quadric_start(nodes, near, FitModel::EllipsoidNdf, Weighting::Log));
}

}  // namespace
}  // namespace micro
