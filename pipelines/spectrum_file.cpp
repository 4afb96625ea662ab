#include "pipelines/spectrum_file.h"

#include <algorithm>
#include <numeric>
#include <string>

namespace micro {

SpectrumNumbers numbers_of(const SpectrumOfScans& spectrum) {
  SpectrumNumbers numbers{};
  for (std::size_t k = 0; k < spectrum.lambda_q.size(); ++k) {
    numbers.normalizations.push_back(normalization(spectrum.mean.mean(k)));
    numbers.rel_errors.push_back(spectrum.rel_error(k));
    numbers.valid_sin_theta.push_back(spectrum.valid_sin_theta(k));
  }
  const auto& all = numbers.normalizations;
  numbers.normalization = std::accumulate(all.begin(), all.end(), 0.) / static_cast<double>(all.size());
  numbers.rel_error = *std::max_element(numbers.rel_errors.begin(), numbers.rel_errors.end());
  return numbers;
}

void write_spectrum(Hdf5Writer& file, const SpectrumOfScans& spectrum) {
  const std::string group = "/ndf/kirchhoff_spectrum";
  const DiskGrid& grid = spectrum.mean.grid();
  const auto n = static_cast<std::size_t>(grid.size);
  const std::size_t wavelengths = spectrum.lambda_q.size();
  const auto write_axis = [&](const char* name, const std::vector<double>& values) {
    file.write<double>(group + "/" + name, values, {values.size()});
    file.make_scale(group + "/" + name, name);
  };
  std::vector<double> nodes;
  for (Eigen::Index i = 0; i < grid.size; ++i)
    nodes.push_back(grid.coordinate(i));
  file.create_group(group);
  write_axis("lambda_q_um", spectrum.lambda_q);
  write_axis("m_y", nodes);
  write_axis("m_x", nodes);
  const auto write_tables = [&](const char* name, const auto& table) {
    constexpr int kDeflate = 1;
    const std::string dataset = group + "/" + name;
    file.write_slices(dataset, {wavelengths, n, n}, kDeflate, table);
    file.attach_scale(dataset, 0, group + "/lambda_q_um", "lambda_q_um");
    file.attach_scale(dataset, 1, group + "/m_y", "m_y");
    file.attach_scale(dataset, 2, group + "/m_x", "m_x");
  };
  write_tables("density",
               [&](std::size_t k) -> Grid<float> { return spectrum.mean.mean(k).density.cast<float>(); });
  if (spectrum.mean.count() > 1)
    write_tables("standard_error", [&](std::size_t k) -> Grid<float> {
      return spectrum.mean.standard_error(k)->cast<float>();
    });
  const auto set = [&](const char* name, const auto& value) { file.set_attribute(group, name, value); };
  const auto set_all = [&](const char* name, const std::vector<double>& values) {
    file.set_attribute(group, name, std::span<const double>(values));
  };
  const SpectrumNumbers numbers = numbers_of(spectrum);
  set("extent", grid.extent);
  set("unit", std::string_view("1/sr"));
  set_all("lambda_q_um", spectrum.lambda_q);
  set_all("normalization", numbers.normalizations);
  set_all("rel_error", numbers.rel_errors);
  set_all("valid_sin_theta", numbers.valid_sin_theta);
  set_all("missed_tolerance", {spectrum.unreached.begin(), spectrum.unreached.end()});
  if (!spectrum.coherence_area.empty()) set_all("coherence_area_um2", spectrum.coherence_area);
  set("area_um2", spectrum.mean.weight());
  set("scans", spectrum.mean.count());
  set("samples", spectrum.windows);
  set("estimator", std::string_view("spectral"));
  set("tolerance", spectrum.tolerance);
  set("seconds", spectrum.seconds);
}

}  // namespace micro
