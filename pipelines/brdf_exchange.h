#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipelines/brdf_report.h"

namespace micro {

/// Formats in which others read a BRDF.
enum class BrdfFormat {
  Tensor,   ///< .bsdf: RGL's measured BRDF, as Mitsuba 3 and pbrt-v4 read it
  Merl,     ///< .binary: MERL's isotropic table
  Astm,     ///< .astm: text in the manner of ASTM E1392, the slices that were asked for
  Radiance  ///< .xml: WINDOW's matrix in the full Klems basis, as Radiance reads it
};

/// By the file's suffix. Throws InputError for another one.
BrdfFormat brdf_format_of(const std::filesystem::path& path);

/// The files that write_exchanged_brdf() writes for `path`: it, and what says beside MERL's what its header
/// cannot.
std::vector<std::filesystem::path> exchange_paths(const std::filesystem::path& path);

/// What a file was told of its model, and how well it keeps it.
struct ExchangedBrdf {
  std::filesystem::path path;
  std::string kept;  ///< one line: sizes, and what was averaged
};

/// Writes the model in the format of `path`'s suffix; whole or absent. `report` names the model, the material
/// and the wavelengths, and has ASTM's slices. Throws InputError, FileError.
ExchangedBrdf write_exchanged_brdf(const std::filesystem::path& path, const AnyBrdf& model,
                                   const BrdfReport& report, const std::string& command);

}  // namespace micro
