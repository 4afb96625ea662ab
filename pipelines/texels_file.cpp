#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "pipelines/texels.h"

namespace micro {
namespace {

/// [rows, cols, numbers] of float32, NaN in gaps.
void write_numbers(Hdf5Writer& file, const Texels& texels, const std::string& name,
                   const std::vector<std::string>& channels,
                   const std::function<void(const Texel&, float*)>& numbers_of) {
  const std::size_t n = channels.size();
  std::vector<float> values(static_cast<std::size_t>(texels.rows * texels.cols) * n, std::nanf(""));
  for (std::size_t k = 0; k < texels.texels.size(); ++k)
    if (texels.states[k] != TexelState::Gap)
      numbers_of(texels.texels[k], &values[static_cast<std::size_t>(texels.places[k]) * n]);
  const std::string dataset = "/texels/" + name;
  file.write<float>(dataset, values,
                    {static_cast<std::size_t>(texels.rows), static_cast<std::size_t>(texels.cols), n});
  file.set_attribute(dataset, "channels", std::span<const std::string>(channels));
}

void write_axes(Hdf5Writer& file, const Texels& texels) {
  const auto axis = [&](const char* name, Eigen::Index count, double step) {
    std::vector<double> centres;
    for (Eigen::Index k = 0; k < count; ++k)
      centres.push_back((static_cast<double>(k) + 0.5) * step);
    file.write<double>(std::string("/texels/") + name, centres, {centres.size()});
    file.set_attribute(std::string("/texels/") + name, "unit", "um");
    file.make_scale(std::string("/texels/") + name, name);
  };
  axis("y", texels.rows, texels.height);
  axis("x", texels.cols, texels.width);
}

/// The float next to a number on the side away from zero, or the number itself.
float rounded_up(double value) {
  const auto nearest = static_cast<float>(value);
  return static_cast<double>(nearest) < value ? std::nextafter(nearest, INFINITY) : nearest;
}

/// The same towards zero.
float rounded_to_zero(double value) {
  const auto nearest = static_cast<float>(value);
  return std::abs(static_cast<double>(nearest)) > std::abs(value) ? std::nextafter(nearest, 0.F) : nearest;
}

}  // namespace

std::array<float, 3> stored_scale(const SlopeFrame& frame) {
  const Eigen::Matrix2d scale = frame.scale();
  std::array<float, 3> stored = {rounded_up(scale(0, 0)), rounded_to_zero(scale(0, 1)),
                                 rounded_up(scale(1, 1))};
  const auto determinant = [&] {  // of products that are exact
    return static_cast<double>(stored[0]) * stored[2] - static_cast<double>(stored[1]) * stored[1];
  };
  // Where all three happen to be floats, the determinant is lost in double already.
  if (!(determinant() > 0)) stored[1] = std::nextafter(stored[1], 0.F);
  return stored;
}

void write_texels(Hdf5Writer& file, const Texels& texels) {
  file.create_group("/texels");
  if (texels.texels.empty()) return;
  const auto set = [&](const char* name, const auto& value) { file.set_attribute("/texels", name, value); };
  set("texel_width_um", texels.width);
  set("texel_height_um", texels.height);
  set("sigma_um", texels.sigma);
  set("texels", texels.count());
  set("tilt_removed_x", texels.tilt.x());
  set("tilt_removed_y", texels.tilt.y());
  set("seconds", texels.seconds);
  write_axes(file, texels);
  const std::vector<std::string> parameters = {"alpha.x", "alpha.y", "theta.x", "theta.y", "theta.z"};
  write_numbers(file, texels, "parameters", parameters, [](const Texel& texel, float* out) {
    const EllipsoidParameters& p = texel.fit.parameters;
    const std::array<double, 5> values = {p.alpha_x, p.alpha_y, p.theta_x, p.theta_y, p.theta_z};
    std::copy(values.begin(), values.end(), out);
  });
  write_numbers(file, texels, "standard_error", parameters, [](const Texel& texel, float* out) {
    for (int k = 0; k < 5; ++k)
      out[k] = static_cast<float>(std::sqrt(texel.fit.covariance(k, k)));
  });
  write_numbers(file, texels, "location", {"slope.x", "slope.y"}, [](const Texel& texel, float* out) {
    out[0] = static_cast<float>(texel.fit.frame.centre.x());
    out[1] = static_cast<float>(texel.fit.frame.centre.y());
  });
  write_numbers(file, texels, "scale", {"xx", "xy", "yy"}, [](const Texel& texel, float* out) {
    const std::array<float, 3> scale = stored_scale(texel.fit.frame);
    std::copy(scale.begin(), scale.end(), out);
  });
  write_numbers(file, texels, "rel_rms", {"rel_rms"},
                [](const Texel& texel, float* out) { *out = static_cast<float>(texel.fit.rel_rms); });
  write_numbers(file, texels, "independent_normals", {"normals"},
                [](const Texel& texel, float* out) { *out = static_cast<float>(texel.independent); });
  const Shape grid = {static_cast<std::size_t>(texels.rows), static_cast<std::size_t>(texels.cols)};
  const std::size_t places = grid[0] * grid[1];
  std::vector<std::int32_t> status(places, static_cast<std::int32_t>(FitStatus::Empty)),
      state(places, static_cast<std::int32_t>(TexelState::Gap)), scan(places, -1);
  for (std::size_t k = 0; k < texels.texels.size(); ++k) {
    const auto place = static_cast<std::size_t>(texels.places[k]);
    status[place] = static_cast<std::int32_t>(texels.texels[k].fit.status);
    state[place] = static_cast<std::int32_t>(texels.states[k]);
    scan[place] = texels.scan[k];
  }
  file.write<std::int32_t>("/texels/status", status, grid);
  std::vector<std::string> names;
  for (int k = 0; k <= static_cast<int>(FitStatus::Empty); ++k)
    names.emplace_back(name_of(static_cast<FitStatus>(k)));
  file.set_attribute("/texels/status", "names", std::span<const std::string>(names));
  file.write<std::int32_t>("/texels/state", state, grid);
  names = {"gap", "fitted", "shrunk", "few"};
  file.set_attribute("/texels/state", "names_from_minus_1", std::span<const std::string>(names));
  file.write<std::int32_t>("/texels/scan", scan, grid);
  for (const char* name : {"parameters", "standard_error", "location", "scale", "status", "state", "scan"}) {
    file.attach_scale(std::string("/texels/") + name, 0, "/texels/y", "y");
    file.attach_scale(std::string("/texels/") + name, 1, "/texels/x", "x");
  }
  if (texels.ndf_size == 0) return;
  const auto size = static_cast<std::size_t>(texels.ndf_size);
  constexpr int kDeflate = 1;
  file.write_sparse("/texels/slope_density", {grid[0], grid[1], size, size}, kDeflate, texels.places,
                    [&](std::size_t k) { return std::span<const float>(texels.texels[k].slopes); });
  file.set_attribute("/texels/slope_density", "reach", kNdfReach);
  file.set_attribute("/texels/slope_density", "of",
                     "v = L^-1 (slope - location), L the Cholesky factor of scale");
}

}  // namespace micro
