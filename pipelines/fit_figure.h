#pragma once

#include <filesystem>
#include <string>

#include "pipelines/ndf_fits.h"

namespace micro {

/// Writes a PNG of one method's table and its fits, as in [Dong15 Figs. 9, 12]: the table, the ellipsoid and
/// their difference around the lobe, and slices through the ellipsoid's peak along and across its wider
/// principal direction with data, ellipsoid and Beckmann. False, and nothing is written, if `fits` hold no
/// ellipsoid of this method with numbers. Throws FileError.
bool write_fit_figure(const std::filesystem::path& path, const NdfTable& table, const NdfFits& fits);

/// Name of that file for a method: fit_<method>.png.
std::string fit_figure_name(const std::string& method);

}  // namespace micro
