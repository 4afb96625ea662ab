#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/grid.h"
#include "io/hdf5_writer.h"

namespace micro {

/// What every HDF5 file begins with.
constexpr std::string_view kHdf5Signature = "\x89HDF\r\n\x1a\n";

/// Fields of one element of a compound, by name: text, a number, or a list of numbers. Fields of any other
/// kind are left out.
using Hdf5Record = std::map<std::string, std::variant<std::string, double, std::vector<double>>, std::less<>>;

/// Reads one HDF5 file. Objects are named by their path. Every failure is a FileError naming the file and the
/// object. Nothing is allocated before the size in the header has been held against the bytes that are there.
/// Calls are serialised, so several threads may read several files.
class Hdf5Reader {
 public:
  explicit Hdf5Reader(const std::filesystem::path& path);
  ~Hdf5Reader();
  Hdf5Reader(Hdf5Reader&& other) noexcept;
  Hdf5Reader& operator=(Hdf5Reader&&) = delete;

  /// Throws FileError unless this is a file of ours that was finished: root attributes format = "microbrdf"
  /// and complete = 1. Files made by other programs need not pass.
  void require_complete() const;

  bool contains(const std::string& object) const;
  bool is_group(const std::string& object) const;
  /// Names of the objects in a group, sorted.
  std::vector<std::string> children(const std::string& group) const;

  Shape shape(const std::string& dataset) const;
  /// All values, row-major, of an integer or floating-point dataset, converted to T (the types of
  /// Hdf5Writer::write).
  template <typename T>
  std::vector<T> read(const std::string& dataset) const;
  /// The same for a 2-D dataset.
  template <typename T>
  Grid<T> read_grid(const std::string& dataset) const;
  /// A dataset of one string.
  std::string read_text(const std::string& dataset) const;
  std::vector<Hdf5Record> read_records(const std::string& dataset) const;

  bool has_attribute(const std::string& object, const std::string& name) const;
  /// An attribute of one string, one number or one integer, scalar or of length one.
  std::string text_attribute(const std::string& object, const std::string& name) const;
  double number_attribute(const std::string& object, const std::string& name) const;
  std::int64_t integer_attribute(const std::string& object, const std::string& name) const;
  std::vector<double> numbers_attribute(const std::string& object, const std::string& name) const;
  std::vector<std::string> texts_attribute(const std::string& object, const std::string& name) const;
  /// A compound attribute.
  std::vector<Hdf5Record> records_attribute(const std::string& object, const std::string& name) const;

 private:
  class Source;
  Source attribute(const std::string& object, const std::string& name) const;
  Source dataset(const std::string& dataset) const;
  [[noreturn]] void fail(const std::string& fact) const;

  std::filesystem::path path_;
  std::uintmax_t size_ = 0;  // bytes in the file
  std::int64_t id_ = -1;     // HDF5's hid_t
};

}  // namespace micro
