#pragma once

#include <array>
#include <functional>
#include <optional>

#include "distribution/slope_coordinates.h"
#include "pipelines/ndf_of_scans.h"
#include "pipelines/texel_layout.h"
#include "pipelines/texels_of_surface.h"

namespace micro {

/// What texels are made of.
struct TexelRequest {
  Preparation prepare = {{}, Level::Mean, {}, Preparation::Holes::Keep};
  /// A plane common to all scans is the sample's tilt on the stage, and goes; a plane of each scan's own
  /// would take the texels' own tilt with it.
  enum class Tilt { RemoveCommon, Keep } tilt = Tilt::RemoveCommon;
  double sigma = 1;           ///< µm
  std::optional<Vec2> block;  ///< width and height of a texel, µm; absent: each scan is one
  double enough = 50;         ///< independent normals below which a texel's fit is shrunk
  int ndf_size = 33;          ///< see TexelCut::ndf_size
};

/// How a texel of the grid came about.
enum class TexelState : std::int32_t {
  Gap = -1,  ///< no scan there, or no normal
  Fitted,    ///< as fitted
  Shrunk,    ///< drawn towards the set's mean: too few independent normals
  Few,       ///< as fitted from too few, since the set does not say what is usual
};

/// A grid of texels [rows, cols]: those that scans cover. Other places are gaps and take no memory.
struct Texels {
  Eigen::Index rows = 0, cols = 0;
  double width = 0, height = 0;  ///< µm, of a texel
  double sigma = 0;              ///< µm
  int ndf_size = 0;
  Vec2 tilt = {0, 0};  ///< common slope that was removed
  std::vector<Texel> texels;
  std::vector<TexelState> states;    ///< of each texel
  std::vector<std::int32_t> scan;    ///< which one each lies in
  std::vector<std::int64_t> places;  ///< row·cols + col of each, ascending
  std::vector<ScanRecord> scans;
  Plan plan;
  double seconds = 0;

  /// Texels that have a lobe.
  std::int64_t count() const;
};

/// Reads scans, puts them where the layout of the listing says, and fits each texel [Dong15 §9]. A scan that
/// fails, or has no place, is recorded and leaves a gap. The same for any number of threads. Throws
/// MixedPitches if pitches differ by more than 1 %.
Texels texels_of_scans(const ScanListing& listing, const TexelLayout& layout, const TexelRequest& request,
                       const std::function<void(const Progress&)>& report);

/// Draws texels of fewer than `enough` independent normals towards the mean of the others, in slope
/// coordinates: µ + B(B + E)⁻¹(p − µ), B the covariance between texels less what errors add to it, E the
/// texel's own error: so many of its own widths, which is taken from all texels whose lobes were resolved,
/// and the number of its normals. Says what it did in the plan.
void shrink_few(Texels& texels, double enough);

/// The scale of a lobe (xx, xy, yy) as float32, rounded outwards: positive definite however thin and turned
/// the lobe is, where the nearest numbers are not from widths of 1:4000 on.
std::array<float, 3> stored_scale(const SlopeFrame& frame);

/// Writes /texels (docs/design.md has its layout).
void write_texels(Hdf5Writer& file, const Texels& texels);

}  // namespace micro
