#include "io/hdf5_api.h"

#include <pthread.h>

#include <string_view>

namespace micro::hdf5 {
namespace {

std::mutex& library_mutex() {
  // Every identifier is closed by its owner. HDF5's own clean-up at exit would only try once more to write
  // what a full disk has refused.
  [[maybe_unused]] static const herr_t no_cleanup_at_exit = H5dont_atexit();
  static std::mutex mutex;
  // A child process must not be born while another thread is inside the library.
  [[maybe_unused]] static const int fork_waits =
      pthread_atfork([] { mutex.lock(); }, [] { mutex.unlock(); }, [] { mutex.unlock(); });
  return mutex;
}

/// Keeps the first description, which is where things went wrong.
herr_t keep_first(unsigned, const H5E_error2_t* error, void* text) {
  auto& message = *static_cast<std::string*>(text);
  if (message.empty() && error->desc) message = error->desc;
  return 0;
}

}  // namespace

Lock::Lock() : guard_(library_mutex()) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

std::string last_error() {
  std::string message;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep_first, &message);
  // HDF5 wraps what the system says: "…, errno = 28, error message = 'No space left on device', …".
  constexpr std::string_view key = "error message = '";
  if (const std::size_t found = message.find(key); found != std::string::npos) {
    const std::size_t begin = found + key.size();
    return message.substr(begin, message.find('\'', begin) - begin);
  }
  return message;
}

Handle string_type() {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  return type;
}

Handle open_object(hid_t file, const std::string& object) {
  return {H5Oopen(file, object.c_str(), H5P_DEFAULT), H5Oclose};
}

}  // namespace micro::hdf5
