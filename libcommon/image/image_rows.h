/// \file
/// Images of which only some rows are in memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "libcommon/image/image.h"

namespace patinate {

/// Named channels of an image file (no movie, no camera RAW), rows at a time. Files stored by rows (EXR, TIFF, PNG) are read without the rest.
class ImageRowReader {
 public:
  /// @throws IoError if it is missing, no image, or lacks a channel (naming those there are).
  ImageRowReader(std::filesystem::path path, const std::vector<std::string>& channels);
  ~ImageRowReader();
  ImageRowReader(const ImageRowReader&) = delete;
  ImageRowReader& operator=(const ImageRowReader&) = delete;

  [[nodiscard]] int width() const;
  [[nodiscard]] int height() const;
  /// Rows [begin, end), raw values, the channels in the order asked for. @throws IoError if they are damaged or hold NaN or infinity.
  [[nodiscard]] ImageF read(int begin, int end);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// write_color() by rows: equal rows give the bytes that it writes, but the picture is never in memory. The file is whole or absent.
class ColorRowWriter {
 public:
  /// @throws UsageError on an unknown extension; CannotComplete if it cannot be written.
  ColorRowWriter(const std::filesystem::path& path, int width, int height, const std::string& key = "");
  ~ColorRowWriter();
  ColorRowWriter(const ColorRowWriter&) = delete;
  ColorRowWriter& operator=(const ColorRowWriter&) = delete;

  /// Which write() is to be called: 8-bit sRGB codes, or (.exr) linear values.
  [[nodiscard]] bool takes_codes() const;
  /// The next rows. @param codes  3 a pixel; whole rows. @throws InvalidInput on others; CannotComplete.
  void write(std::span<const std::uint8_t> codes);
  /// @param linear  3 a pixel; finite, at most 65504.
  void write(std::span<const float> linear);
  /// After the last row. @throws CannotComplete, InvalidInput if rows are missing.
  void finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The extension of an image that holds 8-bit codes when write_color() writes it.
[[nodiscard]] bool is_coded_image(const std::filesystem::path& path);

}  // namespace patinate
