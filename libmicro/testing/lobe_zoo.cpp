#include "testing/lobe_zoo.h"

#include <numbers>

namespace micro::testing {

std::vector<ZooLobe> zoo_lobes() {
  constexpr double kRight = std::numbers::pi / 2;
  return {{"mirror", {1e-5, 1e-5, 0, 0, 0}, {129, 1e-4}},
          {"all_directions_alike", {1, 1, 0, 0, 0}, {129, 1}},
          {"upright", {1e3, 1e3, 0, 0, 0}, {129, 1}},
          {"scratch", {1, 1e-5, 0, 0, 0.4}, {129, 1e-4}},
          {"scratch_of_upright_walls", {1e3, 1e-2, 0, 0, 0.4}, {129, 0.1}},
          {"upright_along_one_axis", {1e3, 0.1, 0, 0, -1.2}, {129, 1}},
          {"mirror_at_45_degrees", {1e-5, 1e-5, 0.6, 0.5, 0}, {129, 1}},
          {"scratch_at_30_degrees", {0.3, 1e-3, 0.4, 0.3, 0.7}, {1025, 1}},
          {"leaning_80_degrees", {0.2, 0.1, 1.4, 0, 0.7}, {129, 1}},
          {"leaning_89_degrees", {0.2, 0.1, 0, 1.553, 0.7}, {129, 1}},
          {"a_microradian_from_the_horizon", {0.2, 0.1, kRight - 1e-6, 0, 0.7}, {129, 1}},
          {"on_the_horizon", {0.2, 0.1, kRight, 0, 0.7}, {129, 1}},
          {"needle_on_the_horizon", {0.1, 1e-6, kRight - 1e-3, 0, 0.7}, {129, 1}},
          {"upright_and_tilted", {1e3, 10, 0.5, 0.3, 1}, {129, 1}},
          {"lying_cigar", {100, 1, 0.3, 0.1, 0.2}, {129, 1}},
          {"as_wide_as_high", {1, 0.3, 0.3, 0.1, 0.2}, {129, 1}}};
}

}  // namespace micro::testing
