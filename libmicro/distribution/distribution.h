#pragma once

#include <concepts>

#include "core/grid.h"

namespace micro {

/// A distribution of normals over the hemisphere about n = +z, as a value. Directions are unit vectors; `xi`
/// are two uniform numbers in [0, 1); what lies below the horizon has density 0.
///   D(m)               1/sr, ∫ D m_z dω = 1 (a table: as much as it holds)
///   visible_area(u)    ∫ D max(0, m·u) dω: area seen from u for each unit of projected area
///   G1(u)              Smith's masking, min(1, u_z/visible_area(u)) for ∫ D m_z dω = 1
///   sample(xi)         m with density pdf(m) = D m_z/∫ D m_z dω, 1/sr
///   sample_visible     m with density pdf_visible(u, m) = D max(0, m·u)/visible_area(u), 1/sr
template <typename T>
concept Distribution = requires(const T& d, const Vec3& u, const Vec3& m, const Vec2& xi) {
  { d.D(m) } -> std::same_as<double>;
  { d.visible_area(u) } -> std::same_as<double>;
  { d.G1(u) } -> std::same_as<double>;
  { d.sample(xi) } -> std::same_as<Vec3>;
  { d.pdf(m) } -> std::same_as<double>;
  { d.sample_visible(u, xi) } -> std::same_as<Vec3>;
  { d.pdf_visible(u, m) } -> std::same_as<double>;
};

}  // namespace micro
