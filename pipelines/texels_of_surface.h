#pragma once

#include <vector>

#include "fit/fit.h"
#include "height/height_field.h"

namespace micro {

/// One texel: its fit, and what it stands on.
struct Texel {
  Fit fit;                 ///< status Empty where there is no normal
  double independent = 0;  ///< about how many of its normals are independent: their area/(4πσ²)
  std::int64_t normals = 0;
  Vec2 mean_slope = {0, 0};   ///< of its normals
  std::vector<float> slopes;  ///< its own distribution, see TexelCut::ndf_size
};

/// How a surface is cut.
struct TexelCut {
  Eigen::Index rows = 0, cols = 0;  ///< points of a texel; 0: the whole surface is one
  double sigma = 1;                 ///< µm, of the filtered normals
  /// Nodes along a side of each texel's own table, 0 for none: the density of v = L⁻¹(slope − t) at nodes
  /// that span [−kNdfReach, kNdfReach]², with t and L the texel's own, so that every lobe is resolved.
  int ndf_size = 0;
};
constexpr double kNdfReach = 4;

/// Texels of a surface, [rows, cols] row-major; what is left over at the far borders belongs to none.
struct SurfaceTexels {
  Eigen::Index rows = 0, cols = 0;
  std::vector<Texel> texels;
};

/// Filtered normals of the surface [Dong15 §5.1], windows reaching over the texels' borders, and the
/// ellipsoid of each texel [Dong15 §9]. Large surfaces go band by band: memory for slopes is that of one
/// band. Throws InputError if σ is not resolved or longer than the surface, or no texel fits in.
SurfaceTexels texels_of_surface(const HeightField& surface, const TexelCut& cut);

}  // namespace micro
