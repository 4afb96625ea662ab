#pragma once

#include <complex>
#include <cstdint>
#include <memory>
#include <new>
#include <type_traits>
#include <vector>

namespace micro {

namespace detail {
/// In large pages where they are worth it.
void* fft_allocate(std::size_t bytes);
void fft_free(void* p) noexcept;
struct FftFree {
  void operator()(void* p) const noexcept { fft_free(p); }
};
}  // namespace detail

/// Memory aligned as the transforms below want it.
template <typename T>
struct FftAllocator {
  using value_type = T;
  FftAllocator() = default;
  template <typename U>
  FftAllocator(const FftAllocator<U>&) {}  // NOLINT(google-explicit-constructor)
  T* allocate(std::size_t n) {
    if (n > static_cast<std::size_t>(-1) / sizeof(T)) throw std::bad_alloc();
    return static_cast<T*>(detail::fft_allocate(n * sizeof(T)));
  }
  void deallocate(T* p, std::size_t) noexcept { detail::fft_free(p); }
  friend bool operator==(const FftAllocator&, const FftAllocator&) { return true; }
};

template <typename T>
using FftVector = std::vector<T, FftAllocator<T>>;

/// The same for numbers that are written before they are read: nobody sets them to zero first.
template <typename T>
using FftArray = std::unique_ptr<T[], detail::FftFree>;
template <typename T>
FftArray<T> make_fft_array(std::int64_t n) {
  static_assert(std::is_trivially_destructible_v<T>);
  return FftArray<T>(FftAllocator<T>().allocate(static_cast<std::size_t>(n)));
}

/// Whether a buffer is as well aligned as FftVector's are.
template <typename Real>
bool is_fft_aligned(const Real* buffer);

/// How a plan is found: Estimate is immediate and gives the same plan, hence the same bits, every time;
/// Measure tries a few and is worth it when the plan runs many times.
enum class FftPlanning { Estimate, Measure };

/// Sign of the exponent: Forward is Σ x e^{−2πi jk/n}, Backward is Σ x e^{+2πi jk/n}; neither is normalised.
enum class FftDirection { Forward, Backward };

/// `batch` contiguous transforms of shape [rows, cols] (rows = 1: one-dimensional), row-major.
/// cols must be positive; an empty shape or batch is a bug.
struct FftShape {
  std::int64_t rows = 1;
  std::int64_t cols = 1;
  std::int64_t batch = 1;

  std::int64_t size() const { return rows * cols * batch; }
  /// Complex numbers of the half spectrum of a real transform, [batch, rows, cols/2 + 1].
  std::int64_t half_size() const { return rows * (cols / 2 + 1) * batch; }
};

/// A complex transform in place. `Real` is float or double. Making one takes the planner's lock; running one
/// is free of locks and of side effects, so one plan may serve several threads with buffers of their own.
/// Buffers must come from FftVector (or be as well aligned).
template <typename Real>
class ComplexFft {
 public:
  ComplexFft(const FftShape& shape, FftDirection direction, FftPlanning planning = FftPlanning::Estimate);
  void operator()(std::complex<Real>* data) const;  ///< shape.size() numbers
  const FftShape& shape() const { return shape_; }

 private:
  FftShape shape_;
  std::shared_ptr<void> plan_;
};

/// A real transform and its inverse: real [batch, rows, cols] ↔ half spectrum [batch, rows, cols/2 + 1].
template <typename Real>
class RealFft {
 public:
  explicit RealFft(const FftShape& shape, FftPlanning planning = FftPlanning::Estimate);
  void forward(Real* in, std::complex<Real>* out) const;   ///< `in` keeps its values when rows = 1
  void backward(std::complex<Real>* in, Real* out) const;  ///< destroys `in`; not normalised
  const FftShape& shape() const { return shape_; }

 private:
  FftShape shape_;
  std::shared_ptr<void> forward_, backward_;
};

/// The smallest even number ≥ n (and ≥ 2) whose only prime factors are 2, 3, 5 and 7: sizes that are fast.
std::int64_t fast_fft_size(std::int64_t n);

extern template bool is_fft_aligned(const float*);
extern template bool is_fft_aligned(const double*);
extern template class ComplexFft<float>;
extern template class ComplexFft<double>;
extern template class RealFft<float>;
extern template class RealFft<double>;

}  // namespace micro
