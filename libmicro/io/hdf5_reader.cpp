#include "io/hdf5_reader.h"

#include <algorithm>
#include <cstring>
#include <functional>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>

#include "core/error.h"
#include "io/hdf5_api.h"

namespace micro {
namespace {

using hdf5::Handle;
using hdf5::Lock;
using Value = Hdf5Record::mapped_type;

/// Deflate cannot shrink anything by more than 1032 : 1; the rest allows for headers of chunks.
constexpr std::uintmax_t kMostCompression = 1100;

/// a·b, or the largest number if that is more than fits.
std::uintmax_t saturating_product(std::uintmax_t a, std::uintmax_t b) {
  std::uintmax_t product = 0;
  return __builtin_mul_overflow(a, b, &product) ? std::numeric_limits<std::uintmax_t>::max() : product;
}

bool is_number(hid_t type) {
  const H5T_class_t kind = H5Tget_class(type);
  return kind == H5T_INTEGER || kind == H5T_FLOAT;
}

double decode_number(hid_t type, const std::byte* at) {
  // H5Tconvert works in place and needs room for the larger of the two.
  alignas(std::max_align_t) std::byte buffer[32] = {};
  const std::size_t size = H5Tget_size(type);
  if (size > sizeof buffer) return std::numeric_limits<double>::quiet_NaN();
  std::memcpy(buffer, at, size);
  if (H5Tconvert(type, H5T_NATIVE_DOUBLE, 1, buffer, nullptr, H5P_DEFAULT) < 0)
    return std::numeric_limits<double>::quiet_NaN();
  double value = 0;
  std::memcpy(&value, buffer, sizeof value);
  return value;
}

std::vector<double> decode_numbers(hid_t type, const std::byte* at, std::size_t count) {
  std::vector<double> values(count);
  const std::size_t size = H5Tget_size(type);
  for (std::size_t k = 0; k < count; ++k)
    values[k] = decode_number(type, at + k * size);
  return values;
}

std::string decode_text(hid_t type, const std::byte* at) {
  if (H5Tis_variable_str(type) > 0) {
    const char* text = nullptr;
    std::memcpy(&text, at, sizeof text);
    return text ? text : "";
  }
  const auto* text = reinterpret_cast<const char*>(at);
  std::string_view whole(text, strnlen(text, H5Tget_size(type)));
  if (H5Tget_strpad(type) == H5T_STR_SPACEPAD) whole = whole.substr(0, whole.find_last_not_of(' ') + 1);
  return std::string(whole);
}

/// One value in memory, or nothing if it is of a kind that no reader needs.
std::optional<Value> decode(hid_t type, const std::byte* at) {
  switch (H5Tget_class(type)) {
    case H5T_INTEGER:
    case H5T_FLOAT:
      return decode_number(type, at);
    case H5T_STRING:
      return decode_text(type, at);
    case H5T_VLEN: {
      const Handle element(H5Tget_super(type), H5Tclose);
      hvl_t list;
      std::memcpy(&list, at, sizeof list);
      if (!is_number(element)) return std::nullopt;
      return decode_numbers(element, static_cast<const std::byte*>(list.p), list.p ? list.len : 0);
    }
    case H5T_ARRAY: {
      const Handle element(H5Tget_super(type), H5Tclose);
      if (!is_number(element)) return std::nullopt;
      return decode_numbers(element, at, H5Tget_size(type) / H5Tget_size(element));
    }
    default:
      return std::nullopt;
  }
}

Hdf5Record decode_record(hid_t type, const std::byte* at) {
  Hdf5Record record;
  for (int k = 0; k < H5Tget_nmembers(type); ++k) {
    const auto index = static_cast<unsigned>(k);
    const Handle member(H5Tget_member_type(type, index), H5Tclose);
    char* name = H5Tget_member_name(type, index);
    if (!name) continue;
    if (auto value = decode(member, at + H5Tget_member_offset(type, index)))
      record.insert_or_assign(name, *std::move(value));
    H5free_memory(name);
  }
  return record;
}

/// Values as HDF5 puts them into memory, with what it allocated for strings and lists.
class Raw {
 public:
  Raw(Handle type, hid_t space, std::size_t count)
      : type_(std::move(type)), space_(space), size_(H5Tget_size(type_)), bytes_(count * size_) {}
  ~Raw() { H5Dvlen_reclaim(type_, space_, H5P_DEFAULT, bytes_.data()); }
  Raw(const Raw&) = delete;
  Raw& operator=(const Raw&) = delete;
  hid_t type() const { return type_; }
  std::byte* data() { return bytes_.data(); }
  const std::byte* at(std::size_t k) const { return bytes_.data() + k * size_; }

