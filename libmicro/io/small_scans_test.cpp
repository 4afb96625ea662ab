#include "io/small_scans_test.h"

#include <hdf5.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cfloat>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>

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

void write_surface(hid_t file, const std::string& name, const Datx& datx) {
  std::array<double, 12> values;
  for (std::size_t k = 0; k < values.size(); ++k)
    values[k] = k == 5 ? DBL_MAX : static_cast<double>(k) + 0.5;
  const std::array<hsize_t, 2> extents = {3, 4};
  const hid_t space = H5Screate_simple(2, extents.data(), nullptr);
  const hid_t data = H5Dcreate2(file, ("/Data/Surface/" + name).c_str(), H5T_IEEE_F64LE, space, H5P_DEFAULT,
                                H5P_DEFAULT, H5P_DEFAULT);
  H5Dwrite(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  const hid_t text = text_type();
  attribute(data, "Unit", text, datx.unit.c_str());
  attribute(data, "No Data", H5T_NATIVE_DOUBLE, DBL_MAX);
  attribute(data, "Wavelength", H5T_NATIVE_DOUBLE, 0.6e-6);
  attribute(data, "Interferometric Scale Factor", H5T_NATIVE_DOUBLE, 0.5);
  attribute(data, "Obliquity Factor", H5T_NATIVE_DOUBLE, 2.);
  converter(data, "X Converter", datx, datx.pitch_x);
  converter(data, "Y Converter", datx, datx.pitch_y);
  for (const hid_t id : {text, data, space})
    H5Idec_ref(id);
}

}  // namespace

std::vector<std::byte> read_bytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text((std::istreambuf_iterator<char>(file)), {});
  const auto* begin = reinterpret_cast<const std::byte*>(text.data());
  return {begin, begin + text.size()};
}

void write_bytes(const std::filesystem::path& path, const std::vector<std::byte>& bytes) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

