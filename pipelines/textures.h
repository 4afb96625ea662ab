#pragma once

#include <filesystem>
#include <optional>

#include "io/exr_texture.h"
#include "pipelines/texels.h"
#include "texture/minify.h"
#include "texture/model.h"
#include "texture/synthesis.h"

namespace micro {

/// The texels' slope coordinates.
Exemplar exemplar_of(const Texels& texels);

/// What texture is made.
struct TextureRequest {
  Recipe recipe = Recipe::Joint;
  Taper taper = Taper::Hann;
  enum class Marginals { Gaussian, Exemplar } marginals = Marginals::Exemplar;
  TextureSize size;
  std::uint64_t seed = 1;
  ExrPixel pixel = ExrPixel::Float;
  enum class Levels { Finest, All } levels = Levels::All;
};

/// How a level misfits the lobes of the finest that it covers, as a mean over some of its texels: the
/// refitted lobe, and beside it what averaged parameters would give. Of many lobes 4096 or fewer stand for
/// all.
struct LevelMisfit {
  int level = 0;
  Eigen::Index rows = 0, cols = 0;
  Misfit refitted, averaged;  ///< means
};

/// What became of a texture.
struct TextureSummary {
  TextureRequest request;
  double texel_width = 0, texel_height = 0;  ///< µm
  bool in_parts = false;
  std::vector<LevelMisfit> misfits;  ///< from level 1 on
  std::optional<SlopeFrame> coarsest;
  Picture picture;  ///< α_x, α_y and slopes beside the exemplar's
  double seconds = 0;
  Plan plan;
};

/// Synthesises a texture like the texels [Dong15 §9] and writes it to /texture of `file` and as OpenEXR. Up
/// to 4096² texels at once, larger ones by parts of 2048², whose memory does not grow with the texture but
/// for its levels from the third on. `command` goes into the picture's metadata.
TextureSummary write_texture(const Texels& texels, const TextureRequest& request, Hdf5Writer& file,
                             const std::filesystem::path& exr, const std::string& command);

}  // namespace micro
