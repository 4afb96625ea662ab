#include "io/hdf5_writer.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>

#include "core/error.h"
#include "io/hdf5_api.h"

namespace micro {
namespace {

using hdf5::Handle;
using hdf5::Lock;

static_assert(sizeof(hid_t) == sizeof(std::int64_t));

/// Chunks hold whole rows (the slowest axis is cut) and about this many values: large enough to deflate well,
/// small enough for HDF5's default chunk cache of 1 MiB.
constexpr hsize_t kChunkValues = 1 << 17;

Handle intermediate_groups() {
  Handle list(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
  H5Pset_create_intermediate_group(list, 1);
  H5Pset_char_encoding(list, H5T_CSET_UTF8);
  return list;
}

void set_chunks(hid_t list, const std::vector<hsize_t>& chunk, int deflate) {
  H5Pset_chunk(list, static_cast<int>(chunk.size()), chunk.data());
  if (deflate == 0) return;
  H5Pset_shuffle(list);
  H5Pset_deflate(list, static_cast<unsigned>(deflate));
}

Handle storage(const std::vector<hsize_t>& extents, int deflate) {
  Handle list(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  const bool empty = std::find(extents.begin(), extents.end(), 0u) != extents.end();
  if (deflate == 0 || extents.empty() || empty) return list;
  std::vector<hsize_t> chunk = extents;
  const hsize_t row = std::accumulate(extents.begin() + 1, extents.end(), hsize_t{1}, std::multiplies<>());
  chunk[0] = std::clamp<hsize_t>(kChunkValues / row, 1, extents[0]);
  set_chunks(list, chunk, deflate);
  return list;
}

/// A new dataset of floats in chunks, NaN where nothing is written. The caller holds the lock and looks
/// whether it was made.
Handle chunked_floats(hid_t file, const std::string& dataset, hid_t space, const std::vector<hsize_t>& chunk,
                      int deflate) {
  const Handle list(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  set_chunks(list, chunk, deflate);
  const float missing = std::numeric_limits<float>::quiet_NaN();
  H5Pset_fill_value(list, hdf5::native_type<float>(), &missing);
  return Handle(H5Dcreate2(file, dataset.c_str(), hdf5::native_type<float>(), space, intermediate_groups(),
                           list, H5P_DEFAULT),
                H5Dclose);
}

}  // namespace

Hdf5Writer::Hdf5Writer(const std::filesystem::path& path) : file_(path) {
  const Lock lock;
  // The new format of groups and superblocks is smaller; HDF5 1.10 and h5py since 2.9 read it.
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_libver_bounds(access, H5F_LIBVER_V18, H5F_LIBVER_V110);
  H5Pset_fclose_degree(access, H5F_CLOSE_STRONG);
  id_ = H5Fcreate(file_.temporary().c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access);
  require(id_ >= 0, "cannot be written");
}

Hdf5Writer::Hdf5Writer(AtomicFile file, std::int64_t id) : file_(std::move(file)), id_(id) {}

Hdf5Writer Hdf5Writer::amend(const std::filesystem::path& source, const std::filesystem::path& path) {
  AtomicFile file(path);
  std::error_code error;
  std::filesystem::copy_file(source, file.temporary(), std::filesystem::copy_options::overwrite_existing,
                             error);
  if (error) throw FileError(path, "cannot be written: " + error.message());
  const auto open = [&] {
    const Lock lock;
    const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    H5Pset_fclose_degree(access, H5F_CLOSE_STRONG);
    return H5Fopen(file.temporary().c_str(), H5F_ACC_RDWR, access);
  };
  const hid_t id = open();
  Hdf5Writer writer(std::move(file), id);
  writer.unfinish();
  return writer;
}

void Hdf5Writer::unfinish() {
  const Lock lock;
  require(id_ >= 0, "cannot be written");
  if (H5Aexists(id_, "complete") > 0)
    require(H5Adelete(id_, "complete") >= 0, "attribute complete of / cannot be written");
}

Hdf5Writer::Hdf5Writer(Hdf5Writer&& other) noexcept
    : file_(std::move(other.file_)), id_(std::exchange(other.id_, -1)) {}

Hdf5Writer::~Hdf5Writer() {
  if (id_ < 0) return;
  const Lock lock;
  H5Fclose(id_);
}

void Hdf5Writer::require(bool done, const std::string& what) const {
  if (done) return;
  const std::string reason = hdf5::last_error();
  throw FileError(file_.path(), reason.empty() ? what : what + ": " + reason);
}

void Hdf5Writer::create_group(const std::string& group) {
  const Lock lock;
  if (hdf5::open_object(id_, group)) return;
  const Handle made(H5Gcreate2(id_, group.c_str(), intermediate_groups(), H5P_DEFAULT, H5P_DEFAULT),
                    H5Gclose);
  require(static_cast<bool>(made), "group " + group + " cannot be written");
}

void Hdf5Writer::remove(const std::string& object) {
  const Lock lock;
  if (!hdf5::open_object(id_, object)) return;
  require(H5Ldelete(id_, object.c_str(), H5P_DEFAULT) >= 0, object + " cannot be replaced");
}

template <typename T>
void Hdf5Writer::write(const std::string& dataset, std::span<const T> values, const Shape& shape,
                       int deflate) {
  const std::vector<hsize_t> extents(shape.begin(), shape.end());
  assert(std::accumulate(extents.begin(), extents.end(), hsize_t{1}, std::multiplies<>()) == values.size());
  const Lock lock;
  const Handle space(H5Screate_simple(static_cast<int>(extents.size()), extents.data(), nullptr), H5Sclose);
  const Handle data(H5Dcreate2(id_, dataset.c_str(), hdf5::native_type<T>(), space, intermediate_groups(),
                               storage(extents, deflate), H5P_DEFAULT),
                    H5Dclose);
  require(data && H5Dwrite(data, hdf5::native_type<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0,
          "dataset " + dataset + " cannot be written");
}

template void Hdf5Writer::write(const std::string&, std::span<const float>, const Shape&, int);
template void Hdf5Writer::write(const std::string&, std::span<const double>, const Shape&, int);
template void Hdf5Writer::write(const std::string&, std::span<const std::uint8_t>, const Shape&, int);
template void Hdf5Writer::write(const std::string&, std::span<const std::int32_t>, const Shape&, int);
template void Hdf5Writer::write(const std::string&, std::span<const std::uint32_t>, const Shape&, int);
template void Hdf5Writer::write(const std::string&, std::span<const std::int64_t>, const Shape&, int);
template void Hdf5Writer::write(const std::string&, std::span<const std::uint64_t>, const Shape&, int);

void Hdf5Writer::write_slices(const std::string& dataset, const Shape& shape, int deflate,
                              const std::function<Grid<float>(std::size_t)>& slice) {
  assert(shape.size() == 3);
  const std::vector<hsize_t> extents(shape.begin(), shape.end());
  const hsize_t rows = std::clamp<hsize_t>(kChunkValues / std::max<hsize_t>(extents[2], 1), 1, extents[1]);
  const std::vector<hsize_t> chunk = {1, rows, extents[2]};
  const hsize_t count[3] = {1, extents[1], extents[2]};
  const Lock lock;
  const Handle space(H5Screate_simple(3, extents.data(), nullptr), H5Sclose);
  const Handle data = chunked_floats(id_, dataset, space, chunk, deflate);
  const Handle memory(H5Screate_simple(3, count, nullptr), H5Sclose);
  for (std::size_t k = 0; k < shape[0]; ++k) {
    const Grid<float> values = slice(k);
    assert(static_cast<hsize_t>(values.rows()) == extents[1] &&
           static_cast<hsize_t>(values.cols()) == extents[2]);
    const hsize_t start[3] = {k, 0, 0};
    require(data && H5Sselect_hyperslab(space, H5S_SELECT_SET, start, nullptr, count, nullptr) >= 0 &&
                H5Dwrite(data, hdf5::native_type<float>(), memory, space, H5P_DEFAULT, values.data()) >= 0,
            "dataset " + dataset + " cannot be written");
  }
}

void Hdf5Writer::create_in_parts(const std::string& dataset, const Shape& shape, std::size_t side,
                                 int deflate) {
  assert(shape.size() == 3);
  const std::vector<hsize_t> extents(shape.begin(), shape.end());
  const std::vector<hsize_t> chunk = {std::min<hsize_t>(side, extents[0]),
                                      std::min<hsize_t>(side, extents[1]), extents[2]};
  const Lock lock;
  const Handle space(H5Screate_simple(3, extents.data(), nullptr), H5Sclose);
  const Handle data = chunked_floats(id_, dataset, space, chunk, deflate);
  require(static_cast<bool>(data), "dataset " + dataset + " cannot be written");
}

void Hdf5Writer::write_part(const std::string& dataset, std::size_t row, std::size_t col, const Shape& shape,
                            std::span<const float> values) {
  assert(shape.size() == 3 && shape[0] * shape[1] * shape[2] == values.size());
  const hsize_t start[3] = {row, col, 0}, count[3] = {shape[0], shape[1], shape[2]};
  const Lock lock;
  const Handle data(H5Dopen2(id_, dataset.c_str(), H5P_DEFAULT), H5Dclose);
  const Handle space(H5Dget_space(data), H5Sclose), memory(H5Screate_simple(3, count, nullptr), H5Sclose);
  require(data && H5Sselect_hyperslab(space, H5S_SELECT_SET, start, nullptr, count, nullptr) >= 0 &&
              H5Dwrite(data, hdf5::native_type<float>(), memory, space, H5P_DEFAULT, values.data()) >= 0,
          "dataset " + dataset + " cannot be written");
}

void Hdf5Writer::write_sparse(const std::string& dataset, const Shape& shape, int deflate,
                              std::span<const std::int64_t> places,
                              const std::function<std::span<const float>(std::size_t)>& table) {
  assert(shape.size() > 2);
  const std::vector<hsize_t> extents(shape.begin(), shape.end());
  std::vector<hsize_t> start(extents.size(), 0), count = extents;
  count[0] = count[1] = 1;
  const int rank = static_cast<int>(extents.size());
  const Lock lock;
  const Handle space(H5Screate_simple(rank, extents.data(), nullptr), H5Sclose),
      memory(H5Screate_simple(rank, count.data(), nullptr), H5Sclose);
  const Handle data = chunked_floats(id_, dataset, space, count, deflate);
  const auto require_written = [&](bool done) { require(done, "dataset " + dataset + " cannot be written"); };
  require_written(static_cast<bool>(data));
  for (std::size_t k = 0; k < places.size(); ++k) {
    const std::span<const float> values = table(k);
    if (values.empty()) continue;
    const auto place = static_cast<hsize_t>(places[k]);
    start[0] = place / extents[1];
    start[1] = place % extents[1];
    require_written(
        H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr) >= 0 &&
        H5Dwrite(data, hdf5::native_type<float>(), memory, space, H5P_DEFAULT, values.data()) >= 0);
  }
}

void Hdf5Writer::write_text(const std::string& dataset, std::string_view text) {
  const std::string terminated(text);
  const char* pointer = terminated.c_str();
  const Lock lock;
  const Handle type = hdf5::string_type();
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Handle data(
      H5Dcreate2(id_, dataset.c_str(), type, space, intermediate_groups(), H5P_DEFAULT, H5P_DEFAULT),
      H5Dclose);
  require(data && H5Dwrite(data, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, &pointer) >= 0,
          "dataset " + dataset + " cannot be written");
}

void Hdf5Writer::write_attribute(const std::string& object, const std::string& name, std::int64_t memory_type,
                                 std::int64_t file_type, std::int64_t space, const void* values) {
  const std::string what = "attribute " + name + " of " + object + " cannot be written";
  const Handle owner = hdf5::open_object(id_, object);
  require(static_cast<bool>(owner), what);
  if (H5Aexists(owner, name.c_str()) > 0) require(H5Adelete(owner, name.c_str()) >= 0, what);
  const Handle attribute(H5Acreate2(owner, name.c_str(), file_type, space, H5P_DEFAULT, H5P_DEFAULT),
                         H5Aclose);
  require(attribute && H5Awrite(attribute, memory_type, values) >= 0, what);
}

void Hdf5Writer::set_attribute(const std::string& object, const std::string& name, std::string_view value) {
  const std::string terminated(value);
  const char* pointer = terminated.c_str();
  const Lock lock;
  const Handle type = hdf5::string_type();
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  write_attribute(object, name, type, type, space, &pointer);
}

void Hdf5Writer::set_attribute(const std::string& object, const std::string& name, double value) {
  const Lock lock;
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  write_attribute(object, name, H5T_NATIVE_DOUBLE, H5T_NATIVE_DOUBLE, space, &value);
}

void Hdf5Writer::set_integer_attribute(const std::string& object, const std::string& name,
                                       std::int64_t value) {
  const Lock lock;
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  write_attribute(object, name, H5T_NATIVE_INT64, H5T_NATIVE_INT64, space, &value);
}

void Hdf5Writer::set_attribute(const std::string& object, const std::string& name,
                               std::span<const double> values) {
  const Lock lock;
  const hsize_t extent = values.size();
  const Handle space(H5Screate_simple(1, &extent, nullptr), H5Sclose);
  write_attribute(object, name, H5T_NATIVE_DOUBLE, H5T_NATIVE_DOUBLE, space, values.data());
}

void Hdf5Writer::set_attribute(const std::string& object, const std::string& name,
                               std::span<const std::string> values) {
  std::vector<const char*> pointers(values.size());
  std::transform(values.begin(), values.end(), pointers.begin(),
                 [](const auto& value) { return value.c_str(); });
  const Lock lock;
  const hsize_t extent = values.size();
  const Handle type = hdf5::string_type();
  const Handle space(H5Screate_simple(1, &extent, nullptr), H5Sclose);
  write_attribute(object, name, type, type, space, pointers.data());
}

void Hdf5Writer::set_attribute(const std::string& object, const std::string& name,
                               const Grid<double>& values) {
  const Lock lock;
  const std::array extents = {static_cast<hsize_t>(values.rows()), static_cast<hsize_t>(values.cols())};
  const Handle space(H5Screate_simple(2, extents.data(), nullptr), H5Sclose);
  write_attribute(object, name, H5T_NATIVE_DOUBLE, H5T_NATIVE_DOUBLE, space, values.data());
}

void Hdf5Writer::make_scale(const std::string& dataset, const std::string& label) {
  const Lock lock;
  const Handle data(H5Dopen2(id_, dataset.c_str(), H5P_DEFAULT), H5Dclose);
  require(data && H5DSset_scale(data, label.c_str()) >= 0, "scale " + dataset + " cannot be written");
}

void Hdf5Writer::attach_scale(const std::string& dataset, unsigned axis, const std::string& scale,
                              const std::string& label) {
  const Lock lock;
  const Handle data(H5Dopen2(id_, dataset.c_str(), H5P_DEFAULT), H5Dclose);
  const Handle values(H5Dopen2(id_, scale.c_str(), H5P_DEFAULT), H5Dclose);
  require(data && values && H5DSattach_scale(data, values, axis) >= 0 &&
              H5DSset_label(data, axis, label.c_str()) >= 0,
          "axis " + std::to_string(axis) + " of " + dataset + " cannot be given the scale " + scale);
}

void Hdf5Writer::finish() {
  {
    const Lock lock;
    require(H5Fflush(id_, H5F_SCOPE_GLOBAL) >= 0, "cannot be written");
  }
  set_attribute("/", "complete", 1);
  {
    const Lock lock;
    require(H5Fclose(std::exchange(id_, -1)) >= 0, "cannot be written");
  }
  file_.commit();
}

}  // namespace micro
