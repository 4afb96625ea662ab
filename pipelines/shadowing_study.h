#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipelines/shadowing_simulation.h"

namespace micro {

/// One slope ν = s·cot θ of rays: what they do on profiles, and what is said of them. Sun counts all rays,
/// Smith those from facets that face the ray; the facing part P turns one into the other.
struct ShadowingStudyRow {
  ShadowingRow simulated;
  double sun_closed = 0;         ///< Γ₀ [Sun02 Eq. 3.4.23]
  Estimate<double> covered;      ///< ∫Q dx/τ at η = 0
  double sun_mean_height = 0;    ///< Γ(0) by quadrature [3.4.14]
  Estimate<double> sun_mean;     ///< ⟨Γ⟩ over all heights
  Estimate<double> sun_product;  ///< ⟨ΓΓ⟩, both rays at this slope [3.5.1]
  double facing = 0;             ///< P = P(slope < ray's) = Φ(ν/√2)
  double smith_lambda = 0;       ///< Λ, G1 = 1/(1 + Λ)
  double table_g1 = 0;  ///< of the same distribution tabulated on 1025² nodes, at s = kTableSmoothness
};
constexpr double kTableSmoothness = 10;

/// Smith's probability that a facet at height η = h/σ_h that faces the ray is seen, Φ(η)^Λ; its mean over
/// heights is 1/(1 + Λ).
double smith_at_height(double eta, double lambda);

/// Γ and ⟨ΓΓ⟩ by quadrature, by the closed form, by simulation, by Smith and by a tabulated distribution.
std::vector<ShadowingStudyRow> study_shadowing(const ShadowingRequest& request);

/// The slopes that the study takes by itself: θ from 9° to 87° at s = 1.
std::vector<double> shadowing_study_slopes();

std::string to_markdown(const std::vector<ShadowingStudyRow>& rows);
std::string to_csv(const std::vector<ShadowingStudyRow>& rows);

/// Writes [Sun02] Figs. 4–7 and two of the comparison into a folder as shadowing_*.png.
void write_shadowing_figures(const std::vector<ShadowingStudyRow>& rows, const std::filesystem::path& folder);

}  // namespace micro
