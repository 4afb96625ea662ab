#include "pipelines/thumbnail.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace micro {
namespace {

constexpr Rgb kMissingColour = {255, 210, 0};

std::uint8_t byte(double value) {
  return static_cast<std::uint8_t>(std::lrint(255 * std::clamp(value, 0., 1.)));
}

/// Black through violet, red and yellow to white, t in [0, 1]; lightness rises all the way.
Rgb heat(double t) {
  struct Stop {
    double r, g, b;
  };
  static constexpr std::array kStops = {Stop{0, 0, 0.02},       Stop{0.27, 0.06, 0.43},
                                        Stop{0.71, 0.19, 0.36}, Stop{0.96, 0.49, 0.13},
                                        Stop{0.99, 0.80, 0.30}, Stop{1, 1, 0.85}};
  const double x = std::clamp(t, 0., 1.) * (kStops.size() - 1);
  const auto k = std::min(static_cast<std::size_t>(x), kStops.size() - 2);
  const double u = x - static_cast<double>(k);
  const Stop &a = kStops[k], &b = kStops[k + 1];
  return {byte(a.r + u * (b.r - a.r)), byte(a.g + u * (b.g - a.g)), byte(a.b + u * (b.b - a.b))};
}

/// Points of the original that one point of the picture stands for.
Eigen::Index reduction(Eigen::Index rows, Eigen::Index cols) {
  return std::max<Eigen::Index>(1, (std::max(rows, cols) + kThumbnail - 1) / kThumbnail);
}

}  // namespace

Picture thumbnail_of(const HeightField& surface) {
  double sum = 0, square = 0;
  Eigen::Index valid = 0;
  for (const float z : surface.z.reshaped<Eigen::RowMajor>())
    if (!is_missing(z)) {
      sum += static_cast<double>(z);
      square += static_cast<double>(z) * static_cast<double>(z);
      ++valid;
    }
  const double n = static_cast<double>(std::max<Eigen::Index>(1, valid)), mean = sum / n;
  const double deviation = std::sqrt(std::max(0., square / n - mean * mean));
  const Eigen::Index step = reduction(surface.rows(), surface.cols());
  Picture picture((surface.rows() + step - 1) / step, (surface.cols() + step - 1) / step);
  for (Eigen::Index j = 0; j < picture.rows(); ++j)
    for (Eigen::Index i = 0; i < picture.cols(); ++i) {
      const float z = surface.z(j * step, i * step);
      const double scaled = deviation > 0 ? (static_cast<double>(z) - mean) / (5 * deviation) : 0;
      const std::uint8_t grey = byte(0.5 + scaled);
      picture(j, i) = is_missing(z) ? kMissingColour : Rgb{grey, grey, grey};
    }
  return picture;
}

namespace {

constexpr Rgb kOffDisk = {255, 255, 255};

/// A view of a table's values, coloured: fewer nodes than points are repeated, of more the value farthest
/// from zero in each block is shown.
template <typename Value, typename Colour>
Picture draw(const DiskGrid& grid, const DiskView& view, Value&& value, Colour&& colour) {
  const auto c = static_cast<Eigen::Index>(grid.centre());
  const Eigen::Index first = c - view.half, nodes = 2 * view.half + 1;
  const Eigen::Index step = reduction(nodes, nodes), zoom = std::max<Eigen::Index>(1, kThumbnail / nodes);
  const Eigen::Index blocks = (nodes + step - 1) / step;
  Grid<double> farthest = Grid<double>::Zero(blocks, blocks);
  Grid<bool> on_disk = Grid<bool>::Constant(blocks, blocks, false);
  for (Eigen::Index j = 0; j < nodes; ++j)
    for (Eigen::Index i = 0; i < nodes; ++i)
      if (grid.mz2(first + j, first + i) > 0) {
        double& block = farthest(j / step, i / step);
        const double here = value(first + j, first + i);
        if (std::abs(here) > std::abs(block)) block = here;
        on_disk(j / step, i / step) = true;
      }
  Picture picture(blocks * zoom, blocks * zoom);
  for (Eigen::Index j = 0; j < picture.rows(); ++j)
    for (Eigen::Index i = 0; i < picture.cols(); ++i)
      picture(j, i) = on_disk(j / zoom, i / zoom) ? colour(farthest(j / zoom, i / zoom)) : kOffDisk;
  return picture;
}

}  // namespace

DiskView view_of(const DiskTable& table) {
  constexpr double kEnergy = 0.999, kMargin = 1.2;
  const double spacing = table.grid.spacing();
  const auto half =
      std::clamp(static_cast<Eigen::Index>(std::ceil(kMargin * extent_holding(table, kEnergy) / spacing)),
                 Eigen::Index{1}, static_cast<Eigen::Index>(table.grid.centre()));
  return {half, static_cast<double>(half) * spacing, table.density.maxCoeff()};
}

Picture picture_of(const DiskTable& table, const DiskView& view) {
  constexpr double kDecades = 4;
  return draw(
      table.grid, view, [&](Eigen::Index j, Eigen::Index i) { return table.density(j, i); },
      [&](double d) { return heat(1 + (d > 0 ? std::log10(d / view.peak) : -kDecades) / kDecades); });
}

Picture difference_of(const DiskTable& a, const DiskTable& b, const DiskView& view) {
  constexpr double kFull = 0.2;
  return draw(
      a.grid, view, [&](Eigen::Index j, Eigen::Index i) { return a.density(j, i) - b.density(j, i); },
      [&](double d) -> Rgb {
        const double part = std::clamp(d / (kFull * view.peak), -1., 1.);
        const std::uint8_t faded = byte(1 - std::abs(part));
        return part > 0 ? Rgb{255, faded, faded} : Rgb{faded, faded, 255};
      });
}

}  // namespace micro
