#include "kirchhoff/height_basis.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/large_pages.h"
#include "core/parallel.h"

namespace micro {
namespace {

using Complex = std::complex<double>;

/// ψ(h, q) = (e^{−iqh} − 1)/q, −ih at q = 0: by half angles, free of cancellation.
Complex psi(double h, double q) {
  const double half = q * h / 2;
  const double sinc = std::abs(half) < 1e-8 ? 1 : std::sin(half) / half;
  return Complex(0, -h) * sinc * std::polar(1.0, -half);
}

/// n Chebyshev nodes of the first kind in (−1, 1).
Eigen::ArrayXd chebyshev_nodes(int n) {
  return Eigen::ArrayXd::NullaryExpr(
      n, [n](Eigen::Index i) { return std::cos(std::numbers::pi * (static_cast<double>(i) + 0.5) / n); });
}

/// [degree, n] from values at n nodes to Chebyshev coefficients.
Eigen::MatrixXd chebyshev_transform(int n) {
  return Eigen::MatrixXd::NullaryExpr(n, n, [n](Eigen::Index k, Eigen::Index i) {
    return (k == 0 ? 1.0 : 2.0) / n *
           std::cos(std::numbers::pi * static_cast<double>(k) * (static_cast<double>(i) + 0.5) / n);
  });
}

/// [points, degree] T_k at points of [−1, 1].
Eigen::MatrixXd chebyshev_values(const Eigen::ArrayXd& x, Eigen::Index degree) {
  Eigen::MatrixXd t(x.size(), degree);
  t.col(0).setOnes();
  if (degree > 1) t.col(1) = x;
  for (Eigen::Index k = 2; k < degree; ++k)
    t.col(k) = 2 * x * t.col(k - 1).array() - t.col(k - 2).array();
  return t;
}

/// Degrees that resolve a phase of ±`phase` radians over [−1, 1] to double precision.
int resolving_degree(double phase) {
  constexpr double kMost = 1e9;
  return static_cast<int>(std::min(std::ceil(phase + 6 * std::cbrt(phase) + 18), kMost));
}

/// Chebyshev nodes of h and of q_z that ψ is sampled on.
struct SampleSize {
  int heights, waves;
};

/// `farthest`: the largest |h − origin|.
SampleSize sample_size(double half_range, double farthest, const WaveRange& q) {
  return {resolving_degree(q.high * half_range), resolving_degree((q.high - q.low) / 2 * farthest)};
}

/// Whether the samples' decomposition, a cube of the smaller side, is a matter of tenths of a second, and
/// tables of φ_k over all heights one of 200 MB (heights of ±0.6 mm in the visible).
bool decomposable(const SampleSize& size) {
  constexpr int kMostDegree = 320, kMostHeights = 30000;
  return std::min(size.heights, size.waves > kMostDegree ? size.waves : 2 * size.waves) <= kMostDegree &&
         size.heights <= kMostHeights;
}

/// All but the terms.
BasisSize size_of(double half_range, double farthest, const WaveRange& q) {
  BasisSize size;
  size.phase_reach = q.high * farthest;
  const SampleSize samples = sample_size(half_range, farthest, q);
  if (!decomposable(samples)) return size;
  size.waves = samples.waves;
  size.decomposed = std::min(samples.heights, 2 * samples.waves);
  return size;
}

/// [n] how often heights near each Chebyshev node occur; nodes descend. A height between nodes sees the nodes
/// j away by 1/j, so that is how far their errors may go: weights fall as 1/j² beside it.
Eigen::ArrayXd node_weights(const HeightHistogram& heights, int n) {
  // A height that the histogram's sample missed still has to come out: a floor under the weights.
  constexpr double kFloor = 1e-3;
  Eigen::ArrayXd weight = Eigen::ArrayXd::Constant(n, kFloor / n);
  const Eigen::ArrayXd index = Eigen::ArrayXd::LinSpaced(n, 0.5, n - 0.5);
  for (Eigen::Index b = 0; b < heights.mass.size(); ++b) {
    if (heights.mass[b] == 0) continue;
    const double position = 2 * (static_cast<double>(b) + 0.5) / static_cast<double>(heights.mass.size()) - 1;
    const double nearest = std::acos(std::clamp(position, -1.0, 1.0)) / std::numbers::pi * n;
    const Eigen::ArrayXd share = 1 / (1 + 4 * (index - nearest).square());
    weight += heights.mass[b] / share.sum() * share;
  }
  return weight;
}

/// A table for somebody to fill in. Millions of numbers come in small pages more slowly than they are
/// computed.
template <typename T>
Grid<T> large_table(Eigen::Index rows, Eigen::Index cols) {
  Grid<T> table(rows, cols);
  prefer_large_pages(table.data(), sizeof(T) * static_cast<std::size_t>(table.size()));
  return table;
}

/// J_0(x) … J_{n−1}(x), x ≥ 0, by Miller's downward recurrence [NIST DLMF §3.6(v)], normalised by J_0 +
/// 2ΣJ_2k = 1.
std::vector<double> bessel_series(double x, int n) {
  std::vector<double> j(static_cast<std::size_t>(n), 0);
  if (x < 1e-12) {
    j[0] = 1;
    if (n > 1) j[1] = x / 2;
    return j;
  }
  const int start = 2 * ((std::max(n, resolving_degree(x)) + 30) / 2);
  double above = 0, here = 1e-280, sum = 0;
  const double slope = 2 / x;
  for (int k = start; k >= 0; --k) {  // here = J_k, above = J_{k+1}
    if (k < n) j[k] = here;
    sum += (k == 0 ? 1 : k % 2 == 0 ? 2 : 0) * here;
    const double below = slope * k * here - above;
    above = here;
    here = below;
    if (std::abs(here) > 1e200) {
      for (int i = k; i < n; ++i)
        j[i] *= 1e-200;
      here *= 1e-200;
      above *= 1e-200;
      sum *= 1e-200;
    }
  }
  for (double& value : j)
    value /= sum;
  return j;
}

}  // namespace

HeightHistogram height_histogram(const HeightField& surface) {
  constexpr int kBins = 512;
  constexpr Eigen::Index kSamples = 60000;
  HeightHistogram histogram{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
                            Eigen::ArrayXd::Zero(kBins)};
  for (const float z : surface.z.reshaped<Eigen::RowMajor>())
    if (!is_missing(z)) {
      histogram.low = std::min<double>(histogram.low, z);
      histogram.high = std::max<double>(histogram.high, z);
    }
  if (!(histogram.low <= histogram.high)) return {0, 0, Eigen::ArrayXd::Zero(kBins)};
  const double scale = histogram.high > histogram.low ? (kBins - 1e-6) / (histogram.high - histogram.low) : 0;
  const Eigen::Index step = std::max<Eigen::Index>(1, surface.rows() * surface.cols() / kSamples);
  for (Eigen::Index j = 0; j + 1 < surface.rows(); ++j)
    for (Eigen::Index i = j % step; i + 1 < surface.cols(); i += step) {
      const float z = surface.z(j, i), middle = (z + surface.z(j + 1, i + 1)) / 2;
      for (const float value : {z, middle})
        if (!is_missing(value))
          histogram.mass[static_cast<Eigen::Index>((value - histogram.low) * scale)] += 1;
    }
  const double total = histogram.mass.sum();
  if (total > 0) histogram.mass /= total;
  return histogram;
}

HeightBasis::HeightBasis(const HeightHistogram& heights, double origin, const WaveRange& q, double tolerance)
    : centre_((heights.high + heights.low) / 2),
      half_((heights.high - heights.low) / 2),
      origin_(origin),
      q_(q),
      size_(size_of(half_, half_ + std::abs(centre_ - origin), q)) {
  if (orthonormal())
    decompose(heights, tolerance);
  else
    expand(tolerance);
}

void HeightBasis::decompose(const HeightHistogram& heights, double tolerance) {
  const SampleSize size = sample_size(half_, half_ + std::abs(centre_ - origin_), q_);
  const int n = size.heights, m = size.waves;
  const Eigen::ArrayXd x = chebyshev_nodes(n), weight = node_weights(heights, n).sqrt();
  waves_ = (q_.high + q_.low) / 2 + (q_.high - q_.low) / 2 * chebyshev_nodes(m);
  Eigen::MatrixXd samples(n, 2 * m);
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < m; ++k) {
      const Complex value = psi(centre_ + half_ * x[i] - origin_, waves_[k]);
      samples(i, k) = weight[i] * value.real();
      samples(i, m + k) = weight[i] * value.imag();
    }
  // The squares of the singular values: half the digits, which is 1e-8 of the largest. Of the two products
  // the smaller one.
  const bool fewer_heights = n <= 2 * m;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
      fewer_heights ? Eigen::MatrixXd(samples * samples.transpose())
                    : Eigen::MatrixXd(samples.transpose() * samples));  // ascending
  const Eigen::ArrayXd squares = eigen.eigenvalues().array().max(0);
  const double allowed = m * tolerance * tolerance;
  double tail = 0;
  size_.terms = static_cast<int>(squares.size());
  while (size_.terms > 0 && tail + squares[squares.size() - size_.terms] <= allowed) {
    tail += squares[squares.size() - size_.terms];
    --size_.terms;
  }
  const Eigen::MatrixXd vectors = eigen.eigenvectors().rightCols(size_.terms).rowwise().reverse();
  // [2m, terms] right singular vectors times singular values
  const Eigen::MatrixXd scaled =
      fewer_heights ? Eigen::MatrixXd(samples.transpose() * vectors)
                    : Eigen::MatrixXd(vectors * (samples * vectors).colwise().norm().asDiagonal());
  const Eigen::ArrayXd norms2 = scaled.colwise().squaredNorm().transpose().array().max(1e-300);
  combinations_ = scaled * norms2.inverse().matrix().asDiagonal();
  coefficient_series_re_ = chebyshev_transform(m) * scaled.topRows(m);
  coefficient_series_im_ = chebyshev_transform(m) * scaled.bottomRows(m);
}

