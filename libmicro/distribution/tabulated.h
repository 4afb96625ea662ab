#pragma once

#include <memory>

#include "distribution/disk_table.h"
#include "distribution/distribution.h"

namespace micro {

/// A disk table as a distribution. D is bilinear in m_xy in every cell of four nodes that are all on the
/// disk, m_z > spacing/2, and zero elsewhere: the ring of cells that the horizon cuts is left out. All else
/// follows from that function: masking is Smith's for its own slopes, samples follow it exactly. ∫ D m_z dω
/// is what the table holds.
///
/// Copies share their tables. Masking and sampling tables are made when they are first asked for, from any
/// thread.
class Tabulated {
 public:
  /// Throws InputError if the table holds no mass, or a number that is negative or not finite.
  explicit Tabulated(const DiskTable& table);

  const DiskTable& table() const;
  /// ∫ D m_z dω.
  double mass() const;

  double D(const Vec3& m) const;

  /// Interpolated between 128 azimuths and 129 elevations in the lobe's own frame, where it is nearly round:
  /// there to 1e-3 of itself as far down as 1e-4 of mass·|u'|, u' being u in that frame. Mass that stands
  /// apart may fall between the azimuths: where less than 1 % is seen the area of a single node is off by up
  /// to a tenth, that of single nodes far apart by a few times itself; where more than a tenth is seen, by 7
  /// %.
  double visible_area(const Vec3& u) const;
  /// min(1, mass·u_z/visible_area(u)).
  double G1(const Vec3& u) const;

  Vec3 sample(const Vec2& xi) const;
  double pdf(const Vec3& m) const;

  /// Exact by rejection. The first try uses xi itself, the others numbers that follow from it. u_z ≥ 0. Where
  /// visible_area(u) is less than 1e-4 of what |u'| in the lobe's own frame would give, sample and pdf are
  /// those of D m_z: rejection would take too long, and the interpolated area is not that exact.
  Vec3 sample_visible(const Vec3& u, const Vec2& xi) const;
  /// Samples follow it in shape exactly; its integral is off by as much as visible_area is.
  double pdf_visible(const Vec3& u, const Vec3& m) const;

 private:
  struct State;
  std::shared_ptr<State> state_;
};
static_assert(Distribution<Tabulated>);

}  // namespace micro
