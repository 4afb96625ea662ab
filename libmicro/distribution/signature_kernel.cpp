#include "distribution/signature_kernel.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace micro {
namespace {

constexpr std::size_t kSamples = 4096;

}  // namespace

double response_at(const Signature& signature, double angle) {
  const auto next = std::upper_bound(signature.angle.begin(), signature.angle.end(), angle);
  if (next == signature.angle.end()) return signature.response.back();
  const auto k = static_cast<std::size_t>(next - signature.angle.begin());
  const double t = (angle - signature.angle[k - 1]) / (signature.angle[k] - signature.angle[k - 1]);
  return signature.response[k - 1] + t * (signature.response[k] - signature.response[k - 1]);
}

SignatureKernel::SignatureKernel(const Signature& signature)
    : reach_angle_(signature.angle.back()),
      reach_(2 * std::pow(std::sin(reach_angle_ / 2), 2)),
      scale_((kSamples - 1) / std::sqrt(reach_)) {
  const double last = std::sqrt(reach_);
  for (std::size_t k = 0; k < kSamples; ++k) {
    const double root = std::min(last, static_cast<double>(k) / scale_);
    table_.push_back(response_at(
        signature, std::min(reach_angle_, 2 * std::asin(std::min(1., root / std::numbers::sqrt2)))));
  }
  table_.push_back(0);
}

double SignatureKernel::operator()(double c) const {
  const double x = std::sqrt(std::max(0., c)) * scale_;
  const auto k = std::min(static_cast<std::size_t>(x), kSamples - 1);
  return table_[k] + (x - static_cast<double>(k)) * (table_[k + 1] - table_[k]);
}

}  // namespace micro
