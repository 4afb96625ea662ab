#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include "io/atomic_file.h"
#include "io/hdf5_writer.h"
#include "pipelines/brdf_report.h"
#include "pipelines/origin.h"
#include "pipelines/plot.h"

namespace micro {
namespace {

constexpr double kRadian = 180 / std::numbers::pi;

double theta_of(const Vec3& u) {
  return std::atan2(u.head<2>().norm(), u.z());
}

double phi_of(const Vec3& u) {
  return std::atan2(u.y(), u.x());
}

/// A 1-D axis as a dimension scale.
void write_axis(Hdf5Writer& file, const std::string& name, const std::string& label,
                const std::vector<double>& values) {
  file.write<double>(name, values, {values.size()});
  file.make_scale(name, label);
}

template <typename At>
std::vector<double> sampled(std::int64_t n, At&& at) {
  std::vector<double> values;
  for (std::int64_t i = 0; i < n; ++i)
    values.push_back(at(i));
  return values;
}

/// Values and errors of estimates, [rows, columns], with the axes of both.
void write_estimates(Hdf5Writer& file, const std::string& group,
                     const std::vector<std::vector<Estimate<double>>>& rows, const std::string& row_axis) {
  std::vector<double> values, errors;
  for (const auto& row : rows)
    for (const auto& estimate : row) {
      values.push_back(estimate.value);
      errors.push_back(estimate.error);
    }
  const Shape shape = {rows.size(), rows.front().size()};
  file.write<double>(group + "/value", values, shape);
  file.write<double>(group + "/error", errors, shape);
  file.attach_scale(group + "/value", 0, row_axis, "wi");
  file.attach_scale(group + "/value", 1, "/brdf/lambda_um", "wavelength");
}

void write_slices(Hdf5Writer& file, const BrdfReport& report) {
  for (std::size_t k = 0; k < report.slices.size(); ++k) {
    const BrdfSlice& slice = report.slices[k];
    const std::string group = "/brdf/slice" + std::to_string(k);
    std::vector<float> values;
    for (const auto& row : slice.f)
      values.insert(values.end(), row.begin(), row.end());
    file.create_group(group);
    write_axis(file, group + "/theta_o", "theta_o (rad)", slice.theta_o);
    file.write<float>(group + "/f", values, {slice.f.size(), slice.theta_o.size()});
    file.attach_scale(group + "/f", 0, "/brdf/lambda_um", "wavelength");
    file.attach_scale(group + "/f", 1, group + "/theta_o", "theta_o");
    file.set_attribute(group, "theta_i", theta_of(slice.wi));
    file.set_attribute(group, "phi_i", slice.phi_i);
    file.set_attribute(group, "plane", slice.plane);
    file.set_attribute(group, "unit", std::string_view("1/sr"));
  }
}

void write_spectrum(Hdf5Writer& file, const BrdfReport& report) {
  const BrdfSpectrum& spectrum = *report.spectrum;
  file.create_group("/brdf/spectrum");
  write_axis(file, "/brdf/spectrum/lambda_um", "wavelength (um)", spectrum.lambda_um);
  std::vector<double> values;
  for (const auto& estimate : spectrum.albedo)
    values.push_back(estimate.value);
  file.write<double>("/brdf/spectrum/albedo", values, {values.size()});
  file.attach_scale("/brdf/spectrum/albedo", 0, "/brdf/spectrum/lambda_um", "wavelength");
  file.set_attribute("/brdf/spectrum", "xyz", std::span<const double>(spectrum.xyz.data(), 3));
  file.set_attribute("/brdf/spectrum", "linear_srgb", std::span<const double>(spectrum.linear_rgb.data(), 3));
  file.set_attribute("/brdf/spectrum", "white", std::string_view("D65, CIE 1931 2 degrees"));
  file.set_attribute("/brdf/spectrum", "theta_i", theta_of(report.request.wi.front()));
}

void write_furnace(Hdf5Writer& file, const BrdfReport& report) {
  const WhiteFurnace& furnace = *report.furnace;
  std::vector<double> wi, values, errors;
  for (std::size_t k = 0; k < furnace.wi.size(); ++k) {
    wi.insert(wi.end(), furnace.wi[k].begin(), furnace.wi[k].end());
    values.push_back(furnace.albedo[k].value);
    errors.push_back(furnace.albedo[k].error);
  }
  file.create_group("/brdf/furnace");
  file.write<double>("/brdf/furnace/wi", wi, {values.size(), 3});
  file.write<double>("/brdf/furnace/value", values, {values.size()});
  file.write<double>("/brdf/furnace/error", errors, {values.size()});
  file.set_attribute("/brdf/furnace", "most", furnace.most());
  file.set_attribute("/brdf/furnace", "reciprocity", report.reciprocity->difference);
}

void write_table(Hdf5Writer& file, const BrdfReport& report) {
  const HalfAngleGrid& grid = *report.request.table;
  const std::string group = "/brdf/table";
  const auto size = [](std::int64_t n) { return static_cast<std::size_t>(n); };
  file.create_group(group);
  file.write<float>(
      group + "/f", report.table->value,
      {report.request.lambda_um.size(), size(grid.theta_h), size(grid.theta_d), size(grid.phi_d)});
  write_axis(file, group + "/theta_h", "theta_h (rad)",
             sampled(grid.theta_h, [&](std::int64_t i) { return grid.theta_h_at(i); }));
  write_axis(file, group + "/theta_d", "theta_d (rad), half of the angle between wi and wo",
             sampled(grid.theta_d, [&](std::int64_t i) { return grid.theta_d_at(i); }));
  write_axis(file, group + "/phi_d", "phi_d (rad)",
             sampled(grid.phi_d, [&](std::int64_t i) { return grid.phi_d_at(i); }));
  file.attach_scale(group + "/f", 0, "/brdf/lambda_um", "wavelength");
  unsigned axis = 1;
  const std::string f = group + "/f", within = group + "/";
  for (const std::string name : {"theta_h", "theta_d", "phi_d"})
    file.attach_scale(f, axis++, within + name, name);
  file.set_attribute(group, "unit", std::string_view("1/sr"));
  file.set_attribute(group, "phi_h", grid.phi_h);
  file.set_attribute(group, "seconds", report.table->cost.seconds);
}

std::string slices_csv(const BrdfReport& report) {
  std::ostringstream text;
  text << "theta_i_deg,phi_i_deg,plane_deg,theta_o_deg";
  for (const double lambda : report.request.lambda_um)
    text << ",f_" << lambda << "um_per_sr";
  text << '\n';
  for (const BrdfSlice& slice : report.slices)
    for (std::size_t k = 0; k < slice.theta_o.size(); ++k) {
      text << theta_of(slice.wi) * kRadian << ',' << slice.phi_i * kRadian << ',' << slice.plane * kRadian
           << ',' << slice.theta_o[k] * kRadian;
      for (const auto& f : slice.f)
        text << ',' << f[k];
      text << '\n';
    }
  return text.str();
}

std::string albedo_csv(const BrdfReport& report) {
  std::ostringstream text;
  text << "theta_i_deg,phi_i_deg,lambda_um,albedo,error,draws,seconds\n";
  for (std::size_t k = 0; k < report.albedo.size(); ++k)
    for (std::size_t c = 0; c < report.albedo[k].size(); ++c) {
      const Estimate<double>& a = report.albedo[k][c];
      const Vec3& wi = report.request.wi[k];
      text << theta_of(wi) * kRadian << ',' << phi_of(wi) * kRadian << ',' << report.request.lambda_um[c]
           << ',' << a.value << ',' << a.error << ',' << a.cost.evaluations << ',' << a.cost.seconds << '\n';
    }
  return text.str();
}

std::string spectrum_csv(const BrdfSpectrum& spectrum) {
  std::ostringstream text;
  text << "lambda_um,albedo,error\n";
  for (std::size_t k = 0; k < spectrum.lambda_um.size(); ++k)
    text << spectrum.lambda_um[k] << ',' << spectrum.albedo[k].value << ',' << spectrum.albedo[k].error
         << '\n';
  return text.str();
}

/// From blue over green to red for a part from 0 to 1.
Rgb spectral_colour(double part) {
  constexpr std::array<std::array<double, 3>, 3> kColours = {{{40, 90, 200}, {40, 140, 60}, {200, 30, 40}}};
  const std::size_t from = part < 0.5 ? 0 : 1;
  const auto mixed = [&](std::size_t k) {
    const double along = 2 * part - static_cast<double>(from);
    return static_cast<std::uint8_t>(
        std::lround((1 - along) * kColours[from][k] + along * kColours[from + 1][k]));
  };
  return {mixed(0), mixed(1), mixed(2)};
}

Picture draw_slice(const BrdfReport& report, const BrdfSlice& slice) {
  constexpr std::size_t kNames = 6;  // in the legend
  constexpr double kDecades = 1e-5, kHeadroom = 10;
  double peak = 0;
  std::vector<Curve> curves;
  for (std::size_t c = 0; c < slice.f.size(); ++c) {
    std::ostringstream name;
    const std::size_t last = slice.f.size() - 1, each = last / kNames + 1;
    if (c % each == 0) name << report.request.lambda_um[c] << " um";
    const double part = static_cast<double>(c) / static_cast<double>(std::max<std::size_t>(1, last));
    Curve curve{name.str(), spectral_colour(part), Curve::Style::Line, {}};
    for (std::size_t k = 0; k < slice.theta_o.size(); ++k) {
      curve.points.emplace_back(slice.theta_o[k] * kRadian, slice.f[c][k]);
      peak = std::max(peak, slice.f[c][k]);
    }
    curves.push_back(std::move(curve));
  }
  std::ostringstream title;
  title << "f (1/sr), wi at " << theta_of(slice.wi) * kRadian << " deg, plane " << slice.plane * kRadian
        << " deg, " << report.material;
  constexpr Eigen::Index kWidth = 720, kHeight = 360;
  if (!(peak > 0)) peak = 1;
  return draw_plot(
      {title.str(), "theta_o (deg)", -90, 90, peak * kDecades, peak * kHeadroom, std::move(curves)}, kWidth,
      kHeight);
}

}  // namespace

void write_brdf(const std::filesystem::path& path, const BrdfReport& report, const std::string& command) {
  Hdf5Writer file(path);
  write_origin(file, origin_of(command));
  file.create_group("/brdf");
  file.set_attribute("/brdf", "model", std::string_view(report.description));
  file.set_attribute("/brdf", "material", std::string_view(report.material));
  write_axis(file, "/brdf/lambda_um", "wavelength (um)", report.request.lambda_um);
  write_slices(file, report);
  if (!report.albedo.empty()) {
    file.create_group("/brdf/albedo");
    std::vector<double> thetas;
    for (const Vec3& wi : report.request.wi)
      thetas.push_back(theta_of(wi));
    write_axis(file, "/brdf/albedo/theta_i", "theta_i (rad)", thetas);
    write_estimates(file, "/brdf/albedo", report.albedo, "/brdf/albedo/theta_i");
  }
  if (report.spectrum) write_spectrum(file, report);
  if (report.furnace) write_furnace(file, report);
  if (report.table) write_table(file, report);
  file.finish();
}

std::vector<std::filesystem::path> brdf_picture_paths(const std::filesystem::path& path,
                                                      const BrdfRequest& request) {
  std::vector<std::filesystem::path> files;
  const auto beside = [&](const std::string& name) {
    files.push_back(path.parent_path() / (path.stem().string() + "_" + name));
  };
  const std::size_t slices = request.wi.size() * request.planes.size();
  if (slices > 0) beside("slices.csv");
  if (request.albedo && slices > 0) beside("albedo.csv");
  if (request.spectrum > 0) beside("spectrum.csv");
  for (std::size_t k = 0; k < slices; ++k)
    beside("slice" + std::to_string(k) + ".png");
  return files;
}

std::vector<std::filesystem::path> write_brdf_pictures(const std::filesystem::path& path,
                                                       const BrdfReport& report) {
  std::vector<std::filesystem::path> files = brdf_picture_paths(path, report.request);
  auto next = files.cbegin();
  if (!report.slices.empty()) write_text_file(*next++, slices_csv(report));
  if (!report.albedo.empty()) write_text_file(*next++, albedo_csv(report));
  if (report.spectrum) write_text_file(*next++, spectrum_csv(*report.spectrum));
  for (const BrdfSlice& slice : report.slices)
    write_png(*next++, draw_slice(report, slice));
  return files;
}

}  // namespace micro
