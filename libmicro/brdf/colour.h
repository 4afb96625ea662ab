#pragma once

#include <vector>

#include "core/grid.h"

namespace micro {

/// Colours of reflectances known at some wavelengths, under daylight D65 and for the CIE 1931 2-degree
/// observer. Between the wavelengths a reflectance is taken as linear, beyond them as constant, from 0.36 to
/// 0.83 µm: integrals of hat functions against the CIE's tables at 5 nm. Perfectly white is Y = 1.
class ColourWeights {
 public:
  /// Wavelengths in µm, ascending; one gives its grey. Throws InputError.
  explicit ColourWeights(std::vector<double> lambda_um);

  const std::vector<double>& lambda_um() const { return lambda_um_; }
  /// X, Y, Z of a reflectance at the wavelengths.
  Vec3 xyz(const std::vector<double>& reflectance) const;

 private:
  std::vector<double> lambda_um_;
  std::vector<Vec3> weights_;
};

/// n wavelengths from 0.38 to 0.73 µm, at the middles of equal parts.
std::vector<double> visible_wavelengths(int n);

/// X, Y, Z of the white, D65, Y = 1: about (0.9505, 1, 1.0888).
Vec3 white_point();

/// Linear sRGB [IEC 61966-2-1, primaries of ITU-R BT.709] from XYZ: the white D65 becomes (1, 1, 1) exactly.
/// Colours outside the gamut have a negative component; nothing is clipped.
Vec3 linear_srgb(const Vec3& xyz);
Vec3 xyz_of_linear_srgb(const Vec3& rgb);

/// sRGB's transfer function for one component, and its inverse; what is outside [0, 1] is clipped.
double srgb_encoded(double linear);
double srgb_decoded(double encoded);

/// A smooth reflectance ½ + x/(2√(1 + x²)), x = c0·t² + c1·t + c2, t from 0 to 1 over 0.36 to 0.83 µm
/// [Jakob, Hanika 2019, "A low-dimensional function space for efficient spectral upsampling"]: in (0, 1) at
/// all wavelengths.
struct SmoothReflectance {
  double c0, c1, c2;
  double error;  ///< of the colour, the largest difference in linear sRGB

  double operator()(double lambda_um) const;
};

/// The one of a colour in linear sRGB, each component in [0, 1], by Levenberg–Marquardt from grey. The
/// reflectance never reaches 0 or 1: pure black, white and the corners of the gamut come out within a few
/// 1e-3, which `error` says. Throws InputError outside.
SmoothReflectance smooth_reflectance(const Vec3& linear_rgb);

}  // namespace micro
