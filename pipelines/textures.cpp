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
/// Every 2^kSparse-th texel of the finest level is kept along either axis: what the coarsest levels are
/// judged by. A part holds whole texels of the others.
constexpr int kSparse = 5, kJudgedBySparse = 11;
static_assert(Eigen::Index{1} << kJudgedBySparse == kPart);

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
           const std::array<float, 3> scale = stored_scale(frame);
           std::copy(scale.begin(), scale.end(), out);
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

/// Misfits of some texels of a level, against the lobes of the finest that they cover: those of `finer`,
/// `finer_by` levels finer, which may be less than the whole.
LevelMisfit misfit_of_level(const TextureField& coarse, const TextureField& finer, int level, int finer_by) {
  constexpr Eigen::Index kMost = 4096;                  // lobes of a texel
  constexpr Eigen::Index kTexels = 32, kFewTexels = 4;  // the latter from 64² lobes on
  constexpr int kLarge = 6;
  LevelMisfit result{
      .level = level, .rows = coarse[0].rows(), .cols = coarse[0].cols(), .refitted = {}, .averaged = {}};
  const Eigen::Index rows = level_size(finer[0].rows(), finer_by),
                     cols = level_size(finer[0].cols(), finer_by), count = rows * cols;
  const Eigen::Index judged = std::min(finer_by < kLarge ? kTexels : kFewTexels, count);
  std::vector<std::array<Misfit, 2>> each(static_cast<std::size_t>(judged));
  parallel_for(judged, [&](std::int64_t k) {
    const Eigen::Index texel = k * count / judged;
    const Eigen::Index j = texel / cols, i = texel % cols;
    const std::vector<SlopeFrame> lobes = covered(finer, finer_by, j, i, kMost);
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

/// The names that files tell a request by.
struct RequestNames {
  std::string recipe, marginals, taper;

  explicit RequestNames(const TextureRequest& request)
      : recipe(name_of(request.recipe)),
        marginals(request.marginals == TextureRequest::Marginals::Exemplar ? "exemplar" : "gaussian"),
        taper(request.taper == Taper::Hann ? "hann" : "none") {}
};

ExrTextureWriter::Layout picture_layout(const Texels& texels, const TextureRequest& request,
                                        const RequestNames& names, const std::string& command) {
  const bool all_levels = request.levels == TextureRequest::Levels::All;
  return {.rows = request.size.rows,
          .cols = request.size.cols,
          .channels = kParameters,
          .positive = {"alpha.x", "alpha.y"},
          .pixel = request.pixel,
          .levels = all_levels ? ExrTextureWriter::Levels::All : ExrTextureWriter::Levels::Finest,
          .attributes = {{"units", "alpha: slope; theta: radians [Dong15 Eq. 12]"},
                         {"texelWidth", std::to_string(texels.width) + " um"},
                         {"texelHeight", std::to_string(texels.height) + " um"},
                         {"recipe", names.recipe},
                         {"marginals", names.marginals},
                         {"taper", names.taper},
                         {"seed", std::to_string(request.seed)},
                         {"wrapmodes", "periodic"},
                         {"provenance", command},
                         {"software", "microbrdf " + std::string(version())}}};
}

/// The levels above the finest. Those up to kFiner are made part by part, the coarser ones of a whole level
/// kFiner, which is kept.
class CoarseLevels {
 public:
  /// `levels` counts the finest; `picture` has to outlive this.
  CoarseLevels(const TextureSize& size, int levels, ExrTextureWriter& picture)
      : size_(size), picture_(picture), kept_(static_cast<std::size_t>(levels)) {
    sparse_ = empty_field(level_size(size.rows, kSparse), level_size(size.cols, kSparse));
    for (int level = kFiner; level < levels; ++level)
      kept(level) = empty_field(level_size(size.rows, level), level_size(size.cols, level));
  }

  /// What a part of the finest level covers.
  void add(const TexturePart& part, const TextureField& field) {
    for (int level = 1; level <= std::min(kFiner, last()); ++level) {
      const TextureField coarse = minified(field, level);
      const Eigen::Index row = part.row >> level, col = part.col >> level;
      if (row == 0 && col == 0) misfits_.push_back(misfit_of_level(coarse, field, level, level));
      write(level, row, col, coarse);
      if (level == kFiner)
        for (std::size_t c = 0; c < kChannels; ++c)
          kept(level)[c].block(row, col, coarse[c].rows(), coarse[c].cols()) = coarse[c];
      else if (level == last())
        kept(level) = coarse;
    }
    const Eigen::Index step = Eigen::Index{1} << kSparse;
    for (std::size_t c = 0; c < kChannels; ++c)
      for (Eigen::Index j = 0; j < part.rows; j += step)
        for (Eigen::Index i = 0; i < part.cols; i += step)
          sparse_[c]((part.row + j) / step, (part.col + i) / step) = field[c](j, i);
  }

  /// After every part: the levels beyond kFiner. `first` is the first part.
  void finish(const TextureField& first) {
    for (int level = kFiner + 1; level <= last(); ++level) {
      const int by = std::min(kFiner, level - kFiner);
      kept(level) = minified(kept(level - by), by, size_, level - by);
      misfits_.push_back(level < kJudgedBySparse
                             ? misfit_of_level(kept(level), first, level, level)
                             : misfit_of_level(kept(level), sparse_, level, level - kSparse));
      write(level, 0, 0, kept(level));
    }
  }

  const std::vector<LevelMisfit>& misfits() const { return misfits_; }
  /// The one lobe of the whole texture.
  SlopeFrame coarsest() const {
    SlopeCoordinates p;
    for (std::size_t c = 0; c < kChannels; ++c)
      p[c] = kept_.back()[c](0, 0);
    return frame_of(p);
  }

 private:
  int last() const { return static_cast<int>(kept_.size()) - 1; }
  TextureField& kept(int level) { return kept_[static_cast<std::size_t>(level)]; }
  void write(int level, Eigen::Index row, Eigen::Index col, const TextureField& field) {
    picture_.write(level, row, col, planes_of(parameters_of(field), field[0].rows(), field[0].cols()));
  }

  TextureSize size_;
  ExrTextureWriter& picture_;
  std::vector<TextureField> kept_;
  TextureField sparse_;
  std::vector<LevelMisfit> misfits_;
};

void write_misfits(Hdf5Writer& file, const std::vector<LevelMisfit>& misfits) {
  std::vector<float> table;
  for (const LevelMisfit& m : misfits)
    for (const double value : {static_cast<double>(m.level), m.refitted.divergence, m.refitted.rel_rms,
                               m.averaged.divergence, m.averaged.rel_rms})
      table.push_back(static_cast<float>(value));
  file.write<float>("/texture/level_misfit", table, {misfits.size(), 5});
  const std::vector<std::string> columns = {"level", "divergence", "rel_rms", "averaged_divergence",
                                            "averaged_rel_rms"};
  file.set_attribute("/texture/level_misfit", "columns", std::span<const std::string>(columns));
}

void write_attributes(Hdf5Writer& file, const TextureSummary& summary, const RequestNames& names) {
  const auto set = [&](const char* name, const auto& value) { file.set_attribute("/texture", name, value); };
  set("texel_width_um", summary.texel_width);
  set("texel_height_um", summary.texel_height);
  set("recipe", std::string_view(names.recipe));
  set("marginals", std::string_view(names.marginals));
  set("taper", std::string_view(names.taper));
  set("seed", summary.request.seed);
  set("in_parts", summary.in_parts ? 1 : 0);
  set("seconds", summary.seconds);
}

/// How many texels are narrower than half can tell, as the picture's finest level holds them.
std::int64_t below_half(const std::vector<float>& parameters) {
  std::int64_t texels = 0;
  for (std::size_t k = 0; k < parameters.size(); k += kChannels)
    texels += std::min(parameters[k], parameters[k + 1]) < ExrTextureWriter::kLeastHalf ? 1 : 0;
  return texels;
}

/// What a model's spectra were measured on.
std::string basis_of(const TextureModel& model) {
  const auto* axes = std::get_if<TextureModel::Axes>(&model.spectrum);
  if (!axes) return " from a block";
  const auto along = [](const AxisSpectrum& axis, const char* name) {
    const std::size_t n = axis.strips[0].size();
    return (n > 0 ? counted(static_cast<std::int64_t>(n), "strip") : std::string("no strip")) + " along " +
           name;
  };
  return " from " + along(axes->x, "x") + " and " + along(axes->y, "y");
}

Plan plan_of(const TextureSummary& summary, const RequestNames& names, const TextureModel& model,
             int levels) {
  const TextureSize& size = summary.request.size;
  const std::string minification = summary.request.levels == TextureRequest::Levels::Finest ? "--no-levels"
                                   : levels == 1 ? "one texel has no coarser level"
                                                 : std::to_string(levels) + " levels, each texel refitted";
  return {ran("texture", std::to_string(size.rows) + " x " + std::to_string(size.cols) + " texels, " +
                             names.recipe + basis_of(model) + ", marginals " + names.marginals + ", taper " +
                             names.taper + (summary.in_parts ? ", by parts" : "")),
          stage_if(levels > 1, "minification", minification)};
}

}  // namespace

Exemplar exemplar_of(const Texels& texels) {
  Exemplar exemplar = make_exemplar(texels.rows, texels.cols);
  for (std::size_t k = 0; k < texels.texels.size(); ++k) {
    if (texels.states[k] == TexelState::Gap) continue;
    const SlopeCoordinates p = slope_coordinates(texels.texels[k].fit.frame);
    for (std::size_t c = 0; c < kChannels; ++c)
      exemplar.channels[c].data()[texels.places[k]] = p[c];
  }
  return exemplar;
}

TextureSummary write_texture(const Texels& texels, const TextureRequest& request, Hdf5Writer& file,
                             const std::filesystem::path& exr, const std::string& command) {
  const Stopwatch watch;
  const Exemplar exemplar = exemplar_of(texels);
  const MarginalMap marginals(exemplar);
  const TextureModel model = request.marginals == TextureRequest::Marginals::Exemplar
                                 ? with_correlations_before(model_of(exemplar, request.recipe, request.taper),
                                                            marginals.correlations_before())
                                 : model_of(exemplar, request.recipe, request.taper);
  const TextureSize& size = request.size;
  const RequestNames names(request);
  TextureSummary summary{.request = request,
                         .texel_width = texels.width,
                         .texel_height = texels.height,
                         .in_parts = std::max(size.rows, size.cols) > kWhole,
                         .misfits = {},
                         .coarsest = {},
                         .picture = {},
                         .plan = {}};
  const int levels = request.levels == TextureRequest::Levels::All ? level_count(size) : 1;
  ExrTextureWriter picture(exr, picture_layout(texels, request, names, command));
  TextureDatasets datasets(file, size);
  CoarseLevels coarse(size, levels, picture);
  const Eigen::Index step = summary.in_parts ? kPart : kWhole;
  TextureField first;
  std::int64_t narrow = 0;
  for (Eigen::Index row = 0; row < size.rows; row += step)
    for (Eigen::Index col = 0; col < size.cols; col += step) {
      const TexturePart part = {row, col, std::min(step, size.rows - row), std::min(step, size.cols - col)};
      TextureField field = summary.in_parts ? synthesise_part(model, size, request.seed, part)
                                            : synthesise(model, size, request.seed);
      if (request.marginals == TextureRequest::Marginals::Exemplar) marginals.apply(field);
      const std::vector<float> parameters = parameters_of(field);
      datasets.write(part, field, parameters);
      picture.write(0, row, col, planes_of(parameters, part.rows, part.cols));
      if (request.pixel == ExrPixel::Half) narrow += below_half(parameters);
      if (levels > 1) coarse.add(part, field);
      if (row == 0 && col == 0) {
        summary.picture = texture_picture(exemplar, field);
        first = std::move(field);
      }
    }
  coarse.finish(first);
  picture.finish();
  summary.misfits = coarse.misfits();
  if (levels > 1) summary.coarsest = coarse.coarsest();
  summary.seconds = watch.seconds();
  write_attributes(file, summary, names);
  if (!summary.misfits.empty()) write_misfits(file, summary.misfits);
  summary.plan = plan_of(summary, names, model, levels);
  if (narrow > 0)
    summary.plan.push_back(
        ran("half", counted(narrow, "texel") +
                        " narrower than 6.1e-05, the least width in half, written as that: "
                        "--pixel float keeps them"));
  return summary;
}

}  // namespace micro
