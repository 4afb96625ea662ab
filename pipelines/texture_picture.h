#pragma once

#include "io/png.h"
#include "texture/synthesis.h"

namespace micro {

/// An exemplar beside the first texels of a texture made from it: a pair of pictures for each slope
/// coordinate, both on the scale mean ± 2.5 standard deviations of the exemplar, grey from dark to light;
/// gaps are yellow. Strips of a few texels are drawn larger.
Picture texture_picture(const Exemplar& exemplar, const TextureField& field);

}  // namespace micro
