#pragma once

namespace micro::testing {

/// Whether this is built with the address or thread sanitizer: they reserve terabytes of address space, and
/// abort where memory cannot be had.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#elif defined(__has_feature)
inline constexpr bool kSanitized = __has_feature(address_sanitizer) || __has_feature(thread_sanitizer);
#else
inline constexpr bool kSanitized = false;
#endif

}  // namespace micro::testing
