#include "fit/normal_equations.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "core/random.h"
#include "distribution/beckmann.h"
#include "distribution/ellipsoid.h"
#include "distribution/tabulate.h"

namespace micro {
namespace {

const SlopeFrame kFrame = slope_frame({0.4, 0.2, 0.3, -0.2, 0.5});

double density(const SlopeFrame& frame, FitModel model, const Vec3& m) {
  return model == FitModel::EllipsoidNdf ? Ellipsoid(frame).D(m) : Beckmann(frame).D(m);
}

/// 1/m_z, but no more than its mean over a cell that ends at the horizon, (2/spacing)^½.
double literal_weight(const DiskGrid& grid, double mz) {
  return std::min(1 / mz, std::sqrt(2 / grid.spacing()));
}

/// The sums as their definition says, derivatives by central differences.
NormalEquations literal(const DiskTable& table, FitModel model, Weighting weighting) {
  constexpr double kStep = 1e-5;
  const bool log = weighting == Weighting::Log;
  const auto in_scale = [&](double d) { return log ? std::log(d) : d; };
  NormalEquations sums;
  for (Eigen::Index j = 0; j < table.grid.size; ++j)
    for (Eigen::Index i = 0; i < table.grid.size; ++i) {
      const double mz2 = table.grid.mz2(j, i), data = table.density(j, i);
      if (!(mz2 > 0) || (log && !(data > 0))) continue;
      const Vec3 m(table.grid.coordinate(i), table.grid.coordinate(j), std::sqrt(mz2));
      Vector5 g;
      for (int k = 0; k < 5; ++k) {
        const Vector5 step = kStep * Vector5::Unit(k);
        g[k] = (in_scale(density(moved(kFrame, step), model, m)) -
                in_scale(density(moved(kFrame, -step), model, m))) /
               (2 * kStep);
      }
      const double w = literal_weight(table.grid, m.z());
      const double r = in_scale(data) - in_scale(density(kFrame, model, m));
      sums.gram += w * g * g.transpose();
      sums.gradient += w * r * g;
      sums.cost += w * r * r;
      sums.data += w * in_scale(data) * in_scale(data);
      ++sums.nodes;
    }
  return sums;
}

/// A table that is no ellipsoid, with zeros.
DiskTable uneven_table(const DiskGrid& grid) {
  DiskTable table = tabulate(Ellipsoid(slope_frame({0.5, 0.3, 0, 0.2, 0})), grid);
  for (Eigen::Index k = 0; k < table.density.size(); ++k)
    table.density.data()[k] *=
        std::max(0., 1.2 * random_uniform(1, 0, static_cast<std::uint64_t>(k))[0] - 0.2);
  return table;
}

TEST(NormalEquations, AreTheLiteralSums) {
  constexpr double kDifferences = 1e-7;
  for (const DiskGrid& grid : {DiskGrid{31, 0.6}, DiskGrid{67, 0.9}, DiskGrid{131, 1}}) {
    const DiskTable table = uneven_table(grid);
    TableEquations equations(table);
    for (const FitModel model : {FitModel::EllipsoidNdf, FitModel::BeckmannNdf})
      for (const Weighting weighting : {Weighting::SolidAngle, Weighting::Log}) {
        if (model == FitModel::BeckmannNdf && weighting == Weighting::Log && grid.extent > 0.65)
          continue;  // near the horizon the literal density is 0
        const NormalEquations sums = equations(kFrame, model, weighting),
                              expected = literal(table, model, weighting);
        EXPECT_LE((sums.gram - expected.gram).norm(), kDifferences * expected.gram.norm());
        EXPECT_LE((sums.gradient - expected.gradient).norm(),
                  kDifferences * std::sqrt(expected.gram.norm() * expected.cost));
        EXPECT_NEAR(sums.cost, expected.cost, 1e-11 * expected.cost);
        EXPECT_NEAR(sums.data, expected.data, 1e-11 * expected.data);
        EXPECT_EQ(sums.nodes, expected.nodes);
      }
  }
}

TEST(NormalEquations, ScatteredNodesAreThoseOfTheTable) {
  const DiskTable table = uneven_table({31, 0.8});
  std::vector<double> x, y, d;
  for (Eigen::Index j = 0; j < 31; ++j)
    for (Eigen::Index i = 0; i < 31; ++i) {
      x.push_back(table.grid.coordinate(i));
      y.push_back(table.grid.coordinate(j));
      d.push_back(table.density(j, i));
    }
  TableEquations equations(table);
  const NormalEquations all = equations(kFrame, FitModel::EllipsoidNdf, Weighting::SolidAngle),
                        scattered =
                            normal_equations({x.data(), y.data(), d.data(), 31 * 31, table.grid.least_mz()},
                                             kFrame, FitModel::EllipsoidNdf, Weighting::SolidAngle);
  EXPECT_NEAR(all.cost, scattered.cost, 1e-12 * all.cost);
  EXPECT_LE((all.gram - scattered.gram).norm(), 1e-12 * all.gram.norm());
}

TEST(NormalEquations, DoNotDependOnTheThreads) {
  const DiskTable table = uneven_table({401, 1});
  TableEquations equations(table);
  const NormalEquations many = equations(kFrame, FitModel::BeckmannNdf, Weighting::SolidAngle);
  set_thread_count(1);
  const NormalEquations one = equations(kFrame, FitModel::BeckmannNdf, Weighting::SolidAngle);
  set_thread_count(0);
  EXPECT_EQ(many.cost, one.cost);
  EXPECT_EQ(many.gram, one.gram);
}

// Σ w²r²/(1 − h)·g·gᵀ as its definition says.
TEST(NormalEquations, ResidualGramIsTheLiteralSum) {
  const DiskTable table = uneven_table({31, 0.8});
  TableEquations equations(table);
  const Matrix5 inverse = equations(kFrame, FitModel::EllipsoidNdf, Weighting::SolidAngle).gram.inverse();
  Matrix5 expected = Matrix5::Zero();
  const Ellipsoid model(kFrame);
  for (Eigen::Index j = 0; j < 31; ++j)
    for (Eigen::Index i = 0; i < 31; ++i) {
      const double z2 = table.grid.mz2(j, i);
      if (!(z2 > 0)) continue;
      const Vec3 m(table.grid.coordinate(i), table.grid.coordinate(j), std::sqrt(z2));
      Vector5 g;
      for (int k = 0; k < 5; ++k)
        g[k] = (Ellipsoid(moved(kFrame, 1e-5 * Vector5::Unit(k))).D(m) -
                Ellipsoid(moved(kFrame, -1e-5 * Vector5::Unit(k))).D(m)) /
               2e-5;
      const double w = literal_weight(table.grid, m.z());
      const double r = table.density(j, i) - model.D(m);
      expected += w * w * r * r / (1 - w * g.dot(inverse * g)) * g * g.transpose();
    }
  const Matrix5 sums =
      equations.residual_gram(kFrame, FitModel::EllipsoidNdf, Weighting::SolidAngle, inverse);
  EXPECT_LE((sums - expected).norm(), 1e-7 * expected.norm());
}

TEST(NormalEquations, MovingBackReturns) {
  const Vector5 step = (Vector5() << 0.1, -0.2, 0.3, 0.4, -0.1).finished();
  const SlopeFrame there = moved(kFrame, step);
  EXPECT_GT(there.l11, 0);
  EXPECT_NEAR(kFrame.whiten(there.centre).x(), 0.1, 1e-12);
  EXPECT_NEAR(kFrame.whiten(there.centre).y(), -0.2, 1e-12);
}

}  // namespace
}  // namespace micro
