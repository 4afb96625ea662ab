#pragma once

#include <vector>

#include "distribution/signature.h"

namespace micro {

/// A signature's response as a function of c = 1 − cos(angle), tabulated evenly in √c: one square root and a
/// linear interpolation for each pair of directions instead of an arc cosine.
class SignatureKernel {
 public:
  /// `signature` is valid.
  explicit SignatureKernel(const Signature& signature);

  /// Beyond this angle (radians), or this c, there is no response.
  double reach_angle() const { return reach_angle_; }
  double reach() const { return reach_; }

  double operator()(double c) const;

 private:
  double reach_angle_, reach_, scale_;
  std::vector<double> table_;
};

/// The response at an angle (radians) up to the last sample's.
double response_at(const Signature& signature, double angle);

}  // namespace micro
