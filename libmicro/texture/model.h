#pragma once

#include <complex>
#include <string_view>
#include <variant>
#include <vector>

#include "core/fft.h"
#include "texture/correlation_map.h"
#include "texture/exemplar.h"

namespace micro {

/// How the field of slope coordinates is modelled: always Gaussian, with the exemplar's mean and variances.
enum class Recipe {
  Separable,  ///< [Dong15 §9]: each channel alone, amplitude = that along × that across
  Full,       ///< each channel alone, its whole two-dimensional spectrum; needs a block
  Joint,      ///< keeps how channels vary together: a block's spectra with one phase for all channels (all
          ///< cross-correlations [Galerne11]); of strips, separable spectra whose phases go together as far
          ///< as correlations at lag 0 want it
};
std::string_view name_of(Recipe recipe);

/// Powers along one axis, for each channel: the strips they are the mean of.
struct AxisSpectrum {
  std::array<std::vector<Eigen::ArrayXd>, kChannels> strips;  ///< deviations; none: white
  std::array<bool, kChannels> constant{};                     ///< whether nothing varies along this axis
  std::array<CorrelationMap, kChannels> before;               ///< what is done to their correlations

  /// √ of the mean power of the strips at the frequencies 0 … n−1 over n. Below the lowest frequency that a
  /// strip resolves, 1/length, the power is at least that there: a strip alone cannot tell its mean from slow
  /// variation. Several tell it by their means.
  std::vector<float> amplitudes(std::size_t channel, Eigen::Index n) const;
};

/// A Gaussian model of five channels.
struct TextureModel {
  Recipe recipe = Recipe::Separable;
  SlopeCoordinates mean{};
  std::array<double, kChannels> variance{};
  Covariance correlation = Covariance::Identity();  ///< at lag 0, where the recipe keeps it
  struct Axes {
    AxisSpectrum x, y;
  };
  std::variant<Axes, std::array<Grid<double>, kChannels>> spectrum;  ///< or a block's deviations

  bool common_phase() const { return recipe == Recipe::Joint && std::holds_alternative<Blocks>(spectrum); }
  bool mixed_phases() const { return recipe == Recipe::Joint && std::holds_alternative<Axes>(spectrum); }
  using Blocks = std::array<Grid<double>, kChannels>;
};

/// The model of an exemplar. A row (column) is a strip if it holds at least two texels and half as many as
/// the fullest one; where an axis has no strip, texels along it are taken as independent. Throws InputError
/// if the exemplar is empty, or the recipe is Full and it is no block.
TextureModel model_of(const Exemplar& exemplar, Recipe recipe, Taper taper = Taper::Hann);

/// The same model with the correlations that its numbers need before a map of each number's own, so that
/// those of mapped numbers are the model's: along axes (of separable ones the map spoils a product off the
/// axes), at every lag of a block's number with itself, and at lag 0 between numbers that keep theirs. Where
/// no normal numbers have such correlations, powers below 0 are taken as 0. Rows and columns of maps are
/// channels.
using CorrelationMaps = std::array<std::array<CorrelationMap, kChannels>, kChannels>;
TextureModel with_correlations_before(TextureModel model, const CorrelationMaps& before);

/// Amplitudes of a channel on the half spectrum of a texture of rows × cols texels: their squares over the
/// whole spectrum sum to the channel's variance, and (0, 0) is 0. Separable ones are a product; a block's
/// are complex with `phase`.
struct AxisAmplitudes {
  std::vector<float> x, y;  ///< [cols/2 + 1], [rows]
};
AxisAmplitudes axis_amplitudes(const TextureModel& model, std::size_t channel, Eigen::Index rows,
                               Eigen::Index cols);
/// The same for white noise on rows × cols texels, of which each reaches no further than `reach`: the spectra
/// of one kernel whatever the size (at least 2·reach). It is that of 2·reach texels, drawn to zero over
/// its outer half, so that its spectrum is smoothed by less than 1/reach. (0, 0) stays; an axis along which
/// nothing varies is white (there the noise has to be constant).
AxisAmplitudes kernel_amplitudes(const TextureModel& model, std::size_t channel, Eigen::Index rows,
                                 Eigen::Index cols, Eigen::Index reach);
Grid<std::complex<float>> block_amplitudes(const TextureModel& model, std::size_t channel, Eigen::Index rows,
                                           Eigen::Index cols);

/// What mixes independent phases (or white noise) so that channels of these amplitudes correlate at lag 0 as
/// the model wants: M of unit rows, M·Mᵀ = correlation over the cosine between both amplitudes. Where spectra
/// are too different to allow it, the nearest that can be; the identity if phases are not mixed.
Covariance phase_mixing(const TextureModel& model, const std::array<AxisAmplitudes, kChannels>& amplitudes,
                        Eigen::Index cols);

/// Texels beyond which what lies at one place hardly tells of another: the exemplar's length along the longer
/// axis.
Eigen::Index reach_of(const TextureModel& model);

}  // namespace micro
