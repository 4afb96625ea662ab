#pragma once

#include "texture/exemplar.h"
#include "texture/synthesis.h"

namespace micro {

/// Maps Gaussian values to the exemplar's own distribution, channel by channel: the value of normal quantile
/// p becomes the exemplar's quantile p, interpolated between its sorted texels. No value leaves the range
/// that was measured; ranks stay, so the pattern does, while spectra and correlations change as far as the
/// exemplar is not Gaussian: see correlations_before().
class MarginalMap {
 public:
  explicit MarginalMap(const Exemplar& exemplar);
  float operator()(std::size_t channel, float value) const;
  void apply(TextureField& field) const;
  /// What correlations Gaussian values need for the mapped ones to have given ones.
  CorrelationMaps correlations_before() const;

 private:
  static constexpr int kNodes = 2048;
  static constexpr double kReach = 6;  // standard deviations
  SlopeCoordinates mean_{}, deviation_{};
  std::array<std::vector<float>, kChannels> nodes_;
};

}  // namespace micro
