#include "distribution/spectrum_mean.h"

#include <cassert>
#include <cmath>

#include "core/error.h"
#include "core/parallel.h"

namespace micro {

SpectrumMean::SpectrumMean(const DiskGrid& grid, std::size_t wavelengths) : grid_(grid), sums_(wavelengths) {
  make_disk_table(grid);  // refuses a grid that cannot be
  for (Eigen::Index j = 0; j < grid.size; ++j)
    for (Eigen::Index i = 0; i < grid.size; ++i)
      if (grid.mz2(j, i) > 0) nodes_.push_back(static_cast<std::int32_t>(j * grid.size + i));
}

void SpectrumMean::add(const std::vector<Grid<float>>& tables, double weight) {
  assert(tables.size() == sums_.size());
  if (!(weight > 0)) return;
  weight_ += weight;
  parallel_for(static_cast<std::int64_t>(tables.size()), [&](std::int64_t k) {
    add(tables[static_cast<std::size_t>(k)], weight, sums_[static_cast<std::size_t>(k)]);
  });
  ++count_;
  weight2_ += weight * weight;
}

/// With the new total weight, and the earlier count and Σ A².
void SpectrumMean::add(const Grid<float>& table, double weight, Sums& sums) const {
  assert(table.rows() == grid_.size && table.cols() == grid_.size);
  if (count_ == 0) sums.mean.assign(nodes_.size(), 0);
  if (count_ == 1) {
    sums.first.assign(nodes_.size(), 0);
    sums.square.assign(nodes_.size(), 0);
  }
  const double share = weight / weight_, weight2 = weight * weight;
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    const double d = static_cast<double>(table.data()[nodes_[n]]);
    const double shift = count_ == 0 ? d : share * (d - sums.mean[n]);
    sums.mean[n] += shift;
    if (count_ == 0) continue;
    // Sums about the mean, moved with it.
    const double rest = d - sums.mean[n], first = static_cast<double>(sums.first[n]);
    const double square = static_cast<double>(sums.square[n]);
    sums.first[n] = static_cast<float>(first - shift * weight2_ + weight2 * rest);
    sums.square[n] =
        static_cast<float>(square - 2 * shift * first + shift * shift * weight2_ + weight2 * rest * rest);
  }
}

void SpectrumMean::merge(const SpectrumMean& other) {
  if (!(other.grid_ == grid_) || other.wavelengths() != wavelengths())
    throw InputError("spectra of different tables or wavelengths have no common mean");
  if (other.count_ == 0) return;
  parallel_for(static_cast<std::int64_t>(wavelengths()),
               [&](std::int64_t k) { merge(other, static_cast<std::size_t>(k)); });
  count_ += other.count_;
  weight_ += other.weight_;
  weight2_ += other.weight2_;
}

/// With the counts and weights that both have had so far. Each side's sums are moved from its own mean D̄ to
/// the common one D̄ + δ: Σ A²(D − D̄ − δ) and Σ A²(D − D̄ − δ)².
void SpectrumMean::merge(const SpectrumMean& other, std::size_t wavelength) {
  Sums& sums = sums_[wavelength];
  const Sums& more = other.sums_[wavelength];
  if (count_ == 0) {
    sums = more;
    return;
  }
  struct Moments {
    double first, square;
  };
  const auto moved = [](const Sums& own, double weight2, std::size_t n, double shift) {
    const Moments about = own.first.empty() ? Moments{0, 0} : Moments{own.first[n], own.square[n]};
    return Moments{about.first - shift * weight2,
                   about.square - 2 * shift * about.first + shift * shift * weight2};
  };
  Sums both{sums.mean, std::vector<float>(nodes_.size()), std::vector<float>(nodes_.size())};
  const double share = other.weight_ / (weight_ + other.weight_);
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    const double shift = share * (more.mean[n] - sums.mean[n]);
    both.mean[n] += shift;
    const Moments a = moved(sums, weight2_, n, shift);
    const Moments b = moved(more, other.weight2_, n, both.mean[n] - more.mean[n]);
    both.first[n] = static_cast<float>(a.first + b.first);
    both.square[n] = static_cast<float>(a.square + b.square);
  }
  sums = std::move(both);
}

DiskTable SpectrumMean::mean(std::size_t wavelength) const {
  DiskTable table = make_disk_table(grid_);
  const Sums& sums = sums_[wavelength];
  for (std::size_t n = 0; n < sums.mean.size(); ++n)
    table.density.data()[nodes_[n]] = sums.mean[n];
  return table;
}

std::optional<Grid<double>> SpectrumMean::standard_error(std::size_t wavelength) const {
  if (count_ < 2) return std::nullopt;
  const double n = static_cast<double>(count_);
  Grid<double> error = Grid<double>::Zero(grid_.size, grid_.size);
  const Sums& sums = sums_[wavelength];
  for (std::size_t k = 0; k < nodes_.size(); ++k)
    error.data()[nodes_[k]] =
        std::sqrt(n / (n - 1) * std::max(0.0, static_cast<double>(sums.square[k]))) / weight_;
  return error;
}

}  // namespace micro
