#pragma once

#include <vector>

#include "distribution/slope_space.h"

namespace micro {

/// Points of slope space that stand for a distribution: mass, whitened slope v, and the covariance that each
/// one's surroundings have, [0] = vv_11, [1] = vv_12, [2] = vv_22.
struct SlopePoints {
  std::vector<float> mass, v1, v2, spread11, spread12, spread22;
};

/// ∫ mass·(u_z − slope·u_xy)₊ for every direction u, of points given in a frame's whitened slopes. Along each
/// of 128 directions e stands the flank ∫ mass·(c − e·v)₊ at 129 cotangents c ≤ 0 with its derivative, the
/// mass below c; between them it is cubic. Of c > 0 it is the other flank's: (c − s)₊ = c − s + (s − c)₊.
class MaskingTable {
 public:
  MaskingTable(const SlopeFrame& frame, const SlopePoints& points);

  double visible_area(const Vec3& u) const;

 private:
  struct Node {
    double value, step;  ///< the flank, and its derivative times the distance between nodes
  };
  SlopeFrame frame_;
  double mass_ = 0;
  Vec2 mean_ = {0, 0};       // ∫ mass·v
  std::vector<Node> flank_;  // [azimuth, elevation]
};

}  // namespace micro
