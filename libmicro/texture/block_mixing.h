#pragma once

#include <array>

#include "texture/exemplar.h"

namespace micro {

/// Mixes the channels of a block of deviations so that they correlate at lag 0 as wanted, each with its power
/// as it was: a taper weighs the middle, where correlations are not those of the whole. Of all mixtures that
/// do it the one that changes channels least, the optimal transport between both normal laws [Olkin82],
///   M = R^{1/2} (R^{1/2} S R^{1/2})^{−1/2} R^{1/2},
/// S the block's correlations, R those wanted. Where channels of the block are no independent directions,
/// what can be had within those there are; channels without power stay zero.
std::array<Grid<double>, kChannels> mixed_block(const std::array<Grid<double>, kChannels>& block,
                                                const Covariance& correlation);

}  // namespace micro
