#pragma once

#include <cstdint>
#include <vector>

#include "brdf/any_brdf.h"

namespace micro {

/// How finely a BRDF is kept in the tables of [Dupuy18]. Directions of light: θ_i evenly from 0 to 88.2°, φ_i
/// evenly from −π to π, or one where the model is isotropic. Normals: √(2θ/π) by (φ+π)/2π.
struct MeasuredGrid {
  std::size_t theta_i = 16, phi_i = 17;
  std::size_t ndf_theta = 512, ndf_phi = 129;
  std::size_t sigma_theta = 33, sigma_phi = 33;
  std::size_t vndf_theta = 128, vndf_phi = 65;
  std::size_t samples = 64;  ///< along each side of the unit square that visible normals are drawn from

  /// The grid of a model that is the same in all azimuths: one φ_i, finer in the rest.
  static MeasuredGrid isotropic();
};

/// A BRDF in the parameters of [Dupuy18]: wi by its angles, wo by the uniform numbers that would draw its
/// half vector m from the visible normals. f·cosθ_o = spectra·ndf(m)/(4·sigma(wi)).
struct MeasuredTables {
  MeasuredGrid grid;
  std::vector<float> phi_i = {}, theta_i = {};  ///< radians
  std::vector<float> wavelengths = {};          ///< nm
  std::vector<float> ndf =
      {};  ///< [φ_m, θ_m] retroreflection 4·f(m, m)·cos²θ_m and a floor, of mass 1 in cosθ
  std::vector<float> sigma = {};  ///< [φ_i, θ_i] ∫ ndf·max(0, m·wi) dm
  std::vector<float> vndf = {};  ///< [φ_i, θ_i, φ_m, θ_m] density of visible normals on their unit square
  std::vector<float> luminance = {};  ///< [φ_i, θ_i, y, x] mean of spectra over wavelengths, and a floor
  std::vector<float> spectra = {};    ///< [φ_i, θ_i, λ, y, x]
};

/// Largest relative difference between f and f of the same directions turned about n, over a few hundred
/// pairs that the model draws itself.
double anisotropy(const AnyBrdf& model, double lambda_um);

/// Tables of any model. Throws InputError where the model is infinite or NaN, or dark in every mirror of its
/// normals.
MeasuredTables measured_tables(const AnyBrdf& model, const std::vector<double>& lambda_um,
                               const MeasuredGrid& grid);

}  // namespace micro
