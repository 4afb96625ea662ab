#pragma once

#include <functional>
#include <memory>

#include "core/estimate.h"
#include "distribution/tabulated.h"

namespace micro {

/// ∫ D(m) g(m) m_z dω of a tabulated D with any g that varies slowly from node to node, however D does.
///
/// The disk is cut into squares of cells. Of each, mass and centre of mass are known exactly, D being
/// bilinear in every cell, so that g at the centre is all it takes where g is straight. A square's error is
/// how much its quarters differ from the whole; where g is 0 at some of its centres and corners and not at
/// others, as albedos are at the viewer's horizon, all that it may hold. The square with the largest is cut
/// in four until all together are below the tolerance.
///
/// Copies share their sums, which are made when first asked for, from any thread.
class TableIntegral {
 public:
  explicit TableIntegral(Tabulated table);

  /// To the absolute `tolerance`. The error says what was reached: above the tolerance if four million
  /// evaluations of g were not enough, which cost.evaluations counts.
  Estimate<double> operator()(const std::function<double(const Vec3& m)>& g, double tolerance) const;

  struct State;

 private:
  std::shared_ptr<State> state_;
};

}  // namespace micro
