#include "distribution/slope_coordinates.h"

#include <algorithm>

namespace micro {

SlopeCoordinates slope_coordinates(const SlopeFrame& frame) {
  // Singular values of L, the small one by the determinant: no digit is lost on needles.
  const double xx = frame.l11 * frame.l11, xy = frame.l11 * frame.l21,
               yy = frame.l21 * frame.l21 + frame.l22 * frame.l22;
  const double mean = (xx + yy) / 2, half = (xx - yy) / 2, away = std::hypot(half, xy);
  const double log_determinant = std::log(frame.l11) + std::log(frame.l22);
  const double log_wide = std::log(mean + away) / 2, log_narrow = log_determinant - log_wide;
  const double middle = log_determinant / 2, spread = (log_wide - log_narrow) / 2;
  const double c = away > 0 ? half / away : 1, s = away > 0 ? xy / away : 0;
  return {frame.centre.x(), frame.centre.y(), middle + spread * c, spread * s, middle - spread * c};
}

SlopeFrame frame_of(const SlopeCoordinates& p) {
  const double middle = (p[2] + p[4]) / 2, half = (p[2] - p[4]) / 2, spread = std::hypot(half, p[3]);
  const double c = spread > 0 ? half / spread : 1, s = spread > 0 ? p[3] / spread : 0;
  const double wide = std::exp(std::clamp(middle + spread, -kMostLogWidth, kMostLogWidth)),
               narrow = std::exp(std::clamp(middle - spread, -kMostLogWidth, kMostLogWidth));
  // Σ = wide²·e·eᵀ + narrow²·e'·e'ᵀ, e at half the angle of (c, s).
  const double xx = (wide * wide * (1 + c) + narrow * narrow * (1 - c)) / 2,
               xy = (wide * wide - narrow * narrow) * s / 2;
  SlopeFrame frame;
  frame.centre = {p[0], p[1]};
  frame.l11 = std::sqrt(std::max(xx, narrow * narrow));
  frame.l21 = xy / frame.l11;
  frame.l22 = wide * (narrow / frame.l11);
  return frame;
}

}  // namespace micro
