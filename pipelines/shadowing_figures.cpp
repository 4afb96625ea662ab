#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <sstream>

#include "brdf/free_travel.h"
#include "pipelines/plot.h"
#include "pipelines/shadowing_study.h"

namespace micro {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr Rgb kBlack = {40, 40, 40}, kRed = {200, 40, 40}, kBlue = {40, 90, 200}, kGreen = {30, 140, 60},
              kOrange = {230, 140, 20}, kViolet = {140, 60, 180};
constexpr std::array kColours = {kRed, kOrange, kGreen, kBlue, kViolet, kBlack};
constexpr Eigen::Index kWidth = 760, kHeight = 480;

using enum Curve::Style;
using Rows = std::vector<ShadowingStudyRow>;

template <typename F>
Curve curve_of(const std::string& name, const Rgb& colour, double low, double high, F&& y) {
  constexpr int kSteps = 400;
  Curve curve{name, colour, Line, {}};
  for (int k = 0; k <= kSteps; ++k) {
    const double x = low + (high - low) * k / kSteps;
    curve.points.push_back({x, y(x)});
  }
  return curve;
}

std::string label(const std::string& name, double value) {
  std::ostringstream text;
  text << name << value;
  return text.str();
}

Curve fall_off(double s, const Rgb& colour, const std::string& prefix) {
  return curve_of(label(prefix, s), colour, 0, 90, [s](double deg) {
    return free_travel_probability(s / std::tan(std::max(1e-9, deg * kDegree)));
  });
}

/// Adds the bar of two standard errors about an estimate.
void add_bar(Curve& curve, double x, const Estimate<double>& estimate) {
  constexpr double kLeastVisible = 0.006;
  const double half = std::max(2 * estimate.error, kLeastVisible);
  for (const double end : {estimate.value - half, estimate.value + half, std::nan("")})
    curve.points.push_back({x, end});
}

/// A line through estimates with bars of two standard errors.
template <typename X, typename Y>
Curve error_bars(const std::string& name, const Rgb& colour, const Rows& rows, X&& x, Y&& y) {
  Curve curve{name, colour, Line, {}};
  for (const ShadowingStudyRow& row : rows)
    curve.points.push_back({x(row), y(row).value});
  curve.points.push_back({0, std::nan("")});
  for (const ShadowingStudyRow& row : rows)
    add_bar(curve, x(row), y(row));
  return curve;
}

template <typename Y>
Curve along_angle(const std::string& name, const Rgb& colour, const Rows& rows, Y&& y) {
  Curve curve{name, colour, Line, {}};
  for (const ShadowingStudyRow& row : rows)
    curve.points.push_back({std::atan2(1, row.simulated.nu) / kDegree, y(row)});
  return curve;
}

Plot probability_plot(const std::string& title, std::vector<Curve> curves) {
  return {title, "polar angle (deg)", 0, 90, 0, 1.4, std::move(curves), Plot::Scale::Linear};
}

/// [Sun02 Fig. 4]: distance over w, and the straight line that replaces it in (3.4.19).
Plot line_for_curve() {
  Curve exact{"exact, from w0 = nu/sqrt 2 on", kBlue, Line, {}};
  for (double t = 1e-3; t < 6; t += 0.01)
    exact.points.push_back({t / std::sqrt(-std::expm1(-2 * t * t)), t});
  Curve line{"x = w sigma/tan gamma", kRed, Line, {{0, 0}, {5, 5}}};
  return {"x/tau over w, nu = 1, h = 0 (Sun02 Fig. 4)", "w", 0, 5, 0, 5, {exact, line}, Plot::Scale::Linear};
}

/// [Sun02 Fig. 5], [SunGlossy Fig. 4].
Plot free_travel_plot() {
  std::vector<Curve> curves;
  std::size_t k = 0;
  for (const double s : {0.1, 0.25, 0.5, 1., 2., 5., 10., 20.})
    curves.push_back(fall_off(s, kColours[k++ % kColours.size()], "s = "));
  return probability_plot("free travel probability (Sun02 Fig. 5, SunGlossy Fig. 4)", curves);
}

/// [Sun02 Fig. 6]: two of one roughness, two smoother ones.
Plot profiles_plot() {
  constexpr int kPerTau = 32, kLength = 24;
  const double rms[] = {1, 1, 0.5, 0.25};
  Plot plot{"profiles made by a moving average (Sun02 Fig. 6)",
            "x/tau",
            0,
            kLength,
            -2,
            23,
            {},
            Plot::Scale::Linear};
  for (std::size_t k = 0; k < 4; ++k) {
    const std::vector<double> h = gaussian_profile(kLength * kPerTau + 1, kPerTau, 40 + k);
    Curve curve{label("rms = tau x ", rms[k]), kColours[k], Line, {}};
    for (std::size_t i = 0; i < h.size(); ++i)
      curve.points.push_back(
          {static_cast<double>(i) / kPerTau, 16 - 5 * static_cast<double>(k) + rms[k] * h[i]});
    plot.curves.push_back(curve);
  }
  return plot;
}

/// [Sun02 Fig. 7] with error bars; rays from where profiles cross their mean height beside those from all
/// points at that height.
Plot simulated_plot(const Rows& rows) {
  std::vector<Curve> curves;
  for (const double s : {0.1, 0.25, 0.5, 1., 2., 5.}) {
    const auto x = [s](const ShadowingStudyRow& row) { return std::atan2(s, row.simulated.nu) / kDegree; };
    Curve analytic = fall_off(s, kBlack, "");
    Curve points = error_bars("", kBlue, rows, x, [](const ShadowingStudyRow& row) {
      return row.simulated.from_mean_height().all;
    });
    Curve crossings = error_bars("", kRed, rows, x,
                                 [](const ShadowingStudyRow& row) { return row.simulated.from_crossings; });
    const bool first = s == 0.1;
    analytic.name = first ? "analytic (3.4.23), s = 0.1 0.25 0.5 1 2 5" : "";
    points.name = first ? "simulated, from all points at the mean height" : "";
    crossings.name = first ? "simulated, from crossings of the mean height" : "";
    curves.insert(curves.end(), {analytic, points, crossings});
  }
  return probability_plot("free travel probability, simulated (Sun02 Fig. 7)", curves);
}

/// Γ(h) at one slope.
Plot heights_plot(const ShadowingStudyRow& row) {
  const double nu = row.simulated.nu, lambda = row.smith_lambda;
  Curve all{"simulated, all rays", kBlue, Line, {}}, facing{"simulated, facing", kGreen, Line, {}};
  for (int bin = 0; bin < HeightBins::kCount; ++bin) {
    const EscapingPart& part = row.simulated.from_height[static_cast<std::size_t>(bin)];
    add_bar(all, HeightBins::centre(bin), part.all);
    add_bar(facing, HeightBins::centre(bin), part.facing);
  }
  return {label("escape from height h, nu = ", nu),
          "h/sigma",
          -3.2,
          3.2,
          0,
          1.3,
          {curve_of("Sun (3.4.14)", kRed, -3.2, 3.2,
                    [&](double eta) { return free_travel_probability(eta, nu, 1e-4).value; }),
           curve_of("Smith, P x phi to the Lambda", kOrange, -3.2, 3.2,
                    [&](double eta) { return row.facing * smith_at_height(eta, lambda); }),
           all,
           curve_of("Smith, phi to the Lambda", kViolet, -3.2, 3.2,
                    [&](double eta) { return smith_at_height(eta, lambda); }),
           facing},
          Plot::Scale::Linear};
}

/// What a BRDF needs: the part of the facing facets that is seen.
Plot masking_plot(const Rows& rows) {
  const auto theta = [](const ShadowingStudyRow& row) { return std::atan2(1, row.simulated.nu) / kDegree; };
  return probability_plot(
      "masking at s = 1",
      {fall_off(1, kRed, "Sun (3.4.23), s = "),
       along_angle("Sun, all heights", kOrange, rows, [](const auto& row) { return row.sun_mean.value; }),
       along_angle("Smith G1", kViolet, rows, [](const auto& row) { return 1 / (1 + row.smith_lambda); }),
       error_bars("simulated, all rays", kBlue, rows, theta,
                  [](const auto& row) { return row.simulated.from_anywhere.all; }),
       error_bars("simulated, facing", kGreen, rows, theta,
                  [](const auto& row) { return row.simulated.from_anywhere.facing; })});
}

}  // namespace

void write_shadowing_figures(const Rows& rows, const std::filesystem::path& folder) {
  const auto write = [&](const char* name, const Plot& plot) {
    write_png(folder / (std::string("shadowing_") + name + ".png"), draw_plot(plot, kWidth, kHeight));
  };
  write("fig4_line", line_for_curve());
  write("fig5_free_travel", free_travel_plot());
  write("fig6_profiles", profiles_plot());
  write("fig7_simulated", simulated_plot(rows));
  write("masking", masking_plot(rows));
  const auto middle = std::min_element(rows.begin(), rows.end(), [](const auto& a, const auto& b) {
    return std::abs(a.simulated.nu - 1) < std::abs(b.simulated.nu - 1);
  });
  if (middle != rows.end()) write("heights", heights_plot(*middle));
}

}  // namespace micro
