#pragma once

#include "distribution/density_volume.h"
#include "height/height_field.h"

namespace micro {

/// The extent that a surface's D_K takes for all q with |q_x|, |q_y| ≤ q_xy and |q_z| ≤ q_z (rad/µm).
VolumeExtent kirchhoff_extent(const HeightField& surface, double q_xy, double q_z);

/// Computes D_K of a surface on the nodes of a volume [Dong15 Eq. 8], by the images of the spectral estimator
/// (spectrum.h), whose spectra stand on the volume's own wave numbers. `tol`: relative L2 error of D on the
/// nodes, as of SpectralSolver but not measured; interpolation adds its own (density_volume.h). Replaces what
/// the volume held. Throws InputError if the surface has no triangle, is larger than what the volume's
/// wave numbers resolve, or would take more than 2 GiB for its spectra.
void fill_with_kirchhoff(const HeightField& surface, double tol, DensityVolume& volume);

/// Both in one.
DensityVolume kirchhoff_volume(const HeightField& surface, double q_xy, double q_z, double tol);

}  // namespace micro
