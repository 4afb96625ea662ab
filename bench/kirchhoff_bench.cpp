// D_K: what one exact direction costs, what bounds a spectral table, and what 41 wavelengths cost beside one.
// Optional argument: the effective wavelength in µm.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "core/fft.h"
#include "core/parallel.h"
#include "core/random.h"
#include "height/triangles.h"
#include "kirchhoff/exact.h"
#include "kirchhoff/spectral.h"
#include "kirchhoff/spectrum.h"

namespace {

using namespace micro;

/// Sum of cosines of correlation rms²·exp(−x²/τx² − y²/τy²), 480 × 640 at 0.11 µm.
HeightField gaussian(double rms, double tau_x, double tau_y) {
  constexpr int kWaves = 300;
  constexpr double kPitch = 0.11;
  Grid<double> z = Grid<double>::Zero(480, 640);
  for (int wave = 0; wave < kWaves; ++wave) {
    const auto normal = random_normal(1, 1, wave);
    const double kx = normal[0] * std::sqrt(2.0) / tau_x, ky = normal[1] * std::sqrt(2.0) / tau_y;
    const std::complex<double> step = std::polar(1.0, kx * kPitch);
    for (Eigen::Index j = 0; j < z.rows(); ++j) {
      auto e = std::polar(1.0, ky * kPitch * static_cast<double>(j) + 6.283 * random_uniform(1, 2, wave)[0]);
      for (Eigen::Index i = 0; i < z.cols(); ++i, e *= step)
        z(j, i) += e.real();
    }
  }
  return make_height_field(z * (rms * std::sqrt(2.0 / kWaves)), kPitch, kPitch);
}

HeightField with_holes(HeightField surface) {
  for (Eigen::Index n = 0; n < surface.z.size(); ++n)
    if (random_uniform(3, 3, n)[0] < 0.04) surface.z(n / surface.cols(), n % surface.cols()) = kMissing;
  return surface;
}

/// Seconds of the fastest of a few runs.
template <typename Run>
double fastest(int runs, Run&& run) {
  double seconds = 1e300;
  for (int n = 0; n < runs; ++n) {
    const Stopwatch watch;
    run();
    seconds = std::min(seconds, watch.seconds());
  }
  return seconds;
}

/// What bounds a table: its transforms alone, against all of it, in one run.
void report_bound(const std::string& name, const HeightField& surface, double lambda_q) {
  SpectralSolver solver({}, lambda_q, 1e-3);
  KirchhoffTable table = solver(surface);
  const double all = fastest(5, [&] { table = solver(surface); });
  const SpectralChoice choice = table.choice;
  DiskMemory<float> memory;
  const double unchecked = fastest(5, [&] {
    transform_disk(Window{surface, {}}, DiskGrid{}, lambda_q, choice, memory);
  });
  const ComplexFft<float> fft({1, table.work.fft_length, 1}, FftDirection::Forward);
  const double transforms = fastest(5, [&] {
    parallel_blocks(table.work.transforms, 256, [&](std::int64_t begin, std::int64_t end) {
      FftVector<std::complex<float>> data(static_cast<std::size_t>(table.work.fft_length));
      for (std::int64_t n = begin; n < end; ++n)
        fft(data.data());
    });
  });
  const ComplexFft<float> plane({table.work.fft_length, table.work.fft_length, 1}, FftDirection::Forward);
  FftVector<std::complex<float>> data(
      static_cast<std::size_t>(table.work.fft_length * table.work.fft_length));
  const double one = fastest(3, [&] { plane(data.data()); });
  std::printf(
      "bound,%s: %.3f s a table, %.3f s without measuring its error; its %lld transforms of %lld numbers "
      "take %.3f s "
      "(%.0f %%); a complex %lld² transform on one core %.3f s, so a table costs %.1f of them\n",
      name.c_str(), all, unchecked, static_cast<long long>(table.work.transforms),
      static_cast<long long>(table.work.fft_length), transforms, 100 * transforms / unchecked,
      static_cast<long long>(table.work.fft_length), one, all / one);
}

/// 41 wavelengths in one pass against one of them, in turn: medians.
void report_all_wavelengths(const HeightField& surface) {
  constexpr int kRepeats = 5;
  constexpr double kTolerance = 1e-3;
  std::vector<double> visible;
  for (int k = 0; k < 41; ++k)
    visible.push_back((38 + k) / 100.0);
  SpectralSolver one({}, 0.555, kTolerance);
  SpectrumSolver all({}, visible, kTolerance);
  one(surface);  // touches the memory
  all(surface);
  std::vector<double> one_seconds, all_seconds;
  double worst = 0;
  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    for (int scan = 0; scan < 4; ++scan)
      one_seconds.push_back(one(surface, 4 * repeat + scan).cost.seconds);
    const KirchhoffSpectrum spectrum = all(surface, repeat);
    all_seconds.push_back(spectrum.cost.seconds);
    for (const SpectrumTable& table : spectrum.tables)
      worst = std::max(worst, table.error.error());
  }
  const auto median = [](std::vector<double>& values) {
    std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
    return values[values.size() / 2];
  };
  const double single = median(one_seconds), together = median(all_seconds);
  std::printf("all_wavelengths,one_s,%.3f,41_s,%.3f,ratio,%.1f,worst_error,%.1e\n", single, together,
              together / single, worst);
}

}  // namespace

int main(int argc, char** argv) {
  const double lambda_q = argc > 1 ? std::atof(argv[1]) : 0.555;
  const HeightField rough = gaussian(0.3, 3, 3), steep = gaussian(1, 1.5, 1.5),
                    brushed = gaussian(0.3, 12, 1.5);
  const Vec3 q = wave_vector(Vec3(0.36, 0.48, 0.8), lambda_q);
  const double seconds = fastest(20, [&] { exact_field(rough, q); });
  std::printf("exact_ms_per_direction,%.2f\n", 1e3 * seconds);
  report_all_wavelengths(rough);
  report_bound("rough", rough, lambda_q);
  report_bound("holed", with_holes(rough), lambda_q);
  report_bound("brushed", brushed, lambda_q);
  report_bound("steep", steep, lambda_q);
}
