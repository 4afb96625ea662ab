#pragma once

#include <cstdint>
#include <filesystem>

namespace micro {

/// What turns Zygo's integer phase into height: z = raw · S·W·O/R, negated if `sign` is not 0.
struct ZygoScale {
  double interferometric;  ///< S, the interferometric scale factor
  double wavelength;       ///< W, m
  double obliquity;        ///< O
  int phase_res;           ///< 0, 1, 2: R = 4096, 32768, 131072
  int sign;
};

/// Micrometres per count. Throws FileError if the phase resolution is unknown or a factor is not positive and
/// finite.
double zygo_step(const std::filesystem::path& path, const ZygoScale& scale);

/// Raw phase from here on upwards is missing.
constexpr std::int32_t kZygoMissing = 2147483640;

}  // namespace micro
