#include "error_vs_time/texture_curves.h"

#include <cmath>
#include <tuple>

#include "core/estimate.h"
#include "core/random.h"
#include "height/gaussian_surface.h"
#include "pipelines/texels_of_surface.h"
#include "texture/minify.h"
#include "texture/synthesis.h"

namespace micro::bench {
namespace {

using Report = std::function<void(const CurvePoint&)>;

CurvePoint point(std::string surface, std::string estimator, double asked, double error, double second,
                 double seconds) {
  CurvePoint made;
  made.part = "texture";
  made.surface = std::move(surface);
  made.estimator = std::move(estimator);
  made.asked = asked;
  made.error = error;
  made.error_core_free = second;
  made.seconds = seconds;
  return made;
}

double log_width(const SlopeFrame& frame) {
  return std::log(frame.l11 * frame.l22) / 2;
}

void report_texels(const Report& report) {
  const HeightField surface =
      gaussian_surface({1920, 1920, 0.25, 0.25}, {.rms = 0.3, .tau_x = 3, .tau_y = 3}, 1);
  const double truth = log_width(texels_of_surface(surface, {}).texels[0].fit.frame);
  for (const Eigen::Index side : {24, 32, 48, 64, 96, 128, 192, 320}) {
    const Stopwatch watch;
    const SurfaceTexels cut = texels_of_surface(surface, {side, side, 1, 0});
    const auto n = static_cast<double>(cut.texels.size());
    const double seconds = watch.seconds() / n;
    double mean = 0, squares = 0, predicted = 0;
    for (const Texel& texel : cut.texels) {
      const double away = log_width(texel.fit.frame) - truth;
      mean += away / n;
      squares += away * away / n;
      const Matrix5& c = texel.fit.step_covariance;
      predicted += (c(2, 2) + 2 * c(2, 4) + c(4, 4)) / 4 / n;
    }
    const double normals = std::round(cut.texels[0].independent);
    report(point("gaussian surface", "texel", normals, std::sqrt(squares - mean * mean), mean, seconds));
    report(point("gaussian surface", "texel predicted", normals, std::sqrt(predicted), mean, seconds));
  }
}

/// A strip of a first-order autoregressive process of correlation exp(−|lag|/length), variance 1.
Eigen::ArrayXd strip(Eigen::Index n, double length, std::uint64_t seed, std::uint32_t stream) {
  const double keep = std::exp(-1 / length);
  Eigen::ArrayXd values(n);
  double value = 0;
  for (Eigen::Index k = 0; k < n; ++k) {
    const double noise = random_normal(seed, stream, static_cast<std::uint64_t>(k))[0];
    value = k == 0 ? noise : keep * value + std::sqrt(1 - keep * keep) * noise;
    values[k] = value;
  }
  return values;
}

constexpr double kAcross = 3, kAlong = 8;  // texels

void report_strips(const Report& report) {
  constexpr std::uint64_t kSeeds = 16;
  constexpr Eigen::Index kLags = 20, kSide = 256;
  const std::array<std::tuple<const char*, Recipe, Taper>, 3> ways = {
      std::tuple{"separable hann", Recipe::Separable, Taper::Hann},
      {"separable none", Recipe::Separable, Taper::None},
      {"joint hann", Recipe::Joint, Taper::Hann}};
  for (const auto& [name, recipe, taper] : ways)
    for (const Eigen::Index n : {10, 20, 50, 100, 200, 500, 1000}) {
      double squares = 0, variances = 0, seconds = 0;
      for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
        Exemplar exemplar = make_exemplar(n, n);
        for (std::size_t c = 0; c < kChannels; ++c) {
          const auto stream = static_cast<std::uint32_t>(c);
          exemplar.channels[c].row(n / 2) = strip(n, kAlong, seed, stream).transpose();
          exemplar.channels[c].col(n / 2) = strip(n, kAcross, seed, stream + 8);
        }
        const Stopwatch watch;
        const TextureField field = synthesise(model_of(exemplar, recipe, taper), {kSide, kSide}, seed);
        seconds += watch.seconds() / kSeeds;
        const Grid<double> values = field[0].cast<double>() - field[0].cast<double>().mean();
        const double variance = values.square().mean();
        variances += std::pow(variance - 1, 2) / kSeeds;
        for (Eigen::Index lag = 1; lag <= kLags; ++lag) {
          const double x = (values.rightCols(kSide - lag) * values.leftCols(kSide - lag)).mean() / variance,
                       y = (values.bottomRows(kSide - lag) * values.topRows(kSide - lag)).mean() / variance;
          const auto d = static_cast<double>(lag);
          squares += (std::pow(x - std::exp(-d / kAlong), 2) + std::pow(y - std::exp(-d / kAcross), 2)) /
                     (2. * kLags * kSeeds);
        }
      }
      report(
          point("strips", name, static_cast<double>(n), std::sqrt(squares), std::sqrt(variances), seconds));
    }
}

void report_sizes(const Report& report) {
  Exemplar exemplar = make_exemplar(100, 100);
  for (std::size_t c = 0; c < kChannels; ++c) {
    exemplar.channels[c].row(50) = strip(100, kAlong, 1, static_cast<std::uint32_t>(c)).transpose();
    exemplar.channels[c].col(50) = strip(100, kAcross, 2, static_cast<std::uint32_t>(c));
  }
  const ExemplarMoments moments = moments_of(exemplar);
  const TextureModel model = model_of(exemplar, Recipe::Separable);
  for (const Eigen::Index n : {64, 128, 256, 512, 1024, 2048})
    for (const char* way : {"whole", "parts"}) {
      const Stopwatch watch;
      const TextureField field =
          way[0] == 'w' ? synthesise(model, {n, n}, 1) : synthesise_part(model, {n, n}, 1, {0, 0, n, n});
      const double seconds = watch.seconds();
      const Grid<double> values = field[0].cast<double>() - moments.mean[0];
      const double mean = values.mean(), variance = (values - mean).square().mean();
      report(point("strips of 100", way, static_cast<double>(n),
                   std::abs(variance / moments.covariance(0, 0) - 1),
                   std::abs(mean) / std::sqrt(moments.covariance(0, 0)), seconds));
    }
}

void report_levels(const Report& report) {
  for (const double spread : {0., 0.5, 1., 2., 5., 10.}) {
    std::vector<SlopeFrame> lobes;
    for (std::uint64_t k = 0; k < 64; ++k) {
      const auto [a, b] = random_normal(3, 0, k);
      const auto [c, d] = random_normal(3, 1, k);
      lobes.push_back(slope_frame({0.2 * std::exp(0.3 * c), 0.02 * std::exp(0.3 * d), spread * 0.02 * a,
                                   spread * 0.02 * b, 0.05 * a}));
    }
    const Stopwatch watch;
    const SlopeFrame frame = minified(lobes);
    const double seconds = watch.seconds();
    report(point("64 lobes", "levels", spread, misfit(lobes, frame).divergence,
                 misfit(lobes, naive_average(lobes)).divergence, seconds));
  }
}

}  // namespace

void texture_curves(const Report& report) {
  report_texels(report);
  report_strips(report);
  report_sizes(report);
  report_levels(report);
}

}  // namespace micro::bench
