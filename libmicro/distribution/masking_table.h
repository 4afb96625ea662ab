#pragma once

#include <vector>

#include "distribution/slope_space.h"

namespace micro {

/// Points of slope space that stand for a distribution: mass, whitened slope v, and the covariance that each
/// one's surroundings have, [0] = vv_11, [1] = vv_12, [2] = vv_22.
struct SlopePoints {
  std::vector<float> mass, v1, v2, spread11, spread12, spread22;
};

/// ∫ mass·(u_z − slope·u_xy)₊ for every direction u, of points given in a frame's whitened slopes.
class MaskingTable {
 public:
  MaskingTable(const SlopeFrame& frame, const SlopePoints& points);

  double visible_area(const Vec3& u) const;

 private:
  SlopeFrame frame_;
  double mass_ = 0;
  Grid<double> excess_;  // [azimuth, elevation]
};

}  // namespace micro
