#include "io/npy.h"

#include <charconv>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/atomic_file.h"
#include "io/bytes.h"
#include "io/printable.h"

namespace micro {
namespace {

using std::string_view;

constexpr string_view kMagic = "\x93NUMPY";

/// What stands behind `'key':` in the header, a Python dictionary, up to where `ends` says.
string_view value_of(const FileBytes& file, string_view dictionary, const std::string& key,
                     string_view ends) {
  for (const char quote : {'\'', '"'}) {
    const std::string quoted = quote + key + quote;
    std::size_t at = dictionary.find(quoted);
    if (at == string_view::npos) continue;
    at = dictionary.find(':', at + quoted.size());
    if (at == string_view::npos) continue;
    at = dictionary.find_first_not_of(" \t", at + 1);
    if (at == string_view::npos) continue;
    const std::size_t end = dictionary.find_first_of(ends, at + 1);
    if (end != string_view::npos) return dictionary.substr(at, end - at);
  }
  throw FileError(file.path(), "its header has no " + key);
}

/// The two numbers of a shape "(rows, cols".
std::pair<std::uint64_t, std::uint64_t> parse_shape(const FileBytes& file, string_view text) {
  const char* at = text.data() + 1;
  const char* end = text.data() + text.size();
  std::vector<std::uint64_t> extents;
  while (text.front() == '(') {
    while (at < end && (*at == ' ' || *at == ','))
      ++at;
    if (at == end) break;
    std::uint64_t extent = 0;
    const auto [rest, error] = std::from_chars(at, end, extent);
    file.require(error == std::errc(), "its shape is no list of numbers");
    extents.push_back(extent);
    at = *rest == 'L' && rest < end ? rest + 1 : rest;  // numbers as Python 2 wrote them
  }
  if (extents.size() != 2)
    throw FileError(file.path(), "has " + std::to_string(extents.size()) + " dimensions instead of two");
  return {extents[0], extents[1]};
}

/// How the values lie in the file.
struct Layout {
  const std::byte* data;
  std::size_t available;  ///< bytes
  std::uint64_t rows, cols;
  bool fortran_order;  ///< columns are contiguous
  std::endian order;
};

template <typename T>
HeightField read_values(const FileBytes& file, const Layout& layout, Pitch pitch) {
  std::uint64_t bytes = 0;
  const bool overflow = __builtin_mul_overflow(layout.rows, layout.cols, &bytes) ||
                        __builtin_mul_overflow(bytes, sizeof(T), &bytes);
  file.require(!overflow && bytes <= layout.available, "is cut: its header promises more values than it has");
  return read_height_field(file.path(), layout.rows, layout.cols, pitch, [&](Eigen::Index k) {
    auto index = static_cast<std::uint64_t>(k);
    if (layout.fortran_order) index = index % layout.cols * layout.rows + index / layout.cols;
    return static_cast<double>(load<T>(layout.data + index * sizeof(T), layout.order));
  });
}

using ReadValues = HeightField (*)(const FileBytes&, const Layout&, Pitch);

/// The reader of a type like "<f4", without its byte order; nullptr if heights cannot be of that type.
ReadValues reader_of(string_view type) {
  if (type == "f4") return read_values<float>;
  if (type == "f8") return read_values<double>;
  if (type == "i1") return read_values<std::int8_t>;
  if (type == "i2") return read_values<std::int16_t>;
  if (type == "i4") return read_values<std::int32_t>;
  if (type == "i8") return read_values<std::int64_t>;
  if (type == "u1") return read_values<std::uint8_t>;
  if (type == "u2") return read_values<std::uint16_t>;
  if (type == "u4") return read_values<std::uint32_t>;
  if (type == "u8") return read_values<std::uint64_t>;
  return nullptr;
}

}  // namespace

bool is_npy(const FileHead& head) {
  return begins_with(head.bytes, kMagic);
}

HeightField read_npy(const std::filesystem::path& path, const ReadOptions& options) {
  const FileBytes file(path);
  file.require(file.size() >= 12, "is cut in its header");
  const int version = std::to_integer<int>(file.data()[6]);
  file.require(version >= 1 && version <= 3, "has a version of .npy that is unknown (1, 2 and 3 are known)");
  const std::size_t begin = version == 1 ? 10 : 12;
  const std::size_t length = version == 1 ? load<std::uint16_t>(file.data() + 8, std::endian::little)
                                          : load<std::uint32_t>(file.data() + 8, std::endian::little);
  file.require(length <= file.size() - begin, "is cut in its header");
  const string_view dictionary = file.text().substr(begin, length);

  string_view type = value_of(file, dictionary, "descr", "'\"");
  if (type.starts_with('\'') || type.starts_with('"')) type.remove_prefix(1);
  const ReadValues read_values_of_type = type.empty() ? nullptr : reader_of(type.substr(1));
  if (!read_values_of_type || std::string_view("<>|=").find(type.front()) == string_view::npos)
    throw FileError(path, "its values have the type " + in_quotes(type) +
                              "; heights are integers or floats of 32 or 64 bits");
  const string_view fortran = value_of(file, dictionary, "fortran_order", ",} ");
  file.require(fortran == "True" || fortran == "False", "its header does not say the memory order");
  const auto [rows, cols] = parse_shape(file, value_of(file, dictionary, "shape", ")"));
  return read_values_of_type(file,
                             {.data = file.data() + begin + length,
                              .available = file.size() - begin - length,
                              .rows = rows,
                              .cols = cols,
                              .fortran_order = fortran == "True",
                              .order = type.front() == '>' ? std::endian::big : std::endian::little},
                             user_pitch(path, options));
}

void write_npy(const std::filesystem::path& path, const HeightField& surface) {
  std::string header = "{'descr': '<f8', 'fortran_order': False, 'shape': (" +
                       std::to_string(surface.rows()) + ", " + std::to_string(surface.cols()) + "), }";
  // Magic, version 1.0, the length of the header, and a header that ends in a line feed where the data are
  // aligned.
  constexpr std::size_t preamble = 10, alignment = 64;
  header.append(alignment - 1 - (preamble + header.size()) % alignment, ' ').push_back('\n');
  std::vector<std::byte> bytes(preamble + header.size() +
                               static_cast<std::size_t>(surface.z.size()) * sizeof(double));
  std::memcpy(bytes.data(), kMagic.data(), kMagic.size());
  bytes[kMagic.size()] = std::byte{1};
  store(bytes.data() + 8, static_cast<std::uint16_t>(header.size()), std::endian::little);
  std::memcpy(bytes.data() + preamble, header.data(), header.size());
  std::byte* at = bytes.data() + preamble + header.size();
  for (const float z : surface.z.reshaped<Eigen::RowMajor>()) {
    store(at, surface.mean + static_cast<double>(z), std::endian::little);
    at += sizeof(double);
  }
  write_file(path, bytes);
}

}  // namespace micro
