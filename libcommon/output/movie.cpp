#include "patinate/output/movie.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cctype>
#include <memory>
#include <new>

#include "libcommon/core/files.h"
#include "libcommon/image/watched_file.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
#include <libswscale/swscale.h>
}

namespace patinate {

namespace {

constexpr const char* kKeyName = "comment";
constexpr std::string_view kKeyPrefix = "patinate_key=";

struct Format {
  const char* extension;
  std::vector<const char*> encoders;  ///< The first that libavcodec has.
};

const std::vector<Format>& formats() {
  static const std::vector<Format> all{{".mp4", {"libx264", "mpeg4"}}, {".webm", {"libvpx-vp9", "libvpx"}}};
  return all;
}

std::string extension_of(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const std::vector<std::string>& all = movie_extensions();
  if (std::find(all.begin(), all.end(), extension) != all.end()) return extension;
  throw UsageError(path.string() + ": is no movie; expected a name that ends in .mp4, .webm or .gif");
}

const Format& format_of(const std::filesystem::path& path) {
  return *std::find_if(formats().begin(), formats().end(),
                       [e = extension_of(path)](const Format& f) { return e == f.extension; });
}

/// A movie file that pictures are added to.
class Movie {
 public:
  virtual ~Movie() = default;
  virtual void add(const ImageU8& codes) = 0;
  virtual void finish() = 0;
};

struct Deleter {
  void operator()(AVFormatContext* p) const {
    if (p->pb != nullptr) avio_closep(&p->pb);
    avformat_free_context(p);
  }
  void operator()(AVCodecContext* p) const { avcodec_free_context(&p); }
  void operator()(AVFrame* p) const { av_frame_free(&p); }
  void operator()(AVPacket* p) const { av_packet_free(&p); }
  void operator()(SwsContext* p) const { sws_freeContext(p); }
};
template <class T>
using Owned = std::unique_ptr<T, Deleter>;

/// H.264 or VP9 by libavcodec.
class EncodedMovie final : public Movie {
 public:
  EncodedMovie(const std::filesystem::path& path, const std::filesystem::path& shown_path, int width, int height,
               const MovieOptions& options, const std::string& key)
      : shown_path_(shown_path.string()), width_(width), height_(height), format_(format_of(path)) {
    AVFormatContext* file = nullptr;
    check(avformat_alloc_output_context2(&file, nullptr, nullptr, path.c_str()), "there is no such format");
    file_.reset(file);
    file_->flags |= AVFMT_FLAG_BITEXACT;  // No dates, versions or random numbers.
    if (!key.empty()) av_dict_set(&file_->metadata, kKeyName, (std::string(kKeyPrefix) + key).c_str(), 0);
    open_encoder(options);
    stream_ = avformat_new_stream(file_.get(), nullptr);
    if (stream_ == nullptr) throw std::bad_alloc();
    check(avcodec_parameters_from_context(stream_->codecpar, encoder_.get()), "the encoder failed");
    stream_->time_base = encoder_->time_base;
    stream_->avg_frame_rate = encoder_->framerate;
    check(avio_open(&file_->pb, path.c_str(), AVIO_FLAG_WRITE), "cannot be written");
    check(avformat_write_header(file_.get(), nullptr), "cannot be written");
    frame_.reset(av_frame_alloc());
    packet_.reset(av_packet_alloc());
    frame_->format = encoder_->pix_fmt;
    frame_->width = encoder_->width;
    frame_->height = encoder_->height;
    check(av_frame_get_buffer(frame_.get(), 0), "not enough memory");
    scaler_.reset(sws_getContext(encoder_->width, encoder_->height, AV_PIX_FMT_RGB24, encoder_->width, encoder_->height,
                                 encoder_->pix_fmt, SWS_BICUBIC | SWS_ACCURATE_RND | SWS_BITEXACT, nullptr, nullptr,
                                 nullptr));
    if (!scaler_) throw CannotComplete(shown_path_ + ": its colors cannot be converted");
    sws_setColorspaceDetails(scaler_.get(), sws_getCoefficients(SWS_CS_ITU709), 1, sws_getCoefficients(SWS_CS_ITU709),
                             0, 0, 1 << 16, 1 << 16);
  }

