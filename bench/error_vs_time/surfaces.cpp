#include "error_vs_time/surfaces.h"

#include "height/brushed_surface.h"
#include "height/gaussian_surface.h"
#include "height/make_holes.h"
#include "pipelines/prepare_scan.h"

namespace micro::bench {

std::vector<NamedSurface> made_surfaces() {
  const SyntheticGrid grid;
  const auto gaussian = [&](double rms, double tau) {
    return gaussian_surface(grid, {.rms = rms, .tau_x = tau, .tau_y = tau}, 1);
  };
  const HeightField rough = gaussian(0.3, 3);
  return {{"smooth", gaussian(0.03, 5)},
          {"rough", rough},
          {"steep", gaussian(1, 1.5)},
          {"holed", make_holes(rough, {.fraction = 0.04}, 1)},
          {"brushed", brushed_surface(grid, {}, 1)}};
}

std::vector<NamedSurface> real_surfaces(std::span<const std::filesystem::path> scans) {
  std::vector<NamedSurface> surfaces;
  for (const std::filesystem::path& scan : scans)
    surfaces.push_back({scan.stem().string(), prepare_scan(scan, {}).surface});
  return surfaces;
}

}  // namespace micro::bench
