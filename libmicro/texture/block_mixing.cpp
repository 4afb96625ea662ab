#include "texture/block_mixing.h"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace micro {
namespace {

/// f of a symmetric matrix, by its eigenvalues.
template <typename Function>
Covariance of_eigenvalues(const Covariance& matrix, const Function& f) {
  const Eigen::SelfAdjointEigenSolver<Covariance> solver(matrix);
  return solver.eigenvectors() * solver.eigenvalues().unaryExpr(f).asDiagonal() *
         solver.eigenvectors().transpose();
}

}  // namespace

std::array<Grid<double>, kChannels> mixed_block(const std::array<Grid<double>, kChannels>& block,
                                                const Covariance& correlation) {
  constexpr double kNoDirection = 1e-10;
  std::array<double, kChannels> scale{};
  for (std::size_t c = 0; c < kChannels; ++c)
    scale[c] = std::sqrt(block[c].square().sum());
  Covariance found = Covariance::Identity(), wanted = Covariance::Identity();
  for (std::size_t c = 0; c < kChannels; ++c)
    for (std::size_t d = 0; d < kChannels; ++d)
      if (c != d && scale[c] > 0 && scale[d] > 0) {
        const auto k = static_cast<Eigen::Index>(c), l = static_cast<Eigen::Index>(d);
        found(k, l) = (block[c] * block[d]).sum() / (scale[c] * scale[d]);
        wanted(k, l) = correlation(k, l);
      }
  const Covariance root = of_eigenvalues(wanted, [](double x) { return std::sqrt(std::max(0., x)); });
  const Covariance mixing =
      root *
      of_eigenvalues(root * found * root, [](double x) { return x > kNoDirection ? 1 / std::sqrt(x) : 0; }) *
      root;
  std::array<Grid<double>, kChannels> mixed;
  for (std::size_t c = 0; c < kChannels; ++c) {
    mixed[c] = Grid<double>::Zero(block[c].rows(), block[c].cols());
    for (std::size_t d = 0; d < kChannels; ++d)
      if (scale[d] > 0)
        mixed[c] += mixing(static_cast<Eigen::Index>(c), static_cast<Eigen::Index>(d)) * scale[c] / scale[d] *
                    block[d];
  }
  return mixed;
}

}  // namespace micro
