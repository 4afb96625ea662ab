#include "io/x3p.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <pugixml.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "io/md5.h"
#include "io/printable.h"
#include "io/words.h"
#include "io/zip_archive.h"

namespace micro {
namespace {

using std::string_view;

constexpr string_view kMain = "main.xml";
constexpr string_view kRoot = "ISO5436";       ///< what the name of the root element begins with
constexpr double kMicrometres = 1e6;           // in a metre
constexpr std::uint64_t kMostXml = 16U << 20;  // bytes: it holds descriptions, not points
constexpr std::uint64_t kMostChecksum = 4096;  // bytes

string_view local_name(const pugi::xml_node& node) {
  const string_view name = node.name();
  const std::size_t colon = name.find(':');
  return colon == string_view::npos ? name : name.substr(colon + 1);
}

/// The child of that name, whatever its namespace; an empty node if there is none.
pugi::xml_node child(const pugi::xml_node& parent, string_view name) {
  return parent.find_child([&](const pugi::xml_node& node) { return local_name(node) == name; });
}

string_view text_of(const pugi::xml_node& node) {
  string_view text = node.text().get();
  while (!text.empty() && is_blank(text.front()))
    text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back()))
    text.remove_suffix(1);
  return text;
}

/// The path of main.xml, the one nearest to the top; macOS leaves shadows of files in __MACOSX. Empty if
/// there is none.
std::string find_main(const std::vector<std::string>& names) {
  const auto depth = [](const std::string& name) { return std::count(name.begin(), name.end(), '/'); };
  std::string found;
  for (const std::string& name : names)
    if (name.substr(name.rfind('/') + 1) == kMain && !name.starts_with("__MACOSX/") &&
        (found.empty() || depth(name) < depth(found)))
      found = name;
  return found;
}

bool same_digits(string_view a, string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}

/// An archive with its main.xml.
class X3p {
 public:
  explicit X3p(const std::filesystem::path& path) : path_(path), archive_(path) {
    const std::string main = find_main(archive_.names());
    folder_ = main.substr(0, main.size() - std::min(main.size(), kMain.size()));
    if (!main.empty()) main_ = archive_.read(main, kMostXml).value_or(std::vector<std::byte>{});
    parsed_ = document_.load_buffer(main_.data(), main_.size());
    root_ =
        document_.find_child([](const pugi::xml_node& node) { return local_name(node).starts_with(kRoot); });
  }
  bool has_main() const { return !main_.empty(); }
  bool is_parsed() const { return parsed_; }
  pugi::xml_node root() const { return root_; }

  void require(bool condition, const char* fact) const {
    if (!condition) throw FileError(path_, fact);
  }
  void require_main() const {
    require(has_main(), "holds no main.xml");
    require(parsed_, "its main.xml is no XML");
    require(!root_.empty(), "its main.xml is not of ISO 5436-2");
  }
  /// The number in a node; `otherwise` if the node is absent or empty.
  double number(const pugi::xml_node& node, double otherwise) const {
    double value = otherwise;
    if (const string_view text = text_of(node); !text.empty() && !parse_number(text, value))
      throw FileError(path_, "its " + std::string(node.name()) + " " + in_quotes(text) + " is no number");
    return value;
  }
  std::uint64_t extent(string_view name) const {
    const auto node = child(child(child(root_, "Record3"), "MatrixDimension"), name);
    std::uint32_t value = 0;
    if (!parse_number(text_of(node), value))
      throw FileError(path_, "its main.xml has no " + std::string(name) + " of a matrix of points");
    return value;
  }
  /// The member that a link in main.xml names, relative to its folder.
  std::vector<std::byte> linked(string_view link, std::uint64_t most) const {
    std::string name(link);
    std::replace(name.begin(), name.end(), '\\', '/');
    while (name.starts_with("./") || name.starts_with('/'))
      name.erase(0, name.find('/') + 1);
    auto bytes = archive_.read(folder_ + name, most);
    if (!bytes) throw FileError(path_, "its main.xml names " + in_quotes(name) + ", which is missing");
    return *std::move(bytes);
  }
  /// Holds bytes against the MD5 that is stated for them, if one is. Throws FileError if it is another.
  void check_md5(string_view what, const std::vector<std::byte>& bytes, string_view stated) const {
    if (stated.empty()) return;
    if (const std::string md5 = md5_of(bytes); !md5.empty() && !same_digits(md5, stated))
      throw FileError(path_, "the MD5 checksum of its " + std::string(what) + " is " + md5 + ", but " +
                                 in_quotes(stated) +
                                 " is stated: it was damaged or changed after it was written");
  }
  /// Holds main.xml against the file of its checksum, if there is one.
  void check_main() const {
    string_view name = text_of(child(child(root_, "Record4"), "ChecksumFile"));
    if (name.empty()) name = "md5checksum.hex";
    const auto bytes = archive_.read(folder_ + std::string(name), kMostChecksum);
    if (!bytes) return;
    const string_view text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
    check_md5(kMain, main_, text.substr(0, text.find_first_of(" \t\r\n*")));
  }

