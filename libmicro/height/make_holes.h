#pragma once

#include <cstdint>

#include "height/height_field.h"

namespace micro {

/// Holes as a profilometer leaves them where too little light returns.
struct Holes {
  double fraction = 0;  ///< expected fraction of points that go missing, 0 … 1
  double radius =
      0;  ///< µm; 0: independent points, otherwise discs of that radius at random places (overlapping)
};

/// Takes points away at random; the same for any number of threads. Discs are a Boolean model of
/// −ln(1 − fraction)/(π radius²) centres per µm². Throws InputError if the fraction is no fraction, or the
/// radius is below half the pitch and not 0.
HeightField make_holes(const HeightField& surface, const Holes& holes, std::uint64_t seed);

}  // namespace micro
