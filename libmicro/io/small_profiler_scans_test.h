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

/// Keyence VK4, whose heights are integers of 8, 16 or 32 bits; the format cannot say that a point is
/// missing: the last height is 6 µm.
struct Vk4 {
  std::uint32_t bits = 32;
};
std::vector<std::byte> small_vk4(const Vk4& vk4);

/// Gwyddion Simple Field.
std::string small_gsf();

/// X3P, its members stored as they are, without checksums unless `md5` states one for the points.
struct X3pFile {
  char type = 'D';            ///< I, L: raw is twice the height; F, D: metres
  std::string folder = "";    ///< of main.xml; with one, macOS has left its shadows
  bool valid_points = false;  ///< as I and L always have: a list of them; otherwise the last point is NaN
  double missing = 0;         ///< of F and D without a list
  std::string md5 = "";
};
std::string x3p_main(const X3pFile& file);
std::vector<std::byte> small_x3p(const X3pFile& file);
/// The same with another main.xml.
std::vector<std::byte> small_x3p(const X3pFile& file, const std::string& main);

/// A zip archive of members that are stored as they are.
struct StoredMember {
  std::string name, content;
};
std::vector<std::byte> stored_zip(const std::vector<StoredMember>& members);

}  // namespace micro
