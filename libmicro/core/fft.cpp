#include "core/fft.h"

#include <fftw3.h>

#include <array>
#include <cassert>
#include <limits>
#include <mutex>
#include <stdexcept>
#include <type_traits>

#include "core/large_pages.h"

namespace micro {

namespace detail {

void* fft_allocate(std::size_t bytes) {
  void* p = fftw_malloc(bytes > 0 ? bytes : 1);
  if (p == nullptr) throw std::bad_alloc();
  prefer_large_pages(p, bytes);
  return p;
}

void fft_free(void* p) noexcept {
  fftw_free(p);
}

}  // namespace detail

namespace {

/// FFTW's planner keeps global state; execution does not.
std::mutex& planner_mutex() {
  static std::mutex mutex;
  return mutex;
}

template <typename Real>
struct Fftw;

template <>
struct Fftw<double> {
  using Complex = fftw_complex;
  using Plan = fftw_plan;
  static constexpr auto plan_complex = fftw_plan_many_dft;
  static constexpr auto plan_forward = fftw_plan_many_dft_r2c;
  static constexpr auto plan_backward = fftw_plan_many_dft_c2r;
  static constexpr auto execute_complex = fftw_execute_dft;
  static constexpr auto execute_forward = fftw_execute_dft_r2c;
  static constexpr auto execute_backward = fftw_execute_dft_c2r;
  static constexpr auto destroy = fftw_destroy_plan;
  static constexpr auto alignment = fftw_alignment_of;
};

template <>
struct Fftw<float> {
  using Complex = fftwf_complex;
  using Plan = fftwf_plan;
  static constexpr auto plan_complex = fftwf_plan_many_dft;
  static constexpr auto plan_forward = fftwf_plan_many_dft_r2c;
  static constexpr auto plan_backward = fftwf_plan_many_dft_c2r;
  static constexpr auto execute_complex = fftwf_execute_dft;
  static constexpr auto execute_forward = fftwf_execute_dft_r2c;
  static constexpr auto execute_backward = fftwf_execute_dft_c2r;
  static constexpr auto destroy = fftwf_destroy_plan;
  static constexpr auto alignment = fftwf_alignment_of;
};

template <typename Real>
auto* as_fftw(std::complex<Real>* p) {
  return reinterpret_cast<typename Fftw<Real>::Complex*>(p);
}

template <typename Real>
std::shared_ptr<void> own(typename Fftw<Real>::Plan plan) {
  if (plan == nullptr) throw std::runtime_error("the Fourier transform could not be planned");
  return {plan, [](void* p) {
            const std::scoped_lock lock(planner_mutex());
            Fftw<Real>::destroy(static_cast<typename Fftw<Real>::Plan>(p));
          }};
}

template <typename Real>
typename Fftw<Real>::Plan get(const std::shared_ptr<void>& plan) {
  return static_cast<typename Fftw<Real>::Plan>(plan.get());
}

unsigned flags(FftPlanning planning) {
  return planning == FftPlanning::Measure ? FFTW_MEASURE : FFTW_ESTIMATE;
}

/// FFTW's own way to say a shape: rank, lengths, and the distance from one transform of the batch to the
/// next.
struct Layout {
  explicit Layout(const FftShape& shape)
      : rank(shape.rows > 1 ? 2 : 1),
        lengths{narrow(shape.rows), narrow(shape.cols)},
        n(rank == 2 ? lengths.data() : lengths.data() + 1),
        batch(narrow(shape.batch)),
        distance(narrow(shape.rows * shape.cols)),
        half_distance(narrow(shape.rows * (shape.cols / 2 + 1))) {}
  Layout(const Layout&) = delete;
  Layout& operator=(const Layout&) = delete;

  static int narrow(std::int64_t value) {
    assert(value > 0);
    if (value > std::numeric_limits<int>::max()) throw std::bad_alloc();
    return static_cast<int>(value);
  }

  int rank;
  std::array<int, 2> lengths;
  const int* n;
  int batch, distance, half_distance;
};

}  // namespace

template <typename Real>
ComplexFft<Real>::ComplexFft(const FftShape& shape, FftDirection direction, FftPlanning planning)
    : shape_(shape) {
  const Layout layout(shape);
  const auto buffer = make_fft_array<std::complex<Real>>(shape.size());
  auto* data = as_fftw(buffer.get());
  const int sign = direction == FftDirection::Forward ? FFTW_FORWARD : FFTW_BACKWARD;
  std::unique_lock lock(planner_mutex());
  auto plan = Fftw<Real>::plan_complex(layout.rank, layout.n, layout.batch, data, nullptr, 1, layout.distance,
                                       data, nullptr, 1, layout.distance, sign, flags(planning));
  lock.unlock();
  plan_ = own<Real>(plan);
}

template <typename Real>
void ComplexFft<Real>::operator()(std::complex<Real>* data) const {
  Fftw<Real>::execute_complex(get<Real>(plan_), as_fftw(data), as_fftw(data));
}

template <typename Real>
RealFft<Real>::RealFft(const FftShape& shape, FftPlanning planning) : shape_(shape) {
  const Layout layout(shape);
  const auto real = make_fft_array<Real>(shape.size());
  const auto half = make_fft_array<std::complex<Real>>(shape.half_size());
  std::unique_lock lock(planner_mutex());
  auto forward =
      Fftw<Real>::plan_forward(layout.rank, layout.n, layout.batch, real.get(), nullptr, 1, layout.distance,
                               as_fftw(half.get()), nullptr, 1, layout.half_distance, flags(planning));
  auto backward = Fftw<Real>::plan_backward(layout.rank, layout.n, layout.batch, as_fftw(half.get()), nullptr,
                                            1, layout.half_distance, real.get(), nullptr, 1, layout.distance,
                                            flags(planning));
  lock.unlock();
  forward_ = own<Real>(forward);
  backward_ = own<Real>(backward);
}

template <typename Real>
void RealFft<Real>::forward(Real* in, std::complex<Real>* out) const {
  Fftw<Real>::execute_forward(get<Real>(forward_), in, as_fftw(out));
}

template <typename Real>
void RealFft<Real>::backward(std::complex<Real>* in, Real* out) const {
  Fftw<Real>::execute_backward(get<Real>(backward_), as_fftw(in), out);
}

template <typename Real>
bool is_fft_aligned(const Real* buffer) {
  return Fftw<Real>::alignment(const_cast<Real*>(buffer)) == 0;  // which is fftw_malloc's
}

std::int64_t fast_fft_size(std::int64_t n) {
  for (std::int64_t size = n > 2 ? n + n % 2 : 2;; size += 2) {
    std::int64_t rest = size;
    for (const int prime : {2, 3, 5, 7})
      while (rest % prime == 0)
        rest /= prime;
    if (rest == 1) return size;
  }
}

template bool is_fft_aligned(const float*);
template bool is_fft_aligned(const double*);
template class ComplexFft<float>;
template class ComplexFft<double>;
template class RealFft<float>;
template class RealFft<double>;

}  // namespace micro
