#pragma once

#include <string>
#include <vector>

#include "core/grid.h"
#include "io/png.h"

namespace micro {

/// A curve of a plot; without a name the legend leaves it out. Points with a y that is not finite or, on a
/// logarithmic axis, not positive leave a gap.
struct Curve {
  std::string name;
  Rgb colour;
  enum class Style { Line, Dots } style;
  std::vector<Vec2> points;
};

/// A plot of curves over x.
struct Plot {
  std::string title, x_label;
  double x_low, x_high, y_low, y_high;
  std::vector<Curve> curves;
  enum class Scale { Logarithmic, Linear } y_scale = Scale::Logarithmic;
};

/// Draws a plot with axes, ticks, a title and a legend, `width` × `height` points.
Picture draw_plot(const Plot& plot, Eigen::Index width, Eigen::Index height);

}  // namespace micro
