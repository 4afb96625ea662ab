#include "io/md5.h"

#include <openssl/evp.h>

#include <array>

#include "io/hexadecimal.h"

namespace micro {

std::string md5_of(std::span<const std::byte> bytes) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  std::size_t size = 0;
  if (EVP_Q_digest(nullptr, "MD5", nullptr, bytes.data(), bytes.size(), digest.data(), &size) != 1) return {};
  return hexadecimal({digest.data(), size});
}

}  // namespace micro
