#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

#include "fit/normal_equations.h"
#include "pipelines/texels.h"

namespace micro {
namespace {

Vector5 vector_of(const SlopeCoordinates& p) {
  return Eigen::Map<const Vector5>(p.data());
}

/// Covariance of slope coordinates from that of a step of the frame, by central differences.
Matrix5 coordinate_covariance(const SlopeFrame& frame, const Matrix5& step_covariance) {
  constexpr double kStep = 1e-4;  // widths
  Matrix5 jacobian;
  for (int k = 0; k < 5; ++k) {
    const Vector5 step = kStep * Vector5::Unit(k);
    jacobian.col(k) = (vector_of(slope_coordinates(moved(frame, step))) -
                       vector_of(slope_coordinates(moved(frame, -step)))) /
                      (2 * kStep);
  }
  return jacobian * step_covariance * jacobian.transpose();
}

/// What texels are usually like: their mean, the covariance between them less that of their errors, and the
/// covariance of the step that one independent normal would leave: in a lobe's own widths, of which wide and
/// narrow ones err by as many.
struct Usual {
  Vector5 mean = Vector5::Zero();
  Matrix5 between = Matrix5::Zero(), one_normal = Matrix5::Zero();
  std::int64_t texels = 0;

  Matrix5 error_of(const Texel& texel) const {
    return coordinate_covariance(texel.fit.frame, one_normal / std::max(texel.independent, 1e-3));
  }
};

/// Whether a texel's scatter tells how much texels err: not where a lobe is narrower than what resolves it.
bool tells_errors(const Texel& texel) {
  return texel.fit.status == FitStatus::Converged &&
         (texel.fit.step_covariance.diagonal().array() <= 1).all();  // squared widths
}

Usual usual(const Texels& texels, double enough) {
  Usual usual;
  std::vector<const Texel*> known;
  std::int64_t telling = 0;
  for (std::size_t k = 0; k < texels.texels.size(); ++k) {
    const Texel& texel = texels.texels[k];
    if (texels.states[k] == TexelState::Gap || texel.independent < enough ||
        !texel.fit.step_covariance.allFinite())
      continue;
    known.push_back(&texel);
    usual.mean += vector_of(slope_coordinates(texel.fit.frame));
    if (!tells_errors(texel)) continue;
    usual.one_normal += texel.fit.step_covariance * texel.independent;
    ++telling;
  }
  usual.texels = telling > 0 ? static_cast<std::int64_t>(known.size()) : 0;
  if (usual.texels < 2) return usual;
  const auto n = static_cast<double>(usual.texels);
  usual.mean /= n;
  usual.one_normal /= static_cast<double>(telling);
  Matrix5 error = Matrix5::Zero();
  for (const Texel* texel : known) {
    const Vector5 away = vector_of(slope_coordinates(texel->fit.frame)) - usual.mean;
    usual.between += away * away.transpose() / (n - 1);
    error += usual.error_of(*texel) / n;
  }
  const Eigen::SelfAdjointEigenSolver<Matrix5> solver(Matrix5(usual.between - error));
  usual.between = solver.eigenvectors() * solver.eigenvalues().cwiseMax(0).asDiagonal() *
                  solver.eigenvectors().transpose();
  return usual;
}

}  // namespace

void shrink_few(Texels& texels, double enough) {
  constexpr std::int64_t kTell = 10;  // texels that say what is usual
  std::vector<std::size_t> few;
  for (std::size_t k = 0; k < texels.texels.size(); ++k)
    if (texels.states[k] != TexelState::Gap && texels.texels[k].independent < enough) few.push_back(k);
  const std::string limit = std::to_string(std::lround(enough)) + " independent normals";
  if (few.empty()) {
    texels.plan.push_back(left_out("shrinkage", "every texel has " + limit + " or more"));
    return;
  }
  const std::string those =
      counted(static_cast<std::int64_t>(few.size()), "texel") + " of fewer than " + limit;
  Usual known = usual(texels, enough);
  // Where all are poor, the set as a whole still tells what is usual.
  if (known.texels < kTell) known = usual(texels, 0);
  if (known.texels < kTell) {
    for (const std::size_t k : few)
      texels.states[k] = TexelState::Few;
    texels.plan.push_back(left_out("shrinkage", those + ", but too few texels to tell what is usual"));
    return;
  }
  for (const std::size_t k : few) {
    Texel& texel = texels.texels[k];
    const Matrix5 error = known.error_of(texel);
    const Vector5 away = vector_of(slope_coordinates(texel.fit.frame)) - known.mean;
    // The ridge is for directions in which nothing varies and nothing errs.
    const double ridge = 1e-12 * (known.between + error).trace() + 1e-300;
    const Matrix5 whole = known.between + error + ridge * Matrix5::Identity();
    const Vector5 drawn = known.mean + known.between * whole.ldlt().solve(away);
    if (!drawn.allFinite()) continue;
    SlopeCoordinates p;
    Eigen::Map<Vector5>(p.data()) = drawn;
    texel.fit.frame = frame_of(p);
    texel.fit.parameters = canonical_parameters(texel.fit.frame);
    texel.slopes.clear();  // it was drawn in the frame that was fitted
    texels.states[k] = TexelState::Shrunk;
  }
  texels.plan.push_back(ran("shrinkage", those + " drawn towards the mean"));
}

}  // namespace micro
