#pragma once

#include <cstdint>
#include <vector>

namespace micro {

/// The Kaiser–Bessel kernel by which sources at arbitrary places are spread onto a regular grid before a fast
/// Fourier transform: K(t) = I₀(β√(1 − t²))/I₀(β) for |t| ≤ 1, in units of the half width, and zero beyond.
/// [Beatty05, "Rapid gridding reconstruction with a minimal oversampling ratio", Eq. 5] gives β for a width
/// in grid points and an oversampling σ; the error falls as exp(−π·width·√(1 − 1/σ)).
class GriddingKernel {
 public:
  /// `width` grid points of pitch `pitch` µm, ≥ 2; `oversampling` σ > 1.
  GriddingKernel(int width, double oversampling, double pitch);

  int width() const { return width_; }               ///< grid points
  double half_width() const { return half_width_; }  ///< µm
  double pitch() const { return pitch_; }            ///< µm
  struct Value {
    double k, slope;  ///< K and dK/dx in 1/µm
  };
  Value operator()(double x) const;  ///< at distance x in µm
  /// (1/pitch)·∫K e^{−iqx} dx: what a spread source's spectrum has been multiplied by, q in rad/µm.
  double spectrum(double q) const;

 private:
  int width_;
  double half_width_, pitch_, beta_, peak_;
};

/// For each grid point, the sources within reach of the kernel: a gather. Sources stand at (first +
/// step·l)·spacing. Every grid point has `taps` consecutive sources from `start`, with zero weights beyond
/// the kernel's reach.
template <typename Real>
struct GatherTable {
  int taps = 0;
  std::vector<std::int32_t> start;  ///< [grid points]
  std::vector<Real> value;          ///< [grid points, taps] K
  std::vector<Real> derivative;     ///< [grid points, taps] dK/dx at (grid point − source)
};

/// Gathers `sources` ≥ 1 sources at (offset + step·l)·spacing onto grid points begin … end−1 at m·pitch.
template <typename Real>
GatherTable<Real> make_gather(const GriddingKernel& kernel, double spacing, int offset, int step,
                              std::int64_t sources, std::int64_t begin, std::int64_t end);

/// For each source, the grid points within its reach: a scatter, for sources that are few.
template <typename Real>
struct ScatterTable {
  int taps = 0;
  std::vector<std::int32_t> start;  ///< [sources], relative to `begin`
  std::vector<Real> value;          ///< [sources, taps] K
  std::vector<Real> derivative;     ///< [sources, taps] dK/dx at (grid point − source)
};

template <typename Real>
ScatterTable<Real> make_scatter(const GriddingKernel& kernel, double spacing, std::int64_t sources,
                                std::int64_t begin, std::int64_t end);

/// K by cubic Hermite interpolation, to 1e-9, for points too many for its series; dK/dx is the interpolant's,
/// to 1e-6 of 1/half width.
class GriddingKernelTable {
 public:
  explicit GriddingKernelTable(const GriddingKernel& kernel);
  GriddingKernel::Value operator()(double x) const;  ///< at distance x in µm

 private:
  struct Entry {
    double k, slope;  ///< slope per entry
  };
  double half_width_, per_length_;
  std::vector<Entry> entries_;
};

}  // namespace micro
