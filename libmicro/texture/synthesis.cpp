#include "texture/synthesis.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "core/large_pages.h"
#include "core/parallel.h"
#include "core/random.h"

namespace micro {
namespace {

using Complex = std::complex<float>;
constexpr std::uint32_t kPhaseStream = 61, kNoiseStream = 62;
constexpr std::int64_t kRowsPerBlock = 16;

/// Unit numbers of 4096 phases.
const std::array<Complex, 4096>& phase_table() {
  static const auto table = [] {
    std::array<Complex, 4096> units;
    for (std::size_t k = 0; k < units.size(); ++k) {
      const double phase = 2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(units.size());
      units[k] = {static_cast<float>(std::cos(phase)), static_cast<float>(std::sin(phase))};
    }
    return units;
  }();
  return table;
}

/// Eight numbers of 16 bits from one draw.
std::uint32_t half_word(const std::array<std::uint32_t, 4>& words, std::size_t k) {
  return words[k / 2] >> (16 * (k % 2)) & 0xffff;
}

/// Amplitudes of every channel, as the model has them, and what mixes phases.
struct Amplitudes {
  std::array<AxisAmplitudes, kChannels> axes;
  std::array<Grid<Complex>, kChannels> blocks;
  Eigen::Matrix<float, 5, 5> mixing;

