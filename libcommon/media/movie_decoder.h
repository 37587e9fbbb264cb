/// \file
/// Frames of a movie by libavcodec: every one of them, in the order in which they are shown. Inside of media
/// only.
#pragma once

#include <filesystem>
#include <memory>

#include "libcommon/image/image_decoder.h"

namespace patinate {

/// An open movie. Frames are cheap to read in order; others begin at the key frame before.
///
/// Color is RGB as the movie says (matrix and range), where it does not say as players take it: ITU-R 601 below 720
/// rows, else 709. HLG, PQ and wide gamuts become light (movie_color.h). Pictures are turned as the file says, and have
/// square pixels.
class MovieDecoder {
 public:
  /// @throws IoError if it is missing, holds no movie that can be decoded, or is too large.
  explicit MovieDecoder(std::filesystem::path path);
  ~MovieDecoder();
  MovieDecoder(const MovieDecoder&) = delete;
  MovieDecoder& operator=(const MovieDecoder&) = delete;

  /// With the frames counted: those that the file holds, whatever its header says.
  [[nodiscard]] const ImageInfo& info() const;
  /// 8 or 16 bits or floats, RGB or RGBA. @throws IoError if there is no such frame or it is damaged.
  [[nodiscard]] CodedImage read(int frame);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace patinate
