#include "distribution/scatter.h"

#include <algorithm>
#include <array>
#include <limits>

namespace micro {
namespace {

/// Median and half the interquartile range of numbers in [−extent, extent], by a histogram of 512 bins.
struct Quartiles {
  double median, half_range;
};
Quartiles quartiles(const std::vector<double>& values, const std::vector<double>& weights, double extent) {
  constexpr std::size_t kBins = 512;
  std::array<double, kBins> histogram{};
  double total = 0;
  for (std::size_t k = 0; k < values.size(); ++k) {
    const double weight = std::max(0., weights[k]);
    const double position = (values[k] / extent + 1) / 2 * kBins;
    histogram[static_cast<std::size_t>(std::clamp(position, 0., kBins - 1.))] += weight;
    total += weight;
  }
  const auto quantile = [&](double p) {
    double below = 0;
    std::size_t bin = 0;
    while (bin + 1 < kBins && below + histogram[bin] < p * total)
      below += histogram[bin++];
    const double part = histogram[bin] > 0 ? std::clamp((p * total - below) / histogram[bin], 0., 1.) : 0.5;
    return ((static_cast<double>(bin) + part) / kBins * 2 - 1) * extent;
  };
  return {quantile(0.5), (quantile(0.75) - quantile(0.25)) / 2};
}

/// Every k-th node with mass as a slope.
WeightedSlopes slopes_of(const TableNodes& nodes, std::size_t stride) {
  WeightedSlopes slopes;
  for (std::size_t k = 0; k < nodes.size(); k += stride) {
    if (!(nodes.density[k] > 0)) continue;
    const double z = std::sqrt(1 - nodes.x[k] * nodes.x[k] - nodes.y[k] * nodes.y[k]);
    slopes.x.push_back(-nodes.x[k] / z);
    slopes.y.push_back(-nodes.y[k] / z);
    slopes.weight.push_back(nodes.density[k]);
  }
  return slopes;
}

/// The columns of each row that lie on the disk.
struct Columns {
  Eigen::Index begin, count;
};
std::vector<Columns> columns_on_disk(const DiskGrid& grid) {
  const auto c = static_cast<Eigen::Index>(grid.centre());
  std::vector<Columns> columns(static_cast<std::size_t>(grid.size));
  Eigen::Index reach = c;  // columns c − reach … c + reach; it shrinks towards the rim
  for (Eigen::Index j = c; j < grid.size; ++j) {
    while (reach >= 0 && !(grid.mz2(j, c + reach) > 0))
      --reach;
    const Columns row = {c - std::max<Eigen::Index>(reach, 0), reach < 0 ? 0 : 2 * reach + 1};
    columns[static_cast<std::size_t>(j)] = columns[static_cast<std::size_t>(2 * c - j)] = row;
  }
  return columns;
}

}  // namespace

SlopeFrame scatter_step(const SlopeFrame& frame, const WeightedSlopes& slopes, double least) {
  const double i11 = 1 / frame.l11, i22 = 1 / frame.l22;
  double sum_w = 0, a = 0, b = 0, aa = 0, ab = 0, bb = 0;
  for (std::size_t k = 0; k < slopes.size(); ++k) {
    const double v1 = (slopes.x[k] - frame.centre.x()) * i11,
                 v2 = (slopes.y[k] - frame.centre.y() - frame.l21 * v1) * i22;
    const double w = slopes.weight[k] / (1 + v1 * v1 + v2 * v2);
    sum_w += w;
    a += w * v1;
    b += w * v2;
    aa += w * v1 * v1;
    ab += w * v1 * v2;
    bb += w * v2 * v2;
  }
  const double ma = a / sum_w, mb = b / sum_w;  // the new centre, in the old frame
  aa = 2 * (aa / sum_w - ma * ma);
  ab = 2 * (ab / sum_w - ma * mb);
  bb = 2 * (bb / sum_w - mb * mb);
  // Σ = L·[aa, ab; ab, bb]·Lᵀ.
  const double least1 = least / frame.l11, least2 = least / frame.l22;
  const double c11 = std::sqrt(std::max(aa, least1 * least1)), c21 = ab / c11,
               c22 = std::sqrt(std::max(bb - c21 * c21, least2 * least2));
  SlopeFrame next;
  next.centre = frame.unwhiten({ma, mb});
  next.l11 = frame.l11 * c11;
  next.l21 = frame.l21 * c11 + frame.l22 * c21;
  next.l22 = frame.l22 * c22;
  return next;
}

TableNodes core_nodes(const DiskTable& table, std::size_t most) {
  const Eigen::Index n = table.grid.size;
  const Grid<double>& density = table.density;
  constexpr double kFaint = 1e-3, kEnough = 0.9;
  const std::vector<Columns> columns = columns_on_disk(table.grid);
  const auto on_disk = [&](Eigen::Index j) {
    const Columns& range = columns[static_cast<std::size_t>(j)];
    return density.row(j).segment(range.begin, range.count);
  };
  double peak = 0;
  for (Eigen::Index j = 0; j < n; ++j)
    if (on_disk(j).size() > 0) peak = std::max(peak, on_disk(j).maxCoeff());
  double threshold = kFaint * peak, bright = 0, all = 0;
  Eigen::Index count = 0, count_all = 0;
  for (Eigen::Index j = 0; j < n; ++j) {
    const auto row = on_disk(j);
    count += (row >= threshold).count();
    count_all += (row > 0).count();
    bright += (row >= threshold).select(row, 0.).sum();
    all += row.max(0.).sum();
  }
  if (!(bright >= kEnough * all)) {
    threshold = std::numeric_limits<double>::denorm_min();
    count = count_all;
  }
  const Eigen::Index room = std::max<Eigen::Index>(1, static_cast<Eigen::Index>(most)),
                     stride = std::max<Eigen::Index>(1, (count + room - 1) / room);
  TableNodes nodes;
  nodes.least_mz = table.grid.least_mz();
  const auto expected = static_cast<std::size_t>(count / stride + 1);
  for (auto* values : {&nodes.x, &nodes.y, &nodes.density})
    values->reserve(expected);
  // Runs of nodes that hold none of every stride-th are passed over by their count alone.
  constexpr Eigen::Index kRun = 16;
  Eigen::Index to_skip = 0;
  for (Eigen::Index j = 0; j < n; ++j) {
    const auto [first, in_row] = columns[static_cast<std::size_t>(j)];
    for (Eigen::Index begin = first; begin < first + in_row; begin += kRun) {
      const Eigen::Index length = std::min(kRun, first + in_row - begin);
      const Eigen::Index in_run = (density.row(j).segment(begin, length) >= threshold).count();
      if (in_run <= to_skip) {
        to_skip -= in_run;
        continue;
      }
      for (Eigen::Index i = begin; i < begin + length; ++i) {
        if (!(density(j, i) >= threshold) || to_skip-- > 0) continue;
        to_skip = stride - 1;
        nodes.x.push_back(table.grid.coordinate(i));
        nodes.y.push_back(table.grid.coordinate(j));
        nodes.density.push_back(density(j, i));
      }
    }
  }
  return nodes;
}

TableNodes strided_nodes(const DiskTable& table, Eigen::Index stride) {
  TableNodes nodes;
  nodes.least_mz = table.grid.least_mz();
  const Eigen::Index n = table.grid.size, across = (n + stride - 1) / stride;
  for (auto* values : {&nodes.x, &nodes.y, &nodes.density})
    values->reserve(static_cast<std::size_t>(across * across));
  for (Eigen::Index j = 0; j < n; j += stride)
    for (Eigen::Index i = 0; i < n; i += stride) {
      if (!(table.grid.mz2(j, i) > 0)) continue;
      nodes.x.push_back(table.grid.coordinate(i));
      nodes.y.push_back(table.grid.coordinate(j));
      nodes.density.push_back(table.density(j, i));
    }
  return nodes;
}

SlopeFrame slope_scatter(const TableNodes& core, const DiskGrid& grid) {
  constexpr int kSteps = 8;
  constexpr std::size_t kNodes = 512;  // a start needs no more
  const Quartiles x = quartiles(core.x, core.density, grid.extent),
                  y = quartiles(core.y, core.density, grid.extent);
  const double spacing = grid.spacing(), z2 = std::max(1 - x.median * x.median - y.median * y.median, 0.01);
  SlopeFrame frame;
  frame.centre = Vec2(-x.median, -y.median) / std::sqrt(z2);
  frame.l11 = std::max(x.half_range, spacing) / z2;
  frame.l22 = std::max(y.half_range, spacing) / z2;
  const std::size_t stride = std::max<std::size_t>(1, core.size() / kNodes);
  const WeightedSlopes slopes = slopes_of(core, stride);
  for (int k = 0; k < kSteps && slopes.size() > 0; ++k)
    frame = scatter_step(frame, slopes, spacing / 4);  // nothing is narrower than the table's own bins
  return frame;
}

}  // namespace micro
