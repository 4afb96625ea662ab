#include "io/small_hdf5_scans_test.h"

#include <hdf5.h>

#include <array>
#include <cfloat>
#include <cmath>

namespace micro {
namespace {

hid_t text_type() {
  const hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, H5T_VARIABLE);
  return type;
}

template <typename T>
void attribute(hid_t owner, const char* name, hid_t type, const T& value) {
  const hsize_t one = 1;
  const hid_t space = H5Screate_simple(1, &one, nullptr);
  const hid_t made = H5Acreate2(owner, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
  H5Awrite(made, type, &value);
  H5Aclose(made);
  H5Sclose(space);
}

struct Converter3 {
  const char* category;
  const char* base_unit;
  hvl_t parameters;
};
struct Converter5 {
  const char* category;
  const char* base_unit;
  const char* sub_category;
  const char* sub_unit;
  hvl_t parameters;
};

void converter(hid_t owner, const char* name, const Datx& datx, double pitch) {
  std::array<double, 4> values = {0, pitch, 0, 0};
  const hvl_t parameters = {values.size(), values.data()};
  const hid_t text = text_type();
  const hid_t list = H5Tvlen_create(H5T_NATIVE_DOUBLE);
  if (datx.converter_fields == 3) {
    const hid_t type = H5Tcreate(H5T_COMPOUND, sizeof(Converter3));
    H5Tinsert(type, "Category", HOFFSET(Converter3, category), text);
    H5Tinsert(type, "BaseUnit", HOFFSET(Converter3, base_unit), text);
    H5Tinsert(type, "Parameters", HOFFSET(Converter3, parameters), list);
    attribute(owner, name, type, Converter3{"LateralCat", "Pixels", parameters});
    H5Tclose(type);
  } else {
    const hid_t type = H5Tcreate(H5T_COMPOUND, sizeof(Converter5));
    H5Tinsert(type, "Category", HOFFSET(Converter5, category), text);
    H5Tinsert(type, "BaseUnit", HOFFSET(Converter5, base_unit), text);
    H5Tinsert(type, "SubCategory", HOFFSET(Converter5, sub_category), text);
    H5Tinsert(type, "SubUnit", HOFFSET(Converter5, sub_unit), text);
    H5Tinsert(type, "Parameters", HOFFSET(Converter5, parameters), list);
    attribute(owner, name, type,
              Converter5{"LateralCat", "Pixels", "LinearCat", datx.sub_unit.c_str(), parameters});
    H5Tclose(type);
  }
  H5Tclose(list);
  H5Tclose(text);
}

struct Edge {
  const char* source;
  const char* link;
  const char* destination;
};

void write_graph(hid_t file, const std::string& surface) {
  const std::string path = "/Data/Surface/" + surface;
  const std::array edges = {Edge{"Root", "Measurement", "{M}"}, Edge{"{M}", "Surface", surface.c_str()},
                            Edge{"{M}", "Attributes", "/Attributes/{A}"},
                            Edge{surface.c_str(), "Path", path.c_str()},
                            Edge{surface.c_str(), "Name", "Surface"}};
  const hid_t text = text_type();
  const hid_t type = H5Tcreate(H5T_COMPOUND, sizeof(Edge));
  H5Tinsert(type, "Source", HOFFSET(Edge, source), text);
  H5Tinsert(type, "Link", HOFFSET(Edge, link), text);
  H5Tinsert(type, "Destination", HOFFSET(Edge, destination), text);
  const hsize_t count = edges.size(), unlimited = H5S_UNLIMITED;
  const hid_t space = H5Screate_simple(1, &count, &unlimited);
  const hid_t list = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_chunk(list, 1, &count);
  const hid_t data = H5Dcreate2(file, "/MetaData", type, space, H5P_DEFAULT, list, H5P_DEFAULT);
  H5Dwrite(data, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, edges.data());
  for (const hid_t id : {data, list, space, type, text})
    H5Idec_ref(id);
}

hid_t create_file(const std::filesystem::path& path, Hdf5Layout layout) {
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  if (layout == Hdf5Layout::Latest) H5Pset_libver_bounds(access, H5F_LIBVER_LATEST, H5F_LIBVER_LATEST);
  const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access);
  H5Pclose(access);
  return file;
}

/// Three rows and four columns of k + 0.5, except number 5.
hid_t write_heights(hid_t file, const std::string& name, hid_t type, Hdf5Storage storage, double number5) {
  std::array<double, 12> values;
  for (std::size_t k = 0; k < values.size(); ++k)
    values[k] = k == 5 ? number5 : static_cast<double>(k) + 0.5;
  const std::array<hsize_t, 2> extents = {3, 4}, chunk = {2, 3};
  const hid_t space = H5Screate_simple(2, extents.data(), nullptr);
  const hid_t list = H5Pcreate(H5P_DATASET_CREATE);
  if (storage == Hdf5Storage::Deflated) {
    H5Pset_chunk(list, 2, chunk.data());
    H5Pset_shuffle(list);
    H5Pset_deflate(list, 6);
    H5Pset_fletcher32(list);
  }
  const hid_t data = H5Dcreate2(file, name.c_str(), type, space, H5P_DEFAULT, list, H5P_DEFAULT);
  H5Dwrite(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  H5Pclose(list);
  H5Sclose(space);
  return data;
}

void write_surface(hid_t file, const std::string& name, const Datx& datx) {
  const hid_t data = write_heights(file, "/Data/Surface/" + name, H5T_IEEE_F64LE, datx.storage, DBL_MAX);
  const hid_t text = text_type();
  attribute(data, "Unit", text, datx.unit.c_str());
  attribute(data, "No Data", H5T_NATIVE_DOUBLE, DBL_MAX);
  attribute(data, "Wavelength", H5T_NATIVE_DOUBLE, 0.6e-6);
  attribute(data, "Interferometric Scale Factor", H5T_NATIVE_DOUBLE, 0.5);
  attribute(data, "Obliquity Factor", H5T_NATIVE_DOUBLE, 2.);
  converter(data, "X Converter", datx, datx.pitch_x);
  converter(data, "Y Converter", datx, datx.pitch_y);
  H5Tclose(text);
  H5Dclose(data);
}

}  // namespace

void write_small_datx(const std::filesystem::path& path, const Datx& datx) {
  const hid_t file = create_file(path, datx.layout);
  for (const char* group : {"/Data", "/Data/Surface", "/Attributes", "/Attributes/{A}"})
    H5Gclose(H5Gcreate2(file, group, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  std::string name;
  for (int k = 0; k < datx.surfaces; ++k) {
    name = "{S" + std::to_string(k) + "}";
    write_surface(file, name, datx);
  }
  if (datx.metadata) write_graph(file, name);
  if (datx.hard_link) {
    H5Gclose(H5Gcreate2(file, "/Processed Data: PM", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    H5Lcreate_hard(file, ("/Data/Surface/" + name).c_str(), file, "/Processed Data: PM/Surface", H5P_DEFAULT,
                   H5P_DEFAULT);
  }
  H5Fclose(file);
}

void write_small_height_file(const std::filesystem::path& path, Hdf5Layout layout, Hdf5Storage storage) {
  constexpr std::array<char, 16> name = {"microbrdf"};
  const hid_t file = create_file(path, layout);
  const hid_t text = H5Tcopy(H5T_C_S1);
  H5Tset_size(text, name.size());
  attribute(file, "format", text, name);
  attribute(file, "format_version", H5T_NATIVE_INT, 1);
  attribute(file, "complete", H5T_NATIVE_INT, 1);
  const hid_t group = H5Gcreate2(file, "/height", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  attribute(group, "dx_um", H5T_NATIVE_DOUBLE, 0.25);
  attribute(group, "dy_um", H5T_NATIVE_DOUBLE, 0.5);
  attribute(group, "mean_um", H5T_NATIVE_DOUBLE, 10.);
  H5Dclose(write_heights(file, "/height/z", H5T_IEEE_F32BE, storage, std::nan("")));
  H5Gclose(group);
  H5Tclose(text);
  H5Fclose(file);
}

}  // namespace micro
