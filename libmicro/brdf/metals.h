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

/// All that are known.
const std::vector<Metal>& metals();

/// One by its name. Throws InputError, naming those there are.
const Metal& metal(std::string_view name);

}  // namespace micro
