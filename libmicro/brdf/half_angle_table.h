#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "brdf/brdf.h"
#include "core/parallel.h"

namespace micro {

/// The grid of MERL's tables over the angles of the half vector h and of wi about it [Rusinkiewicz98]: bins
/// of θ_h = (i/n)²·π/2 (fine near the mirror direction), θ_d = j/n·π/2, φ_d = k/n·π; θ_d is here the half of
/// the angle between wi and wo. 90 × 90 × 180 of them are MERL's 1.46 million.
struct HalfAngleGrid {
  std::int64_t theta_h = 90, theta_d = 90, phi_d = 180;
  double phi_h = 0;  ///< radians: azimuth of h, for models that are not isotropic

  std::int64_t size() const { return theta_h * theta_d * phi_d; }
  /// Middle of a bin, radians; θ_h's in its square root.
  double theta_h_at(std::int64_t i) const;
  double theta_d_at(std::int64_t j) const;
  double phi_d_at(std::int64_t k) const;
  /// wi and wo of a bin's middle; either may lie below the horizon.
  std::pair<Vec3, Vec3> directions(std::int64_t i, std::int64_t j, std::int64_t k) const;
};

/// f in 1/sr at every bin's middle, [λ, θ_h, θ_d, φ_d]; 0 where a direction is below the horizon.
template <Brdf Model>
std::vector<float> half_angle_table(const Model& model, const std::vector<double>& lambda_um,
                                    const HalfAngleGrid& grid = {}) {
  const auto size = static_cast<std::size_t>(grid.size());
  std::vector<float> table(size * lambda_um.size());
  parallel_for(grid.theta_h * grid.theta_d, [&](std::int64_t row) {
    for (std::int64_t k = 0; k < grid.phi_d; ++k) {
      const auto [wi, wo] = grid.directions(row / grid.theta_d, row % grid.theta_d, k);
      if (!(wi.z() > 0 && wo.z() > 0)) continue;
      for (std::size_t c = 0; c < lambda_um.size(); ++c)
        table[c * size + static_cast<std::size_t>(row * grid.phi_d + k)] =
            static_cast<float>(model.f(wi, wo, lambda_um[c]));
    }
  });
  return table;
}

}  // namespace micro
