#include "height/autocorrelation.h"

#include <algorithm>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "core/fft.h"
#include "height/statistics.h"

namespace micro {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Circular autocorrelation Σ f(p) f(p + l) of the padded rows × cols of f, by the power spectrum.
void correlate_with_itself(const RealFft<double>& fft, FftVector<double>& f) {
  const FftShape& shape = fft.shape();
  FftVector<std::complex<double>> spectrum(static_cast<std::size_t>(shape.half_size()));
  fft.forward(f.data(), spectrum.data());
  for (auto& s : spectrum)
    s = std::norm(s) / static_cast<double>(shape.size());
  fft.backward(spectrum.data(), f.data());
}

/// ρ at a lag in grid units, bilinear; NaN outside.
double sample(const Autocorrelation& acf, double i, double j) {
  if (j < 0) i = -i, j = -j;
  const double reach = static_cast<double>(acf.zero);
  if (!(std::abs(i) <= reach && j <= static_cast<double>(acf.rho.rows() - 1))) return kNone;
  const auto cell = [](double t, Eigen::Index n) {
    const Eigen::Index at = std::min(static_cast<Eigen::Index>(t), std::max<Eigen::Index>(n - 2, 0));
    return std::pair(at, t - static_cast<double>(at));
  };
  const auto [col, u] = cell(i + reach, acf.rho.cols());
  const auto [row, v] = cell(j, acf.rho.rows());
  const auto mix = [](double t, double a, double b) { return t > 0 ? (1 - t) * a + t * b : a; };
  const auto along_row = [&acf, &mix, u = u, col = col](Eigen::Index r) {
    return mix(u, acf.rho(r, col), u > 0 ? acf.rho(r, col + 1) : 0.);
  };
  return mix(v, along_row(row), v > 0 ? along_row(row + 1) : 0.);
}

/// The lag at which ρ first falls below `level` along a direction, µm.
double decay_length(const Autocorrelation& acf, double direction, double level) {
  const double x = std::cos(direction), y = std::sin(direction);
  const double step = 0.5 * std::min(acf.dx, acf.dy);
  double before = 1;
  for (double r = step;; r += step) {
    // Rounding of cos(π/2) must not lead out of a surface of one column.
    const auto lag = [&](double c, double pitch) { return std::abs(c) < 1e-12 ? 0 : r * c / pitch; };
    const double rho = sample(acf, lag(x, acf.dx), lag(y, acf.dy));
    if (!std::isfinite(rho)) return kNone;
    if (rho < level) return r - step * (level - rho) / (before - rho);
    before = rho;
  }
}

/// Distances of the border of the connected region ρ ≥ level around lag 0: the crossings, linear between grid
/// points, of every grid line through it.
struct BorderDistances {
  double shortest = std::numeric_limits<double>::infinity();
  double longest = 0;
  bool reaches_end = false;  ///< the region leaves the lags at hand
};

BorderDistances border_of_region(const Autocorrelation& acf, double level) {
  const Eigen::Index rows = acf.rho.rows(), cols = acf.rho.cols();
  BorderDistances border;
  Grid<std::uint8_t> seen = Grid<std::uint8_t>::Zero(rows, cols);
  std::vector<std::pair<Eigen::Index, Eigen::Index>> queue = {{0, acf.zero}};
  seen(0, acf.zero) = 1;
  while (!queue.empty()) {
    const auto [j, i] = queue.back();
    queue.pop_back();
    for (const auto& [dj, di] : {std::pair{0, 1}, {0, -1}, {1, 0}, {-1, 0}}) {
      Eigen::Index jj = j + dj, ii = i + di;
      if (jj < 0) jj = -jj, ii = 2 * acf.zero - ii;  // the other half plane
      if (jj >= rows || ii < 0 || ii >= cols) {
        // A lag that the surface cannot have (one row, one column) is no end that could be reached.
        border.reaches_end = border.reaches_end || (di != 0 ? acf.zero > 0 : rows > 1);
        continue;
      }
      const double inside = acf.rho(j, i), outside = acf.rho(jj, ii);
      if (outside >= level) {
        if (!std::exchange(seen(jj, ii), 1)) queue.emplace_back(jj, ii);
        continue;
      }
      const double t = std::isfinite(outside) ? (inside - level) / (inside - outside) : 1;
      const double x = (static_cast<double>(i - acf.zero) + t * di) * acf.dx;
      const double y = (static_cast<double>(j) + t * dj) * acf.dy;
      border.shortest = std::min(border.shortest, std::hypot(x, y));
      border.longest = std::max(border.longest, std::hypot(x, y));
    }
  }
  return border;
}

}  // namespace

Autocorrelation autocorrelation(const HeightField& surface) {
  const Eigen::Index rows = surface.rows(), cols = surface.cols();
  const Eigen::Index far_j = rows / 2, far_i = cols / 2;
  Autocorrelation acf{Grid<double>::Constant(far_j + 1, 2 * far_i + 1, kNone), far_i, surface.dx, surface.dy};
  const HeightRange range = height_range(surface);
  if (!(range.rms > 0)) return acf;
  const double offset = range.mean - surface.mean;

  // Zeros after the surface keep the lags at hand from wrapping around.
  const FftShape shape{fast_fft_size(rows + far_j), fast_fft_size(cols + far_i)};
  const auto at = [&](Eigen::Index j, Eigen::Index i) {
    return static_cast<std::size_t>((j < 0 ? j + shape.rows : j) * shape.cols + (i < 0 ? i + shape.cols : i));
  };
  const RealFft<double> fft(shape);
  FftVector<double> products(static_cast<std::size_t>(shape.size()), 0.), pairs;
  const bool complete = missing_count(surface) == 0;
  if (!complete) pairs.assign(products.size(), 0.);
  for (Eigen::Index j = 0; j < rows; ++j)
    for (Eigen::Index i = 0; i < cols; ++i) {
      if (is_missing(surface.z(j, i))) continue;
      products[at(j, i)] = (surface.z(j, i) - offset) / range.rms;
      if (!complete) pairs[at(j, i)] = 1;
    }
  correlate_with_itself(fft, products);
  if (!complete) correlate_with_itself(fft, pairs);
  for (Eigen::Index j = 0; j <= far_j; ++j)
    for (Eigen::Index i = -far_i; i <= far_i; ++i) {
      const double n =
          complete ? static_cast<double>((rows - j) * (cols - std::abs(i))) : std::round(pairs[at(j, i)]);
      if (n > 0) acf.rho(j, far_i + i) = products[at(j, i)] / n;
    }
  return acf;
}

CorrelationLengths correlation_lengths(const Autocorrelation& acf, double direction) {
  if (acf.rho.size() == 0 || !std::isfinite(acf.rho(0, acf.zero))) return {kNone, kNone, kNone, kNone};
  constexpr double kDecay = 0.2;  // the default s of ISO 25178-2
  const BorderDistances border = border_of_region(acf, kDecay);
  const double along = std::isnan(direction) ? 0 : direction;
  CorrelationLengths lengths{};
  lengths.Sal = std::isfinite(border.shortest) ? border.shortest : kNone;
  const bool profile = acf.rho.rows() == 1 || acf.zero == 0;  // one row or column has one direction
  lengths.Str = border.reaches_end || profile ? kNone : border.shortest / border.longest;
  lengths.along = decay_length(acf, along, 1 / std::numbers::e);
  lengths.across = decay_length(acf, along + std::numbers::pi / 2, 1 / std::numbers::e);
  return lengths;
}

}  // namespace micro
