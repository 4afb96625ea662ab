#pragma once

#include <array>
#include <span>
#include <vector>

namespace micro {

/// A map of standard normal numbers as its coefficients in normalised Hermite polynomials h₁ … h_n: mapped
/// numbers of correlation ρ correlate by Σ a_k b_k ρᵏ [Mehler].
constexpr int kHermiteTerms = 48;
using HermiteSeries = std::array<double, kHermiteTerms>;

/// Of the map that takes evenly spaced numbers from −reach to reach to `values`; all 0 for a constant one.
HermiteSeries hermite_series(std::span<const float> values, double reach);

/// What correlation two normal numbers need so that, each mapped, they have a given one. Maps that rise make
/// that a rising function; correlations that no normal numbers give are those of the nearest that do. Without
/// maps, and where one is constant, it changes nothing.
class CorrelationMap {
 public:
  CorrelationMap() = default;
  CorrelationMap(const HermiteSeries& a, const HermiteSeries& b);
  bool changes() const { return !after_.empty(); }
  double operator()(double wanted) const;

 private:
  std::vector<double> after_;  // at correlations of evenly spaced steps from −1 to 1
};

}  // namespace micro
