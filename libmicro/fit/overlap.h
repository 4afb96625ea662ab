#pragma once

#include "fit/normal_equations.h"

namespace micro {

/// How much of their energy a table and a lobe have in the same places: Σ min(P_k, Q_k)/max(ΣP_k, ΣQ_k), P_k
/// and Q_k the energies ∫D m_z dω of the table and of the lobe, both at the table's nodes, in sixteen parts
/// of equal energy of the lobe: quadrants of its own slopes v, each cut into four rings; and these where m_z
/// = ½, for lobes of the whole hemisphere and wider. 1 where they agree; noise of single nodes averages out,
/// so the speckle of one patch or the counts of a hundred normals leave some 0.9. A table that holds a part
/// of the energy overlaps no more than that part. Wide lobes are summed over blocks of nodes but for those
/// near the horizon, `across` being the nodes across the lobe's narrowest section.
double overlap(const DiskTable& table, const SlopeFrame& frame, FitModel model, double across);

}  // namespace micro
