#pragma once

// The only file that includes HDF5. Not for use outside io: hdf5_reader.h and hdf5_writer.h are.
#include <hdf5.h>
#include <hdf5_hl.h>

#include <cstdint>
#include <filesystem>
#include <mutex>
#include <string>
#include <utility>

namespace micro::hdf5 {

/// Holds HDF5 for this thread while it lives. The library and its high-level part are called from one thread
/// at a time; its error printing, which is a setting per thread, is off.
class Lock {
 public:
  Lock();

 private:
  std::lock_guard<std::mutex> guard_;
};

/// An HDF5 identifier that closes itself; made, used and dropped under a Lock.
class Handle {
 public:
  using Close = herr_t (*)(hid_t);
  Handle(hid_t id, Close close) : id_(id), close_(close) {}
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Handle& operator=(Handle&&) = delete;
  operator hid_t() const { return id_; }
  explicit operator bool() const { return id_ >= 0; }

 private:
  hid_t id_;
  Close close_;
};

/// What HDF5 last failed at on this thread, in a few words; empty if it has no reason.
std::string last_error();

/// The type of T in memory.
template <typename T>
hid_t native_type();
template <>
inline hid_t native_type<float>() {
  return H5T_NATIVE_FLOAT;
}
template <>
inline hid_t native_type<double>() {
  return H5T_NATIVE_DOUBLE;
}
template <>
inline hid_t native_type<std::uint8_t>() {
  return H5T_NATIVE_UINT8;
}
template <>
inline hid_t native_type<std::int32_t>() {
  return H5T_NATIVE_INT32;
}
template <>
inline hid_t native_type<std::uint32_t>() {
  return H5T_NATIVE_UINT32;
}
template <>
inline hid_t native_type<std::int64_t>() {
  return H5T_NATIVE_INT64;
}
template <>
inline hid_t native_type<std::uint64_t>() {
  return H5T_NATIVE_UINT64;
}

/// A variable-length UTF-8 string.
Handle string_type();

/// Opens a dataset or group by its path. Invalid if it is not there.
Handle open_object(hid_t file, const std::string& object);

}  // namespace micro::hdf5