  /// Of a whole texture; of white noise if the kernel's `reach` is given.
  Amplitudes(const TextureModel& model, Eigen::Index rows, Eigen::Index cols,
             std::optional<Eigen::Index> reach = {}) {
    const bool separable = std::holds_alternative<TextureModel::Axes>(model.spectrum);
    parallel_for(kChannels, [&](std::int64_t k) {
      const auto m = static_cast<std::size_t>(k);
      if (!separable)
        blocks[m] = block_amplitudes(model, m, rows, cols);
      else if (reach)
        axes[m] = kernel_amplitudes(model, m, rows, cols, *reach);
      else
        axes[m] = axis_amplitudes(model, m, rows, cols);
    });
    mixing = phase_mixing(model, axes, cols).cast<float>();
  }
  bool separable() const { return blocks[0].size() == 0; }
  Complex at(std::size_t m, Eigen::Index j, Eigen::Index i) const {
    if (!separable()) return blocks[m](j, i);
    return axes[m].y[static_cast<std::size_t>(j)] * axes[m].x[static_cast<std::size_t>(i)];
  }
};

/// Σ_k M(c, k)·numbers[k].
template <typename Number>
Number mixed_number(const Eigen::Matrix<float, 5, 5>& mixing, std::size_t c,
                    const std::array<Number, kChannels>& numbers) {
  Number sum = 0;
  for (std::size_t k = 0; k < kChannels; ++k)
    sum += mixing(static_cast<Eigen::Index>(c), static_cast<Eigen::Index>(k)) * numbers[k];
  return sum;
}

using Spectra = std::array<FftArray<Complex>, kChannels>;

/// Row j of every component's half spectrum: amplitude times random phase. `mirror` is the row whose
/// conjugate this one's first (and, for even cols, last) number must be for the field to be real.
void fill_row(Spectra& spectra, const Amplitudes& amplitudes, const TextureModel& model, std::uint64_t seed,
              Eigen::Index j, const TextureSize& size) {
  const Eigen::Index half = size.cols / 2 + 1;
  const Eigen::Index mirror = (size.rows - j) % size.rows;
  const bool common = model.common_phase();
  const auto& units = phase_table();
  const bool separable = amplitudes.separable(), mixed = model.mixed_phases();
  for (Eigen::Index i = 0; i < half; ++i) {
    const bool edge = i == 0 || 2 * i == size.cols;
    // The later of two conjugate numbers is drawn as the earlier.
    const bool conjugate = edge && mirror < j, real = edge && mirror == j;
    const auto counter = static_cast<std::uint64_t>((conjugate ? mirror : j) * half + i);
    const auto words = random_words(seed, kPhaseStream, counter);
    const auto place = static_cast<std::size_t>(j * half + i);
    std::array<Complex, kChannels> drawn;
    for (std::size_t m = 0; m < kChannels; ++m) {
      const std::uint32_t bits = half_word(words, common ? 0 : m);
      drawn[m] = real ? Complex(bits & 1 ? 1.f : -1.f, 0) : units[bits >> 4];
      if (conjugate) drawn[m] = std::conj(drawn[m]);
    }
    for (std::size_t m = 0; m < kChannels; ++m) {
      const Complex unit = mixed ? mixed_number(amplitudes.mixing, m, drawn) : drawn[m];
      if (separable) {
        const float a = amplitudes.axes[m].y[static_cast<std::size_t>(j)] *
                        amplitudes.axes[m].x[static_cast<std::size_t>(i)];
        spectra[m][place] = {a * unit.real(), a * unit.imag()};
      } else {
        spectra[m][place] = amplitudes.blocks[m](j, i) * unit;
      }
    }
  }
  if (j == 0)
    for (auto& spectrum : spectra)
      spectrum[0] = 0;  // the mean is the model's
}

/// Scales a channel's deviations and adds its mean.
void finish_channel(Grid<float>& channel, double scale, double mean) {
  channel = (scale * channel.cast<double>() + mean).cast<float>();
}

/// What brings a channel to the model's variance: mixed phases are no unit numbers, and meet it on average
/// only.
double scale_to(double variance, const Grid<float>& deviations) {
  const double found = deviations.cast<double>().square().mean();
  return found > 0 ? std::sqrt(variance / found) : 1;
}

/// Normal numbers of 16 bits: the quantile in the middle of each of 65536 equal parts.
const std::vector<float>& normal_table() {
  static const auto table = [] {
    // Φ⁻¹ by Newton's method on Φ, from the middle outwards.
    constexpr int kSize = 65536;
    std::vector<float> quantiles(kSize);
    double z = 0;
    for (int k = kSize / 2; k < kSize; ++k) {
      const double tail = 1 - (k + 0.5) / kSize;
      for (int step = 0; step < 8; ++step)
        z += (std::erfc(z / std::numbers::sqrt2) / 2 - tail) * std::sqrt(2 * std::numbers::pi) *
             std::exp(z * z / 2);
      quantiles[static_cast<std::size_t>(k)] = static_cast<float>(z);
      quantiles[static_cast<std::size_t>(kSize - 1 - k)] = static_cast<float>(-z);
    }
    return quantiles;
  }();
  return table;
}

/// How far a part's texels reach. A block's kernel is the block; that of strips, which has no phase, has
/// tails beyond its exemplar's length.
Eigen::Index kernel_reach(const TextureModel& model) {
  const Eigen::Index reach = reach_of(model);
  if (std::holds_alternative<TextureModel::Blocks>(model.spectrum)) return reach;
  return std::clamp<Eigen::Index>(6 * reach, 64, 1024);
}

/// White noise of every channel (of one for all if they have a common phase) on a part of a texture's plane,
/// periodic with the texture; constant along an axis along which the channel is.
std::array<FftVector<float>, kChannels> periodic_noise(const TextureModel& model,
                                                       const Eigen::Matrix<float, 5, 5>& mixing,
                                                       const TextureSize& size, std::uint64_t seed,
                                                       const TexturePart& part) {
  const std::size_t drawn = model.common_phase() ? 1 : kChannels;
  const bool mixed = model.mixed_phases();
  std::array<FftVector<float>, kChannels> noise;
  std::array<bool, kChannels> along_x{}, along_y{};
  for (std::size_t m = 0; m < drawn; ++m) {
    noise[m].resize(static_cast<std::size_t>(part.rows * part.cols));
    if (const auto* axes = std::get_if<TextureModel::Axes>(&model.spectrum)) {
      along_x[m] = axes->x.constant[m];
      along_y[m] = axes->y.constant[m];
    }
  }
  const auto& quantiles = normal_table();
  const auto wrapped = [](Eigen::Index k, Eigen::Index n) { return ((k % n) + n) % n; };
  const auto words_at = [&](Eigen::Index row, Eigen::Index col) {
    return random_words(seed, kNoiseStream, static_cast<std::uint64_t>(row * size.cols + col));
  };
  parallel_blocks(part.rows, kRowsPerBlock, [&](std::int64_t begin, std::int64_t end) {
    for (Eigen::Index j = begin; j < end; ++j)
      for (Eigen::Index i = 0; i < part.cols; ++i) {
        const Eigen::Index row = wrapped(part.row + j, size.rows), col = wrapped(part.col + i, size.cols);
        const auto words = words_at(row, col);
        for (std::size_t m = 0; m < drawn; ++m) {
          const bool constant = along_x[m] || along_y[m];
          const auto own = constant ? words_at(along_y[m] ? 0 : row, along_x[m] ? 0 : col) : words;
          const auto quantile = [&](std::size_t k) { return quantiles[half_word(own, k)]; };
          noise[m][static_cast<std::size_t>(j * part.cols + i)] =
              mixed ? mixed_number<float>(mixing, m,
                                          {quantile(0), quantile(1), quantile(2), quantile(3), quantile(4)})
                    : quantile(m);
        }
      }
  });
  return noise;
}

}  // namespace

TextureField synthesise(const TextureModel& model, const TextureSize& size, std::uint64_t seed) {
  const RealFft<float> transform({size.rows, size.cols, 1});
  const Amplitudes amplitudes(model, size.rows, size.cols);
  Spectra spectra;
  for (auto& spectrum : spectra)
    spectrum = make_fft_array<Complex>(transform.shape().half_size());
  parallel_blocks(size.rows, kRowsPerBlock, [&](std::int64_t begin, std::int64_t end) {
    for (Eigen::Index j = begin; j < end; ++j)
      fill_row(spectra, amplitudes, model, seed, j, size);
  });
  TextureField field;
  parallel_for(kChannels, [&](std::int64_t k) {
    const auto m = static_cast<std::size_t>(k);
    field[m].resize(size.rows, size.cols);
    prefer_large_pages(field[m].data(), sizeof(float) * static_cast<std::size_t>(field[m].size()));
    if (is_fft_aligned(field[m].data())) {
      transform.backward(spectra[m].get(), field[m].data());
    } else {
      const auto values = make_fft_array<float>(field[m].size());
      transform.backward(spectra[m].get(), values.get());
      std::copy_n(values.get(), field[m].size(), field[m].data());
    }
    spectra[m].reset();
    finish_channel(field[m], model.mixed_phases() ? scale_to(model.variance[m], field[m]) : 1, model.mean[m]);
  });
  return field;
}

TextureField synthesise_part(const TextureModel& model, const TextureSize& size, std::uint64_t seed,
                             const TexturePart& part) {
  const Eigen::Index margin = kernel_reach(model);
  const Eigen::Index rows = fast_fft_size(part.rows + 2 * margin),
                     cols = fast_fft_size(part.cols + 2 * margin);
  const RealFft<float> transform({rows, cols, 1});
  const Amplitudes amplitudes(model, rows, cols, margin);
  const bool common = model.common_phase();
  auto noise = periodic_noise(model, amplitudes.mixing, size, seed,
                              {part.row - margin, part.col - margin, rows, cols});
  // Noise of variance 1 has numbers of mean square rows·cols where synthesise() has phases of modulus 1.
  const float unit = 1 / std::sqrt(static_cast<float>(rows) * static_cast<float>(cols));
  Spectra drawn;
  parallel_for(kChannels, [&](std::int64_t k) {
    const auto m = static_cast<std::size_t>(k);
    if (noise[m].empty()) return;
    drawn[m] = make_fft_array<Complex>(transform.shape().half_size());
    transform.forward(noise[m].data(), drawn[m].get());
  });
  TextureField field;
  parallel_for(kChannels, [&](std::int64_t k) {
    const auto m = static_cast<std::size_t>(k);
    const auto& noises = drawn[common ? 0 : m];
    const auto spectrum = make_fft_array<Complex>(transform.shape().half_size());
    const Eigen::Index half = cols / 2 + 1;
    for (Eigen::Index j = 0; j < rows; ++j)
      for (Eigen::Index i = 0; i < half; ++i) {
        const auto place = static_cast<std::size_t>(j * half + i);
        spectrum[place] = noises[place] * (amplitudes.at(m, j, i) * unit);
      }
    const auto values = make_fft_array<float>(transform.shape().size());
    transform.backward(spectrum.get(), values.get());
    field[m] =
        Eigen::Map<const Grid<float>>(values.get(), rows, cols).block(margin, margin, part.rows, part.cols);
    finish_channel(field[m], 1, model.mean[m]);
  });
  return field;
}

}  // namespace micro
