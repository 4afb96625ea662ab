#pragma once

#include <array>

#include "distribution/slope_space.h"

namespace micro {

/// Five unconstrained numbers for an elliptical lobe: (t_x, t_y) and the symmetric matrix ½ ln Σ, by its
/// entries (xx, xy, yy). Any five finite numbers are a lobe, no angle wraps, and turning the axes turns the
/// numbers as any symmetric matrix: the place to average, to correlate and to synthesise (log-Euclidean
/// [Arsigny06]).
using SlopeCoordinates = std::array<double, 5>;

inline constexpr std::array<const char*, 5> kSlopeCoordinateNames = {"slope.x", "slope.y", "logscale.xx",
                                                                     "logscale.xy", "logscale.yy"};

SlopeCoordinates slope_coordinates(const SlopeFrame& frame);

/// The inverse. Logarithms of widths beyond ±kMostLogWidth are cut there, so that every frame is finite and
/// of positive width in float32 too.
SlopeFrame frame_of(const SlopeCoordinates& coordinates);
constexpr double kMostLogWidth = 20;

}  // namespace micro
