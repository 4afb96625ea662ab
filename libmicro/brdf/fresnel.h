#pragma once

#include <complex>
#include <variant>
#include <vector>

namespace micro {

/// Reflectance of unpolarised light at a smooth interface, from vacuum (or a medium that η and κ are relative
/// to) onto the complex index η + iκ, by Fresnel's equations in complex arithmetic. `cosine` of the angle of
/// incidence, 0 to 1. Exact to rounding for every η > 0, κ ≥ 0, total reflection (η < 1, κ = 0) included.
double fresnel(double cosine, std::complex<double> index);

/// The same for dielectrics: n > 0 is the index beyond the interface over that before it.
double fresnel_dielectric(double cosine, double n);

/// Schlick's approximation R0 + (1 − R0)(1 − cosine)⁵ [Schlick94].
double fresnel_schlick(double cosine, double r0);

/// The κ that gives a metal of index η the reflectance r0 at normal incidence [Sun02 Eq. 5.11]:
/// κ² = (r0·(η + 1)² − (η − 1)²)/(1 − r0). Throws InputError where there is none: r0 must lie between that
/// of κ = 0 and 1.
double extinction_from_r0(double eta, double r0);

/// Optical constants η + iκ at wavelengths in vacuum, µm, ascending.
struct OpticalConstants {
  std::vector<double> lambda_um, eta, kappa;

  /// Linear between the wavelengths. Throws InputError beyond them.
  std::complex<double> at(double lambda_um) const;
};

/// Reflects all of the light.
struct PerfectMirror {};
/// R0 + (1 − R0)(1 − cosine)⁵ at every wavelength.
struct Schlick {
  double r0;
};

/// A smooth interface's reflectance as a value: of a material with optical constants, of one index η + iκ at
/// all wavelengths (κ = 0: a dielectric), or one of the idealisations above.
class Fresnel {
 public:
  using Kind = std::variant<PerfectMirror, Schlick, std::complex<double>, OpticalConstants>;

  /// Throws InputError unless η > 0, κ ≥ 0 and finite, 0 ≤ R0 ≤ 1, and tables are of one length, not empty
  /// and ascending in wavelength.
  explicit Fresnel(Kind kind = PerfectMirror{});

  /// `cosine` of the angle of incidence on the facet; what is outside [0, 1] is taken as its nearest end.
  double operator()(double cosine, double lambda_um) const;
  const Kind& kind() const { return kind_; }

 private:
  Kind kind_;
};

}  // namespace micro
