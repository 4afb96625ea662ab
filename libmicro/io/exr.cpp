#include "io/exr.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <ImfStringAttribute.h>

#include <cassert>

#include "core/error.h"
#include "io/atomic_file.h"

namespace micro {

void write_exr(const std::filesystem::path& path, const std::vector<ExrChannel>& channels,
               const std::vector<std::pair<std::string, std::string>>& attributes) {
  assert(!channels.empty());
  const int rows = static_cast<int>(channels.front().values.rows());
  const int cols = static_cast<int>(channels.front().values.cols());
  AtomicFile file(path);
  try {
    Imf::Header header(cols, rows);
    header.compression() = Imf::ZIP_COMPRESSION;
    for (const auto& [name, value] : attributes)
      header.insert(name, Imf::StringAttribute(value));
    Imf::FrameBuffer frame;
    for (const ExrChannel& channel : channels) {
      assert(channel.values.rows() == rows && channel.values.cols() == cols);
      header.channels().insert(channel.name, Imf::Channel(Imf::FLOAT));
      // OpenEXR's frame buffer is one type for reading and writing; writing only reads from it.
      char* base = const_cast<char*>(reinterpret_cast<const char*>(channel.values.data()));
      frame.insert(channel.name, Imf::Slice(Imf::FLOAT, base, sizeof(float),
                                            sizeof(float) * static_cast<std::size_t>(cols)));
    }
    Imf::OutputFile picture(file.temporary().c_str(), header, 0);
    picture.setFrameBuffer(frame);
    picture.writePixels(rows);
  } catch (const std::exception& error) {
    throw FileError(path, std::string("cannot write the picture (") + error.what() + ")");
  }
  file.commit();
}

}  // namespace micro