 private:
  std::filesystem::path path_;
  ZipArchive archive_;
  std::string folder_;
  std::vector<std::byte> main_;
  pugi::xml_document document_;
  pugi::xml_node root_;
  bool parsed_ = false;
};

/// Points in metres → µm: raw·increment + offset; those whose bit in `valid` is 0 are missing.
struct Points {
  std::vector<std::byte> raw, valid;
  double increment, offset;
};

template <typename T>
HeightField read_points(const std::filesystem::path& path, const Points& points, std::uint64_t rows,
                        std::uint64_t cols, Pitch pitch) {
  const double step = points.increment * kMicrometres, offset = points.offset * kMicrometres;
  return read_height_field(path, rows, cols, pitch, [&, step, offset](Eigen::Index k) {
    const auto point = static_cast<std::size_t>(k);
    if (!points.valid.empty() &&
        (std::to_integer<unsigned>(points.valid[point / 8]) >> (point % 8) & 1U) == 0)
      return std::numeric_limits<double>::quiet_NaN();
    return static_cast<double>(load<T>(points.raw.data() + point * sizeof(T), std::endian::little)) * step +
           offset;
  });
}

struct Type {
  std::size_t bytes;
  HeightField (*read)(const std::filesystem::path&, const Points&, std::uint64_t rows, std::uint64_t cols,
                      Pitch);
};

Type type_of(const std::filesystem::path& path, string_view name) {
  if (name == "I") return {2, read_points<std::int16_t>};
  if (name == "L") return {4, read_points<std::int32_t>};
  if (name == "F") return {4, read_points<float>};
  if (name == "D") return {8, read_points<double>};
  throw FileError(path, "its data type " + in_quotes(name) + " is unknown (I, L, F and D are known)");
}

/// The scale of the heights. Floats are metres as they stand, so an increment beside them would contradict.
std::pair<double, double> height_scale(const X3p& file, const pugi::xml_node& axis, string_view type) {
  const double increment = file.number(child(axis, "Increment"), 1),
               offset = file.number(child(axis, "Offset"), 0);
  file.require(std::isfinite(increment) && increment != 0 && std::isfinite(offset),
               "its height scale makes no sense");
  file.require(type == "I" || type == "L" || increment == 1,
               "its heights are floats, which are metres, and yet it gives them an increment");
  return {increment, offset};
}

double axis_pitch(const X3p& file, const pugi::xml_node& axis) {
  file.require(text_of(child(axis, "AxisType")) != "A",
               "its points are not evenly spaced (an absolute axis)");
  return file.number(child(axis, "Increment"), 0) * kMicrometres;
}

void append(pugi::xml_node parent, const char* name, const std::string& text) {
  parent.append_child(name).text().set(text.c_str());
}

/// The shortest text that reads back as the same number.
std::string number_text(double value) {
  std::array<char, 32> text;
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

std::string main_xml(const HeightField& surface, const std::string& md5) {
  pugi::xml_document document;
  pugi::xml_node declaration = document.append_child(pugi::node_declaration);
  declaration.append_attribute("version") = "1.0";
  declaration.append_attribute("encoding") = "UTF-8";
  pugi::xml_node root = document.append_child("p:ISO5436_2");
  root.append_attribute("xmlns:p") = "http://www.opengps.eu/2008/ISO5436_2";
  pugi::xml_node record1 = root.append_child("Record1");
  append(record1, "Revision", "ISO5436 - 2000");
  append(record1, "FeatureType", "SUR");
  pugi::xml_node axes = record1.append_child("Axes");
  const auto append_axis = [&](const char* name, const char* kind, const char* type, double increment) {
    pugi::xml_node axis = axes.append_child(name);
    append(axis, "AxisType", kind);
    append(axis, "DataType", type);
    append(axis, "Increment", number_text(increment));
    append(axis, "Offset", "0");
  };
  append_axis("CX", "I", "D", surface.dx / kMicrometres);
  append_axis("CY", "I", "D", surface.dy / kMicrometres);
  append_axis("CZ", "A", "D", 1);
  pugi::xml_node record3 = root.append_child("Record3");
  pugi::xml_node matrix = record3.append_child("MatrixDimension");
  append(matrix, "SizeX", std::to_string(surface.cols()));
  append(matrix, "SizeY", std::to_string(surface.rows()));
  append(matrix, "SizeZ", "1");
  pugi::xml_node link = record3.append_child("DataLink");
  append(link, "PointDataLink", "bindata/data.bin");
  append(link, "MD5ChecksumPointData", md5);
  append(root.append_child("Record4"), "ChecksumFile", "md5checksum.hex");
  std::ostringstream text;
  document.save(text, "  ");
  return text.str();
}

std::vector<std::byte> bytes_of(string_view text) {
  const auto* begin = reinterpret_cast<const std::byte*>(text.data());
  return {begin, begin + text.size()};
}

}  // namespace

