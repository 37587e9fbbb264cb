/// \file
/// Pictures over time as a movie: .mp4 (H.264), .webm (VP9) or an animated .gif.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "patinate/core/options.h"
#include "patinate/core/run_control.h"
#include "patinate/image/image.h"

namespace patinate {

/// Settings of write_movie().
struct MovieOptions {
  double fps = 25.0;  ///< Pictures per second; (0, 120]. A .gif rounds the time of a picture to 0.01 s.
};
void describe(OptionVisitor& v, MovieOptions& o);

/// {".mp4", ".webm", ".gif"}.
[[nodiscard]] const std::vector<std::string>& movie_extensions();

/// Writes a movie picture by picture: memory does not grow with their number. The file is whole or absent. Equal
/// pictures give equal bytes, for any number of threads (each encoder runs on one).
/// @param path     Its extension decides the format.
/// @param picture  Called for 0 ... num_pictures - 1 in order: linear RGB, all of one size. The last column and row are
/// repeated
///                 where H.264 and VP9 want even sizes.
/// @param key      Content key, kept in the file.
/// @throws InvalidInput if there is no picture, sizes differ, a size is outside [2, 8192], or an option is out of
/// range; ParseError on another extension; CannotComplete if this build has no encoder or it cannot be written;
/// Canceled.
void write_movie(const std::filesystem::path& path, int num_pictures, const std::function<ImageF(int)>& picture,
                 const MovieOptions& options = {}, const std::string& key = "", const RunControl& control = {});
/// Writes a movie from sRGB codes with 3 channels: a quarter of the memory, plus the encoder's pictures (H.264: about
/// 60 pictures of 1.5 bytes per pixel).
void write_coded_movie(const std::filesystem::path& path, int num_pictures, const std::function<ImageU8(int)>& picture,
                       const MovieOptions& options = {}, const std::string& key = "", const RunControl& control = {});

/// The content key in a movie of write_movie(); "" if it is absent, carries none, or is no movie.
[[nodiscard]] std::string read_movie_key(const std::filesystem::path& path);

}  // namespace patinate
