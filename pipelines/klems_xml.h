#pragma once

#include <filesystem>
#include <span>
#include <string>

namespace micro {

/// What the head of such a file says.
struct KlemsXmlHead {
  std::string name, manufacturer;  ///< of the material
  std::string comment;             ///< source, version, units: an XML comment
};

/// Writes a reflection matrix [wo, wi] in 1/sr, 145 × 145 in the full Klems basis, as the XML of LBNL WINDOW
/// 6 that Radiance reads; the same for both faces. Whole or absent. Throws FileError.
void write_klems_xml(const std::filesystem::path& path, const KlemsXmlHead& head, std::span<const double> f);

}  // namespace micro
