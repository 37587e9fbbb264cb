#include "patinate/output/movie.h"

#include <algorithm>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "libcommon/core/file_name.h"
#include "libcommon/core/files.h"
#include "libcommon/image/media_module.h"
#include "libcommon/image/watched_file.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"

namespace patinate {

namespace {

constexpr std::string_view kKeyPrefix = "patinate_key=";

std::string extension_of(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  const std::vector<std::string>& all = movie_extensions();
  if (std::find(all.begin(), all.end(), extension) != all.end()) return extension;
  throw ParseError(path.string() + ": is no movie; expected a name that ends in .mp4, .webm or .gif");
}

/// The movie that is written, and what is left to do when it is.
class MovieFile {
 public:
  MovieFile(std::filesystem::path path, const std::filesystem::path& shown_path, const ImageU8& first,
            const MovieOptions& options, std::string key)
      : path_(std::move(path)), shown_path_(shown_path.string()), key_(std::move(key)) {
    constexpr int kLeast = 2, kMost = 8192;
    if (std::min(first.width(), first.height()) < kLeast || std::max(first.width(), first.height()) > kMost) {
      throw InvalidInput(shown_path_ + ": a movie of " + std::to_string(first.width()) + " x " +
                         std::to_string(first.height()) + " pixels; expected 2 to 8192 along each side");
    }
    const std::string extension = extension_of(path_);
    if (extension == ".gif") {
      disk_ = std::make_unique<WatchedFile>(path_);
      encoder_ = media_module().create_gif(shown_path_, options.fps, *disk_);
    } else {
      encoder_ = media_module().create_movie({.path = path_,
                                              .shown_path = shown_path_,
                                              .extension = extension,
                                              .width = first.width(),
                                              .height = first.height(),
                                              .fps = options.fps,
                                              .comment = key_.empty() ? "" : comment()});
    }
  }

  void add(const ImageU8& codes) {
    encoder_->add(codes);
    check(true);
  }

  void finish() {
    encoder_->finish();
    if (disk_) finish_gif();
  }

 private:
  [[nodiscard]] std::string comment() const { return std::string(kKeyPrefix) + key_; }

  /// GIF keeps no metadata: the key goes into a comment block before the last byte.
  void finish_gif() {
    disk_->close();
    check(true);
    std::string bytes = read_file(path_);
    check(bytes.ends_with(';'));
    if (key_.empty()) return;
    const std::string text = comment();
    bytes.pop_back();
    bytes += std::string("\x21\xfe") + static_cast<char>(text.size()) + text + std::string(1, '\0') + ";";
    bool is_written = true;
    try {
      write_atomically(path_, bytes);
    } catch (const CannotComplete&) {
      is_written = false;  // said with the name that the user gave
    }
    check(is_written);
  }

  /// The writer of GIFs does not see a full disk.
  void check(bool is_good) const {
    if (!is_good || (disk_ && disk_->has_failed())) {
      throw CannotComplete(shown_path_ + ": cannot be written; is the disk full?");
    }
  }

  std::filesystem::path path_;
  std::string shown_path_;
  std::string key_;
  std::unique_ptr<WatchedFile> disk_;  ///< File of a GIF; outlives its encoder.
  std::unique_ptr<MovieEncoder> encoder_;
};

std::string gif_comment(const std::filesystem::path& path) {
  constexpr std::uint64_t kMaxBytes = std::uint64_t{1} << 31;
  const std::string bytes = read_file(path, kMaxBytes);
  const std::size_t at = bytes.rfind(kKeyPrefix);
  if (at == std::string::npos || bytes.size() - at > 256) return "";
  const std::string tail = bytes.substr(at + kKeyPrefix.size());
  return tail.substr(0, tail.find('\0'));
}

}  // namespace

void describe(OptionVisitor& v, MovieOptions& o) {
  Range range = above(0);
  range.high = 120.0;
  v.visit({"fps", "Pictures of a movie per second", "", range}, o.fps);
}

const std::vector<std::string>& movie_extensions() {
  static const std::vector<std::string> extensions{".mp4", ".webm", ".gif"};
  return extensions;
}

void write_coded_movie(const std::filesystem::path& path, int num_pictures, const std::function<ImageU8(int)>& picture,
                       const MovieOptions& options, const std::string& key, const RunControl& control) {
  check_ranges(options);
  (void)extension_of(path);
  if (num_pictures < 1) throw InvalidInput(path.string() + ": a movie needs a picture");
  write_atomically(path, [&](const std::filesystem::path& temporary) {
    std::unique_ptr<MovieFile> movie;
    for (int i = 0; i < num_pictures; ++i) {
      control.throw_if_stopped();
      const ImageU8 image = picture(i);
      if (!movie) movie = std::make_unique<MovieFile>(temporary, path, image, options, key);
      movie->add(image);
      control.report((i + 1.0) / (num_pictures + 1.0));
    }
    movie->finish();
  });
  control.report(1.0);
}

void write_movie(const std::filesystem::path& path, int num_pictures, const std::function<ImageF(int)>& picture,
                 const MovieOptions& options, const std::string& key, const RunControl& control) {
  write_coded_movie(
      path, num_pictures, [&](int i) { return srgb8_from_linear(picture(i)); }, options, key, control);
}

std::string read_movie_key(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return "";
  if (extension_of(path) == ".gif") return gif_comment(path);
  const std::string comment = media_module().movie_comment(path);
  return comment.starts_with(kKeyPrefix) ? comment.substr(kKeyPrefix.size()) : "";
}

}  // namespace patinate
