#include "pipelines/textures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "core/estimate.h"
#include "core/parallel.h"
#include "pipelines/texture_picture.h"
#include "pipelines/version.h"
#include "texture/marginals.h"

namespace micro {
namespace {

constexpr Eigen::Index kWhole = 4096, kPart = 2048;
/// A coarse texel is fitted to what it covers this many levels finer: 64 lobes.
constexpr int kFiner = 3;

const std::vector<std::string> kParameters = {"alpha.x", "alpha.y", "theta.x", "theta.y", "theta.z"};

/// Numbers of every texel in the layout of a dataset, [rows, cols, n].
std::vector<float> numbers(const TextureField& field, std::size_t n,
                           const std::function<void(const SlopeFrame&, float*)>& of) {
  const Eigen::Index rows = field[0].rows(), cols = field[0].cols();
  std::vector<float> values(static_cast<std::size_t>(rows * cols) * n);
  parallel_for(rows, [&](std::int64_t j) {
    for (Eigen::Index i = 0; i < cols; ++i) {
      SlopeCoordinates p;
      for (std::size_t c = 0; c < kChannels; ++c)
        p[c] = field[c](j, i);
      of(frame_of(p), &values[static_cast<std::size_t>(j * cols + i) * n]);
    }
  });
  return values;
}

std::vector<float> parameters_of(const TextureField& field) {
  return numbers(field, 5, [](const SlopeFrame& frame, float* out) {
    const EllipsoidParameters p = canonical_parameters(frame);
    const std::array<double, 5> values = {p.alpha_x, p.alpha_y, p.theta_x, p.theta_y, p.theta_z};
    std::copy(values.begin(), values.end(), out);
  });
}

/// One grid a channel from [rows, cols, 5].
std::vector<Grid<float>> planes_of(const std::vector<float>& values, Eigen::Index rows, Eigen::Index cols) {
  std::vector<Grid<float>> planes;
  for (std::size_t c = 0; c < kChannels; ++c)
    planes.emplace_back(Eigen::Map<const Grid<float>, 0, Eigen::Stride<Eigen::Dynamic, Eigen::Dynamic>>(
        values.data() + c, rows, cols, {cols * static_cast<Eigen::Index>(kChannels), kChannels}));
  return planes;
}

/// /texture while it is filled.
class TextureDatasets {
 public:
  TextureDatasets(Hdf5Writer& file, const TextureSize& size) : file_(file) {
    file_.create_group("/texture");
    create("parameters", size, kParameters);
    create("location", size, {"slope.x", "slope.y"});
    create("scale", size, {"xx", "xy", "yy"});
  }

  void write(const TexturePart& part, const TextureField& field, const std::vector<float>& parameters) {
    fill("parameters", part, 5, parameters);
    fill("location", part, 2, numbers(field, 2, [](const SlopeFrame& frame, float* out) {
           out[0] = static_cast<float>(frame.centre.x());
           out[1] = static_cast<float>(frame.centre.y());
         }));
    fill("scale", part, 3, numbers(field, 3, [](const SlopeFrame& frame, float* out) {
           const Eigen::Matrix2d scale = frame.scale();
           out[0] = static_cast<float>(scale(0, 0));
           out[1] = static_cast<float>(scale(0, 1));
           out[2] = static_cast<float>(scale(1, 1));
         }));
  }

 private:
  void create(const std::string& name, const TextureSize& size, const std::vector<std::string>& channels) {
    constexpr std::size_t kSide = 256;
    constexpr int kDeflate = 1;
    const std::string dataset = "/texture/" + name;
    file_.create_in_parts(
        dataset, {static_cast<std::size_t>(size.rows), static_cast<std::size_t>(size.cols), channels.size()},
        kSide, kDeflate);
    file_.set_attribute(dataset, "channels", std::span<const std::string>(channels));
  }
  void fill(const std::string& name, const TexturePart& part, std::size_t n,
            const std::vector<float>& values) {
    file_.write_part("/texture/" + name, static_cast<std::size_t>(part.row),
                     static_cast<std::size_t>(part.col),
                     {static_cast<std::size_t>(part.rows), static_cast<std::size_t>(part.cols), n}, values);
  }

