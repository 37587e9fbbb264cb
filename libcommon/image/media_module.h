/// \file
/// What the module `patinate-media` does: all image formats but PNG and EXR by OpenImageIO, writing of movies by
/// libavformat. Those two bring 260 libraries, so the module is loaded when first needed (core/module.h), unless the
/// program links the library `patinate::media`, which is the same code. Inside of image input and output only.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "libcommon/image/image_source.h"
#include "patinate/image/image.h"

namespace patinate {

/// A movie that pictures are added to, all of one size.
class MovieEncoder {
 public:
  virtual ~MovieEncoder() = default;
  /// @param codes  3 channels. @throws InvalidInput if it differs in size; CannotComplete.
  virtual void add(const ImageU8& codes) = 0;
  /// @throws CannotComplete
  virtual void finish() = 0;
};

/// Format of the encoded movie.
struct MovieFormat {
  std::filesystem::path path;  ///< Where it is written.
  std::string shown_path;      ///< For messages.
  std::string extension;       ///< ".mp4" or ".webm".
  int width = 0;
  int height = 0;
  double fps = 25.0;
  std::string comment;  ///< Kept in the file; "" = none.
};

/// Raise the number in kMediaEntry with every change of this class or of a type that it takes or gives. Its functions
/// may be called from several threads, each object it makes from one at a time. They throw patinate's errors, which
/// programs catch by type as if their own code threw them.
class MediaModule {
 public:
  virtual ~MediaModule() = default;
  /// Any image, RAW or movie. @param path  For messages. @param name  By which it is opened, without a question mark.
  /// @param has_raw_color  CMYK and L*a*b* are given as the file has them.
  /// @throws IoError if it is none that can be read.
  [[nodiscard]] virtual std::unique_ptr<ImageSource> open_image(const std::filesystem::path& path,
                                                                const std::filesystem::path& name,
                                                                bool has_raw_color) = 0;
  /// Works as create_encoder(), which asks this for what is neither PNG nor EXR; but those too.
  [[nodiscard]] virtual std::unique_ptr<ImageEncoder> create_encoder(const EncodedFormat& format, ByteSink& sink) = 0;
  /// @throws CannotComplete if there is no encoder or it cannot be written.
  [[nodiscard]] virtual std::unique_ptr<MovieEncoder> create_movie(const MovieFormat& format) = 0;
  /// @param sink  Outlives it. @throws CannotComplete
  [[nodiscard]] virtual std::unique_ptr<MovieEncoder> create_gif(const std::string& shown_path, double fps,
                                                                 ByteSink& sink) = 0;
  /// The comment in a movie of create_movie(); "" if there is none, or it is no such movie.
  [[nodiscard]] virtual std::string movie_comment(const std::filesystem::path& path) = 0;
};

/// The module, loaded by the first call. Thread-safe. @throws CannotComplete naming its file if it cannot be loaded.
[[nodiscard]] MediaModule& media_module();
/// The function of the module that gives it: `MediaModule* patinate_media_3()`. The number is that of this interface.
inline constexpr const char* kMediaEntry = "patinate_media_3";

}  // namespace patinate
