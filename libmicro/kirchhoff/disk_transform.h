#pragma once

#include "distribution/disk_table.h"
#include "kirchhoff/coherence.h"
#include "kirchhoff/combine.h"
#include "kirchhoff/spectral_work.h"

namespace micro {

/// Memory that may serve one table after the other; nothing in it outlives a call.
template <typename Real>
struct DiskMemory {
  FftVector<std::complex<Real>> spectra;
  DiskField<Real> field;
};

struct DiskDensity {
  DiskTable table;
  SpectralWork work;
};

/// D_K on every node of the table in one go, at one |q| = 4π/λ_q. In letters, with ψ = (e^{−iq_z h} − 1)/q_z,
///   F(q) = q_z·I[1] + |q|²·I[ψ] − i ∮ (q_⊥·n) ψ e^{−iq_⊥·x} dl,   I[f] = ∫ f(x) e^{−iq_⊥·x} dxdy,
/// which follows from Eq. 6 by parts on the piecewise linear surface and has nothing to divide by q_z. Since
/// |q| is the same at all nodes, the last two terms are the spectrum of one image, and with ψ ≈ Σ c_k(q_z)
/// φ_k(h) that of a few real images, two to a complex transform: sources at quadrature points, dipoles on the
/// rim and around holes, spread onto a grid whose transform lands on the nodes. Sources beyond the grid's
/// period fold into it, which is exact.
///
/// A taper weighs the cells, and the edges between cells of different weight are rims of that difference.
///
/// `Real` is float (error about 1e-6 of the peak of |F| without the coherent part) or double.
/// Throws InputError if not one triangle is there, or if a table would take many minutes (check_work).
template <typename Real>
DiskDensity transform_disk(const Window& window, const DiskGrid& grid, double lambda_q,
                           const SpectralChoice& choice, DiskMemory<Real>& memory);

}  // namespace micro