bool is_x3p(const FileHead& head) {
  if (!begins_with(head.bytes, kZipSignature)) return false;
  try {
    const X3p file(head.path);
    return file.has_main() && (!file.is_parsed() || file.root());
  } catch (const FileError&) {
    // A zip archive that was cut cannot be opened: its first names tell what it was.
    const string_view text(reinterpret_cast<const char*>(head.bytes.data()), head.bytes.size());
    return text.find(kMain) != string_view::npos || text.find("bindata/") != string_view::npos;
  }
}

HeightField read_x3p(const std::filesystem::path& path, const ReadOptions& options) {
  const X3p file(path);
  file.require_main();
  file.check_main();

  const std::uint64_t rows = file.extent("SizeY"), cols = file.extent("SizeX");
  file.require(rows > 0 && cols > 0, "holds no heights");
  file.require(file.extent("SizeZ") == 1, "holds several layers of points; files with one are read");
  const auto axes = child(child(file.root(), "Record1"), "Axes");
  const string_view type_name = text_of(child(child(axes, "CZ"), "DataType"));
  const Type type = type_of(path, type_name);
  const auto [increment, offset] = height_scale(file, child(axes, "CZ"), type_name);
  const Pitch pitch =
      file_pitch(path, {axis_pitch(file, child(axes, "CX")), axis_pitch(file, child(axes, "CY"))}, options);

  const auto link = child(child(file.root(), "Record3"), "DataLink");
  file.require(!text_of(child(link, "PointDataLink")).empty(),
               "keeps its points in main.xml; files with a binary file of points are read");
  std::uint64_t bytes = 0;
  const bool fits = !__builtin_mul_overflow(rows * cols, type.bytes, &bytes);  // two 32-bit numbers
  file.require(fits, "its rows and columns make no sense");
  Points points = {.raw = file.linked(text_of(child(link, "PointDataLink")), bytes),
                   .valid = {},
                   .increment = increment,
                   .offset = offset};
  file.require(points.raw.size() == bytes, "is cut: it has fewer points than its main.xml promises");
  file.check_md5("points", points.raw, text_of(child(link, "MD5ChecksumPointData")));
  if (const string_view valid = text_of(child(link, "ValidPointsLink")); !valid.empty()) {
    const std::uint64_t bits = rows * cols / 8 + 1;
    points.valid = file.linked(valid, bits);
    file.require(points.valid.size() >= (rows * cols + 7) / 8,
                 "is cut: its list of valid points is too short");
    file.check_md5("valid points", points.valid, text_of(child(link, "MD5ChecksumValidPoints")));
  }
  return type.read(path, points, rows, cols, pitch);
}

std::optional<StageWindow> stage_of_x3p(const std::filesystem::path& path) {
  const X3p file(path);
  file.require_main();
  const auto axes = child(child(file.root(), "Record1"), "Axes");
  const auto x = child(axes, "CX"), y = child(axes, "CY");
  if (text_of(child(x, "Offset")).empty() && text_of(child(y, "Offset")).empty()) return std::nullopt;
  const auto offset = [&](const pugi::xml_node& axis) {
    return file.number(child(axis, "Offset"), 0) * kMicrometres;
  };
  return StageWindow{.x = offset(x),
                     .y = offset(y),
                     .width = axis_pitch(file, x) * static_cast<double>(file.extent("SizeX")),
                     .height = axis_pitch(file, y) * static_cast<double>(file.extent("SizeY"))};
}

void write_x3p(const std::filesystem::path& path, const HeightField& surface) {
  std::vector<std::byte> points(static_cast<std::size_t>(surface.z.size()) * sizeof(double));
  std::byte* at = points.data();
  for (const float z : surface.z.reshaped<Eigen::RowMajor>()) {
    store(at, (surface.mean + static_cast<double>(z)) / kMicrometres, std::endian::little);
    at += sizeof(double);
  }
  const auto main = bytes_of(main_xml(surface, md5_of(points)));
  write_zip(path, {{std::string(kMain), main},
                   {"bindata/data.bin", std::move(points)},
                   {"md5checksum.hex", bytes_of(md5_of(main) + " *main.xml\n")}});
}

}  // namespace micro
