#include "io/exr_heights.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>

#include <string>
#include <vector>

#include "io/bytes.h"
#include "io/printable.h"

namespace micro {
namespace {

/// Points a byte: deflate cannot shrink anything by more than 1032 : 1.
constexpr std::uint64_t kMostCompression = 1100;

/// The channel that holds heights. Throws FileError if there are several and none of them is Y.
std::string height_channel(const std::filesystem::path& path, const Imf::ChannelList& channels) {
  std::vector<std::string> names;
  std::string all;
  for (auto channel = channels.begin(); channel != channels.end(); ++channel) {
    names.emplace_back(channel.name());
    all += (all.empty() ? "" : ", ") + names.back();
    if (names.back() == "Y") return "Y";
  }
  if (names.size() == 1) return names.front();
  throw FileError(path, "has the channels " + printable(all, 100) +
                            ": which one is height? (Y, or the only channel, is taken)");
}

}  // namespace

bool is_exr_heights(const FileHead& head) {
  return begins_with(head.bytes, kExrSignature);
}

HeightField read_exr_heights(const std::filesystem::path& path, const ReadOptions& options) {
  const Pitch pitch = user_pitch(path, options);
  std::vector<float> z;
  std::uint64_t rows = 0, cols = 0;
  try {
    Imf::InputFile picture(path.c_str(), 0);
    const Imath::Box2i window = picture.header().dataWindow();
    const std::string channel = height_channel(path, picture.header().channels());
    if (const Imf::Channel& found = picture.header().channels()[channel.c_str()];
        found.xSampling != 1 || found.ySampling != 1)
      throw FileError(path, "its channel " + channel + " has fewer points than the picture");
    cols = static_cast<std::uint64_t>(std::int64_t{window.max.x} - window.min.x + 1);
    rows = static_cast<std::uint64_t>(std::int64_t{window.max.y} - window.min.y + 1);
    // A header may promise anything: hold it against the bytes that are there.
    if (rows * cols > std::filesystem::file_size(path) * kMostCompression)
      throw FileError(path, "says that it is larger than it can be");
    z.resize(rows * cols);
    Imf::FrameBuffer frame;
    frame.insert(channel, Imf::Slice::Make(Imf::FLOAT, z.data(), window));
    picture.setFrameBuffer(frame);
    picture.readPixels(window.min.y, window.max.y);
  } catch (const FileError&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    throw FileError(path, std::string("cannot be read as an OpenEXR picture: ") + error.what());
  }
  return read_height_field(path, rows, cols, pitch, [&](Eigen::Index k) {
    return static_cast<double>(z[static_cast<std::size_t>(k)]);
  });
}

}  // namespace micro
