#include "io/exr_texture.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfStringAttribute.h>
#include <ImfTileDescriptionAttribute.h>
#include <ImfTiledOutputFile.h>
#include <half.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>

#include "core/error.h"
#include "io/atomic_file.h"

namespace micro {

struct ExrTextureWriter::State {
  State(const std::filesystem::path& path, Layout l) : file(path), layout(std::move(l)) {}

  AtomicFile file;
  Layout layout;
  std::optional<Imf::TiledOutputFile> picture;

  template <typename Call>
  void guard(Call&& call) const {
    try {
      call();
    } catch (const std::exception& error) {
      throw FileError(file.path(), std::string("cannot write the texture (") + error.what() + ")");
    }
  }
  bool is_positive(const std::string& channel) const {
    return std::find(layout.positive.begin(), layout.positive.end(), channel) != layout.positive.end();
  }
};

ExrTextureWriter::ExrTextureWriter(const std::filesystem::path& path, const Layout& layout)
    : state_(std::make_unique<State>(path, layout)) {
  state_->guard([&] {
    Imf::Header header(static_cast<int>(layout.cols), static_cast<int>(layout.rows));
    header.compression() = Imf::ZIP_COMPRESSION;
    header.lineOrder() = Imf::RANDOM_Y;  // tiles stand in the file as they come
    header.setTileDescription(
        {kTile, kTile, layout.levels == Levels::All ? Imf::MIPMAP_LEVELS : Imf::ONE_LEVEL, Imf::ROUND_UP});
    for (const std::string& channel : layout.channels)
      header.channels().insert(channel,
                               Imf::Channel(layout.pixel == ExrPixel::Half ? Imf::HALF : Imf::FLOAT));
    for (const auto& [name, value] : layout.attributes)
      header.insert(name, Imf::StringAttribute(value));
    state_->picture.emplace(state_->file.temporary().c_str(), header, 0);
  });
}

ExrTextureWriter::~ExrTextureWriter() = default;

int ExrTextureWriter::levels() const {
  return state_->picture->numLevels();
}

void ExrTextureWriter::write(int level, Eigen::Index row, Eigen::Index col,
                             const std::vector<Grid<float>>& values) {
  assert(row % kTile == 0 && col % kTile == 0 && values.size() == state_->layout.channels.size());
  const Eigen::Index rows = values[0].rows(), cols = values[0].cols();
  state_->guard([&] {
    const bool in_half = state_->layout.pixel == ExrPixel::Half;
    std::vector<Grid<half>> halves;
    Imf::FrameBuffer frame;
    for (std::size_t c = 0; c < values.size(); ++c) {
      const std::string& channel = state_->layout.channels[c];
      char* base = const_cast<char*>(reinterpret_cast<const char*>(values[c].data()));
      std::size_t pixel = sizeof(float);
      if (in_half) {
        const float least = state_->is_positive(channel) ? kLeastHalf : -65504.F;
        halves.push_back(values[c].unaryExpr([least](float value) {
          return half(std::isnan(value) ? value : std::clamp(value, least, 65504.F));
        }));
        base = reinterpret_cast<char*>(halves.back().data());
        pixel = sizeof(half);
      }
      const std::size_t line = pixel * static_cast<std::size_t>(cols);
      // The frame buffer's origin is that of the level.
      base -= static_cast<std::ptrdiff_t>(line) * row + static_cast<std::ptrdiff_t>(pixel) * col;
      frame.insert(channel, Imf::Slice(in_half ? Imf::HALF : Imf::FLOAT, base, pixel, line));
    }
    state_->picture->setFrameBuffer(frame);
    const auto tile = [](Eigen::Index k) { return static_cast<int>(k / kTile); };
    state_->picture->writeTiles(tile(col), tile(col + cols - 1), tile(row), tile(row + rows - 1), level);
  });
}

void ExrTextureWriter::finish() {
  state_->guard([&] { state_->picture.reset(); });
  state_->file.commit();
}

}  // namespace micro