 private:
  Handle type_;
  hid_t space_;
  std::size_t size_;
  std::vector<std::byte> bytes_;
};

}  // namespace

/// A dataset or an attribute, opened; its size has been checked.
class Hdf5Reader::Source {
 public:
  using Read = std::function<herr_t(hid_t memory_type, void* values)>;
  std::string name;
  Handle object;
  Handle type;
  Handle space;
  Shape extents;
  std::size_t count = 1;
  Read read = {};

  /// Elements decoded one by one.
  template <typename Decode>
  auto elements(Decode&& decode_element) const {
    std::vector<decltype(decode_element(hid_t{}, nullptr))> values;
    Raw raw(Handle(H5Tget_native_type(type, H5T_DIR_ASCEND), H5Tclose), space, count);
    if (read(raw.type(), raw.data()) < 0) return values;
    for (std::size_t k = 0; k < count; ++k)
      values.push_back(decode_element(raw.type(), raw.at(k)));
    return values;
  }
};

Hdf5Reader::Hdf5Reader(const std::filesystem::path& path) : path_(path) {
  std::error_code error;
  size_ = std::filesystem::file_size(path, error);
  if (error) throw FileError(path, "cannot be read: " + error.message());
  const Lock lock;
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_fclose_degree(access, H5F_CLOSE_STRONG);
  id_ = H5Fopen(path.c_str(), H5F_ACC_RDONLY, access);
  if (id_ < 0) fail("is no readable HDF5 file");
}

Hdf5Reader::~Hdf5Reader() {
  if (id_ < 0) return;
  const Lock lock;
  H5Fclose(id_);
}

Hdf5Reader::Hdf5Reader(Hdf5Reader&& other) noexcept
    : path_(std::move(other.path_)), size_(other.size_), id_(std::exchange(other.id_, -1)) {}

void Hdf5Reader::fail(const std::string& fact) const {
  const std::string reason = hdf5::last_error();
  throw FileError(path_, reason.empty() ? fact : fact + ": " + reason);
}

void Hdf5Reader::require_complete() const {
  if (!has_attribute("/", "format") || text_attribute("/", "format") != "microbrdf")
    throw FileError(path_, "is an HDF5 file, but not one of microbrdf's");
  if (!has_attribute("/", "complete") || integer_attribute("/", "complete") != 1)
    throw FileError(path_, "was cut while it was written (the root attribute complete is missing)");
}

bool Hdf5Reader::contains(const std::string& object) const {
  const Lock lock;
  return static_cast<bool>(hdf5::open_object(id_, object));
}

bool Hdf5Reader::is_group(const std::string& object) const {
  const Lock lock;
  const Handle opened = hdf5::open_object(id_, object);
  return opened && H5Iget_type(opened) == H5I_GROUP;
}

std::vector<std::string> Hdf5Reader::children(const std::string& group) const {
  const Lock lock;
  std::vector<std::string> names;
  const Handle opened = hdf5::open_object(id_, group);
  const auto add = [](hid_t, const char* name, const H5L_info_t*, void* list) -> herr_t {
    static_cast<std::vector<std::string>*>(list)->emplace_back(name);
    return 0;
  };
  hsize_t position = 0;
  if (!opened || H5Literate(opened, H5_INDEX_NAME, H5_ITER_INC, &position, add, &names) < 0)
    fail("group " + group + " cannot be read");
  std::sort(names.begin(), names.end());
  return names;
}

Hdf5Reader::Source Hdf5Reader::dataset(const std::string& dataset) const {
  Handle data(H5Dopen2(id_, dataset.c_str(), H5P_DEFAULT), H5Dclose);
  if (!data) fail("dataset " + dataset + " cannot be read");
  const hid_t id = data;
  Source source{.name = "dataset " + dataset,
                .object = std::move(data),
                .type = {H5Dget_type(id), H5Tclose},
                .space = {H5Dget_space(id), H5Sclose},
                .extents = {}};
  const int rank = H5Sget_simple_extent_ndims(source.space);
  if (!source.type || rank < 0) fail(source.name + " cannot be read");
  std::vector<hsize_t> extents(static_cast<std::size_t>(rank));
  if (rank > 0) H5Sget_simple_extent_dims(source.space, extents.data(), nullptr);
  source.extents.assign(extents.begin(), extents.end());

  // A header may promise anything: hold it against the bytes that are there.
  std::uintmax_t bytes = H5Tget_size(source.type);
  for (const hsize_t extent : extents)
    bytes = saturating_product(bytes, extent);
  const Handle layout(H5Dget_create_plist(id), H5Pclose);
  const H5D_layout_t kind = H5Pget_layout(layout);
  if (kind == H5D_VIRTUAL || H5Pget_external_count(layout) > 0)
    throw FileError(path_, source.name + " lies in other files, which are not followed");
  std::uintmax_t available = kind == H5D_CHUNKED ? H5Dget_storage_size(id) : size_;
  if (kind == H5D_CHUNKED && H5Pget_nfilters(layout) > 0)
    available = saturating_product(available, kMostCompression);
  if (bytes > available)
    throw FileError(path_, source.name + " says that it has " + std::to_string(bytes) +
                               " bytes, more than the file can hold");
  for (const hsize_t extent : extents)
    source.count *= extent;
  source.read = [id](hid_t type, void* values) {
    return H5Dread(id, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values);
  };
  return source;
}

Hdf5Reader::Source Hdf5Reader::attribute(const std::string& object, const std::string& name) const {
  const std::string what = "attribute " + name + " of " + object;
  Handle data(H5Aopen_by_name(id_, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  if (!data) throw FileError(path_, what + " is missing");
  const hid_t id = data;
  Source source{.name = what,
                .object = std::move(data),
                .type = {H5Aget_type(id), H5Tclose},
                .space = {H5Aget_space(id), H5Sclose},
                .extents = {}};
  const hssize_t count = H5Sget_simple_extent_npoints(source.space);
  if (!source.type || count < 0) fail(what + " cannot be read");
  source.count = static_cast<std::size_t>(count);
  if (saturating_product(source.count, H5Tget_size(source.type)) > size_)
    throw FileError(path_, what + " says that it is larger than the file");
  source.read = [id](hid_t type, void* values) { return H5Aread(id, type, values); };
  return source;
}

Shape Hdf5Reader::shape(const std::string& name) const {
  const Lock lock;
  return dataset(name).extents;
}

template <typename T>
std::vector<T> Hdf5Reader::read(const std::string& name) const {
  const Lock lock;
  const Source source = dataset(name);
  if (!is_number(source.type)) throw FileError(path_, source.name + " does not hold numbers");
  std::vector<T> values(source.count);
  if (source.read(hdf5::native_type<T>(), values.data()) < 0) fail(source.name + " cannot be read");
  return values;
}

template <typename T>
Grid<T> Hdf5Reader::read_grid(const std::string& name) const {
  const Lock lock;
  const Source source = dataset(name);
  if (!is_number(source.type)) throw FileError(path_, source.name + " does not hold numbers");
  if (source.extents.size() != 2)
    throw FileError(
        path_, source.name + " has " + std::to_string(source.extents.size()) + " dimensions instead of two");
  Grid<T> values(static_cast<Eigen::Index>(source.extents[0]), static_cast<Eigen::Index>(source.extents[1]));
  if (source.read(hdf5::native_type<T>(), values.data()) < 0) fail(source.name + " cannot be read");
  return values;
}

template std::vector<float> Hdf5Reader::read(const std::string&) const;
template std::vector<double> Hdf5Reader::read(const std::string&) const;
template std::vector<std::uint8_t> Hdf5Reader::read(const std::string&) const;
template std::vector<std::int32_t> Hdf5Reader::read(const std::string&) const;
template std::vector<std::uint32_t> Hdf5Reader::read(const std::string&) const;
template std::vector<std::int64_t> Hdf5Reader::read(const std::string&) const;
template std::vector<std::uint64_t> Hdf5Reader::read(const std::string&) const;
template Grid<float> Hdf5Reader::read_grid(const std::string&) const;
template Grid<double> Hdf5Reader::read_grid(const std::string&) const;
template Grid<std::uint8_t> Hdf5Reader::read_grid(const std::string&) const;
template Grid<std::int32_t> Hdf5Reader::read_grid(const std::string&) const;
template Grid<std::uint32_t> Hdf5Reader::read_grid(const std::string&) const;
template Grid<std::int64_t> Hdf5Reader::read_grid(const std::string&) const;
template Grid<std::uint64_t> Hdf5Reader::read_grid(const std::string&) const;

std::string Hdf5Reader::read_text(const std::string& name) const {
  const Lock lock;
  const Source source = dataset(name);
  if (H5Tget_class(source.type) != H5T_STRING || source.count != 1)
    throw FileError(path_, source.name + " is not one string");
  const auto texts = source.elements(decode_text);
  if (texts.empty()) fail(source.name + " cannot be read");
  return texts.front();
}

std::vector<Hdf5Record> Hdf5Reader::read_records(const std::string& name) const {
  const Lock lock;
  const Source source = dataset(name);
  if (H5Tget_class(source.type) != H5T_COMPOUND) throw FileError(path_, source.name + " is no compound");
  auto records = source.elements(decode_record);
  if (records.size() != source.count) fail(source.name + " cannot be read");
  return records;
}

bool Hdf5Reader::has_attribute(const std::string& object, const std::string& name) const {
  const Lock lock;
  return H5Aexists_by_name(id_, object.c_str(), name.c_str(), H5P_DEFAULT) > 0;
}

std::string Hdf5Reader::text_attribute(const std::string& object, const std::string& name) const {
  auto texts = texts_attribute(object, name);
  if (texts.size() != 1) throw FileError(path_, "attribute " + name + " of " + object + " is not one string");
  return std::move(texts.front());
}

double Hdf5Reader::number_attribute(const std::string& object, const std::string& name) const {
  const auto values = numbers_attribute(object, name);
  if (values.size() != 1)
    throw FileError(path_, "attribute " + name + " of " + object + " is not one number");
  return values.front();
}

std::int64_t Hdf5Reader::integer_attribute(const std::string& object, const std::string& name) const {
  const Lock lock;
  const Source source = attribute(object, name);
  std::int64_t value = 0;
  if (H5Tget_class(source.type) != H5T_INTEGER || source.count != 1)
    throw FileError(path_, source.name + " is not one integer");
  if (source.read(H5T_NATIVE_INT64, &value) < 0) fail(source.name + " cannot be read");
  return value;
}

std::vector<double> Hdf5Reader::numbers_attribute(const std::string& object, const std::string& name) const {
  const Lock lock;
  const Source source = attribute(object, name);
  if (!is_number(source.type)) throw FileError(path_, source.name + " is no number");
  std::vector<double> values(source.count);
  if (source.read(H5T_NATIVE_DOUBLE, values.data()) < 0) fail(source.name + " cannot be read");
  return values;
}

std::vector<std::string> Hdf5Reader::texts_attribute(const std::string& object,
                                                     const std::string& name) const {
  const Lock lock;
  const Source source = attribute(object, name);
  if (H5Tget_class(source.type) != H5T_STRING) throw FileError(path_, source.name + " is no string");
  auto texts = source.elements(decode_text);
  if (texts.size() != source.count) fail(source.name + " cannot be read");
  return texts;
}

std::vector<Hdf5Record> Hdf5Reader::records_attribute(const std::string& object,
                                                      const std::string& name) const {
  const Lock lock;
  const Source source = attribute(object, name);
  if (H5Tget_class(source.type) != H5T_COMPOUND) throw FileError(path_, source.name + " is no compound");
  auto records = source.elements(decode_record);
  if (records.size() != source.count) fail(source.name + " cannot be read");
  return records;
}

}  // namespace micro
