#include "height/gaussian_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "core/fft.h"
#include "core/parallel.h"
#include "core/random.h"

namespace micro {
namespace {

constexpr double kPi = std::numbers::pi;

/// Noise points per correlation length. A lattice sum of the squared kernel ripples by 2 exp(−π²·3²/4) =
/// 5e-10 of itself about its mean.
constexpr double kPointsPerTau = 3;
/// Noise points that reach a point: kReach on either side; beyond, the kernel is below exp(−2·(10/3)²) =
/// 2e-10.
constexpr int kReach = 10;
constexpr int kTaps = 2 * kReach;
/// Correlation lengths below this fraction of the pitch are raised to it: neighbours are then correlated by
/// exp(−25), which is nothing.
constexpr double kShortestTau = 1. / 5;
/// Correlation lengths beyond this multiple of the patch are lowered to it: the patch is a constant to 1e-18.
constexpr double kLongestTau = 1e9;

/// The field with correlation lengths that the grid can tell from 0 and from infinity.
GaussianField resolvable(GaussianField field, const SyntheticGrid& grid) {
  const double shortest = kShortestTau * std::min(grid.dx, grid.dy);
  const double longest = kLongestTau * std::max(grid.width(), grid.height());
  field.tau_x = std::clamp(field.tau_x, shortest, longest);
  field.tau_y = std::clamp(field.tau_y, shortest, longest);
  return field;
}

/// Kernel weights exp(−2 (d/3)²) of the noise points around position t (in noise spacings), d = t − n for
/// n = ⌊t⌋ − kReach + 1 … ⌊t⌋ + kReach, normalised so that their squares sum to 1. The factors of d's
/// fraction f and its integer part separate: exp(−(2/9)(f − k)²) = exp(−(2/9)f²) · exp((4/9)f)^k ·
/// exp(−(2/9)k²).
class Kernel {
 public:
  Kernel() {
    const double norm = std::sqrt(kPointsPerTau * std::sqrt(kPi) / 2);  // √∫exp(−4t²/3²)dt
    for (int k = 1 - kReach; k <= kReach; ++k)
      at_integer_[static_cast<std::size_t>(k + kReach - 1)] = std::exp(-kSteepness * k * k) / norm;
  }

  std::array<double, kTaps> operator()(double fraction) const {
    std::array<double, kTaps> weights;
    const double base = std::exp(-kSteepness * fraction * fraction);
    const double ratio = std::exp(2 * kSteepness * fraction);
    double power = base * std::pow(ratio, 1 - kReach);
    for (std::size_t t = 0; t < kTaps; ++t, power *= ratio)
      weights[t] = power * at_integer_[t];
    return weights;
  }

