#include "io/png.h"

#include <png.h>

#include "core/error.h"
#include "io/atomic_file.h"

namespace micro {

void write_png(const std::filesystem::path& path, const Picture& picture) {
  AtomicFile file(path);
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(picture.cols());
  image.height = static_cast<png_uint_32>(picture.rows());
  image.format = PNG_FORMAT_RGB;
  if (png_image_write_to_file(&image, file.temporary().c_str(), 0, picture.data(), 0, nullptr) == 0)
    throw FileError(path, std::string("cannot write the picture (") + image.message + ")");
  file.commit();
}

}  // namespace micro