void HeightBasis::expand(double tolerance) {
  const double phase = q_.high * half_;
  const int all = resolving_degree(phase);
  // Heights of decimetres: nobody sums so many terms.
  constexpr double kMostPhase = 1e6;
  if (phase > kMostPhase) {
    size_.terms = all;
    return;
  }
  const std::vector<double> j = bessel_series(phase, all);
  size_.terms = all;
  double tail = 0;
  while (size_.terms > static_cast<int>(phase) &&
         tail + 2 * std::abs(j[size_.terms - 1]) <= tolerance * q_.high) {
    tail += 2 * std::abs(j[size_.terms - 1]);
    --size_.terms;
  }
}

HeightBasis::Functions HeightBasis::functions(int n, int first, int count) const {
  if (!orthonormal()) return polynomials(n, first, count);
  constexpr std::int64_t kBlock = 128;  // ψ and its slope at so many heights at a time
  const double step = 2 * half_ / (n - 1), low = centre_ - half_ - origin_;
  const Eigen::Index m = waves_.size();
  const auto combinations = combinations_.middleCols(first, count);
  Functions f{large_table<double>(n, count), large_table<double>(n, count)};
  parallel_blocks(n, kBlock, [&](std::int64_t begin, std::int64_t end) {
    const Eigen::Index rows = end - begin;
    Eigen::MatrixXd value(rows, 2 * m), slope(rows, 2 * m);
    for (Eigen::Index k = 0; k < m; ++k) {
      const double q = waves_[k];
      const Complex turn = std::polar(1.0, q * step / 2);
      Complex half = std::polar(1.0, q * (low + step * static_cast<double>(begin)) / 2);  // e^{iqh/2}
      for (Eigen::Index e = 0; e < rows; ++e, half *= turn) {
        const double c = half.real(), s = half.imag();
        value(e, k) = -2 * s * s / q;
        value(e, m + k) = -2 * s * c / q;
        slope(e, k) = -2 * s * c * step;
        slope(e, m + k) = (s * s - c * c) * step;
      }
    }
    f.value.middleRows(begin, rows) = (value * combinations).array();
    f.derivative.middleRows(begin, rows) = (slope * combinations).array();
  });
  return f;
}

