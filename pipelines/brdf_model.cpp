#include "pipelines/brdf_model.h"

#include <cmath>
#include <sstream>

#include "brdf/metals.h"
#include "brdf/microfacet.h"
#include "core/error.h"
#include "distribution/beckmann.h"
#include "distribution/ellipsoid.h"
#include "io/hdf5_reader.h"
#include "pipelines/ndf_fits.h"

namespace micro {
namespace {

template <Distribution Normals>
BrdfModel microfacets(const std::string& description, const Normals& normals, const Fresnel& fresnel) {
  return {description, AnyBrdf(Microfacet(normals, fresnel)), AnyBrdf(Microfacet(normals))};
}

BrdfModel lobe_of_frame(const std::string& distribution, const SlopeFrame& frame, const std::string& source,
                        const Fresnel& fresnel) {
  if (distribution == "ellipsoid") return microfacets("ellipsoid NDF, " + source, Ellipsoid(frame), fresnel);
  if (distribution == "beckmann") return microfacets("Beckmann, " + source, Beckmann(frame), fresnel);
  throw InputError("'" + distribution + "' is no lobe; there are ellipsoid and beckmann");
}

/// The frame of /fit/<method>/<model>.
SlopeFrame read_frame(const ResultModelRequest& request) {
  const Hdf5Reader file(request.path);
  const std::string group = "/fit/" + request.fitted + "/" + request.distribution;
  if (!file.contains(group))
    throw FileError(request.path, "holds no " + group + ": run `microbrdf fit` on it first");
  const auto centre = file.numbers_attribute(group, "slope_centre");
  const auto scale = file.numbers_attribute(group, "slope_scale");
  const bool whole = centre.size() == 2 && scale.size() == 4;
  const double l11 = whole ? std::sqrt(scale[0]) : 0, l21 = whole ? scale[1] / l11 : 0;
  const double l22 = whole ? std::sqrt(scale[3] - l21 * l21) : 0;
  if (!(l11 > 0 && l22 > 0 && std::isfinite(l21) && std::isfinite(centre[0] + centre[1])))
    throw FileError(request.path, group + " is a fit without numbers");
  return {{centre[0], centre[1]}, l11, l21, l22};
}

/// The normals that mask: those of the filtered table if the file has one, else of the longest wavelength.
Tabulated masking_normals(const ResultModelRequest& request, const Tabulated& longest) {
  if (!Hdf5Reader(request.path).contains("/ndf/filtered/density")) return longest;
  return Tabulated(read_ndf(request.path, "filtered").front().density);
}

BrdfModel waves(const ResultModelRequest& request, const std::vector<NdfTable>& tables,
                const Fresnel& fresnel) {
  std::vector<double> lambda_q;
  std::vector<Tabulated> densities;
  for (const NdfTable& table : tables) {
    lambda_q.push_back(table.lambda_q.value_or(1));
    densities.emplace_back(table.density);
  }
  const Tabulated normals = masking_normals(request, densities.back());
  const Tabulated& drawn = densities[densities.size() / 2];
  const SpectrumDensity density(lambda_q, densities, request.medium);
  const std::string description = request.distribution +
                                  (request.masking == Masking::Smith ? ", Smith's G, " : ", without G, ") +
                                  request.path.string();
  BrdfModel model = {description, AnyBrdf(KirchhoffBrdf(density, normals, drawn, request.masking, fresnel)),
                     AnyBrdf(KirchhoffBrdf(density, normals, drawn, request.masking))};
  if (lambda_q.size() > 1)
    model.light_um = {request.medium * lambda_q.front(), request.medium * lambda_q.back()};
  return model;
}

const char* form_name(SunForm form) {
  return form == SunForm::AsPrinted ? "as printed" : "corrected";
}

}  // namespace

Fresnel material(const std::string& name) {
  if (name == "mirror") return Fresnel();
  std::istringstream text(name);
  double eta = 0, kappa = 0;
  char comma = 0;
  if (text >> eta) {
    if (text.eof()) return Fresnel(std::complex<double>(eta, 0));
    if (text >> comma >> kappa && comma == ',' && text.peek() == std::istringstream::traits_type::eof())
      return Fresnel(std::complex<double>(eta, kappa));
    throw InputError("'" + name + "' is neither a metal nor an index like 1.5 or 0.2,3.4");
  }
  return Fresnel(metal(name).constants);
}

BrdfModel lobe_model(const std::string& distribution, const EllipsoidParameters& parameters,
                     const Fresnel& fresnel) {
  const auto& [alpha_x, alpha_y, theta_x, theta_y, theta_z] = parameters;
  std::ostringstream source;
  source << "alpha " << alpha_x << ", " << alpha_y << "; theta " << theta_x << ", " << theta_y << ", "
         << theta_z << " rad";
  return lobe_of_frame(distribution, slope_frame(parameters), source.str(), fresnel);
}

BrdfModel result_model(const ResultModelRequest& request, const Fresnel& fresnel) {
  if (request.distribution == "ellipsoid" || request.distribution == "beckmann")
    return lobe_of_frame(request.distribution, read_frame(request),
                         "fit of " + request.fitted + " in " + request.path.string(), fresnel);
  const std::vector<NdfTable> tables = read_ndf(request.path, request.distribution);
  try {
    if (request.distribution.starts_with("kirchhoff")) return waves(request, tables, fresnel);
    return microfacets(request.distribution + " table, " + request.path.string(),
                       Tabulated(tables.front().density), fresnel);
  } catch (const FileError&) {
    throw;
  } catch (const InputError& error) {
    throw FileError(request.path, error.what());
  }
}

BrdfModel sun_model(double s, SunForm form, const Fresnel& fresnel) {
  std::ostringstream description;
  description << "Sun's one-term BRDF " << form_name(form) << ", smoothness " << s;
  return {description.str(), AnyBrdf(SunReflection(s, fresnel, form)),
          AnyBrdf(SunReflection(s, Fresnel(), form))};
}

BrdfModel coated_model(const BrdfModel& substrate, const Coat& coat, SunForm form) {
  std::ostringstream description;
  description << substrate.description << "; under a coat " << form_name(form) << ", n = " << coat.n
              << ", smoothness " << coat.smoothness;
  return {description.str(), AnyBrdf(Coated(substrate.metal, coat, form)),
          AnyBrdf(Coated(substrate.mirror, coat, form)), substrate.light_um};
}

}  // namespace micro
