#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string_view>

#include "height/height_field.h"

namespace micro {

/// A file as the recogniser sees it: its path (to look further into it, as HDF5 needs; the name says
/// nothing), its size and its first bytes.
struct FileHead {
  const std::filesystem::path& path;
  std::uintmax_t size;
  std::span<const std::byte> bytes;  ///< at most kHeadBytes
};
constexpr std::size_t kHeadBytes = 4096;

/// What a file cannot say about itself and the user has to.
struct ReadOptions {
  std::optional<double> pitch_x;  ///< µm, for formats without a lateral scale (.npy, plain text)
  std::optional<double> pitch_y;  ///< µm; like pitch_x when absent
};

/// What part of a specimen a scan shows, by its header: µm in the stage's coordinates, from its first point
/// on.
struct StageWindow {
  double x, y;           ///< of the first point
  double width, height;  ///< along columns and rows
};

/// One readable format. `recognise` looks at content alone; `read` throws FileError, naming the file and the
/// fact.
struct ScanFormat {
  std::string_view name;         ///< short name in tables and results, e.g. "zygo-dat"
  std::string_view description;  ///< what a user calls it
  /// Taken from a directory, only when its file is named, or known as what is no scan.
  enum class Listed { WhenFound, WhenNamed, Never } listed;
  bool (*recognise)(const FileHead& head);
  HeightField (*read)(const std::filesystem::path& path, const ReadOptions& options);
  /// What files begin with that a library opens for us (HDF5, zip, OpenEXR). Such a file is recognised and
  /// read in a child process, so that one that crashes its library is a FileError. Empty: our own parser
  /// reads it.
  std::string_view container = {};
  /// Where the stage stood, from the header alone; no value if the file does not say. Empty: this format
  /// cannot say it.
  std::optional<StageWindow> (*stage)(const std::filesystem::path& path) = nullptr;
};

/// The one visible table of formats, in order of recognition.
std::span<const ScanFormat> scan_formats();

/// The format of a file by its content, or nullptr.
/// Throws FileError if the file cannot be opened.
const ScanFormat* recognise_scan(const std::filesystem::path& path);

/// A scan and where it came from.
struct Scan {
  HeightField surface;
  std::filesystem::path path;
  std::string_view format;
};

/// Recognises and reads one file. Throws FileError if it is no known scan or is broken.
Scan read_scan(const std::filesystem::path& path, const ReadOptions& options = {});

/// Where the stage stood for a scan, by its header. Throws FileError if it is no known scan, its header is
/// broken, or it does not say.
StageWindow stage_window(const std::filesystem::path& path);

}  // namespace micro
