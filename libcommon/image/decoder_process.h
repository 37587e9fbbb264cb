/// \file
/// Decoding in a child process: camera RAW and movies come through large decoders that a damaged or hostile file can
/// crash, hang or bloat; there, that costs one clear error and nothing else.
#pragma once

#include <filesystem>
#include <memory>

#include "libcommon/image/image_decoder.h"

namespace patinate {

/// Whether the extension is one of camera RAW or of a movie.
[[nodiscard]] bool is_decoded_apart(const std::filesystem::path& path);
/// Whether it is one of a movie.
[[nodiscard]] bool is_movie(const std::filesystem::path& path);

/// One file, open in a running `patinate-decode` (tools/decode), which is found beside this program, in
/// $PATINATE_DECODER, or on the PATH. Its memory and its time for a frame are limited. Not thread-safe.
class DecoderProcess {
 public:
  /// Starts the process and opens the file.
  /// @throws IoError naming the file if it is missing, no image, or its decoder crashes, hangs or needs too much
  /// memory; CannotComplete if no process can be started.
  explicit DecoderProcess(std::filesystem::path path);
  /// Ends the process.
  ~DecoderProcess();
  DecoderProcess(const DecoderProcess&) = delete;
  DecoderProcess& operator=(const DecoderProcess&) = delete;

  [[nodiscard]] const ImageInfo& info() const { return info_; }
  /// Reads as ImageDecoder::read() does. @throws IoError
  [[nodiscard]] CodedImage read(int frame);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  ImageInfo info_;
};

}  // namespace patinate
