#pragma once

#include <vector>

#include "kirchhoff/height_basis.h"

namespace micro {

/// The terms of a HeightBasis turned so that the first of them serve small q_z already, the next larger ones,
/// and so on: one set of images φ_k(h) for all |q| up to the largest, of which each q_z takes as many as it
/// needs.
///
/// ψ = Σ_k c_k φ_k = Σ_l (Σ_k V_kl c_k)(Σ_k V_kl φ_k) for any orthogonal V. For one bound on q_z after the
/// other, those directions in the space of the c_k are taken that hold their energy below that bound, from
/// what earlier bounds have left (an eigenvalue problem as large as there are terms). Chebyshev polynomials
/// come in that order by themselves: J_k(x) is tiny for k > x.
class NestedTerms {
 public:
  /// `q`: the basis's range. Leaves a root mean square error of ψ of `tolerance` µm below every bound.
  NestedTerms(const HeightBasis& basis, const WaveRange& q, double tolerance);

  /// Terms that q_z takes; grows with q_z.
  int needed(double qz) const;
  /// Terms that the largest q_z takes.
  int terms() const { return needed_.back(); }

  /// As HeightBasis's, of the turned terms.
  HeightBasis::Functions functions(int n, int first, int count) const;
  Grid<std::complex<double>> coefficients(int n, int first, int count) const;

 private:
  void turn(double tolerance);
  void count(double tolerance);

  const HeightBasis& basis_;
  WaveRange q_;
  Eigen::MatrixXd turn_;     ///< [basis terms, terms] V
  std::vector<int> needed_;  ///< for each bound
};

}  // namespace micro
