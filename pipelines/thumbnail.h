#pragma once

#include "distribution/disk_table.h"
#include "height/height_field.h"
#include "io/png.h"

namespace micro {

/// A small picture of a surface, at most kThumbnail points wide or high: heights in grey from −2.5 to 2.5
/// standard deviations, missing points yellow as in [Dong15 Fig. 3].
Picture thumbnail_of(const HeightField& surface);

/// A picture of a distribution and the half width in m_xy that it shows.
struct DiskPicture {
  Picture picture;
  double extent;
};

/// log D over four decades below the peak, dark to light, around the part of the disk that holds the energy.
DiskPicture picture_of(const DiskTable& table);

/// Side of the square that either picture fits into.
constexpr Eigen::Index kThumbnail = 256;

}  // namespace micro
