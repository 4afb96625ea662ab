#include "pipelines/result_file.h"

#include "io/exr.h"
#include "io/hdf5_writer.h"
#include "io/microbrdf_hdf5.h"
#include "pipelines/origin.h"
#include "pipelines/run_sums.h"
#include "pipelines/spectrum_file.h"
#include "pipelines/version.h"

namespace micro {
namespace {

/// m_x of the columns, or m_y of the rows: the axes that readers see.
std::vector<double> axis(const DiskGrid& grid) {
  std::vector<double> nodes;
  for (Eigen::Index i = 0; i < grid.size; ++i)
    nodes.push_back(grid.coordinate(i));
  return nodes;
}

void write_table(Hdf5Writer& file, const std::string& group, const std::string& name,
                 const Grid<double>& values) {
  constexpr int kDeflate = 1;  // tables are mostly zeros or smooth; more effort gains little
  const std::string dataset = group + "/" + name;
  file.write(dataset, Grid<float>(values.cast<float>()), kDeflate);
  file.attach_scale(dataset, 0, group + "/m_y", "m_y");
  file.attach_scale(dataset, 1, group + "/m_x", "m_x");
}

/// What D_K was asked for.
void write_kirchhoff(Hdf5Writer& file, const std::string& group, const Kirchhoff& kirchhoff) {
  file.set_attribute(group, "lambda_q_um", kirchhoff.lambda_q);
  file.set_attribute(group, "tolerance", kirchhoff.tolerance);
  const auto coherent = [&](std::string_view window, double area) {
    file.set_attribute(group, "coherence_window", window);
    file.set_attribute(group, "coherence_area_um2", area);
  };
  if (const auto* windows = std::get_if<SubWindows>(&kirchhoff.coherence)) coherent("square", windows->area);
  if (const auto* taper = std::get_if<GaussianTaper>(&kirchhoff.coherence)) coherent("gaussian", taper->area);
}

void write_directions(Hdf5Writer& file, const DirectionsOfScans& directions) {
  const std::string group = std::string("/ndf/") + kDirectionsName;
  file.create_group(group);
  const std::size_t n = directions.h.size();
  std::vector<double> h;
  for (const Vec3& direction : directions.h)
    h.insert(h.end(), direction.begin(), direction.end());
  file.write<double>(group + "/direction", h, {n, 3});
  const auto write = [&](const char* name, const std::vector<double>& values) {
    file.write<float>(group + "/" + name, std::vector<float>(values.begin(), values.end()), {n});
  };
  write("density", directions.density);
  if (directions.standard_error) write("standard_error", *directions.standard_error);
  write("estimator_error", directions.estimator_error);
  const auto set = [&](const char* name, const auto& value) { file.set_attribute(group, name, value); };
  set("unit", std::string_view("1/sr"));
  set("area_um2", directions.area);
  set("scans", directions.scans);
  set("valid_sin_theta", directions.valid_sin_theta);
  set("estimator", std::string_view(directions.estimator));
  set("rel_error", directions.rel_error);
  set("seconds", directions.seconds);
  write_kirchhoff(file, group, directions.kirchhoff);
  set("missed_tolerance", directions.unreached);
}

void write_ndf(Hdf5Writer& file, const NdfOfScans& ndf) {
  const std::string group = "/ndf/" + ndf.method.name;
  file.create_group(group);
  const auto set = [&](const char* name, const auto& value) { file.set_attribute(group, name, value); };
  const std::vector<double> nodes = axis(ndf.density.grid);
  for (const char* name : {"m_x", "m_y"}) {
    file.write<double>(group + "/" + name, nodes, {nodes.size()});
    file.make_scale(group + "/" + name, name);
  }
  write_table(file, group, "density", ndf.density.density);
  if (ndf.standard_error) write_table(file, group, "standard_error", *ndf.standard_error);
  if (ndf.estimator_error.size() > 0) write_table(file, group, "estimator_error", ndf.estimator_error);
  set("extent", ndf.density.grid.extent);
  set("unit", std::string_view("1/sr"));
  set("normalization", normalization(ndf.density));
  set("area_um2", ndf.area);
  set("scans", ndf.scans);
  set("samples", ndf.samples);
  set("outside_extent", ndf.outside);
  set("valid_sin_theta", ndf.valid_sin_theta);
  set("estimator", std::string_view(ndf.estimator));
  set("rel_error", ndf.rel_error);
  set("seconds", ndf.seconds);
  if (const auto* filtered = std::get_if<Filtered>(&ndf.method.kind)) {
    set("sigma_um", filtered->sigma);
    set("without_normal", ndf.without_normal);
    set("slope_truncation_error", ndf.truncation_error.value_or(0));
  }
  if (const auto* kirchhoff = std::get_if<Kirchhoff>(&ndf.method.kind)) {
    write_kirchhoff(file, group, *kirchhoff);
    set("missed_tolerance", ndf.unreached);
  }
  if (ndf.signature) set("signature", std::string_view(*ndf.signature));
}

/// The sums themselves: microbrdf merge joins them.
void write_shard(Hdf5Writer& file, const ShardSums& shard) {
  constexpr int kDeflate = 1;
  const std::vector<std::uint8_t> bytes = to_bytes(shard);
  file.create_group("/shard");
  file.write<std::uint8_t>("/shard/state", bytes, {bytes.size()}, kDeflate);
  file.set_attribute("/shard", "index", shard.shard.index);
  file.set_attribute("/shard", "count", shard.shard.count);
}

}  // namespace

void write_result(const std::filesystem::path& path, const NdfResult& result, const std::string& command) {
  Hdf5Writer file(path);
  write_origin(file, origin_of(command));
  write_scans(file, result.scans);
  if (!result.empty()) file.create_group("/ndf");
  for (const NdfOfScans& ndf : result.ndfs)
    write_ndf(file, ndf);
  if (result.fits) write_fits(file, *result.fits);
  if (result.spectrum) write_spectrum(file, *result.spectrum);
  if (result.directions) write_directions(file, *result.directions);
  if (result.shard) write_shard(file, *result.shard);
  file.write_text("/plan", to_json(result.plan));
  file.finish();
}

void write_ndf_picture(const std::filesystem::path& path, const NdfOfScans& ndf) {
  write_exr(path, {{"Y", ndf.density.density.cast<float>()}},
            {{"method", ndf.method.name},
             {"unit", "1/sr"},
             {"extent", std::to_string(ndf.density.grid.extent)},
             {"software", "microbrdf " + std::string(version())}});
}

}  // namespace micro
