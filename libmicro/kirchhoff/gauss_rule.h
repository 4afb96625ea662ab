#pragma once

#include <cstdint>
#include <map>
#include <vector>

namespace micro {

/// So many points of a Gauss–Legendre rule integrate e^{iφt}, 0 ≤ t ≤ 1, |φ| ≤ `phase`, to `tolerance` ≤
/// 1e-5.
int gauss_points(double phase, double tolerance);

/// How an interval is cut: panels of equal length, each with a Gauss–Legendre rule of this order. A rule's
/// making takes the cube of its order, and beyond 200 rad longer panels hardly save points.
struct GaussCut {
  std::int64_t panels;
  int order;
  std::int64_t points() const { return panels * order; }
};

/// For e^{iφt} with |φ| ≤ `phase`; orders go up by an eighth, so that they are few.
GaussCut gauss_cut(double phase, double tolerance);

struct GaussNode {
  double t, weight;
};

/// Rules on [0, 1], made when they are first asked for.
class GaussRules {
 public:
  /// The composite rule's nodes, into the memory of `nodes`.
  void fill(const GaussCut& cut, std::vector<GaussNode>& nodes);

 private:
  std::map<int, std::vector<GaussNode>> rules_;
};

}  // namespace micro
