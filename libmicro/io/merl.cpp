#include "io/merl.h"

#include <array>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/error.h"
#include "io/atomic_file.h"

namespace micro {
namespace {

constexpr std::array<std::int32_t, 3> kBins = {90, 90, 180};
constexpr std::size_t kColour = 90 * 90 * 180;
constexpr std::array<double, 3> kScale = {1.0 / 1500, 1.15 / 1500, 1.66 / 1500};
constexpr double kBelowHorizon = -1;

}  // namespace

void write_merl(const std::filesystem::path& path, std::span<const float> rgb) {
  assert(rgb.size() == 3 * kColour);
  std::vector<double> values(rgb.size());
  for (std::size_t k = 0; k < rgb.size(); ++k) {
    if (std::isinf(rgb[k]) || rgb[k] < 0)
      throw InputError("a BRDF that is infinite or negative has no place in a MERL file");
    values[k] = std::isnan(rgb[k]) ? kBelowHorizon : static_cast<double>(rgb[k]) / kScale[k / kColour];
  }
  std::vector<std::byte> bytes;
  const auto append = [&](std::span<const std::byte> part) {
    bytes.insert(bytes.end(), part.begin(), part.end());
  };
  bytes.reserve(sizeof kBins + values.size() * sizeof(double));
  append(std::as_bytes(std::span(kBins)));
  append(std::as_bytes(std::span(values)));
  write_file(path, bytes);
}

}  // namespace micro
