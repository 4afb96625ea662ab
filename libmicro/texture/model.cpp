#include "texture/model.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/error.h"
#include "texture/block_mixing.h"

namespace micro {
namespace {

using Blocks = TextureModel::Blocks;

/// Which rows (or columns) are strips.
std::vector<Eigen::Index> strips_of(const Grid<bool>& there) {
  std::vector<Eigen::Index> counts, chosen;
  for (Eigen::Index j = 0; j < there.rows(); ++j)
    counts.push_back(there.row(j).count());
  const Eigen::Index fullest = counts.empty() ? 0 : *std::max_element(counts.begin(), counts.end());
  for (Eigen::Index j = 0; j < there.rows(); ++j)
    if (counts[static_cast<std::size_t>(j)] >= std::max<Eigen::Index>(2, (fullest + 1) / 2))
      chosen.push_back(j);
  return chosen;
}

/// A strip from its first to its last texel.
Eigen::ArrayXd trimmed(const Eigen::ArrayXd& strip) {
  Eigen::Index first = 0, last = strip.size() - 1;
  while (std::isnan(strip[first]))
    ++first;
  while (std::isnan(strip[last]))
    --last;
  return strip.segment(first, last - first + 1);
}

AxisSpectrum rows_as_strips(const std::array<Grid<double>, kChannels>& channels, const SlopeCoordinates& mean,
                            Taper taper) {
  AxisSpectrum axis;
  const std::vector<Eigen::Index> rows = strips_of(!channels[0].isNaN());
  for (std::size_t c = 0; c < kChannels; ++c) {
    axis.constant[c] = !rows.empty();
    for (const Eigen::Index j : rows) {
      const Eigen::ArrayXd strip = trimmed(channels[c].row(j).transpose());
      if (!(strip.isNaN() || strip == strip[0]).all()) axis.constant[c] = false;
      axis.strips[c].push_back(strip_deviations(strip, mean[c], taper));
    }
  }
  return axis;
}

TextureModel::Axes axes_of(const std::array<Grid<double>, kChannels>& channels, const SlopeCoordinates& mean,
                           Taper taper) {
  std::array<Grid<double>, kChannels> turned;
  for (std::size_t c = 0; c < kChannels; ++c)
    turned[c] = channels[c].transpose();
  return {rows_as_strips(channels, mean, taper), rows_as_strips(turned, mean, taper)};
}

/// Deviations of a block from its mean, tapered along both axes.
Grid<double> block_deviations(const Grid<double>& values, Taper taper) {
  const Grid<double> weights = (taper_weights(values.rows(), taper).matrix() *
                                taper_weights(values.cols(), taper).matrix().transpose())
                                   .array();
  const Grid<double> held = values.isNaN().select(0., weights);
  const double first = values.isNaN().select(Grid<double>::Zero(values.rows(), values.cols()), values).sum() /
                       static_cast<double>((!values.isNaN()).count());
  const double mean = first + values.isNaN().select(0., weights * (values - first)).sum() / held.sum();
  return values.isNaN().select(0., weights * (values - mean));
}

/// Scales amplitudes along both axes so that their squares but `left_out` sum to the variance; of those along
/// x the half spectrum is kept.
AxisAmplitudes scaled(AxisAmplitudes amplitudes, double variance, double left_out) {
  const auto power = [](const std::vector<float>& a) {
    double sum = 0;
    for (const float value : a)
      sum += static_cast<double>(value) * value;
    return sum;
  };
  const double whole = power(amplitudes.x) * power(amplitudes.y) - left_out;
  // A direction along which nothing varies has no amplitudes; then there is no variance to share out either.
  const double scale = whole > 0 ? std::sqrt(variance / whole) : 0;
  for (float& value : amplitudes.y)
    value = static_cast<float>(value * scale);
  amplitudes.x.resize(amplitudes.x.size() / 2 + 1);
  return amplitudes;
}

/// Spectrum over n texels of the kernel that an axis has on 2·reach texels, drawn to zero over its outer
/// half.
std::vector<float> kernel_spectrum(const AxisSpectrum& axis, std::size_t channel, Eigen::Index n,
                                   Eigen::Index reach) {
  if (axis.constant[channel]) return std::vector<float>(static_cast<std::size_t>(n), 1);
  const std::vector<float> own = axis.amplitudes(channel, 2 * reach);
  FftVector<std::complex<double>> kernel(own.begin(), own.end());
  ComplexFft<double>({1, 2 * reach, 1}, FftDirection::Backward)(kernel.data());
  FftVector<std::complex<double>> padded(static_cast<std::size_t>(n), 0);
  for (Eigen::Index lag = -reach + 1; lag < reach; ++lag) {
    const double outer =
        std::max(0., 2. * static_cast<double>(std::abs(lag)) / static_cast<double>(reach) - 1);
    const double fade = std::pow(std::cos(std::numbers::pi / 2 * outer), 2);
    padded[static_cast<std::size_t>((lag + n) % n)] =
        fade * kernel[static_cast<std::size_t>((lag + 2 * reach) % (2 * reach))].real();
  }
  ComplexFft<double>({1, n, 1}, FftDirection::Forward)(padded.data());
  std::vector<float> spectrum;
  for (const auto& value : padded)
    spectrum.push_back(static_cast<float>(value.real()));
  return spectrum;
}

/// Amplitudes whose powers, all positive, sum to the correlations that theirs have, mapped.
std::vector<float> mapped_amplitudes(std::vector<float> amplitudes, const CorrelationMap& before) {
  const auto n = static_cast<Eigen::Index>(amplitudes.size());
  FftVector<std::complex<double>> values;
  for (const float a : amplitudes)
    values.emplace_back(static_cast<double>(a) * a);
  ComplexFft<double>({1, n, 1}, FftDirection::Backward)(values.data());
  const double whole = values[0].real();
  if (!(whole > 0)) return amplitudes;
  for (auto& value : values)
    value = whole * before(value.real() / whole);
  ComplexFft<double>({1, n, 1}, FftDirection::Forward)(values.data());
  for (std::size_t k = 0; k < amplitudes.size(); ++k)
    amplitudes[k] = static_cast<float>(std::sqrt(std::max(0., values[k].real()) / static_cast<double>(n)));
  return amplitudes;
}

/// The same for a block, with phases as they are. A single periodogram has zeros, from which nothing can be
/// taken: its own spectrum is multiplied by what mapping does to the smooth one of short lags. Twice as long,
/// since that smears the block over so many texels.
Grid<double> mapped_block(const Grid<double>& block, const CorrelationMap& before) {
  constexpr double kWindow = 1. / 6;  // standard deviation of the window on lags, in lengths of the block
  const Eigen::Index rows = 2 * block.rows(), cols = 2 * block.cols();
  const FftShape shape{rows, cols, 1};
  const ComplexFft<double> forward(shape, FftDirection::Forward), backward(shape, FftDirection::Backward);
  FftVector<std::complex<double>> spectrum(static_cast<std::size_t>(shape.size()), 0);
  for (Eigen::Index j = 0; j < block.rows(); ++j)
    for (Eigen::Index i = 0; i < block.cols(); ++i)
      spectrum[static_cast<std::size_t>((j + rows / 4) * cols + i + cols / 4)] = block(j, i);
  forward(spectrum.data());
  FftVector<std::complex<double>> smooth = spectrum;
  for (auto& power : smooth)
    power = std::norm(power);
  backward(smooth.data());
  const double whole = smooth[0].real();
  if (!(whole > 0)) return Grid<double>::Zero(rows, cols);
  const auto window = [](Eigen::Index k, Eigen::Index n) {
    const double lag = static_cast<double>(std::min(k, n - k)) / (kWindow * static_cast<double>(n) / 2);
    return std::exp(-lag * lag / 2);
  };
  FftVector<std::complex<double>> mapped = smooth;
  for (Eigen::Index j = 0; j < rows; ++j)
    for (Eigen::Index i = 0; i < cols; ++i) {
      const auto lag = static_cast<std::size_t>(j * cols + i);
      smooth[lag] *= window(j, rows) * window(i, cols) / whole;
      mapped[lag] = before(smooth[lag].real());
    }
  forward(smooth.data());
  forward(mapped.data());
  for (std::size_t k = 0; k < spectrum.size(); ++k)
    if (const double power = smooth[k].real(); power > 0)
      spectrum[k] *= std::sqrt(std::max(0., mapped[k].real()) / power);
  backward(spectrum.data());
  Grid<double> kernel(rows, cols);
  for (Eigen::Index k = 0; k < kernel.size(); ++k)
    kernel.data()[k] = spectrum[static_cast<std::size_t>(k)].real() / static_cast<double>(shape.size());
  return kernel;
}

/// Between channels at lag 0, 0 where one of them does not vary.
Covariance correlations_of(const ExemplarMoments& moments) {
  Covariance correlation = Covariance::Identity();
  for (Eigen::Index k = 0; k < correlation.rows(); ++k)
    for (Eigen::Index l = 0; l < correlation.cols(); ++l) {
      const double unit = std::sqrt(moments.covariance(k, k) * moments.covariance(l, l));
      if (k != l) correlation(k, l) = unit > 0 ? moments.covariance(k, l) / unit : 0;
    }
  return correlation;
}

}  // namespace

TextureModel with_correlations_before(TextureModel model, const CorrelationMaps& before) {
  for (Eigen::Index k = 0; k < 5; ++k)
    for (Eigen::Index l = 0; l < 5; ++l)
      if (k != l)
        model.correlation(k, l) =
            before[static_cast<std::size_t>(k)][static_cast<std::size_t>(l)](model.correlation(k, l));
  for (std::size_t c = 0; c < kChannels; ++c)
    if (auto* blocks = std::get_if<Blocks>(&model.spectrum)) {
      (*blocks)[c] = mapped_block((*blocks)[c], before[c][c]);
    } else {
      auto& axes = std::get<TextureModel::Axes>(model.spectrum);
      axes.x.before[c] = axes.y.before[c] = before[c][c];
    }
  if (model.common_phase()) {
    auto& blocks = std::get<Blocks>(model.spectrum);
    blocks = mixed_block(blocks, model.correlation);
  }
  return model;
}

std::string_view name_of(Recipe recipe) {
  constexpr std::array<std::string_view, 3> kNames = {"separable", "full", "joint"};
  return kNames[static_cast<std::size_t>(recipe)];
}

std::vector<float> AxisSpectrum::amplitudes(std::size_t channel, Eigen::Index n) const {
  std::vector<float> amplitude(static_cast<std::size_t>(n), 1);
  if (strips[channel].empty()) return amplitude;
  std::vector<double> power(static_cast<std::size_t>(n), 0);
  const ComplexFft<double> transform({1, n, 1}, FftDirection::Forward);
  FftVector<std::complex<double>> buffer(static_cast<std::size_t>(n));
  Eigen::Index shortest = strips[channel].front().size();
  for (const Eigen::ArrayXd& strip : strips[channel]) {
    // Strips longer than the texture go in segments [Bartlett48]: their powers average out what a single
    // periodogram scatters.
    for (Eigen::Index begin = 0; begin < strip.size(); begin += n) {
      std::fill(buffer.begin(), buffer.end(), 0);
      for (Eigen::Index k = begin; k < std::min(begin + n, strip.size()); ++k)
        buffer[static_cast<std::size_t>(k - begin)] = strip[k];
      transform(buffer.data());
      for (std::size_t k = 0; k < power.size(); ++k)
        power[k] += std::norm(buffer[k]);
    }
    shortest = std::min(shortest, strip.size());
  }
  if (constant[channel]) {
    std::fill(amplitude.begin() + 1, amplitude.end(), 0);
    return amplitude;
  }
  const Eigen::Index lowest = std::min<Eigen::Index>((n + shortest - 1) / shortest, n / 2);
  for (Eigen::Index k = 0; k < n; ++k) {
    const double own = power[static_cast<std::size_t>(k)];
    const bool resolved = std::min(k, n - k) >= lowest;
    amplitude[static_cast<std::size_t>(k)] = static_cast<float>(
        std::sqrt(resolved ? own : std::max(own, power[static_cast<std::size_t>(lowest)])));
  }
  return before[channel].changes() ? mapped_amplitudes(std::move(amplitude), before[channel]) : amplitude;
}

TextureModel model_of(const Exemplar& exemplar, Recipe recipe, Taper taper) {
  const ExemplarMoments moments = moments_of(exemplar);
  if (moments.count == 0) throw InputError("the exemplar holds no texel");
  const bool block = is_block(exemplar);
  if (recipe == Recipe::Full) require_block(exemplar.rows(), exemplar.cols(), moments.count);
  TextureModel model;
  model.recipe = recipe;
  model.mean = moments.mean;
  for (std::size_t c = 0; c < kChannels; ++c) {
    const auto k = static_cast<Eigen::Index>(c);
    model.variance[c] = moments.covariance(k, k);
  }
  if (recipe == Recipe::Separable) {
    model.spectrum = axes_of(exemplar.channels, moments.mean, taper);
  } else if (block) {
    Blocks blocks;
    for (std::size_t c = 0; c < kChannels; ++c)
      blocks[c] = block_deviations(exemplar.channels[c], taper);
    model.spectrum = std::move(blocks);
  } else {
    model.spectrum = axes_of(exemplar.channels, moments.mean, taper);
  }
  if (recipe == Recipe::Joint) model.correlation = correlations_of(moments);
  if (model.common_phase()) {
    auto& blocks = std::get<Blocks>(model.spectrum);
    blocks = mixed_block(blocks, model.correlation);
  }
  return model;
}

AxisAmplitudes axis_amplitudes(const TextureModel& model, std::size_t channel, Eigen::Index rows,
                               Eigen::Index cols) {
  const auto& axes = std::get<TextureModel::Axes>(model.spectrum);
  AxisAmplitudes amplitudes = {axes.x.amplitudes(channel, cols), axes.y.amplitudes(channel, rows)};
  const double dc = std::pow(static_cast<double>(amplitudes.x[0]) * amplitudes.y[0], 2);
  return scaled(std::move(amplitudes), model.variance[channel], dc);
}

AxisAmplitudes kernel_amplitudes(const TextureModel& model, std::size_t channel, Eigen::Index rows,
                                 Eigen::Index cols, Eigen::Index reach) {
  const auto& axes = std::get<TextureModel::Axes>(model.spectrum);
  return scaled(
      {kernel_spectrum(axes.x, channel, cols, reach), kernel_spectrum(axes.y, channel, rows, reach)},
      model.variance[channel], 0);
}

Grid<std::complex<float>> block_amplitudes(const TextureModel& model, std::size_t channel, Eigen::Index rows,
                                           Eigen::Index cols) {
  const Grid<double>& block = std::get<Blocks>(model.spectrum)[channel];
  const RealFft<float> transform({rows, cols, 1});
  FftVector<float> folded(static_cast<std::size_t>(rows * cols), 0);
  for (Eigen::Index j = 0; j < block.rows(); ++j)
    for (Eigen::Index i = 0; i < block.cols(); ++i)
      folded[static_cast<std::size_t>(j % rows * cols + i % cols)] += static_cast<float>(block(j, i));
  FftVector<std::complex<float>> half(static_cast<std::size_t>(transform.shape().half_size()));
  transform.forward(folded.data(), half.data());
  Grid<std::complex<float>> amplitudes =
      Eigen::Map<const Grid<std::complex<float>>>(half.data(), rows, cols / 2 + 1);
  amplitudes(0, 0) = 0;
  double whole = 0;
  for (Eigen::Index i = 0; i <= cols / 2; ++i) {
    const double twice = i == 0 || 2 * i == cols ? 1 : 2;
    for (Eigen::Index j = 0; j < rows; ++j)
      whole += twice * std::norm(amplitudes(j, i));
  }
  return amplitudes * static_cast<float>(whole > 0 ? std::sqrt(model.variance[channel] / whole) : 0);
}

Covariance phase_mixing(const TextureModel& model, const std::array<AxisAmplitudes, kChannels>& amplitudes,
                        Eigen::Index cols) {
  if (!model.mixed_phases()) return Covariance::Identity();
  const auto& axes = std::get<TextureModel::Axes>(model.spectrum);
  // Σ a·b over the whole spectrum.
  const auto product = [cols](const AxisAmplitudes& a, const AxisAmplitudes& b) {
    double x = 0, y = 0;
    for (std::size_t i = 0; i < a.x.size(); ++i) {
      const bool once = i == 0 || 2 * static_cast<Eigen::Index>(i) == cols;
      x += (once ? 1 : 2) * static_cast<double>(a.x[i]) * b.x[i];
    }
    for (std::size_t j = 0; j < a.y.size(); ++j)
      y += static_cast<double>(a.y[j]) * b.y[j];
    return x * y;
  };
  Covariance wanted = Covariance::Identity();
  for (std::size_t c = 0; c < kChannels; ++c)
    for (std::size_t d = 0; d < c; ++d) {
      const double unit =
          std::sqrt(product(amplitudes[c], amplitudes[c]) * product(amplitudes[d], amplitudes[d]));
      const double cosine = unit > 0 ? product(amplitudes[c], amplitudes[d]) / unit : 0;
      // What varies along one axis only has nothing in common with what varies along the other.
      const bool alike = axes.x.constant[c] == axes.x.constant[d] && axes.y.constant[c] == axes.y.constant[d];
      if (!alike || !(cosine > 0)) continue;
      const auto k = static_cast<Eigen::Index>(c), l = static_cast<Eigen::Index>(d);
      wanted(k, l) = wanted(l, k) = std::clamp(model.correlation(k, l) / cosine, -1., 1.);
    }
  const Eigen::SelfAdjointEigenSolver<Covariance> solver(wanted);
  Covariance mixing = solver.eigenvectors() * solver.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal() *
                      solver.eigenvectors().transpose();
  mixing.rowwise().normalize();
  return mixing;
}

Eigen::Index reach_of(const TextureModel& model) {
  Eigen::Index reach = 1;
  if (const auto* blocks = std::get_if<Blocks>(&model.spectrum))
    return std::max((*blocks)[0].rows(), (*blocks)[0].cols());
  for (const AxisSpectrum* axis :
       {&std::get<TextureModel::Axes>(model.spectrum).x, &std::get<TextureModel::Axes>(model.spectrum).y})
    for (const Eigen::ArrayXd& strip : axis->strips[0])
      reach = std::max(reach, strip.size());
  return reach;
}

}  // namespace micro
