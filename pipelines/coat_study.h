#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/estimate.h"

namespace micro {

/// Albedos of perfectly reflecting facets at one smoothness and angle: of Sun's BRDF and of the coat over it,
/// corrected and as printed. Above one, a form makes energy.
struct FurnaceRow {
  double s = 0, theta_deg = 0;
  Estimate<double> sun, sun_printed;
  Estimate<double> coat, coat_printed;
};

/// What the furnace says of [Sun02 Eq. 3.5.3] and [SunGlossy Eq. 10] at smoothness 0.1 to 100 and 0 to 85°,
/// under a coat of n = 1.5.
std::vector<FurnaceRow> study_coat_furnace(double tolerance);

std::string to_markdown(const std::vector<FurnaceRow>& rows);
std::string to_csv(const std::vector<FurnaceRow>& rows);

/// Writes [SunGlossy Fig. 5] into a folder as coat_*.png: bare and enamelled copper at s = 1, the light at
/// 45°, over the viewing angle at wavelengths from 0.45 to 0.65 µm; the corrected form and the printed one.
void write_coat_figures(const std::filesystem::path& folder);

}  // namespace micro
