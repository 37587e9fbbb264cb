/// \file
/// Textures of a transfer written without any of them in memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/image/image.h"
#include "patinate/transfer/time_map.h"
#include "patinate/transfer/transfer_reader.h"
#include "transfer/lookup/coordinate_strips.h"

namespace patinate::transfer {

enum class TextureKind {
  Color,   ///< 3 channels, linear; codes are sRGB.
  Normal,  ///< 3 channels, of the source's tangent space, turned into the texels'; codes are 127.5 + 127.5 n, EXR has
           ///< X, Y, Z.
  Value,   ///< 1 channel; codes are 255 v, EXR has Y.
  Packed,  ///< 3 channels, each a value; EXR has R, G, B.
};

/// A texture to be written.
struct TextureFile {
  std::vector<std::filesystem::path> files;  ///< One a tile, with the extensions of write_color().
  ImageF source;                             ///< Source of the history's size: sample(), sample_material_map().
  std::string key = "";                      ///< Content key for the files.
  TextureKind kind = TextureKind::Color;
  std::string unit = "";  ///< Unit of a value, for the header of an EXR.
};

/// TextureWriter::Encode of colors: sRGB.
[[nodiscard]] ImageU8 color_codes(const ImageF& linear);

/// Writes what TransferReader::gather_tiles() (of normals normal_tiles()) and write_color() would, byte for byte, in
/// strips: memory does not grow with the atlas but for 8 bytes a column and strip. Thread-safe.
class TextureWriter {
 public:
  /// Reads and checks the coordinates of every tile. @throws IoError as CoordinateStrips.
  explicit TextureWriter(const TransferFolder& transfer, const CoordinateStripsOptions& options = {},
                         const RunControl& control = {});

  /// All at once: coordinates are gone through once for them. Each file is whole or absent.
  /// @throws CannotComplete, ParseError on an unknown extension, InvalidInput if a source is not of the history's size,
  /// or a normal is asked for without CoordinateStripsOptions::with_turns.
  void write(std::span<const TextureFile> textures, const RunControl& control = {}) const;

  /// Takes rows of codes, whole ones from top to bottom.
  using TakeRows = std::function<void(std::span<const std::uint8_t> codes)>;
  /// Values of a file of codes, pixel by pixel: an image of the same size, of 1 to 4 channels.
  using Encode = std::function<ImageU8(const ImageF& values)>;
  /// The texels of a tile in codes. @param values  Of the history's pixels. @throws InvalidInput if they are not of the
  /// history's size.
  void gather_rows(std::size_t tile, const ImageF& values, const Encode& encode, const TakeRows& take,
                   const RunControl& control = {}) const;
  /// Normals, turned, as TextureKind::Normal has them in codes.
  void normal_rows(std::size_t tile, const ImageF& normals, const TakeRows& take, const RunControl& control = {}) const;

 private:
  void check_size(int width, int height) const;

  int source_width_, source_height_;
  bool with_turns_;
  std::vector<CoordinateStrips> tiles_;
};

/// Writes what TransferReader::sample_tiles(times, between) and write_color() would, byte for byte, in strips: beside
/// the times themselves 5 bytes a texel, while gutters are filled.
/// @param times  Over the sheet of all tiles, in the history's unit; not looked at beside the charts. Used up.
/// @param files  One a tile. @throws as TextureWriter and gather_at_times().
void write_time_map(const TransferFolder& transfer, ImageF times, Between between,
                    std::span<const std::filesystem::path> files, const std::string& key,
                    const TimeMapOptions& frames = {}, const RunControl& control = {},
                    const CoordinateStripsOptions& options = {});

}  // namespace patinate::transfer
