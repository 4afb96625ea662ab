#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "io/exr.h"

namespace micro {

/// How a number is stored in a texture.
enum class ExrPixel {
  Float,
  Half,  ///< 11 significant bits; what is out of range is cut to ±65504, see ExrTextureWriter::write
};

/// A tiled, mip-mapped OpenEXR texture, written part by part; whole or absent. Level l has ⌈n/2^l⌉ texels a
/// side.
class ExrTextureWriter {
 public:
  enum class Levels { Finest, All };
  struct Layout {
    Eigen::Index rows, cols;
    std::vector<std::string> channels;
    /// Channels that must stay positive: in half they are never less than kLeastHalf.
    std::vector<std::string> positive;
    ExrPixel pixel = ExrPixel::Float;
    Levels levels = Levels::All;
    std::vector<std::pair<std::string, std::string>> attributes;
  };
  static constexpr Eigen::Index kTile = 64;
  static constexpr float kLeastHalf = 0x1p-14F;  ///< half's smallest normal number

  /// Throws FileError.
  ExrTextureWriter(const std::filesystem::path& path, const Layout& layout);
  ~ExrTextureWriter();
  ExrTextureWriter(ExrTextureWriter&&) = delete;

  int levels() const;
  /// Writes texels of a level from (row, col) on, both multiples of kTile; values[c] is [rows, cols] of
  /// channel c, whose far sides lie at multiples of kTile or at the level's end.
  void write(int level, Eigen::Index row, Eigen::Index col, const std::vector<Grid<float>>& values);
  /// After every tile of every level.
  void finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace micro
