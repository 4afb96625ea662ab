#include "io/tensor_file.h"

#include <bit>
#include <cassert>
#include <functional>
#include <numeric>

#include "io/atomic_file.h"

namespace micro {
namespace {

static_assert(std::endian::native == std::endian::little, "tensor files are little-endian");

constexpr std::size_t kAlignment = 8;

std::size_t aligned(std::size_t offset) {
  return (offset + kAlignment - 1) / kAlignment * kAlignment;
}

/// Name length, name, dimensions, type, offset, shape.
std::size_t entry_bytes(const Tensor& tensor) {
  return 2 + tensor.name.size() + 2 + 1 + 8 + 8 * tensor.shape.size();
}

template <typename T>
void append(std::vector<std::byte>& bytes, std::span<const T> values) {
  const auto raw = std::as_bytes(values);
  bytes.insert(bytes.end(), raw.begin(), raw.end());
}

template <typename T>
void append(std::vector<std::byte>& bytes, T value) {
  append(bytes, std::span<const T>(&value, 1));
}

}  // namespace

Tensor float_tensor(const std::string& name, std::vector<std::uint64_t> shape,
                    std::span<const float> values) {
  assert(std::accumulate(shape.begin(), shape.end(), std::uint64_t{1}, std::multiplies<>()) == values.size());
  return {name, std::move(shape), Tensor::Type::Floats, std::as_bytes(values)};
}

Tensor byte_tensor(const std::string& name, std::span<const std::byte> values) {
  return {name, {values.size()}, Tensor::Type::Bytes, values};
}

void write_tensor_file(const std::filesystem::path& path, std::span<const Tensor> tensors) {
  constexpr char kMagic[12] = "tensor_file";
  std::size_t offset = sizeof kMagic + 2 + 4;
  for (const Tensor& tensor : tensors)
    offset += entry_bytes(tensor);
  std::vector<std::byte> bytes;
  append(bytes, std::span<const char>(kMagic));
  append(bytes, std::uint8_t{1});
  append(bytes, std::uint8_t{0});
  append(bytes, static_cast<std::uint32_t>(tensors.size()));
  for (const Tensor& tensor : tensors) {
    offset = aligned(offset);
    append(bytes, static_cast<std::uint16_t>(tensor.name.size()));
    append(bytes, std::span<const char>(tensor.name));
    append(bytes, static_cast<std::uint16_t>(tensor.shape.size()));
    append(bytes, static_cast<std::uint8_t>(tensor.type));
    append(bytes, static_cast<std::uint64_t>(offset));
    append(bytes, std::span<const std::uint64_t>(tensor.shape));
    offset += tensor.data.size();
  }
  for (const Tensor& tensor : tensors) {
    bytes.resize(aligned(bytes.size()));
    bytes.insert(bytes.end(), tensor.data.begin(), tensor.data.end());
  }
  write_file(path, bytes);
}

}  // namespace micro
