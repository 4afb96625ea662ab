#pragma once

#include <vector>

#include "pipelines/ndf_of_scans.h"

namespace micro {

/// The tables of a result, its spectrum's left out.
std::vector<NdfTable> tables_of(const NdfResult& result);

/// Fits ellipsoid and Beckmann to every table of a result by solid angle, and to every wavelength of its
/// spectrum, which are taken one after the other: together they are large.
NdfFits fits_of(const NdfResult& result);

}  // namespace micro