 private:
  static constexpr double kSteepness = 2 / (kPointsPerTau * kPointsPerTau);
  std::array<double, kTaps> at_integer_{};
};

/// Position of a coordinate among noise points: the first that matters and the fraction past its cell's
/// start.
struct Place {
  std::int64_t first;
  double fraction;
};

Place place(double t) {
  const double floor = std::floor(t);
  return {static_cast<std::int64_t>(floor) - kReach + 1, t - floor};
}

/// White noise at lattice points (n, m), any sign, two per random number drawn.
void noise_row(std::uint64_t seed, std::uint32_t stream, std::int64_t n, std::int64_t first, double* out,
               std::int64_t count) {
  constexpr std::int64_t kHalf = std::int64_t{1} << 31;
  const std::uint64_t high = static_cast<std::uint64_t>(n + kHalf) << 32;
  for (std::int64_t k = 0; k < count;) {
    const std::int64_t m = first + k + kHalf;
    const auto pair = random_normal(seed, stream, high | static_cast<std::uint64_t>(m >> 1));
    out[k++] = pair[static_cast<std::size_t>(m & 1)];
    if ((m & 1) == 0 && k < count) out[k++] = pair[1];
  }
}

/// The moving average in lines: coordinates s = l·ds across lines, f = p·df along a line. In u = f + shear·s
/// and s the kernel separates, so a line is first the sum of noise rows weighted by their distance in s, then
/// that sum averaged along u.
struct Lines {
  Eigen::Index count, points;
  double ds, df;
  double spacing_s, spacing_u;  ///< of the noise lattice, µm
  double shear;                 ///< |shear| ≤ 1
};

template <typename Write>
void moving_average(const Lines& lines, double rms, std::uint64_t seed, std::uint32_t stream, Write&& write) {
  // A block of lines shares the noise rows it needs: twenty and one for each spacing_s the block covers.
  constexpr double kNoiseRows = 60, kLinesPerBlock = 32;
  const auto grain =
      static_cast<Eigen::Index>(std::clamp(kNoiseRows * lines.spacing_s / lines.ds, 1., kLinesPerBlock));
  const Kernel kernel;
  parallel_blocks(lines.count, grain, [&](Eigen::Index begin, Eigen::Index end) {
    const auto s_at = [&](Eigen::Index l) { return static_cast<double>(l) * lines.ds; };
    const auto u_at = [&](Eigen::Index l, Eigen::Index p) {
      return (static_cast<double>(p) * lines.df + lines.shear * s_at(l)) / lines.spacing_u;
    };
    const std::int64_t n0 = place(s_at(begin) / lines.spacing_s).first;
    const std::int64_t n1 = place(s_at(end - 1) / lines.spacing_s).first + kTaps;
    const std::int64_t m0 = std::min(place(u_at(begin, 0)).first, place(u_at(end - 1, 0)).first);
    const std::int64_t m1 =
        std::max(place(u_at(begin, lines.points - 1)).first, place(u_at(end - 1, lines.points - 1)).first) +
        kTaps;
    Grid<double> noise(n1 - n0, m1 - m0);
    for (std::int64_t n = n0; n < n1; ++n)
      noise_row(seed, stream, n, m0, &noise(n - n0, 0), m1 - m0);

    Eigen::Array<double, 1, Eigen::Dynamic> line(m1 - m0);
    for (Eigen::Index l = begin; l < end; ++l) {
      const Place row = place(s_at(l) / lines.spacing_s);
      const std::int64_t from = place(u_at(l, 0)).first - m0;
      const std::int64_t size = place(u_at(l, lines.points - 1)).first + kTaps - m0 - from;
      const std::array<double, kTaps> across = kernel(row.fraction);
      auto sum = line.head(size);
      sum.setZero();
      for (std::size_t t = 0; t < kTaps; ++t)
        sum += across[t] * noise.row(row.first - n0 + static_cast<std::int64_t>(t)).segment(from, size);
      for (Eigen::Index p = 0; p < lines.points; ++p) {
        const Place column = place(u_at(l, p));
        const std::array<double, kTaps> along = kernel(column.fraction);
        const double* v = &sum(column.first - m0 - from);
        double z = 0;
        for (std::size_t t = 0; t < kTaps; ++t)
          z += along[t] * v[t];
        write(l, p, rms * z);
      }
    }
  });
}

void add_open(Grid<double>& z, const SyntheticGrid& grid, const GaussianField& field, std::uint64_t seed,
              std::uint32_t stream) {
  // C = exp(−(xx x² + 2 xy x y + yy y²)). Lines run along the axis with the shorter correlation:
  // xx (x + (xy/xx) y)² + (yy − xy²/xx) y², where |xy/xx| ≤ 1 because xy² ≤ xx·yy ≤ xx².
  const double a = std::pow(field.tau_x, -2), b = std::pow(field.tau_y, -2);
  const double c = std::cos(field.orientation), s = std::sin(field.orientation);
  const double xx = a * c * c + b * s * s, xy = (a - b) * c * s, yy = a * s * s + b * c * c;
  const bool along_x = xx >= yy;
  const double steep = std::max(xx, yy);
  Lines lines{};
  lines.count = along_x ? grid.rows : grid.cols;
  lines.points = along_x ? grid.cols : grid.rows;
  lines.ds = along_x ? grid.dy : grid.dx;
  lines.df = along_x ? grid.dx : grid.dy;
  lines.shear = xy / steep;
  lines.spacing_u = 1 / std::sqrt(steep) / kPointsPerTau;
  lines.spacing_s = std::sqrt(steep) * field.tau_x * field.tau_y / kPointsPerTau;  // yy − xy²/xx = ab/xx
  if (along_x)
    moving_average(lines, field.rms, seed, stream,
                   [&](Eigen::Index j, Eigen::Index i, double value) { z(j, i) += value; });
  else
    moving_average(lines, field.rms, seed, stream,
                   [&](Eigen::Index i, Eigen::Index j, double value) { z(j, i) += value; });
}

/// Power spectrum of the wrapped and sampled correlation at frequency number (k, l), up to a factor: the
/// Gaussian exp(−π²(τ_x² f_x'² + τ_y² f_y'²)) summed over its aliases.
class Spectrum {
 public:
  Spectrum(const SyntheticGrid& grid, const GaussianField& field) : grid_(grid) {
    const double tx = field.tau_x, ty = field.tau_y;
    const double c = std::cos(field.orientation), s = std::sin(field.orientation);
    along_x_ = kPi * tx * c, along_y_ = kPi * tx * s;
    across_x_ = -kPi * ty * s, across_y_ = kPi * ty * c;
    // Aliases beyond a phase of 6 are below exp(−36).
    const double least = kPi * std::min(tx, ty);
    aliases_x_ = static_cast<int>(std::ceil(6 * grid.dx / least + 0.5));
    aliases_y_ = static_cast<int>(std::ceil(6 * grid.dy / least + 0.5));
  }

