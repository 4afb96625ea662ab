#include "kirchhoff/nested_terms.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace micro {
namespace {

/// Bounds on q_z, equidistant.
constexpr int kLevels = 16;

/// Sampled q_z, as many for each bound: closer than the coefficients' own oscillation. Bessel functions of an
/// order beyond their argument grow with it, so that the bounds alone tell of the tails of a Chebyshev
/// series.
int samples_per_level(const HeightBasis& basis) {
  return basis.orthonormal() ? 8 + basis.terms() / 4 : 1;
}

}  // namespace

NestedTerms::NestedTerms(const HeightBasis& basis, const WaveRange& q, double tolerance)
    : basis_(basis), q_(q) {
  if (basis.terms() == 0)
    needed_.assign(kLevels, 0);
  else if (basis.orthonormal())
    turn(tolerance);
  else
    count(tolerance);
}

void NestedTerms::turn(double tolerance) {
  const int terms = basis_.terms(), each = samples_per_level(basis_);
  const Grid<std::complex<double>> c = basis_.coefficients(kLevels * each + 1, 0, terms);
  turn_.resize(terms, 0);
  Eigen::MatrixXd rest = Eigen::MatrixXd::Identity(terms, terms);
  for (int level = 0; level < kLevels; ++level) {
    const int n = (level + 1) * each + 1;
    const Eigen::MatrixXd re = c.real().topRows(n).matrix() * rest, im = c.imag().topRows(n).matrix() * rest;
    // Ascending.
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(re.transpose() * re + im.transpose() * im);
    const double allowed = n * tolerance * tolerance;
    Eigen::Index spare = 0;
    for (double tail = 0; spare < rest.cols(); ++spare) {
      tail += std::max(0.0, eigen.eigenvalues()[spare]);
      if (tail > allowed) break;
    }
    const Eigen::MatrixXd turned = rest * eigen.eigenvectors();
    const Eigen::Index taken = rest.cols() - spare;
    turn_.conservativeResize(Eigen::NoChange, turn_.cols() + taken);
    turn_.rightCols(taken) = turned.rightCols(taken).rowwise().reverse();
    needed_.push_back(static_cast<int>(turn_.cols()));
    if (spare == 0) {
      needed_.resize(kLevels, terms);
      return;
    }
    rest = turned.leftCols(spare).eval();
  }
}

void NestedTerms::count(double tolerance) {
  const int terms = basis_.terms();
  const Grid<double> size = basis_.coefficients(kLevels + 1, 0, terms).abs();
  int needed = 0;
  for (int level = 0; level < kLevels; ++level) {
    int k = terms;
    for (double tail = 0; k > needed; --k) {
      tail += size(level + 1, k - 1);
      if (tail > tolerance) break;
    }
    needed_.push_back(needed = k);
  }
}

int NestedTerms::needed(double qz) const {
  const double width = q_.high - q_.low;
  const int level =
      width > 0 ? static_cast<int>(std::ceil((qz - q_.low) / width * kLevels * (1 - 1e-12))) - 1 : kLevels;
  return needed_[static_cast<std::size_t>(std::clamp(level, 0, kLevels - 1))];
}

HeightBasis::Functions NestedTerms::functions(int n, int first, int count) const {
  if (!basis_.orthonormal()) return basis_.functions(n, first, count);
  const HeightBasis::Functions f = basis_.functions(n, 0, basis_.terms());
  const auto v = turn_.middleCols(first, count);
  return {(f.value.matrix() * v).array(), (f.derivative.matrix() * v).array()};
}

Grid<std::complex<double>> NestedTerms::coefficients(int n, int first, int count) const {
  if (!basis_.orthonormal()) return basis_.coefficients(n, first, count);
  const Grid<std::complex<double>> c = basis_.coefficients(n, 0, basis_.terms());
  Grid<std::complex<double>> turned(n, count);
  const auto v = turn_.middleCols(first, count);
  turned.real() = (c.real().matrix() * v).array();
  turned.imag() = (c.imag().matrix() * v).array();
  return turned;
}

}  // namespace micro
