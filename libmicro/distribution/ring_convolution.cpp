#include "distribution/ring_convolution.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include "core/fft.h"
#include "core/parallel.h"

namespace micro {
namespace {

using Index = Eigen::Index;

constexpr Index kPoints = 6;  // of the interpolation along either axis, from kFirst on
constexpr Index kFirst = -2;
using Weights = std::array<double, kPoints>;

/// Lagrange's weights of the points −2 … 3 at x in [0, 1).
Weights lagrange(double x) {
  const double a = x + 2, b = x + 1, c = x, d = x - 1, e = x - 2, f = x - 3;
  const double ab = a * b, ef = e * f, cd = c * d;
  return {-b * cd * ef / 120, a * cd * ef / 24,  -ab * d * ef / 12,
          ab * c * ef / 12,   -ab * cd * f / 24, ab * cd * e / 120};
}

/// The polar grid: ring a at θ = (a + ½)·dtheta, its `around` points at φ = b·dphi.
struct Rings {
  double dtheta, dphi;
  Index count, around;  ///< `around` is a multiple of 8

  double theta(Index a) const { return (static_cast<double>(a) + 0.5) * dtheta; }
};

/// θ of the outermost node that holds something.
double outermost(const DiskTable& table) {
  double r2 = 0;
  for (Index j = 0; j < table.grid.size; ++j)
    for (Index i = 0; i < table.grid.size; ++i)
      if (table.density(j, i) != 0) r2 = std::max(r2, 1 - table.grid.mz2(j, i));
  return std::asin(std::min(1., std::sqrt(r2)));
}

/// Farthest θ to which the table's nodes give, through the stencils at both ends.
double farthest(const DiskTable& table, const SignatureKernel& kernel, double spacing) {
  return std::min(std::numbers::pi / 2, outermost(table) + kernel.reach_angle() + kPoints * spacing);
}

Rings make_rings(double farthest_theta, double spacing) {
  const Index quarter = fast_fft_size(static_cast<Index>(std::ceil(std::numbers::pi / 2 / spacing)));
  return {spacing, std::numbers::pi / 2 / static_cast<double>(quarter),
          static_cast<Index>(farthest_theta / spacing) + kPoints, 4 * quarter};
}

/// Values on the rings, of a function that is the same after a quarter turn (turns = 4) or not (1).
struct RingValues {
  Index turns, period;  ///< period = around/turns points are kept of each ring
  FftVector<double> values;