HeightBasis::Functions HeightBasis::polynomials(int n, int first, int count) const {
  const double step = 2.0 / (n - 1);
  Functions f{large_table<double>(n, count), large_table<double>(n, count)};
  parallel_blocks(n, 256, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t e = begin; e < end; ++e) {
      const double angle = std::acos(std::clamp(-1 + step * static_cast<double>(e), -1.0, 1.0)),
                   sine = std::sin(angle);
      const Complex turn = std::polar(1.0, angle);
      Complex at = std::polar(1.0, first * angle);  // e^{ikθ}, T_k(cos θ) = cos kθ
      for (int c = 0; c < count; ++c, at *= turn) {
        const double k = first + c;
        const double end_slope = e == 0 && (first + c) % 2 == 0 ? -k * k : k * k;
        f.value(e, c) = at.real();
        f.derivative(e, c) = step * (e == 0 || e == n - 1 ? end_slope : k * at.imag() / sine);
      }
    }
  });
  return f;
}

Grid<Complex> HeightBasis::coefficients(const Eigen::ArrayXd& qz, int first, int count) const {
  const Eigen::Index n = qz.size();
  auto c = large_table<Complex>(n, count);
  if (orthonormal()) {
    const double middle = (q_.high + q_.low) / 2, half = std::max((q_.high - q_.low) / 2, 1e-300);
    const Eigen::MatrixXd t =
        chebyshev_values(((qz - middle) / half).max(-1).min(1), coefficient_series_re_.rows());
    c.real() = (t * coefficient_series_re_.middleCols(first, count)).array();
    c.imag() = (t * coefficient_series_im_.middleCols(first, count)).array();
    return c;
  }
  // e^{−iq(d + half·x)} = e^{−iqd} Σ_k (2 − δ_k0)(−i)^k J_k(q·half) T_k(x), d = centre − origin.
  const Complex powers[4] = {1.0, {0, -1}, -1.0, {0, 1}};
  parallel_blocks(n, 256, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t e = begin; e < end; ++e) {
      const double q = std::max(qz[e], 1e-7 * q_.high);
      const std::vector<double> j = bessel_series(q * half_, first + count);
      const Complex shift = std::polar(1.0, -q * (centre_ - origin_));
      for (int k = 0; k < count; ++k) {
        const Complex series = (first + k == 0 ? 1.0 : 2.0) * powers[(first + k) % 4] * j[first + k] * shift;
        c(e, k) = (series - (first + k == 0 ? 1.0 : 0.0)) / q;
      }
    }
  });
  return c;
}

Grid<Complex> HeightBasis::coefficients(int n, int first, int count) const {
  return coefficients(Eigen::ArrayXd::LinSpaced(n, q_.low, q_.high), first, count);
}

BasisSize expected_basis(const HeightHistogram& heights, const WaveRange& q, double tolerance) {
  constexpr double kMostTerms = 1e6;
  const double half = (heights.high - heights.low) / 2;
  BasisSize size = size_of(half, std::max(std::abs(heights.low), std::abs(heights.high)), q);
  const double terms = size.orthonormal()
                           ? (q.high - q.low) * 2 * half / std::numbers::pi - 0.7 * std::log(tolerance)
                           : q.high * half - 2 * std::log(tolerance);
  size.terms = std::max(1, static_cast<int>(std::min(terms, kMostTerms)));
  return size;
}

}  // namespace micro
