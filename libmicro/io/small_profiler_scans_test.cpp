#include "io/small_profiler_scans_test.h"

#include <zlib.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "io/small_scans_test.h"

namespace micro {
namespace {

constexpr std::size_t kPoints = 6;

/// Heights of µm as integers or floats of 0.5 µm, the last one missing if T can say so.
template <typename T>
std::vector<std::byte> points() {
  using Limits = std::numeric_limits<T>;
  std::vector<std::byte> bytes(kPoints * sizeof(T));
  for (std::size_t k = 0; k < kPoints; ++k) {
    T value = static_cast<T>(2 * (k + 1));
    if (k == 5 && sizeof(T) > 1)
      value = !Limits::is_integer ? Limits::quiet_NaN() : Limits::is_signed ? Limits::min() : Limits::max();
    put(bytes, k * sizeof(T), value, false);
  }
  return bytes;
}

void append_block(std::vector<std::byte>& directory, std::vector<std::byte>& data, const std::string& name,
                  std::int16_t type, const std::vector<std::byte>& content) {
  const std::size_t at = directory.size();
  directory.resize(at + 24);
  std::memcpy(directory.data() + at, name.data(), name.size());
  put(directory, at + 16, type, false);
  put(directory, at + 18, static_cast<std::int32_t>(content.size()), false);
  data.insert(data.end(), content.begin(), content.end());
}

template <typename T>
std::vector<std::byte> bytes_of(T value) {
  std::vector<std::byte> bytes(sizeof(T));
  put(bytes, 0, value, false);
  return bytes;
}

}  // namespace

std::string small_sdf_ascii() {
  return "aISO-1.0\r\nManufacID = ISOTC213\r\nCreateDate = 040120100853\r\nModDate = "
         "050320101353\r\nNumPoints = "
         "3\r\nNumProfiles = 2\r\nXscale = 0.25E-6\r\nYscale = 5e-7\r\nZscale = 1.0E-6\r\nZresolution = "
         "1.0E-9\r\n"
         "Compression = 0\r\nDataType = 7\r\nCheckType = 0\r\n*\r\n1.0 2 +3\r\n4.00 5 BAD\r\n*\r\n< Note > "
         "BAD\r\n*";
}

std::vector<std::byte> small_sdf_binary(const Sdf& sdf) {
  std::vector<std::byte> bytes(sdf.olympus ? 89 : 81);
  std::memcpy(bytes.data(), "bISO-1.0Somebody  040120100853050320101353", 42);
  put<std::uint16_t>(bytes, 42, 3, false);
  put<std::uint16_t>(bytes, 44, 2, false);
  put(bytes, 46, 0.25e-6, false);
  put(bytes, 54, 0.5e-6, false);
  put(bytes, 62, 0.5e-6, false);
  put(bytes, 70, 1e-9, false);
  bytes[79] = static_cast<std::byte>(sdf.type);
  constexpr std::array points_of_type = {points<std::uint8_t>, points<std::uint16_t>, points<std::uint32_t>,
                                         points<float>,        points<std::int8_t>,   points<std::int16_t>,
                                         points<std::int32_t>, points<double>};
  const auto data = points_of_type.at(static_cast<std::size_t>(sdf.type))();
  bytes.insert(bytes.end(), data.begin(), data.end());
  return bytes;
}

std::vector<std::byte> small_opd(const Opd& opd) {
  // Columns from the bottom: (row 1, column 0), (row 0, column 0), …
  constexpr std::array order = {3, 0, 4, 1, 5, 2};
  std::vector<std::byte> heights(6 + kPoints * (opd.floats ? 4 : 2));
  put<std::uint16_t>(heights, 0, 3, false);
  put<std::uint16_t>(heights, 2, 2, false);
  put<std::uint16_t>(heights, 4, opd.floats ? 4 : 2, false);
  for (std::size_t k = 0; k < kPoints; ++k) {
    const int point = order[k];
    if (opd.floats)
      put(heights, 6 + 4 * k, point == 5 ? 1e38F : 2.F * static_cast<float>(point + 1), false);
    else
      put(heights, 6 + 2 * k, static_cast<std::int16_t>(point == 5 ? 32766 : 500 * (point + 1)), false);
  }
  std::vector<std::byte> directory(2), data;
  directory[0] = std::byte{1};
  append_block(directory, data, "Directory", 1, {});
  append_block(directory, data, "Empty", 5, {});
  if (!opd.floats) append_block(directory, data, "Mult", 6, bytes_of<std::int16_t>(250));
  append_block(directory, data, opd.name, 3, heights);
  append_block(directory, data, "Wavelength", 7, bytes_of(500.F));
  append_block(directory, data, "Aspect", 7, bytes_of(2.F));
  append_block(directory, data, "Pixel_size", 7, bytes_of(0.25e-3F));
  directory.resize(directory.size() + 24);  // records in reserve
  put(directory, 2 + 18, static_cast<std::int32_t>(directory.size() - 2), false);
  directory.insert(directory.end(), data.begin(), data.end());
  return directory;
}

std::vector<std::byte> small_plu() {
  std::vector<std::byte> bytes(508 + 4 * kPoints + 8);
  std::memcpy(bytes.data(), "Fri Mar 10 16:35:59 2023", 24);
  put(bytes, 404, 0.25F, false);
  put(bytes, 408, 0.5F, false);
  put<std::uint32_t>(bytes, 428, 3, false);
  put<std::uint32_t>(bytes, 444, 3, false);
  for (const std::size_t at : {388, 448, 456, 500}) {
    put<std::uint32_t>(bytes, at, 2, false);
    put<std::uint32_t>(bytes, at + 4, 3, false);
  }
  for (std::size_t k = 0; k < kPoints; ++k)
    put(bytes, 508 + 4 * k, k == 5 ? 1000001.F : static_cast<float>(k + 1), false);
  return bytes;
}

std::vector<std::byte> small_vk4(const Vk4& vk4) {
  constexpr std::size_t settings = 84, settings_size = 304, image = settings + settings_size, header = 796;
  const std::size_t bytes_each = vk4.bits / 8;
  std::vector<std::byte> bytes(image + header + 6 * bytes_each);
  const auto integer = [&](std::size_t at, std::size_t value) {
    put(bytes, at, static_cast<std::uint32_t>(value), false);
  };
  std::memcpy(bytes.data(), "VK4_", 4);
  integer(4, 0x08000001);  // version
  integer(12, settings);
  integer(36, image);
  integer(settings, settings_size);
  integer(settings + 168, 250000);  // pm
  integer(settings + 172, 500000);
  integer(settings + 176, 500000);
  integer(image, 3);
  integer(image + 4, 2);
  integer(image + 8, vk4.bits);
  integer(image + 16, 6 * bytes_each);
  for (std::size_t k = 0; k < 6; ++k)
    bytes[image + header + k * bytes_each] = static_cast<std::byte>(2 * (k + 1));
  return bytes;
}

std::string small_gsf() {
  std::string text =
      "Gwyddion Simple Field 1.0\nXRes = 3\nYRes = 2\nXReal=7.5e-07\nYReal = 0.000001\nXYUnits = m\n"
      "ZUnits =  m\nTitle = XRes = 9\n";
  text.append(4 - text.size() % 4, '\0');
  for (int k = 1; k <= 6; ++k) {
    const auto point =
        bytes_of(k == 6 ? std::numeric_limits<float>::quiet_NaN() : 1e-6F * static_cast<float>(k));
    text.append(reinterpret_cast<const char*>(point.data()), point.size());
  }
  return text;
}

std::string x3p_main(const X3pFile& file) {
  const bool integer = file.type == 'I' || file.type == 'L';
  std::string text =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<p:ISO5436_2 "
      "xmlns:p=\"http://www.opengps.eu/2008/ISO5436_2\"><Record1><Revision>ISO5436 - "
      "2000</Revision><FeatureType>SUR</FeatureType><Axes><CX><AxisType>I</AxisType><Increment>2.5e-007</"
      "Increment></CX><CY><AxisType>I</AxisType><Increment> 0.0000005 "
      "</Increment><Offset/></CY><CZ><AxisType>A</AxisType><DataType>";
  text += file.type;
  text += integer ? "</DataType><Increment>5e-7</Increment><Offset>-0.000001</Offset></CZ>"
                  : "</DataType><Increment/><Offset/></CZ>";
  text +=
      "</Axes></Record1><Record3><MatrixDimension><SizeX>3</SizeX><SizeY>2</SizeY><SizeZ>1</SizeZ></"
      "MatrixDimension><DataLink><PointDataLink>bindata/data.bin</PointDataLink>";
  if (!file.md5.empty()) text += "<MD5ChecksumPointData>" + file.md5 + "</MD5ChecksumPointData>";
  if (integer || file.valid_points) text += "<ValidPointsLink>bindata/valid.bin</ValidPointsLink>";
  return text + "</DataLink></Record3></p:ISO5436_2>\n";
}

std::vector<std::byte> small_x3p(const X3pFile& file, const std::string& main) {
  const bool integer = file.type == 'I' || file.type == 'L', list = integer || file.valid_points;
  std::vector<std::byte> points;
  for (int k = 1; k <= 6; ++k) {
    const double metres = k == 6 && !list ? file.missing : 1e-6 * k;
    const auto point = file.type == 'I'   ? bytes_of(static_cast<std::int16_t>(2 * (k + 1)))
                       : file.type == 'L' ? bytes_of(static_cast<std::int32_t>(2 * (k + 1)))
                       : file.type == 'F' ? bytes_of(static_cast<float>(metres))
                                          : bytes_of(metres);
    points.insert(points.end(), point.begin(), point.end());
  }
  std::vector<StoredMember> members;
  if (!file.folder.empty())
    members = {
        {file.folder, ""}, {"__MACOSX/main.xml", "Mac"}, {"__MACOSX/" + file.folder + "main.xml", "Mac"}};
  members.push_back({file.folder + "main.xml", main});
  members.push_back(
      {file.folder + "bindata/data.bin", {reinterpret_cast<const char*>(points.data()), points.size()}});
  if (list) members.push_back({file.folder + "bindata/valid.bin", "\x1F"});
  return stored_zip(members);
}

std::vector<std::byte> small_x3p(const X3pFile& file) {
  return small_x3p(file, x3p_main(file));
}

std::vector<std::byte> stored_zip(const std::vector<StoredMember>& members) {
  std::vector<std::byte> archive, directory;
  const auto append = [](std::vector<std::byte>& to, const std::string& text) {
    const auto* begin = reinterpret_cast<const std::byte*>(text.data());
    to.insert(to.end(), begin, begin + text.size());
  };
  for (const auto& [name, content] : members) {
    const auto size = static_cast<std::uint32_t>(content.size());
    const auto crc = static_cast<std::uint32_t>(
        crc32(0, reinterpret_cast<const Bytef*>(content.data()), static_cast<uInt>(content.size())));
    // From the needed version to the length of the name both headers are the same.
    std::vector<std::byte> common(24);
    put<std::uint16_t>(common, 0, 20, false);
    put<std::uint16_t>(common, 8, 0x21, false);
    put(common, 10, crc, false);
    put(common, 14, size, false);
    put(common, 18, size, false);
    put(common, 22, static_cast<std::uint16_t>(name.size()), false);
    const auto at = static_cast<std::uint32_t>(archive.size());
    append(archive, "PK\3\4");
    archive.insert(archive.end(), common.begin(), common.end());
    archive.resize(archive.size() + 2);
    append(archive, name + content);
    append(directory, std::string("PK\1\2\x14\0", 6));
    directory.insert(directory.end(), common.begin(), common.end());
    directory.resize(directory.size() + 16);
    put(directory, directory.size() - 4, at, false);
    append(directory, name);
  }
  std::vector<std::byte> end(18);
  put(end, 4, static_cast<std::uint16_t>(members.size()), false);
  put(end, 6, static_cast<std::uint16_t>(members.size()), false);
  put(end, 8, static_cast<std::uint32_t>(directory.size()), false);
  put(end, 12, static_cast<std::uint32_t>(archive.size()), false);
  archive.insert(archive.end(), directory.begin(), directory.end());
  append(archive, "PK\5\6");
  archive.insert(archive.end(), end.begin(), end.end());
  return archive;
}

}  // namespace micro
