/// \file
/// The frames of a file that holds many (a movie, an animated WebP or GIF), decoded in order however many ask.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "libcommon/image/decoded_image.h"

namespace patinate {

/// Decodes in a child process (decoder_process.h), which is started by the first read(). Thread-safe.
///
/// As long as frames are asked for roughly in the order of `wanted`, each is decoded once: what lies before the one
/// that is asked for waits in memory (a bounded number, however long the movie) until it is asked for too. Going back
/// is possible and costs what the format makes it cost.
class FrameStream {
 public:
  /// @param wanted  Frames that will be asked for, rising; each usually once.
  FrameStream(std::filesystem::path path, std::vector<int> wanted);
  ~FrameStream();
  FrameStream(const FrameStream&) = delete;
  FrameStream& operator=(const FrameStream&) = delete;

  /// @throws IoError naming the file if there is no such frame, it is damaged, or the decoder crashes or hangs;
  /// CannotComplete if no process can be started.
  [[nodiscard]] DecodedImage read(int frame);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace patinate
