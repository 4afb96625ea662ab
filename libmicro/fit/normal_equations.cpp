#include "fit/normal_equations.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "fit/node_sums.h"

namespace micro {
namespace {

NormalEquations unpack(const NodeSums& sums) {
  NormalEquations equations;
  std::size_t s = 0;
  for (int a = 0; a < 5; ++a)
    for (int b = 0; b <= a; ++b, ++s)
      equations.gram(a, b) = equations.gram(b, a) = sums[s];
  for (int a = 0; a < 5; ++a, ++s)
    equations.gradient[a] = sums[s];
  equations.cost = sums[20];
  equations.data = sums[21];
  equations.nodes = static_cast<std::int64_t>(sums[22]);
  return equations;
}

NodeSumInput input_of(const NodeSpan& nodes, const SlopeFrame& frame) {
  return {nodes, frame, frame.l11 * frame.l22, {}};
}

constexpr std::int64_t kBlockRows = 64;
constexpr std::int64_t kWorthThreads = 1 << 17;  // nodes

}  // namespace

SlopeFrame moved(const SlopeFrame& frame, const Vector5& step) {
  SlopeFrame result;
  const double grow1 = std::exp(step[2]), grow2 = std::exp(step[4]);
  result.centre = frame.unwhiten({step[0], step[1]});
  result.l11 = frame.l11 * grow1;
  result.l21 = frame.l21 * grow1 + frame.l22 * step[3];
  result.l22 = frame.l22 * grow2;
  return result;
}

NormalEquations& NormalEquations::operator+=(const NormalEquations& other) {
  gram += other.gram;
  gradient += other.gradient;
  cost += other.cost;
  data += other.data;
  nodes += other.nodes;
  return *this;
}

NormalEquations normal_equations(const NodeSpan& nodes, const SlopeFrame& frame, FitModel model,
                                 Weighting weighting) {
  return unpack(sum_equations(input_of(nodes, frame), model, weighting));
}

TableEquations::TableEquations(const DiskTable& table) : table_(table) {
  for (Eigen::Index i = 0; i < table.grid.size; ++i)
    coordinate_.push_back(table.grid.coordinate(i));
  blocks_.resize(static_cast<std::size_t>((table.grid.size + kBlockRows - 1) / kBlockRows));
}

template <typename Kernel>
NormalEquations TableEquations::over_blocks(Kernel&& kernel) {
  const std::int64_t n = table_.grid.size;
  const auto add_rows = [&](std::int64_t begin, std::int64_t end) {
    blocks_[static_cast<std::size_t>(begin / kBlockRows)] =
        kernel({coordinate_.data(), &coordinate_[static_cast<std::size_t>(begin)], &table_.density(begin, 0),
                n, table_.grid.least_mz(), NodeSpan::Layout::Rows, end - begin});
  };
  if (n * n < kWorthThreads) {
    for (std::int64_t begin = 0; begin < n; begin += kBlockRows)
      add_rows(begin, std::min(begin + kBlockRows, n));
  } else {
    parallel_blocks(n, kBlockRows, add_rows);
  }
  NormalEquations sum;
  for (const NormalEquations& block : blocks_)
    sum += block;
  return sum;
}

NormalEquations TableEquations::operator()(const SlopeFrame& frame, FitModel model, Weighting weighting) {
  return over_blocks([&](const NodeSpan& rows) { return normal_equations(rows, frame, model, weighting); });
}

Matrix5 TableEquations::residual_gram(const SlopeFrame& frame, FitModel model, Weighting weighting,
                                      const Matrix5& inverse) {
  return over_blocks([&](const NodeSpan& rows) {
           NodeSumInput input = input_of(rows, frame);
           for (int k = 0; k < 25; ++k)
             input.inverse[static_cast<std::size_t>(k)] = inverse(k / 5, k % 5);
           return unpack(sum_residuals(input, model, weighting));
         })
      .gram;
}

}  // namespace micro
