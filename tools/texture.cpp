#include <cmath>
#include <memory>

#include "core/error.h"
#include "pipelines/origin.h"
#include "pipelines/output_lock.h"
#include "pipelines/texels.h"
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
  std::vector<std::string> scans, pitch;
  std::string output, block, layout, manifest, level = "common";
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
  if (!options.layout.empty()) request.layout = ByName{options.layout};
  if (!options.manifest.empty()) request.layout = Manifest{options.manifest};
  return request;
}

nlohmann::json summary_of(const Texels& texels, const ScanListing& listing,
                          const std::filesystem::path& output) {
  nlohmann::json failed = nlohmann::json::array();
  for (const ScanRecord& scan : texels.scans)
    if (scan.failure) failed.push_back({{"source", scan.source}, {"message", *scan.failure}});
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
  const std::filesystem::path output = options.output;
  const ScanListing listing = list_scans({options.scans.begin(), options.scans.end()}, output);
  require_scans(listing, options.scans);
  lay_out(listing, request.layout);  // what makes no sense is refused before there is a folder
  const OutputLock lock(output);
  const Texels texels = texels_of_scans(listing, request, progress_line(options.common));
  bool failed = false;
  for (const ScanRecord& scan : texels.scans) {
    if (!scan.failure) continue;
    failed = true;
    std::fprintf(stderr, "microbrdf: %s: %s\n", scan.source.c_str(), scan.failure->c_str());
  }
  if (texels.count() == 0) throw InputError("no scan gave a texel");
  const std::filesystem::path result = output / "texture.h5";
  Hdf5Writer file(result);
  write_origin(file, origin_of(command_line_of(app)));
  write_scans(file, texels.scans);
  write_texels(file, texels);
  file.write_text("/plan", to_json(texels.plan));
  file.finish();
  if (options.common.json) {
    print_json(summary_of(texels, listing, result));
  } else {
    std::printf("%s", to_text(texels.plan).c_str());
    print_skipped(listing);
    std::printf("%s\n", result.c_str());
  }
  return failed ? kSomeFailed : kDone;
}

}  // namespace

Run add_texture(CLI::App& app) {
  auto options = std::make_shared<Options>();
  app.add_option("SCAN", options->scans, "Scans, or directories of scans")->required();
  app.add_option("-o,--output", options->output, "Folder for texture.h5 and pictures")->required();
  app.add_option("--texel", options->block,
                 "Size of a texel, L or X,Y: scans are cut into blocks (default: each scan is a texel)")
      ->type_name("LENGTH");
  CLI::Option* layout =
      app.add_option("--layout", options->layout,
                     "Where scans lie, by their names, e.g. \"r{row}_c{col}\" (default: one strip along x)");
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
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--texel-ndf", options->texels.ndf_size,
                 "Nodes along a side of each texel's own table of slopes, 0 for none")
      ->check(CLI::Range(0, 257))
      ->capture_default_str();
  add_pitch(app, options->pitch, "Distance between points, P or X,Y, for files that don't say it");
  add_progress(app, options->common);
  add_common_options(app, options->common, "microbrdf texture strips/ --layout \"r{row}_c{col}\" -o texture");
  return [options, &app] { return run(*options, app); };
}

}  // namespace micro::tools
