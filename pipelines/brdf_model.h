#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>

#include "brdf/any_brdf.h"
#include "brdf/coat.h"
#include "brdf/kirchhoff_brdf.h"
#include "distribution/slope_space.h"

namespace micro {

/// A model that was asked for by name, and the same of a perfect mirror instead of its metal, for the
/// furnace.
struct BrdfModel {
  std::string description;  ///< distribution, its source, masking
  AnyBrdf metal, mirror;
  std::optional<std::array<double, 2>> light_um = {};  ///< shortest and longest that tables of D_K are for
};

/// The smooth interface called so: a metal (metals.h), `mirror`, `n` or `eta,kappa`. Throws InputError.
Fresnel material(const std::string& name);

/// A lobe by its parameters [Dong15 Eqs. 11, 12]: `ellipsoid` (GGX where θ = 0) or `beckmann`, which takes
/// the same place in slope space. Throws InputError for another name.
BrdfModel lobe_model(const std::string& distribution, const EllipsoidParameters& parameters,
                     const Fresnel& fresnel);

/// What to make of a file.
struct ResultModelRequest {
  std::filesystem::path path;  ///< result.h5, or any other with /ndf/<method>/density
  std::string distribution;    ///< a method of /ndf, or `ellipsoid` or `beckmann`: the fit of `fitted`
  std::string fitted = "filtered";
  Masking masking = Masking::Smith;
  double medium = 1;  ///< index of what lies over the surface, such as a coat: there D_K sees λ/medium
};

/// Tables of a method: filtered and naive ones as microfacets, those whose name begins with `kirchhoff` as
/// D_K at λ_q(λ, θ_d) if there are several wavelengths, else at their one λ_q, with G1 of the filtered table
/// if the file has one. Tables at several λ_q are for light of these wavelengths; larger λ_q, of light that
/// turns far, have the last one's. Throws FileError.
BrdfModel result_model(const ResultModelRequest& request, const Fresnel& fresnel);

/// Sun's one-term BRDF of a Gaussian surface of smoothness s = τ/σ_h [Sun02 Eq. 3.5.3]. Throws InputError.
BrdfModel sun_model(double s, SunForm form, const Fresnel& fresnel);

/// A model under a smooth coat [SunGlossy]; its Fresnel reflectance and its D_K are those in the coat's
/// medium (`under`, `ResultModelRequest::medium`). Throws InputError.
BrdfModel coated_model(const BrdfModel& substrate, const Coat& coat, SunForm form);

}  // namespace micro
