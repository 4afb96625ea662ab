#pragma once

#include <concepts>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/grid.h"
#include "io/atomic_file.h"

namespace micro {

/// Extents of a dataset, slowest axis first.
using Shape = std::vector<std::size_t>;

/// Writes one HDF5 file: whole or absent. Objects are named by their path ("/ndf/filtered/density"); groups
/// on the way are made as needed. Only finish() gives the file its name, after the root attribute `complete`
/// = 1: an HDF5 file that was cut still opens and looks valid. Every failure is a FileError that names the
/// final file. Calls are serialised, so several threads may write several files.
class Hdf5Writer {
 public:
  explicit Hdf5Writer(const std::filesystem::path& path);
  /// Writes `path` as a copy of `source`, which may be the same file, to be added to. Until finish() the old
  /// file stays as it is.
  static Hdf5Writer amend(const std::filesystem::path& source, const std::filesystem::path& path);
  ~Hdf5Writer();
  Hdf5Writer(Hdf5Writer&& other) noexcept;
  Hdf5Writer& operator=(Hdf5Writer&&) = delete;

  /// Makes a group and those above it; nothing happens if it is there.
  void create_group(const std::string& group);

  /// Takes an object, and all below it, out of the file; nothing happens if it is not there.
  void remove(const std::string& object);

  /// Writes a dataset of float, double, uint8, int32, uint32, int64 or uint64, row-major. `deflate` 0 stores
  /// it as it is, 1…9 in chunks of whole rows, shuffled and deflated.
  template <typename T>
  void write(const std::string& dataset, std::span<const T> values, const Shape& shape, int deflate = 0);
  template <typename T>
  void write(const std::string& dataset, const Grid<T>& values, int deflate = 0) {
    write(dataset, std::span<const T>(values.data(), static_cast<std::size_t>(values.size())),
          {static_cast<std::size_t>(values.rows()), static_cast<std::size_t>(values.cols())}, deflate);
  }

  /// Writes a dataset of float, [slices, rows, cols], slice by slice: slice(k) gives rows × cols values.
  /// Chunks hold rows of one slice.
  void write_slices(const std::string& dataset, const Shape& shape, int deflate,
                    const std::function<Grid<float>(std::size_t)>& slice);

  /// Makes a dataset of float, [rows, cols, numbers], in deflated chunks of `side` × `side` × numbers, to be
  /// filled part by part.
  void create_in_parts(const std::string& dataset, const Shape& shape, std::size_t side, int deflate);
  /// Fills rows × cols places of it from (row, col) on; values are [rows, cols, numbers].
  void write_part(const std::string& dataset, std::size_t row, std::size_t col, const Shape& shape,
                  std::span<const float> values);

  /// Writes a dataset of float, [rows, cols, …], of which few places (row, col) hold anything: table(k) is
  /// what stands at places[k] = row·cols + col, in a deflated chunk of its own. Places that are not among
  /// them, or whose table is empty, take no memory, hardly any of the file, and read as NaN.
  void write_sparse(const std::string& dataset, const Shape& shape, int deflate,
                    std::span<const std::int64_t> places,
                    const std::function<std::span<const float>(std::size_t)>& table);

  /// Writes one UTF-8 string as a scalar dataset.
  void write_text(const std::string& dataset, std::string_view text);

  /// Writes attributes of a group or dataset that is there; an attribute that is there is replaced.
  void set_attribute(const std::string& object, const std::string& name, std::string_view value);
  void set_attribute(const std::string& object, const std::string& name, double value);
  void set_attribute(const std::string& object, const std::string& name, std::span<const double> values);
  void set_attribute(const std::string& object, const std::string& name, std::span<const std::string> values);
  void set_attribute(const std::string& object, const std::string& name, const Grid<double>& values);
  template <std::integral T>
  void set_attribute(const std::string& object, const std::string& name, T value) {
    set_integer_attribute(object, name, static_cast<std::int64_t>(value));
  }

  /// Makes a 1-D dataset a dimension scale called `label`.
  void make_scale(const std::string& dataset, const std::string& label);

  /// Attaches a scale to an axis of a dataset (0 is the slowest) and labels the axis `label`.
  void attach_scale(const std::string& dataset, unsigned axis, const std::string& scale,
                    const std::string& label);

  /// Flushes, marks the file complete, closes it, brings it to the disk and gives it its name. Without it
  /// nothing stays behind.
  void finish();

 private:
  Hdf5Writer(AtomicFile file, std::int64_t id);
  void unfinish();  // takes `complete` away
  void set_integer_attribute(const std::string& object, const std::string& name, std::int64_t value);
  void write_attribute(const std::string& object, const std::string& name, std::int64_t memory_type,
                       std::int64_t file_type, std::int64_t space, const void* values);
  void require(bool done, const std::string& what) const;

  AtomicFile file_;
  std::int64_t id_ = -1;  // HDF5's hid_t
};

}  // namespace micro
