/// \file
/// Images of which only some rows are in memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "patinate/image/image.h"
#include "patinate/image/image_io.h"

namespace patinate {

/// Named channels of an image file (no movie, no camera RAW), rows at a time. Files stored by rows (EXR, TIFF, PNG) are
/// read without the rest.
class ImageRowReader {
 public:
  /// @throws IoError if it is missing, no image, or lacks a channel (naming those there are).
  ImageRowReader(std::filesystem::path path, const std::vector<std::string>& channels);
  ~ImageRowReader();
  ImageRowReader(const ImageRowReader&) = delete;
  ImageRowReader& operator=(const ImageRowReader&) = delete;

  [[nodiscard]] int width() const;
  [[nodiscard]] int height() const;
  /// Rows [begin, end), raw values, the channels in the order asked for. @throws IoError if they are damaged or hold
  /// NaN or infinity.
  [[nodiscard]] ImageF read(int begin, int end);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Rows that an EXR compresses together: so many, times twice the threads, are to be written at once.
inline constexpr int kExrChunkRows = 16;

/// Format of a file's rows.
struct RowFormat {
  std::vector<std::string> channels = {"R", "G", "B"};  ///< Names in an EXR; other files have 1 or 3.
  ExrDepth depth = ExrDepth::Half;
  std::string key = "";   ///< Content key.
  std::string unit = "";  ///< Unit of the values in an EXR, said by its header; "" = none.
  int num_threads = 1;    ///< That compress an EXR's rows, kExrChunkRows each; > 0. No byte depends on it.
};

/// Images by rows: equal rows give the bytes of write_color() (or write_codes(), write_exr()), but the picture is never
/// in memory. The file is whole or absent.
class ImageRowWriter {
 public:
  /// @throws ParseError on an unknown extension; CannotComplete if it cannot be written.
  ImageRowWriter(const std::filesystem::path& path, int width, int height, const RowFormat& format = {});
  ~ImageRowWriter();
  ImageRowWriter(const ImageRowWriter&) = delete;
  ImageRowWriter& operator=(const ImageRowWriter&) = delete;

  /// Tells which write() is to be called: 8-bit codes, or (.exr) values.
  [[nodiscard]] bool takes_codes() const;
  /// The next rows. @param codes  Of all channels; whole rows. @throws InvalidInput on others; CannotComplete.
  void write(std::span<const std::uint8_t> codes);
  /// @param values  Finite, with ExrDepth::Half at most 65504.
  void write(std::span<const float> values);
  /// After the last row. @throws CannotComplete, InvalidInput if rows are missing.
  void finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The extension of an image that holds 8-bit codes when write_color() writes it.
[[nodiscard]] bool is_coded_image(const std::filesystem::path& path);

}  // namespace patinate
