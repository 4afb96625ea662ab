#include "pipelines/texture_picture.h"

#include <algorithm>
#include <cmath>

#include "pipelines/lettering.h"

namespace micro {
namespace {

constexpr Eigen::Index kSide = 256, kMargin = 12, kLabel = 14;
constexpr Rgb kPaper = {255, 255, 255}, kGap = {214, 226, 245};

Rgb grey(double value, double mean, double deviation) {
  if (std::isnan(value)) return kGap;
  const double z = deviation > 0 ? (value - mean) / deviation : 0;
  const auto level = static_cast<std::uint8_t>(std::lround(std::clamp((z / 2.5 + 1) / 2, 0., 1.) * 255));
  return {level, level, level};
}

/// The first texels of a grid, each drawn `scale` points wide, as far as they fit the square.
template <typename Values>
void place(Picture& sheet, Eigen::Index row, Eigen::Index col, const Values& values, Eigen::Index scale,
           double mean, double deviation) {
  for (Eigen::Index j = 0; j < std::min(kSide, values.rows() * scale); ++j)
    for (Eigen::Index i = 0; i < std::min(kSide, values.cols() * scale); ++i)
      sheet(row + j, col + i) = grey(static_cast<double>(values(j / scale, i / scale)), mean, deviation);
}

}  // namespace

Picture texture_picture(const Exemplar& exemplar, const TextureField& field) {
  const ExemplarMoments moments = moments_of(exemplar);
  const Eigen::Index longest = std::max(exemplar.rows(), exemplar.cols());
  const Eigen::Index scale = std::clamp<Eigen::Index>(kSide / std::max<Eigen::Index>(1, longest), 1, 8);
  Picture sheet =
      Picture::Constant(2 * (kSide + kLabel) + 3 * kMargin, kChannels * (kSide + kMargin) + kMargin, kPaper);
  for (std::size_t c = 0; c < kChannels; ++c) {
    const auto k = static_cast<Eigen::Index>(c);
    const double mean = moments.mean[c], deviation = std::sqrt(moments.covariance(k, k));
    const Eigen::Index col = kMargin + k * (kSide + kMargin), below = 2 * kMargin + kSide + kLabel;
    const std::string name = kSlopeCoordinateNames[c];
    draw_text(sheet, kMargin, col, kSide, name + ": measured");
    place(sheet, kMargin + kLabel, col, exemplar.channels[c], scale, mean, deviation);
    draw_text(sheet, below, col, kSide, name + ": synthesised");
    place(sheet, below + kLabel, col, field[c], scale, mean, deviation);
  }
  return sheet;
}

}  // namespace micro
