#include "brdf/fresnel.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/error.h"

namespace micro {
namespace {

void check_index(double eta, double kappa) {
  if (!(eta > 0 && std::isfinite(eta) && kappa >= 0 && std::isfinite(kappa)))
    throw InputError("optical constants need a finite eta > 0 and kappa >= 0, not " + std::to_string(eta) +
                     " + " + std::to_string(kappa) + "i");
}

void check(const OpticalConstants& constants) {
  const auto& [lambda, eta, kappa] = constants;
  if (lambda.empty() || eta.size() != lambda.size() || kappa.size() != lambda.size())
    throw InputError("optical constants need an eta and a kappa at each of one or more wavelengths");
  if (!std::ranges::is_sorted(lambda, std::less_equal{}))
    throw InputError("the wavelengths of optical constants must ascend");
  for (std::size_t k = 0; k < lambda.size(); ++k)
    check_index(eta[k], kappa[k]);
}

}  // namespace

double fresnel(double cosine, std::complex<double> index) {
  const std::complex<double> squared = index * index;
  // (η + iκ)² − sin²θ with the 1s taken together first: at grazing angles cos²θ is all that is left of them.
  const std::complex<double> refracted = std::sqrt((index - 1.) * (index + 1.) + cosine * cosine);
  const auto reflected = [&refracted](const std::complex<double>& incident) {
    const double sum = std::norm(incident + refracted);
    return sum > 0 ? std::norm(incident - refracted) / sum : 1;
  };
  return (reflected(cosine) + reflected(squared * cosine)) / 2;
}

double fresnel_dielectric(double cosine, double n) {
  return fresnel(cosine, {n, 0});
}

double fresnel_schlick(double cosine, double r0) {
  const double x = 1 - cosine, x2 = x * x;
  return r0 + (1 - r0) * x2 * x2 * x;
}

double extinction_from_r0(double eta, double r0) {
  check_index(eta, 0);
  const double squared = (r0 * (eta + 1) * (eta + 1) - (eta - 1) * (eta - 1)) / (1 - r0);
  if (!(r0 < 1 && squared >= 0))
    throw InputError("no kappa gives an index of " + std::to_string(eta) + " the reflectance " +
                     std::to_string(r0) + " at normal incidence");
  return std::sqrt(squared);
}

std::complex<double> OpticalConstants::at(double lambda) const {
  if (!(lambda >= lambda_um.front() && lambda <= lambda_um.back()))
    throw InputError("the optical constants reach from " + std::to_string(lambda_um.front()) + " to " +
                     std::to_string(lambda_um.back()) + " um, not to " + std::to_string(lambda));
  const auto next = std::ranges::upper_bound(lambda_um, lambda);
  if (next == lambda_um.end()) return {eta.back(), kappa.back()};
  const auto k = static_cast<std::size_t>(next - lambda_um.begin());
  const double t = (lambda - lambda_um[k - 1]) / (lambda_um[k] - lambda_um[k - 1]);
  return {std::lerp(eta[k - 1], eta[k], t), std::lerp(kappa[k - 1], kappa[k], t)};
}

Fresnel::Fresnel(Kind kind) : kind_(std::move(kind)) {
  if (const auto* index = std::get_if<std::complex<double>>(&kind_))
    check_index(index->real(), index->imag());
  if (const auto* constants = std::get_if<OpticalConstants>(&kind_)) check(*constants);
  if (const auto* schlick = std::get_if<Schlick>(&kind_); schlick && !(schlick->r0 >= 0 && schlick->r0 <= 1))
    throw InputError("a reflectance at normal incidence lies between 0 and 1, not at " +
                     std::to_string(schlick->r0));
}

double Fresnel::operator()(double cosine, double lambda_um) const {
  const double c = std::clamp(cosine, 0., 1.);
  if (const auto* index = std::get_if<std::complex<double>>(&kind_)) return fresnel(c, *index);
  if (const auto* constants = std::get_if<OpticalConstants>(&kind_))
    return fresnel(c, constants->at(lambda_um));
  if (const auto* schlick = std::get_if<Schlick>(&kind_)) return fresnel_schlick(c, schlick->r0);
  return 1;
}

}  // namespace micro