  void add(const ImageU8& codes) override {
    if (codes.width() != width_ || codes.height() != height_ || codes.channels() != 3) {
      throw InvalidInput(shown_path_ + ": a picture of a movie differs from the first in size");
    }
    const ImageU8 larger = is_even(codes) ? ImageU8() : padded(codes);
    const ImageU8& even = larger.empty() ? codes : larger;
    const std::uint8_t* planes[1] = {even.data()};
    const int strides[1] = {3 * even.width()};
    check(av_frame_make_writable(frame_.get()), "not enough memory");
    sws_scale(scaler_.get(), planes, strides, 0, even.height(), frame_->data, frame_->linesize);
    frame_->pts = num_pictures_++;
    encode(frame_.get());
  }

  void finish() override {
    encode(nullptr);
    check(av_write_trailer(file_.get()), "cannot be written");
    check(avio_closep(&file_->pb), "cannot be written; is the disk full?");
  }

 private:
  void check(int result, const char* problem) const {
    if (result < 0) throw CannotComplete(shown_path_ + ": " + problem);
  }

  void open_encoder(const MovieOptions& options) {
    const AVCodec* codec = nullptr;
    for (const char* name : format_.encoders) {
      if (codec == nullptr) codec = avcodec_find_encoder_by_name(name);
    }
    if (codec == nullptr) {
      throw CannotComplete(shown_path_ + ": libavcodec has no encoder " + format_.encoders.front() +
                           " here; use another extension or image files");
    }
    encoder_.reset(avcodec_alloc_context3(codec));
    encoder_->width = width_ + width_ % 2;
    encoder_->height = height_ + height_ % 2;
    encoder_->pix_fmt = AV_PIX_FMT_YUV420P;
    encoder_->framerate = av_d2q(options.fps, 1'000'000);
    encoder_->time_base = av_inv_q(encoder_->framerate);
    encoder_->thread_count = 1;  // Bytes depend on the number of threads.
    encoder_->flags |= AV_CODEC_FLAG_BITEXACT;
    encoder_->colorspace = AVCOL_SPC_BT709;
    encoder_->color_primaries = AVCOL_PRI_BT709;
    encoder_->color_trc = AVCOL_TRC_IEC61966_2_1;
    encoder_->color_range = AVCOL_RANGE_MPEG;
    if (file_->oformat->flags & AVFMT_GLOBALHEADER) encoder_->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    const std::string name = codec->name;
    if (name == "mpeg4") encoder_->global_quality = 2 * FF_QP2LAMBDA, encoder_->flags |= AV_CODEC_FLAG_QSCALE;
    av_opt_set(encoder_->priv_data, "crf", name == "libx264" ? "18" : "24", 0);
    av_opt_set(encoder_->priv_data, "preset", "medium", 0);
    av_opt_set(encoder_->priv_data, "cpu-used", "4", 0);
    check(avcodec_open2(encoder_.get(), codec, nullptr), "the encoder does not take pictures of this size");
  }

  [[nodiscard]] bool is_even(const ImageU8& codes) const {
    return codes.width() == encoder_->width && codes.height() == encoder_->height;
  }

  [[nodiscard]] ImageU8 padded(const ImageU8& codes) const {
    ImageU8 out(encoder_->width, encoder_->height, 3);
    for (int y = 0; y < out.height(); ++y) {
      for (int x = 0; x < out.width(); ++x) {
        const auto from = codes.pixel(std::min(x, codes.width() - 1), std::min(y, codes.height() - 1));
        std::copy(from.begin(), from.end(), out.pixel(x, y).begin());
      }
    }
    return out;
  }

  /// @param frame  nullptr at the end.
  void encode(const AVFrame* frame) {
    check(avcodec_send_frame(encoder_.get(), frame), "the encoder failed");
    while (true) {
      const int result = avcodec_receive_packet(encoder_.get(), packet_.get());
      if (result == AVERROR(EAGAIN) || result == AVERROR_EOF) return;
      check(result, "the encoder failed");
      if (packet_->duration == 0) packet_->duration = 1;
      av_packet_rescale_ts(packet_.get(), encoder_->time_base, stream_->time_base);
      packet_->stream_index = stream_->index;
      check(av_interleaved_write_frame(file_.get(), packet_.get()), "cannot be written; is the disk full?");
    }
  }

  std::string shown_path_;
  int width_;
  int height_;
  const Format& format_;
  Owned<AVFormatContext> file_;
  Owned<AVCodecContext> encoder_;
  AVStream* stream_ = nullptr;
  Owned<AVFrame> frame_;
  Owned<AVPacket> packet_;
  Owned<SwsContext> scaler_;
  std::int64_t num_pictures_ = 0;
};

/// Animated GIF by OpenImageIO, whose palettes follow each picture.
class Gif final : public Movie {
 public:
  Gif(const std::filesystem::path& path, const std::filesystem::path& shown_path, const MovieOptions& options,
      std::string key)
      : path_(path),
        shown_path_(shown_path.string()),
        fps_(static_cast<float>(options.fps)),
        key_(std::move(key)),
        disk_(path) {}

