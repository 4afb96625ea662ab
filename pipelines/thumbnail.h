#pragma once

#include "distribution/disk_table.h"
#include "height/height_field.h"
#include "io/png.h"

namespace micro {

/// A small picture of a surface, at most kThumbnail points wide or high: heights in grey from −2.5 to 2.5
/// standard deviations, missing points yellow as in [Dong15 Fig. 3].
Picture thumbnail_of(const HeightField& surface);

/// The part of a table that a picture shows: a square around the centre.
struct DiskView {
  Eigen::Index half;  ///< nodes on either side of the centre
  double extent;      ///< the same as half width in m_xy
  double peak;        ///< 1/sr, the lightest
};

/// The part of the disk that holds the energy.
DiskView view_of(const DiskTable& table);

/// log D over four decades below the peak, dark to light.
Picture picture_of(const DiskTable& table, const DiskView& view);

/// a − b, white where they agree, red where a is larger and blue where b is, full at 20 % of the peak.
Picture difference_of(const DiskTable& a, const DiskTable& b, const DiskView& view);

/// Side of the square that either picture fits into: the usual tables of 1025 and 257 nodes by their centres.
constexpr Eigen::Index kThumbnail = 257;

}  // namespace micro
