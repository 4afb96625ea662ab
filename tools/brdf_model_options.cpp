#include "tools/brdf_model_options.h"

#include "brdf/coat.h"
#include "tools/units.h"

namespace micro::tools {
namespace {

/// Two lengths of the lobe, or one for both.
EllipsoidParameters lobe_of(const BrdfModelOptions& options) {
  const auto number = [](const std::string& text) {
    try {
      std::size_t end = 0;
      const double value = std::stod(text, &end);
      if (end == text.size()) return value;
    } catch (const std::exception&) {
      // falls through to the sentence below
    }
    throw CLI::ValidationError("--alpha: '" + text + "' is no number");
  };
  if (options.alpha.empty())
    throw CLI::ValidationError("a model without a FILE needs --alpha, or --model sun and --smoothness");
  const double alpha_x = number(options.alpha.front()), alpha_y = number(options.alpha.back());
  EllipsoidParameters parameters{alpha_x, alpha_y};
  double* const angles[] = {&parameters.theta_x, &parameters.theta_y, &parameters.theta_z};
  for (std::size_t k = 0; k < options.theta.size(); ++k)
    *angles[k] = parse_angle(options.theta[k]);
  return parameters;
}

/// The distribution that was named, or the one that --model stands for.
std::string distribution_of(const BrdfModelOptions& options) {
  const std::string& named = options.distribution;
  if (options.input.empty()) {
    if (options.model == "kirchhoff")
      throw CLI::ValidationError("--model kirchhoff is that of a FILE with a D_K");
    return named.empty() ? "ellipsoid" : named;
  }
  if (named.empty()) return options.model == "kirchhoff" ? "kirchhoff" : "filtered";
  if (!options.model.empty() && (options.model == "kirchhoff") != named.starts_with("kirchhoff"))
    throw CLI::ValidationError("--model " + options.model + " is not that of --distribution " + named +
                               ": tables whose name begins with kirchhoff are D_K, all others facets");
  return named;
}

/// Refuses what is said of a table or a fit where the model is neither.
void check_source(const BrdfModelOptions& options) {
  const std::string distribution = options.model == "sun" ? "" : distribution_of(options);
  const bool waves = !options.input.empty() && distribution.starts_with("kirchhoff");
  const bool fit = !options.input.empty() && (distribution == "ellipsoid" || distribution == "beckmann");
  if (options.masking && !waves)
    throw CLI::ValidationError("--masking is that of a FILE's D_K: all other models have their own G");
  if (options.fitted && !fit)
    throw CLI::ValidationError("--fit-of is that of --distribution ellipsoid or beckmann of a FILE");
}

void check(const BrdfModelOptions& options) {
  const bool sun = options.model == "sun";
  if (sun && !(options.input.empty() && options.distribution.empty() && options.alpha.empty() &&
               options.theta.empty()))
    throw CLI::ValidationError(
        "--model sun is of --smoothness alone; FILE, --distribution, --alpha and --theta do not go with it");
  if (sun && !options.smoothness)
    throw CLI::ValidationError("--model sun needs --smoothness, the correlation length over the rms height");
  if (!sun && options.smoothness) throw CLI::ValidationError("--smoothness is that of --model sun");
  if (!sun && !options.coat && options.form != "corrected")
    throw CLI::ValidationError("--form is that of --model sun and of --coat");
  if (!options.input.empty() && !(options.alpha.empty() && options.theta.empty()))
    throw CLI::ValidationError("--alpha and --theta make a model; they do not go with a FILE");
  check_source(options);
}

}  // namespace

void add_brdf_model_options(CLI::App& app, BrdfModelOptions& options) {
  app.add_option("FILE", options.input,
                 "HDF5 file with /ndf/<method>/density: result.h5, or any other (without: a model by "
                 "--alpha or --smoothness)");
  app.add_option("--model", options.model,
                 "microfacet [Dong15 Eqs. 1, 13], kirchhoff [Eqs. 7, 8] or sun [Sun02 Eq. 3.5.3] (default: "
                 "kirchhoff for a D_K, else microfacet)")
      ->check(CLI::IsMember({"microfacet", "kirchhoff", "sun"}));
  app.add_option(
      "--distribution", options.distribution,
      "Of FILE: filtered (default), naive, kirchhoff, kirchhoff_spectrum or any other method in it, or "
      "ellipsoid or beckmann as fitted; without FILE: ellipsoid (default) or beckmann");
  app.add_option("--fit-of", options.fitted,
                 "The method whose fit ellipsoid and beckmann are (default filtered)");
  app.add_option("--alpha", options.alpha, "Width of the model's lobe, or X,Y")
      ->delimiter(',')
      ->expected(1, 2);
  app.add_option("--theta", options.theta, "The lobe's angles X,Y,Z [Dong15 Eq. 12]")
      ->delimiter(',')
      ->type_name("ANGLE")
      ->expected(1, 3);
  app.add_option("--smoothness", options.smoothness,
                 "Of --model sun: the surface's correlation length over its rms height")
      ->check(positive_number());
  app.add_option("--material", options.material,
                 "Al, Cu, Au, Ag, Fe, Cr, Ni, Ti, steel, mirror, or an index: 1.5 or 0.2,3.4")
      ->capture_default_str();
  app.add_option("--masking", options.masking, "G of a FILE's D_K: smith (default) or none")
      ->check(CLI::IsMember({"smith", "none"}));
  CLI::Option* coat = app.add_option("--coat", options.coat,
                                     "Index of a smooth, clear coat over the model [SunGlossy], such as 1.5")
                          ->check(CLI::Range(1., 100.));
  app.add_option("--coat-smoothness", options.coat_smoothness,
                 "Correlation length over rms height of the coat's upper face (default 1000)")
      ->check(positive_number())
      ->needs(coat);
  app.add_option("--form", options.form,
                 "Of --model sun and --coat: corrected, or printed as in the papers (docs/sun.md)")
      ->check(CLI::IsMember({"corrected", "printed"}))
      ->capture_default_str();
}

BrdfModel make_brdf_model(const BrdfModelOptions& options) {
  check(options);
  const SunForm form = options.form == "printed" ? SunForm::AsPrinted : SunForm::Corrected;
  const double medium = options.coat.value_or(1);
  const Fresnel bare = material(options.material);
  const Fresnel fresnel = options.coat ? under(bare, medium) : bare;
  const auto substrate = [&] {
    if (options.model == "sun") return sun_model(*options.smoothness, form, fresnel);
    if (options.input.empty()) return lobe_model(distribution_of(options), lobe_of(options), fresnel);
    const Masking masking = options.masking == "none" ? Masking::None : Masking::Smith;
    return result_model(
        {options.input, distribution_of(options), options.fitted.value_or("filtered"), masking, medium},
        fresnel);
  };
  if (!options.coat) return substrate();
  return coated_model(substrate(), {medium, options.coat_smoothness.value_or(Coat().smoothness)}, form);
}

}  // namespace micro::tools
