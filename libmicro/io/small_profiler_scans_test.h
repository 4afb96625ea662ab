#pragma once

#include <cstddef>
#include <string>
#include <vector>

// Small scans of 3 columns and 2 rows for tests, made without the code under test: heights 1, 2, 3, 4, 5 µm
// in the grid's order, then one that is missing; pitch 0.25 × 0.5 µm.
namespace micro {

std::string small_sdf_ascii();

/// Binary SDF of a data type 0 to 7; of types 0 and 4, which cannot say it, nothing is missing and the last
/// height is 6 µm.
struct Sdf {
  int type = 7;
  bool olympus = false;  ///< two more integers behind the header
};
std::vector<std::byte> small_sdf_binary(const Sdf& sdf);

/// Wyko: 16-bit integers with Mult = 250, or floats without one.
struct Opd {
  bool floats = false;
  std::string name = "RAW_DATA";
};
std::vector<std::byte> small_opd(const Opd& opd);

std::vector<std::byte> small_plu();

}  // namespace micro
