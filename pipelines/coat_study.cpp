#include "pipelines/coat_study.h"

#include <array>
#include <cmath>
#include <iomanip>
#include <numbers>
#include <sstream>

#include "brdf/albedo.h"
#include "brdf/coat.h"
#include "brdf/metals.h"
#include "pipelines/plot.h"

namespace micro {
namespace {

constexpr double kCoatIndex = 1.5, kLambda = 0.55;
/// Of the coat's upper face: "very smooth", and wide enough to be seen in a figure.
constexpr double kCoatSmoothness = 50;

Vec3 at(double degrees) {
  const double theta = degrees * std::numbers::pi / 180;
  return {std::sin(theta), 0, std::cos(theta)};
}

auto coated(double s, const Fresnel& fresnel, SunForm form) {
  return Coated(SunReflection(s, under(fresnel, kCoatIndex), form), {kCoatIndex, kCoatSmoothness}, form);
}

/// f over the viewing angle, negative on the light's side, a curve for each wavelength in its own colour.
template <Brdf Model>
Plot slices(const std::string& title, const Model& copper, double y_high) {
  const struct {
    double lambda;
    Rgb colour;
  } wavelengths[] = {{0.45, {60, 60, 200}},
                     {0.5, {30, 150, 170}},
                     {0.55, {60, 160, 40}},
                     {0.6, {230, 140, 20}},
                     {0.65, {200, 40, 40}}};
  Plot plot{title, "viewing angle (deg), light at -45", -90, 90, 0, y_high, {}, Plot::Scale::Linear};
  for (const auto& [lambda, colour] : wavelengths) {
    std::ostringstream name;
    name << std::lround(lambda * 1000) << " nm";
    Curve curve{name.str(), colour, Curve::Style::Line, {}};
    for (double degrees = -89.75; degrees < 90; degrees += 0.25)
      curve.points.push_back({degrees, copper.f(at(-45), at(degrees), lambda)});
    plot.curves.push_back(curve);
  }
  return plot;
}

}  // namespace

std::vector<FurnaceRow> study_coat_furnace(double tolerance) {
  std::vector<FurnaceRow> rows;
  for (const double s : {0.1, 0.5, 1., 2., 5., 20., 100.})
    for (const double degrees : {0., 45., 75., 85.}) {
      const Vec3 wi = at(degrees);
      const auto sun = [&](SunForm form) {
        return albedo(SunReflection(s, Fresnel(), form), wi, kLambda, tolerance);
      };
      const auto coat = [&](SunForm form) {
        return albedo(coated(s, Fresnel(), form), wi, kLambda, tolerance);
      };
      rows.push_back({s, degrees, sun(SunForm::Corrected), sun(SunForm::AsPrinted), coat(SunForm::Corrected),
                      coat(SunForm::AsPrinted)});
    }
  return rows;
}

std::string to_markdown(const std::vector<FurnaceRow>& rows) {
  std::ostringstream text;
  text << "| s | θ_i | Sun, corrected | Sun, as printed | printed/cos θ_i | coat, corrected | coat, as "
          "printed "
          "|\n|---|---|---|---|---|---|---|\n";
  for (const FurnaceRow& row : rows)
    text << std::defaultfloat << std::setprecision(4) << "| " << row.s << " | " << row.theta_deg << "° | "
         << std::fixed << std::setprecision(3) << row.sun.value << " | " << row.sun_printed.value << " | "
         << row.sun_printed.value / at(row.theta_deg).z() << " | " << row.coat.value << " | "
         << row.coat_printed.value << " |\n";
  return text.str();
}

std::string to_csv(const std::vector<FurnaceRow>& rows) {
  std::ostringstream text;
  text << "s,theta_deg,sun,sun_error,sun_printed,sun_printed_error,coat,coat_error,coat_printed,coat_printed_"
          "error\n"
       << std::setprecision(6);
  for (const FurnaceRow& row : rows) {
    text << row.s << ',' << row.theta_deg;
    for (const Estimate<double>& albedo : {row.sun, row.sun_printed, row.coat, row.coat_printed})
      text << ',' << albedo.value << ',' << albedo.error;
    text << '\n';
  }
  return text.str();
}

void write_coat_figures(const std::filesystem::path& folder) {
  constexpr Eigen::Index kWidth = 760, kHeight = 480;
  const Fresnel copper(metal("Cu").constants);
  const auto write = [&](const char* name, const Plot& plot) {
    write_png(folder / (std::string("coat_") + name + ".png"), draw_plot(plot, kWidth, kHeight));
  };
  constexpr double kHigh = 0.15;
  const std::string bare = "copper, s = 1 (SunGlossy Fig. 5 top)",
                    enamelled = "enamelled copper, s = 1, n = 1.5 (SunGlossy Fig. 5 bottom)";
  write("fig5_bare", slices(bare, SunReflection(1, copper), kHigh));
  write("fig5_enamelled", slices(enamelled, coated(1, copper, SunForm::Corrected), kHigh));
  write("fig5_bare_as_printed",
        slices(bare + ", as printed", SunReflection(1, copper, SunForm::AsPrinted), kHigh));
  write("fig5_enamelled_as_printed",
        slices(enamelled + ", as printed", coated(1, copper, SunForm::AsPrinted), kHigh));
}

}  // namespace micro
