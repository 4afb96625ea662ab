#include "core/fft.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/parallel.h"
#include "core/random.h"

namespace micro {
namespace {

/// Rounding of a transform of some hundred numbers of order one, in the type's epsilon.
constexpr double kRounding = 100;

template <typename Real>
class Fft : public testing::Test {
 protected:
  static constexpr double tolerance(double scale) {
    return kRounding * scale * static_cast<double>(std::numeric_limits<Real>::epsilon());
  }
};
using Reals = testing::Types<float, double>;
TYPED_TEST_SUITE(Fft, Reals);

/// The literal sum Σ x e^{∓2πi(jk/rows + il/cols)} for output (k, l).
template <typename Complex>
std::complex<double> literal(const Complex* x, const FftShape& shape, std::int64_t k, std::int64_t l,
                             int sign) {
  std::complex<double> sum = 0;
  for (std::int64_t j = 0; j < shape.rows; ++j)
    for (std::int64_t i = 0; i < shape.cols; ++i) {
      const double turns = static_cast<double>(j * k) / static_cast<double>(shape.rows) +
                           static_cast<double>(i * l) / static_cast<double>(shape.cols);
      const auto value = x[j * shape.cols + i];
      sum += std::complex<double>(std::real(value), std::imag(value)) *
             std::polar(1., sign * 2 * std::numbers::pi * turns);
    }
  return sum;
}

TYPED_TEST(Fft, IsTheLiteralSum) {
  using Complex = std::complex<TypeParam>;
  for (const FftShape& shape :
       {FftShape{1, 12, 3}, FftShape{6, 7, 2}, FftShape{5, 1, 1}, FftShape{1, 1, 1}}) {
    FftVector<Complex> x(static_cast<std::size_t>(shape.size()));
    FftVector<TypeParam> real(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) {
      const auto [a, b] = random_normal(1, 0, i);
      x[i] = {static_cast<TypeParam>(a), static_cast<TypeParam>(b)};
      real[i] = static_cast<TypeParam>(a);
    }
    const double tol = this->tolerance(static_cast<double>(shape.rows * shape.cols));
    const std::int64_t size = shape.rows * shape.cols, half_cols = shape.cols / 2 + 1;
    for (const auto direction : {FftDirection::Forward, FftDirection::Backward}) {
      auto y = x;
      ComplexFft<TypeParam>(shape, direction)(y.data());
      for (std::int64_t b = 0; b < shape.batch; ++b)
        for (std::int64_t k = 0; k < shape.rows; ++k)
          for (std::int64_t l = 0; l < shape.cols; ++l)
            EXPECT_LE(
                std::abs(
                    literal(x.data() + b * size, shape, k, l, direction == FftDirection::Forward ? -1 : 1) -
                    std::complex<double>(y[static_cast<std::size_t>(b * size + k * shape.cols + l)])),
                tol);
    }
    FftVector<Complex> half(static_cast<std::size_t>(shape.half_size()));
    const auto input = real;
    const RealFft<TypeParam> fft(shape);
    fft.forward(real.data(), half.data());
    for (std::int64_t b = 0; b < shape.batch; ++b)
      for (std::int64_t k = 0; k < shape.rows; ++k)
        for (std::int64_t l = 0; l < half_cols; ++l)
          EXPECT_LE(std::abs(literal(input.data() + b * size, shape, k, l, -1) -
                             std::complex<double>(
                                 half[static_cast<std::size_t>((b * shape.rows + k) * half_cols + l)])),
                    tol);
    fft.backward(half.data(), real.data());
    for (std::size_t i = 0; i < real.size(); ++i)
      EXPECT_LE(std::abs(real[i] / static_cast<double>(size) - input[i]), tol);
  }
}

TYPED_TEST(Fft, PlansAndRunsOnAllThreads) {
  constexpr FftShape kShape{8, 8, 1};
  std::vector<double> error(64);
  parallel_for(64, [&](std::int64_t n) {
    FftVector<std::complex<TypeParam>> x(64);
    x[static_cast<std::size_t>(n)] = 1;
    ComplexFft<TypeParam>(kShape, FftDirection::Forward)(x.data());
    ComplexFft<TypeParam>(kShape, FftDirection::Backward)(x.data());
    error[static_cast<std::size_t>(n)] =
        std::abs(std::complex<double>(x[static_cast<std::size_t>(n)]) / 64. - 1.);
  });
  for (const double e : error)
    EXPECT_LE(e, this->tolerance(1));
}

TEST(FftAlignment, IsThatOfFftVectors) {
  const FftVector<float> floats(100);
  const FftVector<double> doubles(100);
  EXPECT_TRUE(is_fft_aligned(floats.data()));
  EXPECT_TRUE(is_fft_aligned(doubles.data()));
  EXPECT_FALSE(is_fft_aligned(floats.data() + 1));
  EXPECT_FALSE(is_fft_aligned(doubles.data() + 1));
}

TEST(FastFftSize, IsEvenAndSmooth) {
  EXPECT_EQ(fast_fft_size(1), 2);
  EXPECT_EQ(fast_fft_size(11), 12);
  EXPECT_EQ(fast_fft_size(640), 640);
  EXPECT_EQ(fast_fft_size(641), 648);
}

}  // namespace
}  // namespace micro
