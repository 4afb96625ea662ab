#include "pipelines/plot.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "pipelines/lettering.h"

namespace micro {
namespace {

constexpr Rgb kPaper = {255, 255, 255}, kGrid = {225, 225, 225};
constexpr Eigen::Index kLeft = 52, kRight = 10, kTop = 16, kBottom = 30;

std::string tick_label(double value) {
  std::ostringstream text;
  text.precision(3);
  text << (std::abs(value) < 1e-12 ? 0. : value);
  return text.str();
}

/// A step of 1, 2 or 5 times a power of ten that makes about five ticks.
double tick_step(double range) {
  const double power = std::pow(10., std::floor(std::log10(range / 5)));
  for (const double factor : {1., 2., 5.})
    if (range / (factor * power) <= 6) return factor * power;
  return 10 * power;
}

/// Ticks of a linear axis.
std::vector<double> linear_ticks(double low, double high) {
  const double step = tick_step(high - low);
  std::vector<double> ticks;
  for (double value = std::ceil(low / step) * step; value <= high + 1e-9 * step; value += step)
    ticks.push_back(value);
  return ticks;
}

std::vector<double> powers_of_ten(double low, double high) {
  std::vector<double> ticks;
  for (double value = std::pow(10, std::ceil(std::log10(low))); value <= high; value *= 10)
    ticks.push_back(value);
  return ticks;
}

/// The plot's rectangle in points of the picture.
struct Canvas {
  const Plot& plot;
  Picture& picture;
  Eigen::Index width, height;

  double col(double x) const {
    return kLeft + (x - plot.x_low) / (plot.x_high - plot.x_low) * static_cast<double>(width - 1);
  }
  double row(double y) const {
    const double part = plot.y_scale == Plot::Scale::Linear
                            ? (y - plot.y_low) / (plot.y_high - plot.y_low)
                            : std::log(y / plot.y_low) / std::log(plot.y_high / plot.y_low);
    return kTop + (1 - part) * static_cast<double>(height - 1);
  }
  /// Paints a point; what lies outside the rectangle is left out.
  void dot(double r, double c, const Rgb& colour) const {
    const auto j = static_cast<Eigen::Index>(std::lrint(r)), i = static_cast<Eigen::Index>(std::lrint(c));
    if (j >= kTop && j < kTop + height && i >= kLeft && i < kLeft + width) picture(j, i) = colour;
  }
};

void draw_axes(const Canvas& canvas) {
  const Plot& plot = canvas.plot;
  const Eigen::Index bottom = kTop + canvas.height;
  for (const double x : linear_ticks(plot.x_low, plot.x_high)) {
    const auto i = static_cast<Eigen::Index>(std::lrint(canvas.col(x)));
    for (Eigen::Index j = kTop; j < bottom; ++j)
      canvas.dot(static_cast<double>(j), static_cast<double>(i), kGrid);
    const std::string label = tick_label(x);
    const auto length = static_cast<Eigen::Index>(label.size()) * kLetterWidth;
    draw_text(canvas.picture, bottom + 5, i - length / 2, length, label);
  }
  for (const double y : plot.y_scale == Plot::Scale::Linear ? linear_ticks(plot.y_low, plot.y_high)
                                                            : powers_of_ten(plot.y_low, plot.y_high)) {
    const double row = canvas.row(y);
    for (Eigen::Index i = 0; i < canvas.width; ++i)
      canvas.dot(row, static_cast<double>(kLeft + i), kGrid);
    const std::string label = tick_label(y);
    const auto length = static_cast<Eigen::Index>(label.size()) * kLetterWidth;
    draw_text(canvas.picture, static_cast<Eigen::Index>(row) - 3, kLeft - 4 - length, length, label);
  }
  for (Eigen::Index i = 0; i < canvas.width; ++i)
    canvas.picture(bottom, kLeft + i) = kInk;
  for (Eigen::Index j = kTop; j <= bottom; ++j)
    canvas.picture(j, kLeft - 1) = kInk;
  draw_text(canvas.picture, bottom + 18, kLeft, canvas.width, plot.x_label);
  draw_text(canvas.picture, 4, kLeft, canvas.width, plot.title);
}

void draw_line(const Canvas& canvas, const Vec2& from, const Vec2& to, const Rgb& colour) {
  const double c0 = canvas.col(from.x()), r0 = canvas.row(from.y()), c1 = canvas.col(to.x()),
               r1 = canvas.row(to.y());
  const double steps = std::min(1e4, std::ceil(std::max({std::abs(c1 - c0), std::abs(r1 - r0), 1.})));
  for (double k = 0; k <= steps; ++k)
    canvas.dot(r0 + (r1 - r0) * k / steps, c0 + (c1 - c0) * k / steps, colour);
}

void draw_curve(const Canvas& canvas, const Curve& curve) {
  const bool linear = canvas.plot.y_scale == Plot::Scale::Linear;
  const auto shows = [linear](const Vec2& p) { return (linear || p.y() > 0) && std::isfinite(p.y()); };
  for (std::size_t k = 0; k < curve.points.size(); ++k) {
    const Vec2& p = curve.points[k];
    if (!shows(p)) continue;
    if (curve.style == Curve::Style::Line) {
      if (k > 0 && shows(curve.points[k - 1])) draw_line(canvas, curve.points[k - 1], p, curve.colour);
    } else {
      for (const double r : {-0.5, 0.5})
        for (const double c : {-0.5, 0.5})
          canvas.dot(canvas.row(p.y()) + r, canvas.col(p.x()) + c, curve.colour);
    }
  }
}

}  // namespace

Picture draw_plot(const Plot& plot, Eigen::Index width, Eigen::Index height) {
  Picture picture = Picture::Constant(height, width, kPaper);
  const Canvas canvas{plot, picture, width - kLeft - kRight, height - kTop - kBottom};
  draw_axes(canvas);
  for (const Curve& curve : plot.curves)
    draw_curve(canvas, curve);
  Eigen::Index row = kTop + 6;
  for (const Curve& curve : plot.curves) {
    if (curve.name.empty()) continue;
    for (Eigen::Index i = 0; i < 12; ++i)
      for (Eigen::Index j = 0; j < 3; ++j)
        picture(row + j + 2, kLeft + 6 + i) = curve.colour;
    draw_text(picture, row, kLeft + 24, canvas.width, curve.name);
    row += kLetterHeight + 4;
  }
  return picture;
}

}  // namespace micro