void write_text(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

std::vector<std::byte> small_dat(const DatHeader& header) {
  const std::size_t header_bytes = header.format == 3 ? 4096 : 834;
  constexpr std::size_t intensity_bytes = 2 * 2 * 3 * 2, points = 12;
  std::vector<std::byte> bytes(header_bytes + intensity_bytes + 4 * points, std::byte{0x11});
  std::fill_n(bytes.begin(), header_bytes, std::byte{0});
  put(bytes, 0, 0x881B036E + static_cast<std::uint32_t>(header.format), true);
  put(bytes, 4, static_cast<std::uint16_t>(header.format), true);
  put(bytes, 6, static_cast<std::uint32_t>(header_bytes), true);
  put<std::uint16_t>(bytes, 52, 2, true);
  put<std::uint16_t>(bytes, 54, 3, true);
  put<std::uint16_t>(bytes, 56, 2, true);
  put<std::uint32_t>(bytes, 60, intensity_bytes, true);
  put<std::uint16_t>(bytes, 68, 4, true);
  put<std::uint16_t>(bytes, 70, 3, true);
  put<std::uint32_t>(bytes, 72, 4 * points, true);
  put(bytes, 164, 0.5F, true);
  put(bytes, 168, header.wavelength, true);
  put(bytes, 176, 2.F, true);
  put(bytes, 184, header.lateral, true);
  put(bytes, 218, static_cast<std::int16_t>(header.phase_res), true);
  put(bytes, 232, static_cast<std::int16_t>(header.sign), true);
  for (std::size_t k = 0; k < points; ++k)
    put(bytes, header_bytes + intensity_bytes + 4 * k,
        k == 5 ? 2147483640 : static_cast<std::int32_t>(k) * 1000 - 3000, true);
  return bytes;
}

void write_small_datx(const std::filesystem::path& path, const Datx& datx) {
  const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
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

std::string small_asc(const std::string& intensities, int sign) {
  const std::string buckets = intensities.empty() ? "0" : "1";
  return "Zygo ASCII Data File - Format 2\n1 8 1 5 \"Mon Oct 31 13:29:09 2005     \"\n0 0 2 2 " + buckets +
         " 255\n0 0 3 2\n\"a # b\"\n\"c\"\n\"d\"\n0 0.5 2e-006 0 1 0 2.5e-007 1421361442\n"
         "640 480 22 0 59233 0 \" 20X  Mirau\"\n2 0 0 0 0 0 0 30.074 1 0\n1 0 7 1 60 0 0 " +
         std::to_string(sign) + " 0\n0 \"  \"\n1 0\n\"   2X  \"\n#\n" + intensities +
         "32768 -32768 0 2147483640 \n65536 1 \n#\n";
}

std::string small_xyz() {
  return "Zygo XYZ Data File - Format 1\n1 8 1 5 \"Mon Oct 31 13:29:09 2005     \"\n0 0 0 0 0 255\n10 20 3 "
         "2\n"
         "\"a\"\n\"c\"\n\"d\"\n0 0.5 2e-006 0 1 0 2.5e-007 1421361442\n640 480 22 0 59233 0 \" 20X  Mirau\"\n"
         "2 0 0 0 0 0 0 30.074 1 0\n1 0 7 1 60 0 0 0 0\n0 \"  \"\n1 0\n#\n"
         "10 20 0.5\n11 20 -1.25e-001\n12\t20\tNo Data\n10 21 2\n11 21 3\n12 21 4\n#\n";
}

std::vector<std::byte> small_surf(const Surf& surf) {
  const std::array raw = {10, 20, 30, 40, 50, 8};
  const auto bytes_each = static_cast<std::size_t>(surf.bits / 8);
  const bool big = surf.macintosh;
  constexpr std::size_t header = 512, comment = 7, own = 5;
  std::vector<std::byte> bytes(header + comment + own + raw.size() * bytes_each, std::byte{0});
  const auto text = [&](std::size_t at, const std::string& value, std::size_t size) {
    std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), size, std::byte{' '});
    std::memcpy(bytes.data() + at, value.data(), value.size());
  };
  text(0, "DIGITAL SURF", 12);
  put<std::int16_t>(bytes, 12, big ? 257 : 0, big);
  put<std::int16_t>(bytes, 14, 1, big);
  put<std::int16_t>(bytes, 18, 2, big);
  put(bytes, 86, static_cast<std::int16_t>(surf.special_points), big);
  put(bytes, 98, static_cast<std::int16_t>(surf.bits), big);
  put<std::int32_t>(bytes, 100, 10, big);
  put<std::int32_t>(bytes, 104, 50, big);
  put<std::int32_t>(bytes, 108, 3, big);
  put<std::int32_t>(bytes, 112, 2, big);
  put<std::int32_t>(bytes, 116, 6, big);
  put(bytes, 120, 0.25F, big);
  put(bytes, 124, 0.5e-3F, big);
  put(bytes, 128, 0.5F, big);
  text(180, "\xB5m", 16);
  text(196, "mm", 16);
  text(212, surf.dz_unit, 16);
  put<std::uint16_t>(bytes, 334, comment, big);
  put<std::uint16_t>(bytes, 336, own, big);
  put(bytes, 474, 100.F, big);
  for (std::size_t k = 0; k < raw.size(); ++k) {
    const std::size_t at = header + comment + own + k * bytes_each;
    if (surf.bits == 16)
      put(bytes, at, static_cast<std::int16_t>(raw[k]), big);
    else
      put<std::int32_t>(bytes, at, raw[k], big);
  }
  return bytes;
}

std::vector<std::byte> compressed_surf(const std::vector<std::byte>& plain, std::size_t point_bytes) {
  std::vector<std::byte> bytes(plain.begin(), plain.end() - static_cast<std::ptrdiff_t>(point_bytes));
  std::memcpy(bytes.data(), "DSCOMPRESSED", 12);
  const std::size_t directory = bytes.size(), half = point_bytes / 2;
  bytes.resize(directory + 4 + 2 * 8);
  put<std::uint32_t>(bytes, directory, 2, false);
  for (std::size_t stream = 0; stream < 2; ++stream) {
    std::array<Bytef, 200> packed;
    uLongf size = packed.size();
    compress(packed.data(), &size,
             reinterpret_cast<const Bytef*>(plain.data() + plain.size() - point_bytes + stream * half), half);
    put(bytes, directory + 4 + 8 * stream, static_cast<std::uint32_t>(half), false);
    put(bytes, directory + 8 + 8 * stream, static_cast<std::uint32_t>(size), false);
    const auto* begin = reinterpret_cast<const std::byte*>(packed.data());
    bytes.insert(bytes.end(), begin, begin + size);
  }
  return bytes;
}

}  // namespace micro
