#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace micro {

/// Bytes that end before the value does, or that no value has.
class BrokenArchive : public std::runtime_error {
 public:
  BrokenArchive() : std::runtime_error("holds no such values") {}
};

/// Values as bytes, in the machine's own order, for another run of the same program. What an archive writes
/// and reads is said once, in the order of its values: a type has a member `persist(archive)`, or a function
/// `persist(archive, value)` beside it, that calls archive(a, b, …). Writing changes no value, so constant
/// ones are written as well.
class ArchiveWriter {
 public:
  template <typename... T>
  void operator()(const T&... values);
  const std::vector<std::uint8_t>& bytes() const& { return bytes_; }
  std::vector<std::uint8_t> bytes() && { return std::move(bytes_); }

 private:
  template <typename T>
  void write(const T& value);
  void raw(const void* data, std::size_t size) {
    const auto* begin = static_cast<const std::uint8_t*>(data);
    bytes_.insert(bytes_.end(), begin, begin + size);
  }
  void size(std::size_t n) {
    const std::uint64_t count = n;
    raw(&count, sizeof count);
  }

  std::vector<std::uint8_t> bytes_;
};

/// Reads what ArchiveWriter wrote. Throws BrokenArchive; takes no more memory than the bytes account for.
class ArchiveReader {
 public:
  explicit ArchiveReader(const std::vector<std::uint8_t>& bytes) : next_(bytes.data()), left_(bytes.size()) {}
  template <typename... T>
  void operator()(T&... values);
  bool at_end() const { return left_ == 0; }

 private:
  template <typename T>
  void read(T& value);
  void raw(void* data, std::size_t size) {
    if (size > left_) throw BrokenArchive();
    std::copy_n(next_, size, static_cast<std::uint8_t*>(data));
    next_ += size;
    left_ -= size;
  }
  /// A number of elements of at least so many bytes each.
  std::size_t size(std::size_t element) {
    std::uint64_t count = 0;
    raw(&count, sizeof count);
    if (count > left_ / element) throw BrokenArchive();
    return static_cast<std::size_t>(count);
  }

  const std::uint8_t* next_;
  std::size_t left_;
};

namespace detail {
template <typename T>
struct Kind {
  static constexpr bool vector = false, optional = false, map = false, variant = false, eigen = false;
};
template <typename T>
struct Kind<std::vector<T>> : Kind<void> {
  static constexpr bool vector = true;
};
template <typename T>
struct Kind<std::optional<T>> : Kind<void> {
  static constexpr bool optional = true;
};
template <typename K, typename V>
struct Kind<std::map<K, V>> : Kind<void> {
  static constexpr bool map = true;
};
template <typename... T>
struct Kind<std::variant<T...>> : Kind<void> {
  static constexpr bool variant = true;
};
template <typename T, int R, int C, int O>
struct Kind<Eigen::Array<T, R, C, O>> : Kind<void> {
  static constexpr bool eigen = true;
};
template <typename T, int R, int C, int O>
struct Kind<Eigen::Matrix<T, R, C, O>> : Kind<void> {
  static constexpr bool eigen = true;
};
/// Copied byte by byte: numbers, enumerations, and arrays of numbers.
template <typename T>
struct Plain : std::bool_constant<std::is_arithmetic_v<T> || std::is_enum_v<T>> {};
template <typename T, std::size_t N>
struct Plain<std::array<T, N>> : Plain<T> {};
/// Elements that lie in a vector byte beside byte (bool's do not).
template <typename T>
constexpr bool kDense = Plain<T>::value && !std::is_same_v<T, bool>;
}  // namespace detail

template <typename... T>
void ArchiveWriter::operator()(const T&... values) {
  (write(values), ...);
}

template <typename... T>
void ArchiveReader::operator()(T&... values) {
  (read(values), ...);
}

