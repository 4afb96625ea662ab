#pragma once

#include <vector>

#include "distribution/disk_table.h"

namespace micro {

/// How an instrument blurs what it measures [Dong15 §7]: its relative response to a half vector that lies
/// `angle` away from the one it is set to, the same in every direction. Between samples it is linear, beyond
/// the last one zero.
struct Signature {
  std::vector<double> angle;     ///< radians, ascending from 0
  std::vector<double> response;  ///< relative, ≥ 0
};

/// A Gaussian of that full width at half maximum in half-vector angle (radians), cut where it has fallen to
/// 1e-6. Throws InputError unless 0 < fwhm ≤ π/2.
Signature gaussian_signature(double fwhm);

/// Throws InputError unless the samples make a signature: at least two, angles ascending from 0, finite,
/// responses ≥ 0 and positive at angle 0.
void require_valid(const Signature& signature);

/// The table as the instrument would see it: the mass D(m)·m_z dω of each node is spread over the directions
/// h of the hemisphere in proportion to response(∠(h, m))·h_z dω, so that ∫ D m_z dω is kept exactly, at the
/// rim too. What goes beyond the extent of a table that is zoomed
/// in leaves it. Narrow signatures and those with kinks are summed literally (nodes that are not zero × nodes
/// in reach); wide smooth ones on rings (ring_convolution.h), to 1e-4 of the result's peak.
DiskTable convolve(const DiskTable& table, const Signature& signature);

}  // namespace micro
