#include <cmath>
#include <memory>
#include <optional>

#include "core/error.h"
#include "pipelines/origin.h"
#include "pipelines/output_lock.h"
#include "pipelines/textures.h"
#include "tools/commands.h"
#include "tools/json_output.h"
#include "tools/listing_output.h"
#include "tools/ndf_options.h"
#include "tools/scan_output.h"
#include "tools/units.h"

namespace micro::tools {
namespace {

struct Options {
  CommonOptions common;
  TexelRequest texels;
  TextureRequest texture;
  std::vector<std::string> scans, pitch;
  std::string output, block, layout, manifest, level = "common", size = "512", recipe = "joint",
                                               marginals = "exemplar", taper = "hann", pixel = "float";
  bool no_texture = false, no_levels = false;
};

/// One length, or two: X,Y.
Vec2 parse_block(const std::string& text) {
  const std::size_t comma = text.find(',');
  const double x = parse_length(text.substr(0, comma)),
               y = comma == text.npos ? x : parse_length(text.substr(comma + 1));
  if (!(x > 0 && y > 0)) throw CLI::ValidationError("--texel", "must be positive");
  return {x, y};
}

TexelRequest request_of(const Options& options) {
  TexelRequest request = options.texels;
  if (!(request.sigma > 0)) throw CLI::ValidationError("--sigma", "the window must be wider than nothing");
  request.prepare.read = parse_pitch(options.pitch);
  if (!options.block.empty()) request.block = parse_block(options.block);
  if (options.level != "common") {
    request.prepare.level = *level_from_name(options.level);
    request.tilt = TexelRequest::Tilt::Keep;
  }
  return request;
}

LayoutRule layout_rule_of(const Options& options) {
  if (!options.manifest.empty()) return Manifest{options.manifest};
  if (options.layout.empty()) return InOrder{};
  if (options.layout == "stage") return ByStage{};
  return ByName{options.layout};
}

/// N, or WIDTHxHEIGHT.
TextureSize parse_size(const std::string& text) {
  constexpr Eigen::Index kMost = 65536;
  const auto number = [&](const std::string& part) -> Eigen::Index {
    const bool digits =
        !part.empty() && part.size() < 6 && part.find_first_not_of("0123456789") == std::string::npos;
    const Eigen::Index value = digits ? std::stol(part) : 0;
    if (value < 1 || value > kMost)
      throw CLI::ValidationError("--size",
                                 "'" + text + "' is neither N nor WIDTHxHEIGHT, 1 to 65536 texels each");
    return value;
  };
  const std::size_t cross = text.find('x');
  const Eigen::Index cols = number(text.substr(0, cross));
  return {cross == text.npos ? cols : number(text.substr(cross + 1)), cols};
}

TextureRequest texture_of(const Options& options) {
  TextureRequest request = options.texture;
  request.size = parse_size(options.size);
  for (const Recipe recipe : {Recipe::Separable, Recipe::Full, Recipe::Joint})
    if (options.recipe == name_of(recipe)) request.recipe = recipe;
  request.taper = options.taper == "hann" ? Taper::Hann : Taper::None;
  if (options.marginals == "gaussian") request.marginals = TextureRequest::Marginals::Gaussian;
  if (options.pixel == "half") request.pixel = ExrPixel::Half;
  if (options.no_levels) request.levels = TextureRequest::Levels::Finest;
  return request;
}

nlohmann::json to_json(const TextureSummary& texture, const std::filesystem::path& exr) {
  nlohmann::json levels = nlohmann::json::array();
  for (const LevelMisfit& m : texture.misfits)
    levels.push_back({{"level", m.level},
                      {"rows", m.rows},
                      {"cols", m.cols},
                      {"divergence", m.refitted.divergence},
                      {"rel_rms", m.refitted.rel_rms},
                      {"averaged_divergence", m.averaged.divergence},
                      {"averaged_rel_rms", m.averaged.rel_rms}});
  nlohmann::json coarsest;
  if (texture.coarsest) {
    const EllipsoidParameters p = canonical_parameters(*texture.coarsest);
    coarsest = {{"alpha_x", p.alpha_x},
                {"alpha_y", p.alpha_y},
                {"theta_x", p.theta_x},
                {"theta_y", p.theta_y},
                {"theta_z", p.theta_z}};
  }
  return {{"output", exr.string()},
          {"rows", texture.request.size.rows},
          {"cols", texture.request.size.cols},
          {"recipe", name_of(texture.request.recipe)},
          {"seed", texture.request.seed},
          {"levels", levels},
          {"coarsest", coarsest},
          {"seconds", texture.seconds}};
}

nlohmann::json summary_of(const Texels& texels, const ScanListing& listing, const nlohmann::json& failed,
                          const std::filesystem::path& output) {
  return {{"output", output.string()},
          {"scans", texels.scans.size() - failed.size()},
          {"failed", failed},
          {"skipped", skipped_json(listing)},
          {"texels",
           {{"rows", texels.rows},
            {"cols", texels.cols},
            {"fitted", texels.count()},
            {"width_um", texels.width},
            {"height_um", texels.height},
            {"seconds", texels.seconds}}},
          {"plan", nlohmann::json::parse(to_json(texels.plan))}};
}

int run(const Options& options, const CLI::App& app) {
  const TexelRequest request = request_of(options);
  const TextureRequest texture_request = texture_of(options);
  const std::filesystem::path output = options.output;
  const ScanListing listing = list_scans({options.scans.begin(), options.scans.end()}, output);
  require_scans(listing, options.scans);
  const TexelLayout layout = lay_out(listing, layout_rule_of(options));  // refuses before there is a folder
  if (texture_request.recipe == Recipe::Full && !request.block && !options.no_texture)
    require_block(layout.rows, layout.cols, static_cast<std::int64_t>(layout.places.size()));
  const OutputLock lock(output);
  Texels texels = texels_of_scans(listing, layout, request, progress_line(options.common));
  const nlohmann::json failed = report_failed(texels.scans);
  if (texels.count() == 0) throw InputError("no scan gave a texel");
  const std::filesystem::path result = output / "texture.h5";
  // What an earlier run left would contradict this one's result.
  std::error_code ignored;
  for (const char* name : {"texture.h5", "texture.exr", "texture.png"})
    std::filesystem::remove(output / name, ignored);
  Hdf5Writer file(result);
  write_origin(file, origin_of(command_line_of(app)));
  write_scans(file, texels.scans);
  write_texels(file, texels);
  std::optional<TextureSummary> texture;
  const std::filesystem::path exr = output / "texture.exr", png = output / "texture.png";
  if (options.no_texture) {
    texels.plan.push_back(left_out("texture", "--no-texture"));
  } else {
    texture = write_texture(texels, texture_request, file, exr, command_line_of(app));
    write_png(png, texture->picture);
    texels.plan.insert(texels.plan.end(), texture->plan.begin(), texture->plan.end());
  }
  file.write_text("/plan", to_json(texels.plan));
  file.finish();
  if (options.common.json) {
    nlohmann::json summary = summary_of(texels, listing, failed, result);
    if (texture) summary["texture"] = to_json(*texture, exr);
    print_json(summary);
  } else {
    std::printf("%s", to_text(texels.plan).c_str());
    print_skipped(listing);
    if (texture) {
      for (const LevelMisfit& m : texture->misfits)
        std::printf("level %d: divergence %.3g nats from what it covers (averaged parameters: %.3g)\n",
                    m.level, m.refitted.divergence, m.averaged.divergence);
      std::printf("%s\n%s\n", exr.c_str(), png.c_str());
    }
    std::printf("%s\n", result.c_str());
  }
  return failed.empty() ? kDone : kSomeFailed;
}

}  // namespace

Run add_texture(CLI::App& app) {
  auto options = std::make_shared<Options>();
  app.add_option("SCAN", options->scans, "Scans, or directories of scans")->required();
  app.add_option("-o,--output", options->output, "Folder for texture.h5 and pictures")->required();
  app.add_option("--texel", options->block,
                 "Size of a texel, L or X,Y: scans are cut into blocks (default: each scan is a texel)")
      ->type_name("LENGTH");
  CLI::Option* layout = app.add_option(
      "--layout", options->layout,
      "Where scans lie: by their names, e.g. \"r{row}_c{col}\", or `stage`: by the stage coordinates in "
      "their headers (.sur, .x3p, .gsf) (default: one strip along x)");
  app.add_option("--manifest", options->manifest, "Where scans lie: a file of lines `source,row,col`")
      ->excludes(layout);
  add_length(app, "--sigma", options->texels.sigma,
             "Standard deviation of the normals' window (default 1um)");
  std::vector<std::string> levels = {"common"};
  for (const Level level : kLevels)
    levels.emplace_back(name_of(level));
  app.add_option(
         "--level", options->level,
         "What to subtract: one plane common to all scans, or from each scan on its own none, its mean, "
         "plane or quadratic")
      ->check(CLI::IsMember(levels))
      ->capture_default_str();
  app.add_option("--enough", options->texels.enough,
                 "Independent normals below which a texel's fit is drawn towards the mean of all")
      ->check(number_from_zero())
      ->capture_default_str();
  app.add_option("--texel-ndf", options->texels.ndf_size,
                 "Nodes along a side of each texel's own table of slopes, 0 for none")
      ->check(CLI::Range(0, 257))
      ->capture_default_str();
  app.add_option("--size", options->size, "Texels of the texture, N or WIDTHxHEIGHT")->capture_default_str();
  app.add_option("--seed", options->texture.seed, "Seed of everything random (default 1)")
      ->check(seed_number());
  app.add_option(
         "--recipe", options->recipe,
         "separable: amplitudes along times across, as in [Dong15]; full: a block's whole spectrum; joint: "
         "and how the five numbers vary together")
      ->check(CLI::IsMember({"separable", "full", "joint"}))
      ->capture_default_str();
  app.add_option("--marginals", options->marginals,
                 "Distribution of each number: the exemplar's own, by rank, or gaussian")
      ->check(CLI::IsMember({"exemplar", "gaussian"}))
      ->capture_default_str();
  app.add_option("--taper", options->taper, "What is done to the ends of strips: hann or none")
      ->check(CLI::IsMember({"hann", "none"}))
      ->capture_default_str();
  app.add_option("--pixel", options->pixel, "Numbers in texture.exr: float or half")
      ->check(CLI::IsMember({"float", "half"}))
      ->capture_default_str();
  app.add_flag("--no-levels", options->no_levels, "Leave out the coarser levels of texture.exr");
  app.add_flag("--no-texture", options->no_texture, "Leave out the texture: texels only");
  add_pitch(app, options->pitch, "Distance between points, P or X,Y, for files that don't say it");
  add_progress(app, options->common);
  add_common_options(app, options->common, "microbrdf texture strips/ --layout \"r{row}_c{col}\" -o texture");
  return [options, &app] { return run(*options, app); };
}

}  // namespace micro::tools
