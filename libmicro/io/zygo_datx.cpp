#include "io/zygo_datx.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "io/bytes.h"
#include "io/hdf5_reader.h"
#include "io/printable.h"

namespace micro {
namespace {

constexpr const char* kSurfaces = "/Data/Surface";

/// Length units of Mx, in µm.
std::optional<double> micrometres(std::string_view unit) {
  struct Unit {
    std::string_view name;
    double micrometres;
  };
  constexpr std::array units = {Unit{"Meters", 1e6}, Unit{"MilliMeters", 1e3}, Unit{"MicroMeters", 1},
                                Unit{"NanoMeters", 1e-3}};
  for (const Unit& candidate : units)
    if (candidate.name == unit) return candidate.micrometres;
  return std::nullopt;
}

template <typename T>
const T* find(const Hdf5Record& record, std::string_view name) {
  const auto found = record.find(name);
  return found == record.end() ? nullptr : std::get_if<T>(&found->second);
}

/// Where `link` leads from any of `sources` in the graph of /MetaData, whose edges are {Source, Link,
/// Destination}.
std::set<std::string> follow(const std::vector<Hdf5Record>& graph, const std::set<std::string>& sources,
                             std::string_view link) {
  std::set<std::string> reached;
  for (const Hdf5Record& edge : graph) {
    const auto* source = find<std::string>(edge, "Source");
    const auto* name = find<std::string>(edge, "Link");
    const auto* destination = find<std::string>(edge, "Destination");
    if (source && name && destination && *name == link && sources.contains(*source))
      reached.insert(*destination);
  }
  return reached;
}

std::string surface_path(const std::filesystem::path& path, const Hdf5Reader& file) {
  if (file.contains("/MetaData")) {
    const auto graph = file.read_records("/MetaData");
    const auto surfaces = follow(graph, follow(graph, {"Root"}, "Measurement"), "Surface");
    const auto paths = follow(graph, surfaces, "Path");
    if (paths.size() == 1) return *paths.begin();
    if (paths.size() > 1)
      throw FileError(
          path, "holds " + std::to_string(paths.size()) + " surfaces and does not say which one counts");
  }
  const auto names = file.is_group(kSurfaces) ? file.children(kSurfaces) : std::vector<std::string>{};
  if (names.empty()) throw FileError(path, "holds no surface");
  if (names.size() > 1)
    throw FileError(path,
                    "holds " + std::to_string(names.size()) + " surfaces and does not say which one counts");
  return std::string(kSurfaces) + "/" + names.front();
}

/// Distance between points along one axis, µm; 0 = unknown. The converter has 3 or 5 fields, so they are
/// looked up by name: Parameters = {0, pixel size, 0, 0} in SubUnit, or in metres where there is none.
double axis_pitch(const std::filesystem::path& path, const Hdf5Reader& file, const std::string& surface,
                  const std::string& converter) {
  if (!file.has_attribute(surface, converter)) return 0;
  const auto records = file.records_attribute(surface, converter);
  const auto* parameters =
      records.empty() ? nullptr : find<std::vector<double>>(records.front(), "Parameters");
  if (!parameters || parameters->size() < 2) return 0;
  double unit = 1e6;
  if (const auto* name = find<std::string>(records.front(), "SubUnit")) {
    const auto known = micrometres(*name);
    if (!known) throw FileError(path, "its lateral unit " + in_quotes(*name) + " is unknown");
    unit = *known;
  }
  return (*parameters)[1] * unit;
}

/// Micrometres per unit of height.
double height_unit(const std::filesystem::path& path, const Hdf5Reader& file, const std::string& surface) {
  const std::string unit = file.text_attribute(surface, "Unit");
  if (const auto known = micrometres(unit)) return *known;
  if (unit != "Fringes") throw FileError(path, "its height unit " + in_quotes(unit) + " is unknown");
  const auto factor = [&](const char* name) {
    const double value = file.number_attribute(surface, name);
    if (!(value > 0 && std::isfinite(value)))
      throw FileError(path, std::string("its ") + name + " makes no sense: " + std::to_string(value));
    return value;
  };
  return factor("Wavelength") * factor("Interferometric Scale Factor") * factor("Obliquity Factor") * 1e6;
}

}  // namespace

bool is_zygo_datx(const FileHead& head) {
  if (!begins_with(head.bytes, kHdf5Signature)) return false;
  try {
    const Hdf5Reader file(head.path);
    return file.is_group(kSurfaces) || (file.contains("/MetaData") && file.is_group("/Attributes"));
  } catch (const FileError&) {
    return true;
  }
}

HeightField read_zygo_datx(const std::filesystem::path& path, const ReadOptions& options) {
  const Hdf5Reader file(path);
  const std::string surface = surface_path(path, file);
  const double unit = height_unit(path, file, surface);
  const Pitch pitch = file_pitch(
      path, {axis_pitch(path, file, surface, "X Converter"), axis_pitch(path, file, surface, "Y Converter")},
      options);
  const double no_data = file.has_attribute(surface, "No Data") ? file.number_attribute(surface, "No Data")
                                                                : std::numeric_limits<double>::max();
  const auto z = file.read_grid<double>(surface);
  return read_height_field(path, static_cast<std::uint64_t>(z.rows()), static_cast<std::uint64_t>(z.cols()),
                           pitch, [&](Eigen::Index k) {
                             const double value = z.data()[k];
                             return value < no_data ? value * unit : std::numeric_limits<double>::quiet_NaN();
                           });
}

}  // namespace micro
