#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "brdf/albedo.h"
#include "brdf/half_angle_table.h"
#include "pipelines/brdf_model.h"

namespace micro {

/// What is wanted of a model; what is absent is neither computed nor stored.
struct BrdfRequest {
  std::vector<double> lambda_um = {0.45, 0.55, 0.65};
  std::vector<Vec3> wi;                ///< of slices and albedos
  double azimuth = 0;                  ///< radians: of the plane of incidence of a wi along the normal
  std::vector<double> planes = {0};    ///< radians: azimuths of a wi's slices from its plane of incidence
  std::optional<double> albedo = {};   ///< tolerance of albedos
  std::optional<double> furnace = {};  ///< tolerance of the white furnace; with it goes reciprocity
  int spectrum = 0;  ///< wavelengths of the albedo's spectrum and its colour, for the first wi
  double spectrum_tolerance = 1e-3;
  std::optional<HalfAngleGrid> table = {};
};

/// f in the plane that holds n and turns by `plane` about it from that of wi.
struct BrdfSlice {
  Vec3 wi;
  double phi_i;                        ///< radians: azimuth of the plane of incidence
  double plane;                        ///< radians, from there
  std::vector<double> theta_o;         ///< radians, positive on the side a mirror sends to, turned by `plane`
  std::vector<std::vector<double>> f;  ///< [λ, theta_o] 1/sr
};

/// The albedo at one wi over wavelengths, and its colour under D65.
struct BrdfSpectrum {
  std::vector<double> lambda_um;
  std::vector<Estimate<double>> albedo;
  Vec3 xyz, linear_rgb;
};

struct BrdfReport {
  BrdfRequest request;
  std::string description, material;
  std::vector<BrdfSlice> slices;                      ///< of each wi and plane
  std::vector<std::vector<Estimate<double>>> albedo;  ///< [wi, λ]
  std::optional<BrdfSpectrum> spectrum;
  std::optional<WhiteFurnace> furnace;                ///< of a perfect mirror, at the middle wavelength
  std::optional<Reciprocity> reciprocity;             ///< of the metal
  std::optional<Estimate<std::vector<float>>> table;  ///< [λ, θ_h, θ_d, φ_d] 1/sr
};

/// Evaluates a model. Throws InputError for wavelengths at which the metal is not known.
BrdfReport evaluate_brdf(const BrdfModel& model, const std::string& material, const BrdfRequest& request);

/// Writes it as HDF5 (docs/design.md has the layout); whole or absent.
void write_brdf(const std::filesystem::path& path, const BrdfReport& report, const std::string& command);

/// Names of the CSV and pictures that go beside `path`, as write_brdf_pictures() writes them.
std::vector<std::filesystem::path> brdf_picture_paths(const std::filesystem::path& path,
                                                      const BrdfRequest& request);

/// Writes slices, albedo and spectrum as <stem>_slices.csv, …_albedo.csv, …_spectrum.csv, and slices as
/// <stem>_slice<k>.png beside `path`. Gives their names.
std::vector<std::filesystem::path> write_brdf_pictures(const std::filesystem::path& path,
                                                       const BrdfReport& report);

}  // namespace micro
