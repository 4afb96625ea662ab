#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "brdf/fresnel.h"

namespace micro {

/// A metal with its published optical constants from 0.36 to 0.83 µm at least, as measured, not interpolated.
struct Metal {
  std::string name;         ///< Al, Cu, Au, Ag, Fe, Cr, Ni, Ti or steel
  std::string description;  ///< in words
  std::string source;       ///< the paper the numbers come from
  OpticalConstants constants;
};

/// All that are known. For stainless steel no published spectrum of η and κ was at hand; chromium stands in,
/// of which its passive film is made and whose reflectance (0.55 at 0.55 µm) comes nearer to polished steel's
/// than iron's (0.51) does.
const std::vector<Metal>& metals();

/// One by its name. Throws InputError, naming those there are.
const Metal& metal(std::string_view name);

}  // namespace micro