template <typename T>
void ArchiveWriter::write(const T& value) {
  using Kind = detail::Kind<T>;
  [[maybe_unused]] T& unchanged =
      const_cast<T&>(value);  // persist reads its values for a writer, and fills them for a reader
  if constexpr (detail::Plain<T>::value) {
    raw(&value, sizeof value);
  } else if constexpr (std::is_same_v<T, std::string>) {
    size(value.size());
    raw(value.data(), value.size());
  } else if constexpr (Kind::vector) {
    size(value.size());
    if constexpr (detail::kDense<typename T::value_type>) {
      raw(value.data(), value.size() * sizeof(typename T::value_type));
    } else {
      for (const auto& element : value)
        write(element);
    }
  } else if constexpr (Kind::optional) {
    const std::uint8_t there = value.has_value() ? 1 : 0;
    raw(&there, 1);
    if (value) write(*value);
  } else if constexpr (Kind::map) {
    size(value.size());
    for (const auto& [key, element] : value) {
      write(key);
      write(element);
    }
  } else if constexpr (Kind::variant) {
    const auto index = static_cast<std::uint8_t>(value.index());
    raw(&index, 1);
    std::visit([&](const auto& alternative) { write(alternative); }, value);
  } else if constexpr (Kind::eigen) {
    size(static_cast<std::size_t>(value.rows()));
    size(static_cast<std::size_t>(value.cols()));
    raw(value.data(), static_cast<std::size_t>(value.size()) * sizeof(typename T::Scalar));
  } else if constexpr (std::is_empty_v<T>) {
    // Says all by its type.
  } else if constexpr (requires { unchanged.persist(*this); }) {
    unchanged.persist(*this);
  } else {
    persist(*this, unchanged);
  }
}

template <typename T>
void ArchiveReader::read(T& value) {
  using Kind = detail::Kind<T>;
  if constexpr (std::is_same_v<T, bool>) {
    std::uint8_t byte = 0;
    raw(&byte, 1);
    value = byte != 0;
  } else if constexpr (detail::Plain<T>::value) {
    raw(&value, sizeof value);
  } else if constexpr (std::is_same_v<T, std::string>) {
    value.resize(size(1));
    raw(value.data(), value.size());
  } else if constexpr (Kind::vector) {
    if constexpr (detail::kDense<typename T::value_type>) {
      value.resize(size(sizeof(typename T::value_type)));
      raw(value.data(), value.size() * sizeof(typename T::value_type));
    } else {
      const std::size_t n = size(1);
      value.clear();
      for (std::size_t k = 0; k < n; ++k)
        read(value.emplace_back());
    }
  } else if constexpr (Kind::optional) {
    std::uint8_t there = 0;
    raw(&there, 1);
    value.reset();
    if (there != 0) read(value.emplace());
  } else if constexpr (Kind::map) {
    const std::size_t n = size(1);
    value.clear();
    for (std::size_t k = 0; k < n; ++k) {
      typename T::key_type key;
      read(key);
      read(value[key]);
    }
  } else if constexpr (Kind::variant) {
    std::uint8_t index = 0;
    raw(&index, 1);
    const auto pick = [&]<std::size_t... I>(std::index_sequence<I...>) {
      return ((index == I ? (read(value.template emplace<I>()), true) : false) || ...);
    };
    if (!pick(std::make_index_sequence<std::variant_size_v<T>>())) throw BrokenArchive();
  } else if constexpr (Kind::eigen) {
    constexpr std::size_t kMost = std::size_t{1} << 31;
    std::uint64_t rows = 0, cols = 0;
    raw(&rows, sizeof rows);
    raw(&cols, sizeof cols);
    if (rows > kMost || cols > kMost || rows * cols > left_ / sizeof(typename T::Scalar))
      throw BrokenArchive();
    if constexpr (T::SizeAtCompileTime == Eigen::Dynamic)
      value.resize(static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(cols));
    else if (rows * cols != static_cast<std::uint64_t>(value.size()))
      throw BrokenArchive();
    raw(value.data(), static_cast<std::size_t>(value.size()) * sizeof(typename T::Scalar));
  } else if constexpr (std::is_empty_v<T>) {
    // Says all by its type.
  } else if constexpr (requires { value.persist(*this); }) {
    value.persist(*this);
  } else {
    persist(*this, value);
  }
}

}  // namespace micro
