#pragma once

#include <cstdint>

#include "height/synthetic_grid.h"

namespace micro {

/// Brushed metal: a Poisson number of scratches at independent, uniform places, each of profile
/// −d (1 − (u/a)²)² (1 − (v/b)²)² for |u| < a along it and |v| < b across it, 0 elsewhere; depths add.
/// a = length/2 and b = width/2, each times a factor uniform in (½, 3/2); d exponential; the direction
/// uniform within ±spread of the orientation.
struct Brushing {
  double rms = 0.1;        ///< µm, sets the mean depth through Campbell's theorem
  double length = 50;      ///< µm, mean length, end to end
  double width = 1.5;      ///< µm, mean width, edge to edge
  double coverage = 10;    ///< mean number of scratches over a point, counted by length × width
  double spread = 0.02;    ///< radians
  double orientation = 0;  ///< radians from +x towards +y
};

/// Stationary up to the border: scratches that reach in from outside are there. Periodic: scratches go on at
/// the opposite border. Memory: another 56 bytes per scratch.
/// Throws InputError unless the numbers are finite, lengths and coverage positive, rms ≥ 0,
/// 0 ≤ spread ≤ π/2, and there are at most 1e7 scratches.
HeightField brushed_surface(const SyntheticGrid& grid, const Brushing& brushing, std::uint64_t seed,
                            Border border = Border::Open);

/// Mean depth d of a scratch, µm, for the rms asked: Campbell's theorem, rms² = ν·2d²·⟨∬profile²⟩ with ν
/// scratches per µm².
double mean_depth(const Brushing& brushing);

}  // namespace micro