  double operator()(Eigen::Index k, Eigen::Index l) const {
    double sum = 0;
    for (int a = -aliases_y_; a <= aliases_y_; ++a)
      for (int b = -aliases_x_; b <= aliases_x_; ++b) {
        const double fx =
            (static_cast<double>(l) + static_cast<double>(b) * static_cast<double>(grid_.cols)) /
            grid_.width();
        const double fy =
            (static_cast<double>(k) + static_cast<double>(a) * static_cast<double>(grid_.rows)) /
            grid_.height();
        const double p = along_x_ * fx + along_y_ * fy, q = across_x_ * fx + across_y_ * fy;
        sum += std::exp(-p * p - q * q);
      }
    return sum;
  }

 private:
  SyntheticGrid grid_;
  double along_x_, along_y_, across_x_, across_y_;
  int aliases_x_, aliases_y_;
};

void add_periodic(Grid<double>& z, const SyntheticGrid& grid, const GaussianField& field, std::uint64_t seed,
                  std::uint32_t stream) {
  const FftShape shape{grid.rows, grid.cols};
  const Eigen::Index half = grid.cols / 2 + 1;
  FftVector<double> noise(static_cast<std::size_t>(shape.size()));
  FftVector<std::complex<double>> spectrum(static_cast<std::size_t>(shape.half_size()));
  parallel_for(grid.rows, [&](Eigen::Index j) {
    noise_row(seed, stream, j, 0, &noise[static_cast<std::size_t>(j * grid.cols)], grid.cols);
  });
  const RealFft<double> fft(shape);
  fft.forward(noise.data(), spectrum.data());
  const Spectrum power(grid, field);
  std::vector<double> row_power(static_cast<std::size_t>(grid.rows));
  parallel_for(grid.rows, [&](Eigen::Index k) {
    for (Eigen::Index l = 0; l < half; ++l) {
      const Eigen::Index centred = k > grid.rows / 2 ? k - grid.rows : k;
      const double s = power(centred, l);
      const bool alone = l == 0 || 2 * l == grid.cols;  // the others stand for their conjugates as well
      row_power[static_cast<std::size_t>(k)] += alone ? s : 2 * s;
      spectrum[static_cast<std::size_t>(k * half + l)] *= std::sqrt(s);
    }
  });
  double total = 0;
  for (const double p : row_power)
    total += p;
  fft.backward(spectrum.data(), noise.data());
  // E|noise spectrum|² = N and the variance of the unnormalised inverse is N Σ s.
  const double scale = field.rms / std::sqrt(static_cast<double>(shape.size()) * total);
  for (Eigen::Index n = 0; n < z.size(); ++n)
    z(n) += scale * noise[static_cast<std::size_t>(n)];
}

void check(const GaussianField& field) {
  if (!(field.rms >= 0 && std::isfinite(field.rms)))
    throw InputError("the rms height must be finite and not negative");
  if (!(field.tau_x > 0 && field.tau_y > 0 && std::isfinite(field.tau_x) && std::isfinite(field.tau_y)))
    throw InputError("the correlation lengths must be positive and finite");
  if (!std::isfinite(field.orientation)) throw InputError("the orientation must be finite");
}

}  // namespace

HeightField multiscale_surface(const SyntheticGrid& grid, const std::vector<GaussianField>& scales,
                               std::uint64_t seed, Border border) {
  check(grid);
  for (const GaussianField& field : scales)
    check(field);
  Grid<double> z = Grid<double>::Zero(grid.rows, grid.cols);
  for (std::uint32_t stream = 0; const GaussianField& field : scales)
    (border == Border::Open ? add_open : add_periodic)(z, grid, resolvable(field, grid), seed, stream++);
  return make_height_field(z, grid.dx, grid.dy);
}

HeightField gaussian_surface(const SyntheticGrid& grid, const GaussianField& field, std::uint64_t seed,
                             Border border) {
  return multiscale_surface(grid, {field}, seed, border);
}

std::vector<GaussianField> power_law_scales(const PowerLaw& law) {
  if (law.count < 1 || !(law.tau_min > 0) || !(law.tau_max >= law.tau_min) || !std::isfinite(law.tau_max))
    throw InputError("a power law needs at least one scale and 0 < tau-min ≤ tau-max");
  if (!(law.aspect > 0) || !std::isfinite(law.aspect) || !std::isfinite(law.hurst))
    throw InputError("the aspect must be positive, and the Hurst exponent a number");
  std::vector<GaussianField> scales;
  double variance = 0;
  for (int k = 0; k < law.count; ++k) {
    const double octave = law.count > 1 ? static_cast<double>(k) / (law.count - 1) : 0;
    const double ratio = std::pow(law.tau_max / law.tau_min, octave);
    GaussianField field{};
    field.rms = std::pow(ratio, law.hurst);
    field.tau_y = law.tau_min * ratio;
    field.tau_x = law.aspect * field.tau_y;
    field.orientation = law.orientation;
    variance += field.rms * field.rms;
    scales.push_back(field);
  }
  for (GaussianField& field : scales)
    field.rms *= law.rms / std::sqrt(variance);
  return scales;
}

}  // namespace micro
