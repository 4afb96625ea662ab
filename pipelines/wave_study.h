#pragma once

#include <string>
#include <vector>

#include "core/estimate.h"
#include "height/gaussian_surface.h"

namespace micro {

/// A kind of synthetic surface, sampled at `pitch` µm.
struct WaveStudyCase {
  std::string name;
  std::vector<GaussianField> scales;  ///< isotropic: τ_x = τ_y
  double pitch;
};

/// D_K against the filtered NDF on one kind of surface. Widths are given as the α of the Beckmann
/// distribution whose m_x has the same interquartile range.
struct WaveStudyRow {
  std::string name;
  double lambda_q = 0;
  Estimate<double> kirchhoff, filtered;  ///< mean over surfaces, standard error
  double kirchhoff_predicted = 0, filtered_predicted = 0;
};

struct WaveStudyRequest {
  double lambda_q = 0.555;  ///< µm
  double sigma = 1;         ///< µm, of the filtered NDF's window
  int surfaces = 8;         ///< of each kind
  int points = 384;         ///< along a side
};

/// The kinds of surfaces studied: one correlation length from 1.5 to 12 µm, all with slopes of α = 2σ_h/τ =
/// 0.2, and a power law of roughness at all scales, as metal has it.
std::vector<WaveStudyCase> wave_study_cases();

/// Where wave optics and filtered geometric optics agree [Dong15 §6.2, Figs. 8, 9] and where they do not. The
/// filtered NDF of a Gaussian surface is Beckmann with α² = Σ 4σ_k²τ_k⁴/τ_k²·1/(τ_k² + 4s²)² over its scales
/// k; D_K is the transform of e^{−g(1−C)}, g = q_z²σ_h², which for one scale and large g has α = 2σ_h/τ: it
/// does not know the window. Both predictions follow from the statistics alone.
WaveStudyRow study_waves(const WaveStudyCase& surface, const WaveStudyRequest& request);

/// The incoherent part of ⟨D_K⟩ in 1/sr of a Gaussian surface of isotropic scales, at polar angle θ of the
/// half direction: |q|⁴/(2π q_z²)·∫(e^{−g(1−C(Δ))} − e^{−g}) J₀(q_⊥Δ) Δ dΔ, C the correlation of all scales
/// together.
double mean_kirchhoff_density(const std::vector<GaussianField>& scales, double lambda_q, double sin_theta);

std::string to_markdown(const std::vector<WaveStudyRow>& rows);
std::string to_csv(const std::vector<WaveStudyRow>& rows);

}  // namespace micro
