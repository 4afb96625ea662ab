#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "pipelines/brdf_model.h"

namespace micro::tools {

/// Which reflectance model the command line asks for: of a FILE's distribution, or of parameters alone.
struct BrdfModelOptions {
  std::string input, model, distribution, material = "mirror", form = "corrected";
  std::optional<std::string> fitted, masking;
  std::vector<std::string> alpha, theta;
  std::optional<double> smoothness, coat, coat_smoothness;
};

void add_brdf_model_options(CLI::App& app, BrdfModelOptions& options);

/// The model. Throws CLI::ValidationError for options that do not go together, InputError or FileError for
/// what cannot be had.
BrdfModel make_brdf_model(const BrdfModelOptions& options);

}  // namespace micro::tools
