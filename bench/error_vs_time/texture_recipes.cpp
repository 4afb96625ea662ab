#include "error_vs_time/texture_recipes.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/estimate.h"
#include "height/brushed_surface.h"
#include "height/gaussian_surface.h"
#include "pipelines/texels_of_surface.h"
#include "texture/marginals.h"
#include "texture/synthesis.h"

namespace micro::bench {
namespace {

constexpr Eigen::Index kTexels = 32, kPoints = 120;  // along a side of the block, of a texel
constexpr double kPitch = 0.25;                      // µm
constexpr std::uint64_t kSeeds = 4;
constexpr TextureSize kSize = {256, 256};

HeightField surface_of(const std::string& finish, std::uint64_t seed) {
  const SyntheticGrid grid = {kTexels * kPoints, kTexels * kPoints, kPitch, kPitch};
  if (finish == "brushed")
    return brushed_surface(
        grid, {.rms = 0.2, .length = 2000, .width = 3, .coverage = 4, .spread = 0.05, .orientation = 0},
        seed);
  return multiscale_surface(grid, power_law_scales({.tau_max = 300}), seed);
}

Exemplar block_of(const std::string& finish, std::uint64_t seed) {
  const SurfaceTexels cut = texels_of_surface(surface_of(finish, seed), {kPoints, kPoints, 1, 0});
  Exemplar exemplar = make_exemplar(cut.rows, cut.cols);
  for (std::size_t k = 0; k < cut.texels.size(); ++k) {
    const SlopeCoordinates p = slope_coordinates(cut.texels[k].fit.frame);
    for (std::size_t c = 0; c < kChannels; ++c)
      exemplar.channels[c].data()[k] = p[c];
  }
  return exemplar;
}

Exemplar strips_of(Exemplar block) {
  constexpr Eigen::Index kApart = 8;
  for (auto& channel : block.channels)
    for (Eigen::Index j = 0; j < block.rows(); ++j)
      for (Eigen::Index i = 0; i < block.cols(); ++i)
        if (j % kApart > 0 && i % kApart > 0) channel(j, i) = std::nan("");
  return block;
}

Exemplar as_exemplar(const TextureField& field) {
  Exemplar exemplar;
  for (std::size_t c = 0; c < kChannels; ++c)
    exemplar.channels[c] = field[c].cast<double>();
  return exemplar;
}

/// ⟨a(x)·b(x + lag)⟩ over both deviations; di may be negative.
double correlation(const Grid<double>& a, const Grid<double>& b, Eigen::Index dj, Eigen::Index di) {
  const Eigen::Index rows = a.rows() - dj, cols = a.cols() - std::abs(di);
  const Grid<double> x = a - a.mean(), y = b - b.mean();
  const Eigen::Index from = std::max<Eigen::Index>(0, -di), to = std::max<Eigen::Index>(0, di);
  return (x.block(0, from, rows, cols) * y.block(dj, to, rows, cols)).mean() /
         std::sqrt(x.square().mean() * y.square().mean());
}

/// Correlations in space and between numbers, in groups.
std::map<std::string, std::vector<double>> correlations(const Exemplar& e) {
  constexpr Eigen::Index kAxis = 6, kPlane = 4;
  std::map<std::string, std::vector<double>> found;
  for (const auto& a : e.channels) {
    for (Eigen::Index lag = 1; lag <= kAxis; ++lag) {
      found["axes"].push_back(correlation(a, a, 0, lag));
      found["axes"].push_back(correlation(a, a, lag, 0));
    }
    for (Eigen::Index dj = 0; dj <= kPlane; ++dj)
      for (Eigen::Index di = dj == 0 ? 1 : -kPlane; di <= kPlane; ++di)
        found["plane"].push_back(correlation(a, a, dj, di));
    for (const auto& b : e.channels)
      for (const auto& [dj, di] : {std::pair{0, 1}, std::pair{1, 0}, std::pair{1, 1}})
        if (&a != &b) found["between lagged"].push_back(correlation(a, b, dj, di));
  }
  return found;
}

double rms_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double squares = 0;
  for (std::size_t k = 0; k < a.size(); ++k)
    squares += std::pow(a[k] - b[k], 2) / static_cast<double>(a.size());
  return std::sqrt(squares);
}

std::vector<double> sorted(const Grid<double>& values) {
  std::vector<double> there;
  for (const double value : values.reshaped())
    if (!std::isnan(value)) there.push_back(value);
  std::sort(there.begin(), there.end());
  return there;
}

/// Largest distance between two distribution functions.
double distribution_distance(const Grid<double>& a, const Grid<double>& b) {
  const std::vector<double> x = sorted(a), y = sorted(b);
  double most = 0;
  std::size_t below = 0;
  for (std::size_t k = 0; k < x.size(); ++k) {
    while (below < y.size() && y[below] < x[k])
      ++below;
    const double p = static_cast<double>(below) / static_cast<double>(y.size());
    for (const std::size_t step : {k, k + 1})
      most = std::max(most, std::abs(p - static_cast<double>(step) / static_cast<double>(x.size())));
  }
  return most;
}

using Measures = std::map<std::string, double>;

/// How far `made` is from the block in space and from the exemplar, which is all that is known, elsewhere.
Measures measures(const Exemplar& made, const Exemplar& exemplar,
                  const std::map<std::string, std::vector<double>>& of_block) {
  Measures found;
  for (const auto& [name, values] : correlations(made))
    found[name] = rms_difference(values, of_block.at(name));
  const ExemplarMoments to = moments_of(made), from = moments_of(exemplar);
  std::vector<double> between_made, between;
  for (Eigen::Index a = 0; a < 5; ++a) {
    const auto c = static_cast<std::size_t>(a);
    const double variance = from.covariance(a, a);
    found["mean"] = std::max(found["mean"], std::abs(to.mean[c] - from.mean[c]) / std::sqrt(variance));
    found["variance"] = std::max(found["variance"], std::abs(to.covariance(a, a) / variance - 1));
    found["marginals"] =
        std::max(found["marginals"], distribution_distance(exemplar.channels[c], made.channels[c]));
    for (Eigen::Index b = 0; b < a; ++b) {
      between_made.push_back(to.covariance(a, b) / std::sqrt(to.covariance(a, a) * to.covariance(b, b)));
      between.push_back(from.covariance(a, b) / std::sqrt(variance * from.covariance(b, b)));
    }
  }
  found["between"] = rms_difference(between_made, between);
  return found;
}

struct Way {
  Recipe recipe;
  enum class Basis { Strips, Block } basis;
  enum class Marginals { Gaussian, ByRank } marginals;
};

std::string name_of(const Way& way) {
  return std::string(name_of(way.recipe)) + (way.basis == Way::Basis::Strips ? "; strips" : "; block") +
         (way.marginals == Way::Marginals::ByRank ? "; by rank" : "; Gaussian");
}

TextureField made_by(const Way& way, const Exemplar& exemplar, std::uint64_t seed) {
  const TextureModel model = model_of(exemplar, way.recipe);
  if (way.marginals == Way::Marginals::Gaussian) return synthesise(model, kSize, seed);
  const MarginalMap marginals(exemplar);
  TextureField field =
      synthesise(with_correlations_before(model, marginals.correlations_before()), kSize, seed);
  marginals.apply(field);
  return field;
}

std::vector<Way> all_ways() {
  std::vector<Way> ways;
  for (const auto& [recipe, basis] : {std::pair{Recipe::Separable, Way::Basis::Strips},
                                      {Recipe::Joint, Way::Basis::Strips},
                                      {Recipe::Separable, Way::Basis::Block},
                                      {Recipe::Full, Way::Basis::Block},
                                      {Recipe::Joint, Way::Basis::Block}})
    for (const auto marginals : {Way::Marginals::Gaussian, Way::Marginals::ByRank})
      ways.push_back({recipe, basis, marginals});
  return ways;
}

}  // namespace

void texture_recipes(const std::function<void(const CurvePoint&)>& report) {
  for (const std::string finish : {"brushed", "isotropic"}) {
    const Exemplar block = block_of(finish, 1), strips = strips_of(block);
    const auto of_block = correlations(block);
    const auto report_all = [&](const std::string& name, const Measures& found, double seconds) {
      for (const auto& [measure, value] : found) {
        CurvePoint point;
        point.part = "recipes";
        point.surface = finish;
        point.estimator = measure;
        point.error = point.error_core_free = value;
        point.seconds = seconds;
        point.note = name;
        report(point);
      }
    };
    for (const Way& way : all_ways()) {
      const Exemplar& exemplar = way.basis == Way::Basis::Block ? block : strips;
      Measures mean;
      double seconds = 0;
      for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
        const Stopwatch watch;
        const TextureField field = made_by(way, exemplar, seed);
        seconds += watch.seconds() / kSeeds;
        for (const auto& [measure, value] : measures(as_exemplar(field), exemplar, of_block))
          mean[measure] += value / kSeeds;
      }
      report_all(name_of(way), mean, seconds);
    }
    report_all("another piece", measures(block_of(finish, 2), block, of_block), 0);
  }
}

}  // namespace micro::bench