  Hdf5Writer& file_;
};

/// Misfits of some texels of a level, against what they cover.
LevelMisfit misfit_of_level(const TextureField& coarse, const TextureField& finer, int level, int finer_by) {
  constexpr Eigen::Index kTexels = 32;
  LevelMisfit result{
      .level = level, .rows = coarse[0].rows(), .cols = coarse[0].cols(), .refitted = {}, .averaged = {}};
  const Eigen::Index count = coarse[0].size(), judged = std::min(kTexels, count);
  std::vector<std::array<Misfit, 2>> each(static_cast<std::size_t>(judged));
  parallel_for(judged, [&](std::int64_t k) {
    const Eigen::Index texel = k * count / judged;
    const Eigen::Index j = texel / coarse[0].cols(), i = texel % coarse[0].cols();
    const std::vector<SlopeFrame> lobes = covered(finer, finer_by, j, i);
    SlopeCoordinates p;
    for (std::size_t c = 0; c < kChannels; ++c)
      p[c] = coarse[c](j, i);
    each[static_cast<std::size_t>(k)] = {misfit(lobes, frame_of(p)), misfit(lobes, naive_average(lobes))};
  });
  const auto n = static_cast<double>(judged);
  for (const auto& [refitted, averaged] : each) {
    result.refitted.divergence += refitted.divergence / n;
    result.refitted.rel_rms += refitted.rel_rms / n;
    result.averaged.divergence += averaged.divergence / n;
    result.averaged.rel_rms += averaged.rel_rms / n;
  }
  return result;
}

TextureField empty_field(Eigen::Index rows, Eigen::Index cols) {
  TextureField field;
  field.fill(Grid<float>::Zero(rows, cols));
  return field;
}

}  // namespace

Exemplar exemplar_of(const Texels& texels) {
  Exemplar exemplar = make_exemplar(texels.rows, texels.cols);
  for (Eigen::Index k = 0; k < texels.rows * texels.cols; ++k) {
    if (texels.states[static_cast<std::size_t>(k)] == TexelState::Gap) continue;
    const SlopeCoordinates p = slope_coordinates(texels.texels[static_cast<std::size_t>(k)].fit.frame);
    for (std::size_t c = 0; c < kChannels; ++c)
      exemplar.channels[c].data()[k] = p[c];
  }
  return exemplar;
}

TextureSummary write_texture(const Texels& texels, const TextureRequest& request, Hdf5Writer& file,
                             const std::filesystem::path& exr, const std::string& command) {
  const Stopwatch watch;
  const Exemplar exemplar = exemplar_of(texels);
  const TextureModel model = model_of(exemplar, request.recipe, request.taper);
  const MarginalMap marginals(exemplar);
  const TextureSize& size = request.size;
  TextureSummary summary{.request = request,
                         .texel_width = texels.width,
                         .texel_height = texels.height,
                         .in_parts = std::max(size.rows, size.cols) > kWhole,
                         .misfits = {},
                         .coarsest = {},
                         .picture = {},
                         .plan = {}};
  const bool maps = request.marginals == TextureRequest::Marginals::Exemplar;
  const bool all_levels = request.levels == TextureRequest::Levels::All;
  const std::string recipe(name_of(request.recipe)), marginal_name = maps ? "exemplar" : "gaussian",
                                                     taper = request.taper == Taper::Hann ? "hann" : "none";

  ExrTextureWriter picture(
      exr, {.rows = size.rows,
            .cols = size.cols,
            .channels = kParameters,
            .positive = {"alpha.x", "alpha.y"},
            .pixel = request.pixel,
            .levels = all_levels ? ExrTextureWriter::Levels::All : ExrTextureWriter::Levels::Finest,
            .attributes = {{"units", "alpha: slope; theta: radians [Dong15 Eq. 12]"},
                           {"texelWidth", std::to_string(texels.width) + " um"},
                           {"texelHeight", std::to_string(texels.height) + " um"},
                           {"recipe", recipe},
                           {"marginals", marginal_name},
                           {"taper", taper},
                           {"seed", std::to_string(request.seed)},
                           {"wrapmodes", "periodic"},
                           {"provenance", command},
                           {"software", "microbrdf " + std::string(version())}}});
  TextureDatasets datasets(file, size);
  const int levels = all_levels ? level_count(size) : 1;
  std::vector<TextureField> kept(static_cast<std::size_t>(levels));  // levels from kFiner on, whole
  for (int level = kFiner; level < levels; ++level)
    kept[static_cast<std::size_t>(level)] =
        empty_field(level_size(size.rows, level), level_size(size.cols, level));

  const Eigen::Index step = summary.in_parts ? kPart : kWhole;
  for (Eigen::Index row = 0; row < size.rows; row += step)
    for (Eigen::Index col = 0; col < size.cols; col += step) {
      const TexturePart part = {row, col, std::min(step, size.rows - row), std::min(step, size.cols - col)};
      TextureField field = summary.in_parts ? synthesise_part(model, size, request.seed, part)
                                            : synthesise(model, size, request.seed);
      if (maps) marginals.apply(field);
      const std::vector<float> parameters = parameters_of(field);
      datasets.write(part, field, parameters);
      picture.write(0, row, col, planes_of(parameters, part.rows, part.cols));
      if (row == 0 && col == 0) summary.picture = texture_picture(exemplar, field);
      for (int level = 1; level <= std::min(kFiner, levels - 1); ++level) {
        const TextureField coarse = minified(field, level);
        if (row == 0 && col == 0) summary.misfits.push_back(misfit_of_level(coarse, field, level, level));
        const Eigen::Index rows = coarse[0].rows(), cols = coarse[0].cols();
        picture.write(level, row >> level, col >> level, planes_of(parameters_of(coarse), rows, cols));
        for (std::size_t c = 0; c < kChannels && level == kFiner; ++c)
          kept[static_cast<std::size_t>(kFiner)][c].block(row >> level, col >> level, rows, cols) = coarse[c];
        if (level < kFiner && level == levels - 1) kept[static_cast<std::size_t>(level)] = coarse;
      }
    }
  for (int level = kFiner + 1; level < levels; ++level) {
    const int by = std::min(kFiner, level - kFiner);
    const TextureField& finer = kept[static_cast<std::size_t>(level - by)];
    TextureField& coarse = kept[static_cast<std::size_t>(level)];
    coarse = minified(finer, by);
    summary.misfits.push_back(misfit_of_level(coarse, finer, level, by));
    picture.write(level, 0, 0, planes_of(parameters_of(coarse), coarse[0].rows(), coarse[0].cols()));
  }
  picture.finish();
  if (levels > 1) {
    SlopeCoordinates p;
    for (std::size_t c = 0; c < kChannels; ++c)
      p[c] = kept.back()[c](0, 0);
    summary.coarsest = frame_of(p);
  }

  const auto set = [&](const char* name, const auto& value) { file.set_attribute("/texture", name, value); };
  set("texel_width_um", texels.width);
  set("texel_height_um", texels.height);
  set("recipe", std::string_view(recipe));
  set("marginals", std::string_view(marginal_name));
  set("taper", std::string_view(taper));
  set("seed", request.seed);
  set("in_parts", summary.in_parts ? 1 : 0);
  if (!summary.misfits.empty()) {
    std::vector<float> table;
    for (const LevelMisfit& m : summary.misfits)
      for (const double value : {static_cast<double>(m.level), m.refitted.divergence, m.refitted.rel_rms,
                                 m.averaged.divergence, m.averaged.rel_rms})
        table.push_back(static_cast<float>(value));
    file.write<float>("/texture/level_misfit", table, {summary.misfits.size(), 5});
    const std::vector<std::string> columns = {"level", "divergence", "rel_rms", "averaged_divergence",
                                              "averaged_rel_rms"};
    file.set_attribute("/texture/level_misfit", "columns", std::span<const std::string>(columns));
  }
  summary.seconds = watch.seconds();
  set("seconds", summary.seconds);
  const bool block = std::holds_alternative<TextureModel::Blocks>(model.spectrum);
  summary.plan.push_back(
      ran("texture", std::to_string(size.rows) + " x " + std::to_string(size.cols) + " texels, " + recipe +
                         (block ? " from a block" : " from strips") + ", marginals " + marginal_name +
                         ", taper " + taper + (summary.in_parts ? ", by parts" : "")));
  summary.plan.push_back(
      stage_if(levels > 1, "minification",
               levels > 1 ? std::to_string(levels) + " levels, each texel refitted" : "not asked for"));
  return summary;
}

}  // namespace micro