  RingValues(const Rings& rings, Index turns_)
      : turns(turns_),
        period(rings.around / turns_),
        values(static_cast<std::size_t>(rings.count * period)) {}
  double* ring(Index a) { return values.data() + a * period; }
  const double* ring(Index a) const { return values.data() + a * period; }
};

/// Where a direction lies between the rings' points.
struct Stencil {
  Index ring, column;  ///< of the first point; a ring below 0 is ring −1−a half a turn on
  Weights theta, phi;
};

Stencil stencil_at(const Rings& rings, double x, double y, double z) {
  const double t = std::atan2(std::sqrt(x * x + y * y), z) / rings.dtheta - 0.5;
  const double angle = std::atan2(y, x);
  const double u = (angle < 0 ? angle + 2 * std::numbers::pi : angle) / rings.dphi;
  const double ring = std::floor(t), column = std::floor(u);
  return {static_cast<Index>(ring) + kFirst, static_cast<Index>(column) + kFirst + rings.around,
          lagrange(t - ring), lagrange(u - column)};
}

/// Calls visit(first of six consecutive values or, where the ring closes, their six addresses) through
/// `at(k)`, k = 0 … 5, for each of the stencil's rings.
template <typename Values, typename Visit>
void for_each_ring(const Rings& rings, Values& data, const Stencil& s, Visit&& visit) {
  for (Index k = 0; k < kPoints; ++k) {
    Index ring = s.ring + k, column = s.column;
    if (ring < 0) ring = -1 - ring, column += rings.around / 2;
    column %= data.period;
    auto* values = data.ring(ring);
    const double weight = s.theta[static_cast<std::size_t>(k)];
    if (column + kPoints <= data.period)
      visit(
          weight, [=](Index b) -> auto& { return values[column + b]; });
    else
      visit(
          weight, [ =, period = data.period ](Index b) -> auto& { return values[(column + b) % period]; });
  }
}

void add(const Rings& rings, RingValues& data, const Stencil& s, double value) {
  for_each_ring(rings, data, s, [&](double weight, auto at) {
    for (Index b = 0; b < kPoints; ++b)
      at(b) += weight * value * s.phi[static_cast<std::size_t>(b)];
  });
}

double interpolate(const Rings& rings, const RingValues& data, const Stencil& s) {
  double sum = 0;
  for_each_ring(rings, data, s, [&](double weight, auto at) {
    double along = 0;
    for (Index b = 0; b < kPoints; ++b)
      along += at(b) * s.phi[static_cast<std::size_t>(b)];
    sum += weight * along;
  });
  return sum;
}

/// Calls body(band) for all bands, neighbours never at the same time: first the even ones, then the odd.
template <typename Body>
void for_each_band(Index bands, Body&& body) {
  parallel_for((bands + 1) / 2, [&](std::int64_t k) { body(2 * k); });
  parallel_for(bands / 2, [&](std::int64_t k) { body(2 * k + 1); });
}

/// Nodes (i, j)·spacing of a lattice on the disk, |i|, |j| ≤ last. A quarter of them, i ≥ 1 and j ≥ 0, and
/// its turned copies are all of them but the centre.
struct Lattice {
  double spacing;
  Index last;
};

/// Row and column, from the centre, of a node.
struct Node {
  Index j, i;
};

/// The node and its stencil, turned by a quarter.
Node turned(const Node& node) {
  return {node.i, -node.j};
}
Stencil turned(const Rings& rings, Stencil s) {
  s.column += rings.around / 4;
  return s;
}

/// Calls visit(node, stencil) for every node of the lattice's quarter whose place between the rings begins in
/// [begin, end); the first band reaches to the pole.
template <typename Visit>
void for_each_node_of_band(const Rings& rings, const Lattice& lattice, Index begin, Index end,
                           Visit&& visit) {
  const double h = lattice.spacing;
  const auto radius = [&](Index ring) {
    return std::sin(std::min(rings.theta(ring), std::numbers::pi / 2)) / h;
  };
  const double inner = begin == 0 ? 0 : radius(begin), outer = radius(end);
  const auto limit = [](double r, Index j) {
    const double row = static_cast<double>(j);
    return static_cast<Index>(std::sqrt(std::max(0., r * r - row * row)));
  };
  for (Index j = 0; j <= std::min(lattice.last, static_cast<Index>(outer) + 1); ++j)
    // A node more on either side than need be: the stencil decides.
    for (Index i = std::max<Index>(1, limit(inner, j) - 1); i <= std::min(lattice.last, limit(outer, j) + 1);
         ++i) {
      const double x = static_cast<double>(i) * h, y = static_cast<double>(j) * h, z2 = 1 - x * x - y * y;
      if (!(z2 > 0)) break;
      const Stencil s = stencil_at(rings, x, y, std::sqrt(z2));
      const Index ring = s.ring - kFirst;
      if ((ring >= begin || begin == 0) && ring < end) visit(Node{j, i}, s);
    }
}

/// Σ K(a, b) f(b) over all points of all rings.
RingValues apply(const Rings& rings, const SignatureKernel& kernel, RingValues values) {
  using Complex = std::complex<double>;
  const Index half = values.period / 2 + 1;
  const auto empty = [&](Index a) {
    return std::all_of(values.ring(a), values.ring(a) + values.period, [](double v) { return v == 0; });
  };
  std::vector<char> holds;  // rings from which there is something to spread
  for (Index a = 0; a < rings.count; ++a)
    holds.push_back(empty(a) ? 0 : 1);
  const RealFft<double> fft({.rows = 1, .cols = values.period, .batch = 1});
  FftVector<Complex> in(static_cast<std::size_t>(rings.count * half)), out(in.size());
  // FFT buffers are aligned one by one.
  parallel_blocks(rings.count, 16, [&](std::int64_t begin, std::int64_t end) {
    FftVector<double> ring(static_cast<std::size_t>(values.period));
    FftVector<Complex> spectrum(static_cast<std::size_t>(half));
    for (Index a = begin; a < end; ++a) {
      if (!holds[static_cast<std::size_t>(a)]) continue;
      std::copy_n(values.ring(a), values.period, ring.begin());
      fft.forward(ring.data(), spectrum.data());
      std::copy(spectrum.begin(), spectrum.end(), in.begin() + a * half);
    }
  });
  std::vector<double> versine;  // 1 − cosφ up to half a turn
  for (Index b = 0; b <= rings.around / 2; ++b)
    versine.push_back(2 * std::pow(std::sin(static_cast<double>(b) * rings.dphi / 2), 2));

  // K(a, b) = K(b, a): each band serves its own rings and those in reach after it.
  const auto reach = static_cast<Index>(kernel.reach_angle() / rings.dtheta);
  const Index depth = reach + 1;
  for_each_band((rings.count + depth - 1) / depth, [&](Index band) {
    FftVector<double> profile(static_cast<std::size_t>(values.period));
    FftVector<Complex> transfer(static_cast<std::size_t>(half));
    for (Index a = band * depth; a < std::min((band + 1) * depth, rings.count); ++a)
      for (Index b = a; b <= std::min(a + reach, rings.count - 1); ++b) {
        const bool from_a = holds[static_cast<std::size_t>(a)], from_b = holds[static_cast<std::size_t>(b)];
        if (!from_a && !from_b) continue;
        const double least = 2 * std::pow(std::sin(static_cast<double>(b - a) * rings.dtheta / 2), 2);
        const double rise = std::sin(rings.theta(a)) * std::sin(rings.theta(b));
        std::fill(profile.begin(), profile.end(), 0.);
        for (Index k = 0; k <= rings.around / 2; ++k) {
          const double c = least + rise * versine[static_cast<std::size_t>(k)];
          if (c > kernel.reach()) break;
          const double response = kernel(c);
          profile[static_cast<std::size_t>(k % values.period)] += response;
          if (k > 0 && k < rings.around / 2)
            profile[static_cast<std::size_t>((rings.around - k) % values.period)] += response;
        }
        fft.forward(profile.data(), transfer.data());
        const auto multiply = [&](Index from, Index to) {
          const Complex* source = in.data() + from * half;
          Complex* target = out.data() + to * half;
          for (Index m = 0; m < half; ++m)  // an even profile's transform is real
            target[m] += transfer[static_cast<std::size_t>(m)].real() * source[m];
        };
        if (from_b) multiply(b, a);
        if (from_a && a != b) multiply(a, b);
      }
  });

  const double scale = 1 / static_cast<double>(values.period);
  parallel_blocks(rings.count, 16, [&](std::int64_t begin, std::int64_t end) {
    FftVector<double> ring(static_cast<std::size_t>(values.period));
    FftVector<Complex> spectrum(static_cast<std::size_t>(half));
    for (Index a = begin; a < end; ++a) {
      std::copy_n(out.begin() + a * half, half, spectrum.begin());
      fft.backward(spectrum.data(), ring.data());
      for (Index k = 0; k < values.period; ++k)
        values.ring(a)[k] = ring[static_cast<std::size_t>(k)] * scale;
    }
  });
  return values;
}

/// Calls visit(node, stencil) for every node of the lattice's quarter, those of neighbouring bands of rings
/// never at the same time: stencils of other bands touch no common ring. Nodes whose stencil goes beyond the
/// last ring are out of the table's reach.
template <typename Visit>
void for_each_node(const Rings& rings, const Lattice& lattice, Visit&& visit) {
  constexpr Index kDepth = 8;
  static_assert(kDepth >= kPoints);
  const Index last = rings.count - (kFirst + kPoints - 1);  // ring at which a stencil may not begin
  for_each_band((last + kDepth - 1) / kDepth, [&](Index band) {
    for_each_node_of_band(rings, lattice, band * kDepth, std::min((band + 1) * kDepth, last), visit);
  });
}

/// Nodes of the hemisphere on which a table's own stand, out to where they matter. Zoomed tables may have so
/// many that a coarser lattice, of the same centre and still fine beside any signature that spans it, stands
/// for it.
struct Hemisphere {
  Lattice lattice;
  double weight;  ///< nodes of the table's spacing that one of these stands for
};

Hemisphere hemisphere_of(const DiskGrid& grid, double farthest_theta) {
  constexpr double kMost = 2048;  // nodes from the centre outwards
  const double reach = std::sin(farthest_theta);
  const double nodes = reach / grid.spacing();
  const double stride = grid.extent < 1 ? std::max(1., std::ceil(nodes / kMost)) : 1;
  const double spacing = grid.spacing() * stride;
  return {{spacing, static_cast<Index>(std::ceil(reach / spacing))}, stride * stride};
}

/// What the hemisphere takes of a unit mass, as a function on the rings.
RingValues taken_on_rings(const Rings& rings, const Hemisphere& nodes, const SignatureKernel& kernel) {
  RingValues ones(rings, 4);
  for_each_node(rings, nodes.lattice,
                [&](const Node&, const Stencil& s) { add(rings, ones, s, nodes.weight); });
  add(rings, ones, stencil_at(rings, 0, 0, 1), nodes.weight / 4);  // the centre is its own turned copy
  return apply(rings, kernel, std::move(ones));
}

}  // namespace

std::optional<double> ring_spacing(const Signature& signature) {
  constexpr double kTolerance = 2e-5, kFinest = 1. / 200, kStep = 0.92;
  const double reach = signature.angle.back();
  const auto profile = [&](double angle) {
    return std::abs(angle) > reach ? 0. : response_at(signature, std::abs(angle));
  };
  const double peak = *std::max_element(signature.response.begin(), signature.response.end());
  const auto error = [&](double spacing) {
    double worst = 0;
    for (const double x : {0.2, 0.5, 0.8}) {
      const Weights weights = lagrange(x);
      for (double at = 0; at <= reach + 3 * spacing; at += spacing / 5) {
        double sum = 0;
        for (Index k = 0; k < kPoints; ++k)
          sum += weights[static_cast<std::size_t>(k)] *
                 profile(at + (static_cast<double>(kFirst + k) - x) * spacing);
        worst = std::max(worst, std::abs(sum - profile(at)));
      }
    }
    return worst / peak;
  };
  for (double spacing = reach / 4; spacing >= kFinest * reach; spacing *= kStep)
    if (error(spacing) <= kTolerance) return spacing;
  return std::nullopt;
}

double cost_on_rings(const DiskTable& table, const SignatureKernel& kernel, double spacing) {
  const double theta = farthest(table, kernel, spacing);
  const Rings rings = make_rings(theta, spacing);
  const double around = static_cast<double>(rings.around), count = static_cast<double>(rings.count);
  const double pairs = count * (kernel.reach_angle() / spacing + 1);
  const double nodes = std::numbers::pi * std::pow(std::sin(theta) / table.grid.spacing(), 2);
  // Fourier transforms and products of the pairs, whole and of a quarter; 36 points for each node, twice and
  // for a quarter of the hemisphere's.
  return pairs * around * std::log2(around) + 100 * nodes;
}

DiskTable convolve_on_rings(const DiskTable& table, const SignatureKernel& kernel, double spacing) {
  const DiskGrid& grid = table.grid;
  const double theta = farthest(table, kernel, spacing);
  const Rings rings = make_rings(theta, spacing);
  const RingValues taken = taken_on_rings(rings, hemisphere_of(grid, theta), kernel);
  const auto c = static_cast<Index>(grid.centre());
  const Lattice nodes{grid.spacing(), c};
  RingValues shares(rings, 1);
  for_each_node(rings, nodes, [&](Node node, Stencil s) {
    const double whole = interpolate(rings, taken, s);  // the same after every quarter turn
    for (int turn = 0; turn < 4; ++turn, node = turned(node), s = turned(rings, s))
      if (const double mass = table.density(c + node.j, c + node.i); mass != 0)
        add(rings, shares, s, mass / whole);
  });
  // The centre, which has no direction in φ, takes part with a quarter in each of four.
  const Stencil centre = stencil_at(rings, 0, 0, 1);
  const double whole = interpolate(rings, taken, centre);
  Stencil around = centre;
  for (int turn = 0; turn < 4; ++turn, around = turned(rings, around))
    add(rings, shares, around, table.density(c, c) / whole / 4);
  const RingValues spread_out = apply(rings, kernel, std::move(shares));

  DiskTable seen = make_disk_table(grid);
  for_each_node(rings, nodes, [&](Node node, Stencil s) {
    for (int turn = 0; turn < 4; ++turn, node = turned(node), s = turned(rings, s))
      seen.density(c + node.j, c + node.i) = interpolate(rings, spread_out, s);
  });
  for (int turn = 0; turn < 4; ++turn, around = turned(rings, around))
    seen.density(c, c) += interpolate(rings, spread_out, around) / 4;
  const double mass = seen.density.sum();
  seen.density = seen.density.max(0.);
  if (const double kept = seen.density.sum(); kept > 0) seen.density *= mass / kept;
  return seen;
}

}  // namespace micro
