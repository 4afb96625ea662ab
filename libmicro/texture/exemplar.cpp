#include "texture/exemplar.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "core/error.h"

namespace micro {

Exemplar make_exemplar(Eigen::Index rows, Eigen::Index cols) {
  Exemplar exemplar;
  exemplar.channels.fill(Grid<double>::Constant(rows, cols, std::numeric_limits<double>::quiet_NaN()));
  return exemplar;
}

ExemplarMoments moments_of(const Exemplar& exemplar) {
  using Vector = Eigen::Matrix<double, 5, 1>;
  ExemplarMoments moments;
  const auto over_texels = [&](auto&& body) {
    for (Eigen::Index j = 0; j < exemplar.rows(); ++j)
      for (Eigen::Index i = 0; i < exemplar.cols(); ++i)
        if (exemplar.there(j, i)) {
          Vector p;
          for (std::size_t c = 0; c < kChannels; ++c)
            p[static_cast<Eigen::Index>(c)] = exemplar.channels[c](j, i);
          body(p);
        }
  };
  // From the first texel on, so that what is constant has no variance at all.
  Vector first = Vector::Zero(), sum = Vector::Zero();
  over_texels([&](const Vector& p) {
    if (moments.count++ == 0) first = p;
    sum += p - first;
  });
  if (moments.count == 0) return moments;
  const auto n = static_cast<double>(moments.count);
  const Vector mean = first + sum / n;
  over_texels([&](const Vector& p) { moments.covariance += (p - mean) * (p - mean).transpose() / n; });
  Eigen::Map<Vector>(moments.mean.data()) = mean;
  return moments;
}

namespace {

bool form_block(Eigen::Index rows, Eigen::Index cols, std::int64_t there) {
  return rows > 1 && cols > 1 && static_cast<double>(there) >= static_cast<double>(rows * cols) / 2;
}

}  // namespace

bool is_block(const Exemplar& exemplar) {
  return form_block(exemplar.rows(), exemplar.cols(), moments_of(exemplar).count);
}

void require_block(Eigen::Index rows, Eigen::Index cols, std::int64_t there) {
  if (!form_block(rows, cols, there))
    throw InputError(
        "the full spectrum needs a block of texels, at least 2 x 2 and half of it there, not strips");
}

Eigen::ArrayXd taper_weights(Eigen::Index n, Taper taper) {
  if (taper == Taper::None || n < kLeastTapered) return Eigen::ArrayXd::Ones(n);
  const auto length = static_cast<double>(n);
  return (std::numbers::pi / length * Eigen::ArrayXd::LinSpaced(n, 0.5, length - 0.5)).sin().square();
}

Eigen::ArrayXd strip_deviations(const Eigen::ArrayXd& values, double mean, Taper taper) {
  return values.isNaN().select(0., taper_weights(values.size(), taper) * (values - mean));
}

}  // namespace micro
