#include "kirchhoff/gauss_rule.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace micro {
namespace {

/// The n-point rule: eigenvalues of the Jacobi matrix and the squares of its eigenvectors' first components
/// [Golub69].
std::vector<GaussNode> gauss_legendre(int n) {
  const Eigen::VectorXd beside = Eigen::VectorXd::NullaryExpr(n - 1, [](Eigen::Index i) {
    const double k = static_cast<double>(i + 1);
    return k / std::sqrt(4 * k * k - 1);
  });
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> jacobi;
  jacobi.computeFromTridiagonal(Eigen::VectorXd::Zero(n), beside);
  std::vector<GaussNode> nodes;
  for (Eigen::Index k = 0; k < n; ++k) {
    const double first = jacobi.eigenvectors()(0, k);
    nodes.push_back({(1 + jacobi.eigenvalues()[k]) / 2, first * first});
  }
  return nodes;
}

}  // namespace

int gauss_points(double phase, double tolerance) {
  // Exact to degree 2n − 1; beyond a the Legendre series of e^{iat}, |t| ≤ 1, falls like Bessel functions.
  const double a = phase / 2, root = std::cbrt(a), digits = -std::log10(tolerance) - 5;
  constexpr double kMost = 1e9;
  return static_cast<int>(std::min(std::ceil((a + 3.8 * root + 4 + digits * (1.5 + 0.3 * root)) / 2), kMost));
}

GaussCut gauss_cut(double phase, double tolerance) {
  constexpr double kPanelPhase = 200, kMostPanels = 1e5;  // of metres
  const double panels = std::clamp(std::ceil(phase / kPanelPhase), 1., kMostPanels);
  const int wanted = gauss_points(std::min(phase / panels, kPanelPhase), tolerance);
  int order = 2;
  while (order < wanted)
    order += std::max(1, order / 8);
  return {static_cast<std::int64_t>(panels), order};
}

void GaussRules::fill(const GaussCut& cut, std::vector<GaussNode>& nodes) {
  const auto [rule, is_new] = rules_.try_emplace(cut.order);
  if (is_new) rule->second = gauss_legendre(cut.order);
  nodes.clear();
  const auto panels = static_cast<double>(cut.panels);
  for (double p = 0; p < panels; ++p)
    for (const GaussNode& node : rule->second)
      nodes.push_back({(p + node.t) / panels, node.weight / panels});
}

}  // namespace micro
