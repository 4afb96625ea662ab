#include "kirchhoff/coherence.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "core/error.h"
#include "height/triangles.h"

namespace micro {
namespace {

/// Largest distance of the centres of tapers, in units of their width s: Σ exp(−(x−k·1.25 s)²/s²) varies by
/// 2·exp(−(π/1.25)²) = 0.36
/// %.
constexpr double kTaperSpacing = 1.25;
/// How far from the border centres stay, in units of s: a taper cut closer diffracts at the cut (at 2 s its
/// peak is 4 % low, at the border itself 50 %).
constexpr double kTaperInset = 2;
/// Where a taper is cut, in units of s: amplitude 2e-3.
constexpr double kTaperReach = 3.5;

Window cut(const HeightField& s, Eigen::Index row, Eigen::Index col, Eigen::Index rows, Eigen::Index cols) {
  return {{s.z.block(row, col, rows + 1, cols + 1), s.dx, s.dy, s.mean}, {}};
}

void keep_if_any(std::vector<Window>& windows, Window window) {
  if (triangle_count(window.surface) > 0) windows.push_back(std::move(window));
}

void check_area(double area, const HeightField& surface) {
  if (!(area >= surface.dx * surface.dy && std::isfinite(area)))
    throw InputError("a coherence area must be finite and no smaller than one cell, " +
                     std::to_string(surface.dx * surface.dy) + " µm², not " + std::to_string(area) + " µm²");
}

std::vector<Window> windows_of(const HeightField& surface, const WholePatch&) {
  return {{surface, {}}};
}

std::vector<Window> windows_of(const HeightField& surface, const SubWindows& asked) {
  check_area(asked.area, surface);
  const Eigen::Index cell_rows = surface.rows() - 1, cell_cols = surface.cols() - 1;
  if (cell_rows < 1 || cell_cols < 1) return {};
  const double side = std::sqrt(asked.area);
  const auto pieces = [side](Eigen::Index cells, double pitch) {
    return std::clamp<Eigen::Index>(std::llround(std::min(static_cast<double>(cells) * pitch / side, 1e9)), 1,
                                    cells);
  };
  const Eigen::Index down = pieces(cell_rows, surface.dy), across = pieces(cell_cols, surface.dx);
  std::vector<Window> result;
  for (Eigen::Index a = 0; a < down; ++a)
    for (Eigen::Index b = 0; b < across; ++b) {
      const Eigen::Index j = a * cell_rows / down, i = b * cell_cols / across;
      keep_if_any(result,
                  cut(surface, j, i, (a + 1) * cell_rows / down - j, (b + 1) * cell_cols / across - i));
    }
  return result;
}

/// Cells that a taper reaches along one axis, and its amplitude at their middles.
struct TaperSpan {
  Eigen::Index first;
  std::vector<double> amplitude;
};

std::vector<TaperSpan> taper_spans(Eigen::Index cells, double pitch, double s) {
  std::vector<TaperSpan> result;
  const double length = static_cast<double>(cells) * pitch, inset = std::min(kTaperInset * s, length / 2);
  const double range = length - 2 * inset;
  const auto steps = static_cast<Eigen::Index>(std::ceil(range / (kTaperSpacing * s)));
  for (Eigen::Index k = 0; k <= steps; ++k) {
    const double centre =
        inset + (steps > 0 ? range * static_cast<double>(k) / static_cast<double>(steps) : 0);
    const double low = (centre - kTaperReach * s) / pitch, high = (centre + kTaperReach * s) / pitch;
    const auto first = static_cast<Eigen::Index>(std::max(std::floor(low), 0.0));
    const auto last = static_cast<Eigen::Index>(std::min(std::ceil(high), static_cast<double>(cells)));
    TaperSpan span{first, {}};
    for (Eigen::Index i = first; i < last; ++i) {
      const double x = ((static_cast<double>(i) + 0.5) * pitch - centre) / s;
      span.amplitude.push_back(std::exp(-x * x / 2));
    }
    result.push_back(std::move(span));
  }
  return result;
}

std::vector<Window> windows_of(const HeightField& surface, const GaussianTaper& asked) {
  check_area(asked.area, surface);
  if (surface.rows() < 2 || surface.cols() < 2) return {};
  const double s = std::sqrt(asked.area / (2 * std::numbers::pi));
  std::vector<Window> result;
  const auto across = taper_spans(surface.cols() - 1, surface.dx, s);
  for (const TaperSpan& down : taper_spans(surface.rows() - 1, surface.dy, s))
    for (const TaperSpan& over : across) {
      const auto rows = static_cast<Eigen::Index>(down.amplitude.size());
      const auto cols = static_cast<Eigen::Index>(over.amplitude.size());
      Window window = cut(surface, down.first, over.first, rows, cols);
      window.taper.resize(rows, cols);
      for (Eigen::Index j = 0; j < rows; ++j)
        for (Eigen::Index i = 0; i < cols; ++i)
          window.taper(j, i) = static_cast<float>(down.amplitude[static_cast<std::size_t>(j)] *
                                                  over.amplitude[static_cast<std::size_t>(i)]);
      keep_if_any(result, std::move(window));
    }
  return result;
}

}  // namespace

double coherence_area(double lambda, double diameter) {
  if (!(lambda > 0 && std::isfinite(lambda)))
    throw InputError("the wavelength must be positive and finite, not " + std::to_string(lambda) + " µm");
  if (!(diameter > 0 && diameter <= std::numbers::pi))
    throw InputError("a light source must be wider than 0 and no wider than 180 degrees");
  const double half = std::sin(diameter / 4);
  return lambda * lambda / (4 * std::numbers::pi * half * half);
}

double effective_area(const Window& window) {
  if (window.taper.size() == 0) return projected_area(window.surface);
  double sum = 0;
  for (Eigen::Index j = 0; j + 1 < window.surface.rows(); ++j)
    for_each_triangle(window.surface, j, [&](const Triangle& t) {
      const double w = window.taper(t.a.y(), t.a.x());
      sum += w * w;
    });
  return sum * window.surface.dx * window.surface.dy / 2;
}

std::vector<Window> coherent_windows(const HeightField& surface, const Coherence& coherence) {
  return std::visit([&](const auto& kind) { return windows_of(surface, kind); }, coherence);
}

HeightField mirror_x(const HeightField& surface) {
  return {surface.z.rowwise().reverse(), surface.dx, surface.dy, surface.mean};
}

}  // namespace micro
