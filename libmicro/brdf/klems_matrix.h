#pragma once

#include <array>
#include <vector>

#include "brdf/any_brdf.h"

namespace micro {

/// The full basis of [Klems94]: 145 patches of the hemisphere in nine rings. Patch numbers run by rings from
/// the normal, and within a ring by azimuth, the first centred at 0.
struct KlemsRing {
  double centre, low, high;  ///< θ, degrees
  int patches;
};
inline constexpr std::array<KlemsRing, 9> kKlemsRings = {{{0, 0, 5, 1},
                                                          {10, 5, 15, 8},
                                                          {20, 15, 25, 16},
                                                          {30, 25, 35, 20},
                                                          {40, 35, 45, 24},
                                                          {50, 45, 55, 24},
                                                          {60, 55, 65, 24},
                                                          {70, 65, 75, 16},
                                                          {82.5, 75, 90, 12}}};
inline constexpr std::size_t kKlemsPatches = 145;

/// The number of the patch that holds a direction above the horizon.
std::size_t klems_patch(const Vec3& w);

/// ∫ cosθ dω over a patch, sr.
double klems_projected_solid_angle(std::size_t patch);

/// The patch that holds (−x, −y, z) of another's directions.
std::size_t klems_opposite(std::size_t patch);

/// f averaged over patches of light and viewer, [wo, wi] 1/sr, by drawing wi over its patch and wo from the
/// model, which has to be reciprocal; `f` weighs the model's wavelengths to one number.
struct KlemsMatrix {
  std::vector<double> f;  ///< reciprocal itself
  double standard_error;  ///< the largest of a patch's directional albedo
};

/// Light is numbered by where it goes: patch k of `wi` is that of (−x, −y, z), so that a mirror's matrix is
/// diagonal [WINDOW, Radiance]. lambda_um and the weights of their f have the same size; draws of a patch are
/// 16 or more.
KlemsMatrix klems_matrix(const AnyBrdf& model, const std::vector<double>& lambda_um,
                         const std::vector<double>& weights, std::uint64_t draws);

}  // namespace micro
