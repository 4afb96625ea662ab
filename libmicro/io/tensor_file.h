#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace micro {

/// An array of a tensor file: bytes (`text` or flags) or floats, the last dimension the fastest.
struct Tensor {
  enum class Type : std::uint8_t { Bytes = 1, Floats = 10 };
  std::string name;
  std::vector<std::uint64_t> shape;
  Type type;
  std::span<const std::byte> data;
};

/// A view of floats as a tensor; `values` has to live as long as it.
Tensor float_tensor(const std::string& name, std::vector<std::uint64_t> shape, std::span<const float> values);

/// The same of bytes, one-dimensional.
Tensor byte_tensor(const std::string& name, std::span<const std::byte> values);

/// Writes a tensor file, version 1.0, as RGL's measured BRDFs are kept [Dupuy18]; whole or absent. Each array
/// begins at a multiple of 8 bytes. Throws FileError.
void write_tensor_file(const std::filesystem::path& path, std::span<const Tensor> tensors);

}  // namespace micro