  void add(const ImageU8& codes) override {
    OIIO::ImageSpec spec(codes.width(), codes.height(), 3, OIIO::TypeDesc::UINT8);
    spec.attribute("FramesPerSecond", fps_);
    if (!file_) {
      file_ = OIIO::ImageOutput::create("gif");
      spec_ = spec;
      check(file_ && file_->set_ioproxy(static_cast<OIIO::Filesystem::IOProxy*>(disk_.proxy())) &&
            file_->open(path_.string(), spec, OIIO::ImageOutput::Create));
    } else {
      if (spec.width != spec_.width || spec.height != spec_.height) {
        throw InvalidInput(shown_path_ + ": a picture of a movie differs from the first in size");
      }
      check(file_->open(path_.string(), spec, OIIO::ImageOutput::AppendSubimage));
    }
    check(file_->write_image(OIIO::TypeDesc::UINT8, codes.data()));
  }

  /// GIF keeps no metadata: the key goes into a comment block before the last byte.
  void finish() override {
    check(file_->close());
    disk_.close();
    check(true);
    std::string bytes = read_file(path_);
    check(bytes.ends_with(';'));
    if (key_.empty()) return;
    const std::string comment = std::string(kKeyPrefix) + key_;
    bytes.pop_back();
    bytes += std::string("\x21\xfe") + static_cast<char>(comment.size()) + comment + std::string(1, '\0') + ";";
    bool is_written = true;
    try {
      write_atomically(path_, bytes);
    } catch (const CannotComplete&) {
      is_written = false;  // said with the name that the user gave
    }
    check(is_written);
  }

 private:
  void check(bool is_good) const {
    if (!is_good || disk_.has_failed()) throw CannotComplete(shown_path_ + ": cannot be written; is the disk full?");
  }
  std::filesystem::path path_;
  std::string shown_path_;
  float fps_;
  std::string key_;
  OIIO::ImageSpec spec_;
  WatchedFile disk_;  ///< OpenImageIO's writer does not see a full disk.
  std::unique_ptr<OIIO::ImageOutput> file_;
};

std::unique_ptr<Movie> open_movie(const std::filesystem::path& path, const std::filesystem::path& shown_path,
                                  const ImageU8& first, const MovieOptions& options, const std::string& key) {
  constexpr int kLeast = 2, kMost = 8192;
  if (std::min(first.width(), first.height()) < kLeast || std::max(first.width(), first.height()) > kMost) {
    throw InvalidInput(shown_path.string() + ": a movie of " + std::to_string(first.width()) + " x " +
                       std::to_string(first.height()) + " pixels; expected 2 to 8192 along each side");
  }
  if (extension_of(path) == ".gif") return std::make_unique<Gif>(path, shown_path, options, key);
  return std::make_unique<EncodedMovie>(path, shown_path, first.width(), first.height(), options, key);
}

std::string gif_comment(const std::filesystem::path& path) {
  constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 31;
  const std::string bytes = read_file(path, kMostBytes);
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
  av_log_set_level(AV_LOG_QUIET);
  write_atomically(path, [&](const std::filesystem::path& temporary) {
    std::unique_ptr<Movie> movie;
    for (int i = 0; i < num_pictures; ++i) {
      control.throw_if_stopped();
      const ImageU8 image = picture(i);
      if (!movie) movie = open_movie(temporary, path, image, options, key);
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
  av_log_set_level(AV_LOG_QUIET);
  if (extension_of(path) == ".gif") return gif_comment(path);
  AVFormatContext* file = nullptr;
  AVDictionary* limits = nullptr;  // Anything may lie there: only what write_movie() makes is looked into.
  av_dict_set(&limits, "format_whitelist", "mov,mp4,m4a,3gp,3g2,mj2,matroska,webm", 0);
  av_dict_set(&limits, "protocol_whitelist", "file", 0);
  const int error_code = avformat_open_input(&file, path.c_str(), nullptr, &limits);
  av_dict_free(&limits);
  if (error_code < 0) return "";
  std::string key;
  if (const AVDictionaryEntry* entry = av_dict_get(file->metadata, kKeyName, nullptr, 0)) {
    const std::string text = entry->value;
    if (text.starts_with(kKeyPrefix)) key = text.substr(kKeyPrefix.size());
  }
  avformat_close_input(&file);
  return key;
}

}  // namespace patinate
