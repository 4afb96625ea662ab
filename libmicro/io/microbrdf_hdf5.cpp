#include "io/microbrdf_hdf5.h"

#include <cmath>
#include <string_view>
#include <vector>

#include "io/bytes.h"
#include "io/hdf5_reader.h"

namespace micro {
namespace {

constexpr int kFormatVersion = 1;

/// Coordinates 0, pitch, 2·pitch, … along an axis, µm.
void write_axis(Hdf5Writer& file, const std::string& name, Eigen::Index points, double pitch) {
  std::vector<double> coordinates(static_cast<std::size_t>(points));
  for (std::size_t k = 0; k < coordinates.size(); ++k)
    coordinates[k] = static_cast<double>(k) * pitch;
  const std::string dataset = "/height/" + name;
  file.write<double>(dataset, coordinates, {coordinates.size()});
  file.set_attribute(dataset, "unit", "um");
  file.make_scale(dataset, name);
}

enum class Kind { Heights, Result, Foreign };

/// What kind of our files this is, if it is ours. HDF5 opens no file that was cut: then it is judged by the
/// names that stand in its beginning, where the root's attributes and a result's first group are.
Kind kind_of(const FileHead& head) {
  if (!begins_with(head.bytes, kHdf5Signature)) return Kind::Foreign;
  try {
    const Hdf5Reader file(head.path);
    if (!file.has_attribute("/", "format") || file.text_attribute("/", "format") != "microbrdf")
      return Kind::Foreign;
    return file.is_group("/height") ? Kind::Heights : Kind::Result;
  } catch (const FileError&) {
    constexpr std::uintmax_t kBeginning = 1 << 16;
    const FileBytes beginning(head.path, kBeginning);
    const auto has = [&](std::string_view name) {
      return beginning.text().find(name) != std::string_view::npos;
    };
    if (!has("microbrdf_version")) return Kind::Foreign;
    return has("scans") ? Kind::Result : Kind::Heights;
  }
}

}  // namespace

void write_origin(Hdf5Writer& file, const Origin& origin) {
  file.set_attribute("/", "format", "microbrdf");
  file.set_attribute("/", "format_version", kFormatVersion);
  file.set_attribute("/", "microbrdf_version", origin.version);
  file.set_attribute("/", "created", origin.created);
  file.set_attribute("/", "command", origin.command);
}

bool is_microbrdf_hdf5(const FileHead& head) {
  return kind_of(head) == Kind::Heights;
}

bool is_microbrdf_result(const FileHead& head) {
  return kind_of(head) == Kind::Result;
}

HeightField refuse_microbrdf_result(const std::filesystem::path& path, const ReadOptions&) {
  const Hdf5Reader file(path);
  throw FileError(path, "is a result of microbrdf and holds no heights");
}

HeightField read_microbrdf_hdf5(const std::filesystem::path& path, const ReadOptions&) {
  const Hdf5Reader file(path);
  file.require_complete();
  if (const auto version = file.integer_attribute("/", "format_version"); version > kFormatVersion)
    throw FileError(path, "has format version " + std::to_string(version) + ", this program knows up to " +
                              std::to_string(kFormatVersion));
  const Pitch pitch = {file.number_attribute("/height", "dx_um"), file.number_attribute("/height", "dy_um")};
  const double mean = file.number_attribute("/height", "mean_um");
  if (!std::isfinite(mean)) throw FileError(path, "its mean height is no number");
  HeightField surface{.z = file.read_grid<float>("/height/z"), .dx = pitch.dx, .dy = pitch.dy, .mean = mean};
  if (surface.z.size() == 0) throw FileError(path, "holds no heights");
  if (!(pitch.dx > 0 && pitch.dy > 0 && std::isfinite(pitch.dx) && std::isfinite(pitch.dy)))
    throw FileError(path, "its pitch is not positive and finite");
  surface.z = surface.z.isFinite().select(surface.z, kMissing);
  return surface;
}

void write_microbrdf_hdf5(const std::filesystem::path& path, const HeightField& surface,
                          const Origin& origin) {
  Hdf5Writer file(path);
  write_origin(file, origin);
  file.write("/height/z", surface.z);
  file.set_attribute("/height/z", "unit", "um");
  file.set_attribute("/height", "dx_um", surface.dx);
  file.set_attribute("/height", "dy_um", surface.dy);
  file.set_attribute("/height", "mean_um", surface.mean);
  write_axis(file, "y", surface.rows(), surface.dy);
  write_axis(file, "x", surface.cols(), surface.dx);
  file.attach_scale("/height/z", 0, "/height/y", "y");
  file.attach_scale("/height/z", 1, "/height/x", "x");
  file.finish();
}

}  // namespace micro
