#include "io/zygo_scale.h"

#include <array>
#include <cmath>
#include <string>

#include "core/error.h"

namespace micro {

double zygo_step(const std::filesystem::path& path, const ZygoScale& scale) {
  constexpr std::array resolution = {4096., 32768., 131072.};
  if (scale.phase_res < 0 || scale.phase_res > 2)
    throw FileError(path, "its phase resolution " + std::to_string(scale.phase_res) +
                              " is unknown (0, 1 and 2 are known)");
  const auto check = [&](const char* name, double factor) {
    if (!(factor > 0 && std::isfinite(factor)))
      throw FileError(path, std::string("its ") + name + " makes no sense: " + std::to_string(factor));
  };
  check("interferometric scale factor", scale.interferometric);
  check("wavelength", scale.wavelength);
  check("obliquity factor", scale.obliquity);
  const double step = scale.interferometric * scale.wavelength * scale.obliquity /
                      resolution[static_cast<std::size_t>(scale.phase_res)] * 1e6;
  return scale.sign != 0 ? -step : step;
}

}  // namespace micro
