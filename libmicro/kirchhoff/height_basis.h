#pragma once

#include <Eigen/Core>
#include <complex>

#include "core/grid.h"
#include "height/height_field.h"

namespace micro {

/// How often heights occur: a histogram of equal bins over [low, high], of sum 1.
struct HeightHistogram {
  double low = 0, high = 0;  ///< µm
  Eigen::ArrayXd mass;
};

/// The heights of the triangulated surface: vertices and, since steep facets hold what lies between, the
/// middles of diagonals. Throws nothing; a surface without heights has no mass.
HeightHistogram height_histogram(const HeightField& surface);

/// A range of q_z, rad/µm.
struct WaveRange {
  double low = 0, high = 0;
};

/// How large a HeightBasis is.
struct BasisSize {
  int terms = 0;
  double phase_reach = 0;  ///< largest q_z·|h − origin|, rad
  int waves = 0;           ///< q_z that ψ is sampled on where it is decomposed, else 0
  int decomposed = 0;      ///< rows of the matrix that is decomposed
  bool orthonormal() const { return waves > 0; }
};

/// ψ(h, q_z) = (e^{−i q_z h} − 1)/q_z ≈ Σ_k c_k(q_z) φ_k(h), φ_k real, c_k complex, over heights h − `origin`
/// within the histogram and q_z within the range. ψ is bounded by |h| and tends to −ih as q_z → 0.
///
/// Real functions of h are what makes it cheap: two of their images go through one complex Fourier transform,
/// and each image's spectrum is Hermitian. They come from a singular value decomposition of ψ sampled on
/// Chebyshev nodes, weighed by how often each height occurs: about (q range)·(height range)/π terms + O(log
/// 1/ε), fewer where heights cluster. Where both ranges are so wide that the decomposition itself would take
/// seconds, Jacobi–Anger takes its place, φ_k a Chebyshev polynomial: π/2·(q.high/(q range)) times as many
/// terms.
class HeightBasis {
 public:
  /// Keeps as many terms as it takes to bring the root mean square of ψ's error below `tolerance` µm.
  HeightBasis(const HeightHistogram& heights, double origin, const WaveRange& q, double tolerance);

  int terms() const { return size_.terms; }
  /// Whether the φ_k are orthonormal over the heights as they occur; else they are Chebyshev polynomials.
  bool orthonormal() const { return size_.orthonormal(); }
  /// Largest q_z·|h − origin|, rad: tables of c_k need steps well below 1/reach in units of q_z/q.high.
  double phase_reach() const { return size_.phase_reach; }
  const BasisSize& size() const { return size_; }

  /// [n, count] φ_k and [n, count] dφ_k/dx at n ≥ 2 equidistant heights from low to high; k = first …
  /// first+count−1; x counts heights (one step = 1).
  struct Functions {
    Grid<double> value, derivative;
  };
  Functions functions(int n, int first, int count) const;

  /// [n, count] c_k at q_z within the range.
  Grid<std::complex<double>> coefficients(const Eigen::ArrayXd& qz, int first, int count) const;
  /// The same at n ≥ 2 equidistant q_z from q.low to q.high.
  Grid<std::complex<double>> coefficients(int n, int first, int count) const;

 private:
  void decompose(const HeightHistogram& heights, double tolerance);
  void expand(double tolerance);
  Functions polynomials(int n, int first, int count) const;

  double centre_, half_, origin_;  ///< heights are centre ± half
  WaveRange q_;
  BasisSize size_;
  Eigen::ArrayXd waves_;          ///< [m] the Chebyshev nodes of q_z
  Eigen::MatrixXd combinations_;  ///< [2m, terms] φ_k(h) = Σ_j (Re ψ(h, q_j) C_jk + Im ψ(h, q_j) C_{m+j,k})
  Eigen::MatrixXd coefficient_series_re_, coefficient_series_im_;  ///< [m, terms] Chebyshev series of c_k
};

/// About how large a HeightBasis of origin 0 will be, without making one; up to a million terms.
BasisSize expected_basis(const HeightHistogram& heights, const WaveRange& q, double tolerance);

}  // namespace micro
