#pragma once

#include "height/height_field.h"

namespace micro {

/// Heights as they are, mean included: µm over valid points; NaN if there are none.
struct HeightRange {
  double min, max, mean;
  double rms;  ///< about the mean
};
HeightRange height_range(const HeightField& surface);

/// ISO 25178-2 height parameters about the mean of the valid points (each weighs the same); µm, the last two
/// without unit. NaN where undefined: no valid point, or, for Ssk and Sku, a flat surface.
struct HeightParameters {
  double Sq;   ///< root mean square height
  double Sa;   ///< arithmetic mean height
  double Sz;   ///< maximum height, highest peak to deepest pit
  double Ssk;  ///< skewness ⟨z³⟩/Sq³
  double Sku;  ///< kurtosis ⟨z⁴⟩/Sq⁴
};
HeightParameters height_parameters(const HeightField& surface);

/// Root mean square height alone, µm.
double Sq(const HeightField& surface);

/// ISO 25178-2 root mean square gradient √((1/A)∬(z_x² + z_y²) dx dy), integrated exactly over the project's
/// triangulation: (1/A_perp) Σ_T A_T |∇z_T|². NaN if no triangle is there. (Inside a complete grid that is
/// the mean of squared forward differences.)
double Sdq(const HeightField& surface);

/// ISO 25178-2 developed interfacial area ratio (1/A)∬(√(1 + z_x² + z_y²) − 1) dx dy, integrated exactly over
/// the project's triangulation; a ratio, not per cent. NaN if no triangle is there.
double Sdr(const HeightField& surface);

/// Which way a texture runs, from the covariance of the slopes of complete cells (opposite sides averaged:
/// the triangles' own slopes would lean towards the diagonal they share): its eigenvector of least variance
/// points along the lay, its eigenvalues λ₁ ≥ λ₂ give the strength.
struct TextureDirection {
  double direction;  ///< of the lay, radians from +x towards +y, in (−π/2, π/2]; NaN if isotropic
  double anisotropy;  ///< (λ₁ − λ₂)/(λ₁ + λ₂): 0 isotropic, 1 ideal grooves; NaN if flat or without cells
};

/// Below this anisotropy a direction would be chance: a scan of a few hundred correlation areas scatters by
/// nearly as much.
inline constexpr double kLeastAnisotropy = 0.1;

TextureDirection texture_direction(const HeightField& surface);

}  // namespace micro
