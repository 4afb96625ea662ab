#include "texture/marginals.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/parallel.h"

namespace micro {

MarginalMap::MarginalMap(const Exemplar& exemplar) {
  const ExemplarMoments moments = moments_of(exemplar);
  for (std::size_t c = 0; c < kChannels; ++c) {
    const auto k = static_cast<Eigen::Index>(c);
    mean_[c] = moments.mean[c];
    deviation_[c] = std::sqrt(moments.covariance(k, k));
    std::vector<double> sorted;
    for (const double value : exemplar.channels[c].reshaped())
      if (!std::isnan(value)) sorted.push_back(value);
    std::sort(sorted.begin(), sorted.end());
    const auto n = static_cast<double>(sorted.size());
    for (int node = 0; node < kNodes && !sorted.empty(); ++node) {
      const double z = (2. * node / (kNodes - 1) - 1) * kReach;
      // The k-th smallest of n stands at p = (k + ½)/n.
      const double rank = std::clamp(std::erfc(-z / std::numbers::sqrt2) / 2 * n - 0.5, 0., n - 1),
                   below = std::floor(rank);
      const double low = sorted[static_cast<std::size_t>(below)],
                   high = sorted[std::min(static_cast<std::size_t>(below) + 1, sorted.size() - 1)];
      nodes_[c].push_back(static_cast<float>(low + (rank - below) * (high - low)));
    }
  }
}

float MarginalMap::operator()(std::size_t channel, float value) const {
  if (!(deviation_[channel] > 0)) return value;
  const double z = (static_cast<double>(value) - mean_[channel]) / deviation_[channel];
  const double place = std::clamp((z / kReach + 1) / 2 * (kNodes - 1), 0., kNodes - 1.001);
  const auto node = static_cast<std::size_t>(place);
  const auto part = static_cast<float>(place - static_cast<double>(node));
  return nodes_[channel][node] + part * (nodes_[channel][node + 1] - nodes_[channel][node]);
}

void MarginalMap::apply(TextureField& field) const {
  for (std::size_t c = 0; c < kChannels; ++c)
    parallel_blocks(field[c].rows(), 16, [&](std::int64_t begin, std::int64_t end) {
      for (Eigen::Index k = begin * field[c].cols(); k < end * field[c].cols(); ++k)
        field[c].data()[k] = (*this)(c, field[c].data()[k]);
    });
}

CorrelationMaps MarginalMap::correlations_before() const {
  std::array<HermiteSeries, kChannels> series;
  for (std::size_t c = 0; c < kChannels; ++c)
    series[c] = deviation_[c] > 0 ? hermite_series(nodes_[c], kReach) : HermiteSeries{};
  CorrelationMaps maps;
  for (std::size_t a = 0; a < kChannels; ++a)
    for (std::size_t b = 0; b < kChannels; ++b)
      maps[a][b] = CorrelationMap(series[a], series[b]);
  return maps;
}

}  // namespace micro
