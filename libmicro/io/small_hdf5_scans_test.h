#pragma once

#include <filesystem>
#include <string>

// Small scans in HDF5 for tests, made without the code under test.
namespace micro {

/// How HDF5 lays a file out: as its first versions did (superblock 0, symbol tables), or as 1.10 does at its
/// newest (superblock 3, compact links, new chunk indices).
enum class Hdf5Layout { Earliest, Latest };
enum class Hdf5Storage {
  Contiguous,
  Deflated
};  ///< of the heights; deflated: in chunks, shuffled, with checksums

/// A .datx: 3 rows, 4 columns; value k + 0.5, except value 5, which is missing.
struct Datx {
  int converter_fields = 3;  ///< 3 or 5
  std::string unit = "NanoMeters";
  std::string sub_unit = "Meters";
  double pitch_x = 0.25e-6, pitch_y = 0.5e-6;
  int surfaces = 1;
  bool metadata = true;  ///< the graph names the last of them
  bool hard_link = false;
  Hdf5Layout layout = Hdf5Layout::Earliest;
  Hdf5Storage storage = Hdf5Storage::Contiguous;
};
void write_small_datx(const std::filesystem::path& path, const Datx& datx);

/// A height file of microbrdf's as another program might write it (texts of fixed length, big-endian
/// heights): 3 rows, 4 columns; k + 0.5 µm above a mean of 10 µm, except point 5, which is missing; pitch
/// 0.25 × 0.5 µm.
void write_small_height_file(const std::filesystem::path& path, Hdf5Layout layout, Hdf5Storage storage);

}  // namespace micro
