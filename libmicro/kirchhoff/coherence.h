#pragma once

#include <span>
#include <variant>
#include <vector>

#include "height/height_field.h"

namespace micro {

/// How far apart two points of the surface may lie and still interfere [Dong15 Appendix A].
struct WholePatch {};  ///< the patch is one coherence area
struct SubWindows {    ///< windows side by side that share nothing, each one coherence area
  double area;         ///< µm², the area of one window
};
struct GaussianTaper {  ///< overlapping windows that fade like exp(−r²/2s²), A_c = 2π s²
  double area;          ///< µm², the coherence area A_c = ∫|μ|² d²Δ of the degree of coherence μ
};
using Coherence = std::variant<WholePatch, SubWindows, GaussianTaper>;

/// The coherence area λ²/Ω in µm² under a round uniform source of full angular diameter `diameter` (radians),
/// Ω = 2π(1 − cos(diameter/2)) [Dong15 Appendix A; Mandel and Wolf]; λ in µm.
/// Throws InputError unless λ > 0 and 0 < diameter ≤ π.
double coherence_area(double lambda, double diameter);

/// One coherent piece of a surface: the field inside adds up as amplitudes, fields of different windows as
/// intensities.
struct Window {
  HeightField surface;
  Grid<float> taper;  ///< [rows−1, cols−1] amplitude of both triangles of each cell; 0×0: 1 everywhere
};

/// Σ_T W_T² A_T, the projected area that the window's intensity is divided by, µm² (A_perp without taper).
/// D = |Σ_T W_T (q·a_T) mean_T(e^{−iq·s})|² / (4π² · this) then keeps ∫ D m_z dω ≈ 1 by Parseval's theorem.
double effective_area(const Window& window);

/// Cuts a surface into its coherent windows; those without a triangle are left out. D_K of the surface is the
/// mean of the windows' D weighted by effective_area. Whole patch: the surface itself. Sub-windows: as near
/// to squares of the area asked as whole numbers of cells allow; neighbours share their border row of points,
/// so that every triangle is in one window. Gaussian taper: centres at most 1.25 s apart, so that ΣW² varies
/// by less than 0.4 % inside, and 2 s from the border (in the middle of a patch narrower than 4 s), each cut
/// at 3.5 s: what lies within 2 s of the border counts less. Throws InputError if an area is not positive and
/// finite or smaller than one cell.
std::vector<Window> coherent_windows(const HeightField& surface, const Coherence& coherence);

/// The surface mirrored in x. Its triangles are cut along the other diagonal, so that D_K of the mirrored
/// surface at (−q_x, q_y, q_z) is D_K of the surface cut along the other diagonal.
HeightField mirror_x(const HeightField& surface);

}  // namespace micro
