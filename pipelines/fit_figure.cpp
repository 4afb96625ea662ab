#include "pipelines/fit_figure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <optional>
#include <sstream>
#include <utility>

#include "distribution/beckmann.h"
#include "distribution/ellipsoid.h"
#include "distribution/tabulate.h"
#include "pipelines/lettering.h"
#include "pipelines/plot.h"
#include "pipelines/thumbnail.h"

namespace micro {
namespace {

constexpr Rgb kPaper = {255, 255, 255};
constexpr Rgb kData = {120, 120, 120}, kEllipsoid = {200, 30, 40}, kBeckmann = {40, 90, 200};
constexpr Eigen::Index kMargin = 12, kLabel = 14, kPlotHeight = 240;
constexpr double kDecades = 4, kHeadroom = 10;  // above the peak stands the legend

/// The fit of one model to one method, if there is one with numbers.
const Fit* fit_of(const NdfFits& fits, const std::string& method, FitModel model) {
  for (const NdfFit& fit : fits.fits)
    if (fit.method == method && fit.fit.model == model && std::isfinite(fit.fit.frame.l11)) return &fit.fit;
  return nullptr;
}

std::string number(double value) {
  std::ostringstream text;
  text << std::setprecision(3) << value;
  return text.str();
}

/// A straight line on the disk through the peak of a lobe: m_xy = peak + distance·direction.
struct Slice {
  Vec2 peak, direction;
  std::string title;
};

/// Along and across the wider principal direction of the lobe's image on the disk.
std::array<Slice, 2> principal_slices(const SlopeFrame& frame) {
  const Vec3 m = normal_of(frame.centre);
  const Eigen::Matrix2d jacobian =
      (Eigen::Matrix2d::Identity() - m.head<2>() * m.head<2>().transpose()) * m.z();
  const Eigen::Matrix2d scale = jacobian * frame.scale() * jacobian.transpose();
  const double angle = std::atan2(2 * scale(0, 1), scale(0, 0) - scale(1, 1)) / 2;
  const Vec2 wide(std::cos(angle), std::sin(angle)), narrow(-wide.y(), wide.x());
  return {{{m.head<2>(), wide, "along the wider direction"}, {m.head<2>(), narrow, "across it"}}};
}

/// The table at a point of the disk, bilinear; nothing outside it.
std::optional<double> value_at(const DiskTable& table, const Vec2& m) {
  const DiskGrid& grid = table.grid;
  const double x = m.x() / grid.spacing() + grid.centre(), y = m.y() / grid.spacing() + grid.centre();
  if (!(x >= 0 && y >= 0 && x <= grid.size - 1 && y <= grid.size - 1)) return std::nullopt;
  const auto i = std::min(static_cast<Eigen::Index>(x), static_cast<Eigen::Index>(grid.size) - 2),
             j = std::min(static_cast<Eigen::Index>(y), static_cast<Eigen::Index>(grid.size) - 2);
  const double t = x - static_cast<double>(i), s = y - static_cast<double>(j);
  const Grid<double>& d = table.density;
  return (1 - s) * ((1 - t) * d(j, i) + t * d(j, i + 1)) + s * ((1 - t) * d(j + 1, i) + t * d(j + 1, i + 1));
}

Picture draw_slice(const NdfTable& table, const Slice& slice, const Fit* ellipsoid, const Fit* beckmann,
                   double half_width, Eigen::Index width) {
  const double peak = table.density.density.maxCoeff();
  const auto sampled = [&](double step, auto&& density) {
    std::vector<Vec2> points;
    for (double s = -half_width; s <= half_width; s += step) {
      const Vec2 m = slice.peak + s * slice.direction;
      if (m.squaredNorm() < 1) points.emplace_back(s, density(m));
    }
    return points;
  };
  const auto model = [&](const auto& lobe) {
    return sampled(half_width / 400, [&](const Vec2& m) {
      return lobe.D({m.x(), m.y(), std::sqrt(1 - m.squaredNorm())});
    });
  };
  std::vector<Curve> curves;
  curves.push_back({"data", kData, Curve::Style::Dots,
                    sampled(std::max(table.density.grid.spacing(), half_width / 200),
                            [&](const Vec2& m) { return value_at(table.density, m).value_or(0); })});
  if (beckmann)
    curves.push_back({"Beckmann, rel. rms " + number(beckmann->rel_rms), kBeckmann, Curve::Style::Line,
                      model(Beckmann(beckmann->frame))});
  if (ellipsoid)
    curves.push_back({"ellipsoid, rel. rms " + number(ellipsoid->rel_rms), kEllipsoid, Curve::Style::Line,
                      model(Ellipsoid(ellipsoid->frame))});
  return draw_plot({"D (1/sr) " + slice.title, "m_xy from the peak of the ellipsoid", -half_width, half_width,
                    peak * std::pow(10, -kDecades), kHeadroom * peak, std::move(curves)},
                   width, kPlotHeight);
}

/// As many points as a panel has, each the nearest of the picture's.
Picture fill_panel(const Picture& picture) {
  Picture panel(kThumbnail, kThumbnail);
  for (Eigen::Index j = 0; j < kThumbnail; ++j)
    for (Eigen::Index i = 0; i < kThumbnail; ++i)
      panel(j, i) = picture(j * picture.rows() / kThumbnail, i * picture.cols() / kThumbnail);
  return panel;
}

void place(Picture& sheet, const Picture& picture, Eigen::Index row, Eigen::Index col) {
  sheet.block(row, col, picture.rows(), picture.cols()) = picture;
}

}  // namespace

std::string fit_figure_name(const std::string& method) {
  return "fit_" + method + ".png";
}

bool write_fit_figure(const std::filesystem::path& path, const NdfTable& table, const NdfFits& fits) {
  const Fit* ellipsoid = fit_of(fits, table.method, FitModel::EllipsoidNdf);
  const Fit* beckmann = fit_of(fits, table.method, FitModel::BeckmannNdf);
  if (ellipsoid == nullptr) return false;
  const DiskTable model = tabulate(Ellipsoid(ellipsoid->frame), table.density.grid);
  const DiskView view = view_of(table.density);

  const Eigen::Index width = 3 * kThumbnail + 4 * kMargin;
  const Eigen::Index first = kMargin + 2 * kLabel, second = first + kThumbnail + kMargin;
  Picture sheet = Picture::Constant(second + kPlotHeight, width, kPaper);
  const EllipsoidParameters& p = ellipsoid->parameters;
  draw_text(sheet, kMargin, kMargin, width - 2 * kMargin,
            table.method + ": ellipsoid " + std::string(name_of(ellipsoid->status)) + ", alpha " +
                number(p.alpha_x) + ", " + number(p.alpha_y) + ", theta " + number(p.theta_x) + ", " +
                number(p.theta_y) + ", " + number(p.theta_z) + " rad");
  const std::string extent = " to " + number(view.extent);
  const std::array<std::pair<Picture, std::string>, 3> panels = {
      {{picture_of(table.density, view), "table" + extent},
       {picture_of(model, view), "ellipsoid, same scale"},
       {difference_of(table.density, model, view), "table - ellipsoid, +-20% of peak"}}};
  Eigen::Index col = kMargin;
  for (const auto& [picture, label] : panels) {
    draw_text(sheet, kMargin + kLabel, col, kThumbnail, label);
    place(sheet, fill_panel(picture), first, col);
    col += kThumbnail + kMargin;
  }
  const auto slices = principal_slices(ellipsoid->frame);
  const Eigen::Index plot_width = (width - kMargin) / 2;
  for (std::size_t k = 0; k < slices.size(); ++k)
    place(sheet, draw_slice(table, slices[k], ellipsoid, beckmann, view.extent, plot_width), second,
          static_cast<Eigen::Index>(k) * plot_width);
  write_png(path, sheet);
  return true;
}

}  // namespace micro
