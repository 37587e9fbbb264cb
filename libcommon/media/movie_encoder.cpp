#include <algorithm>
#include <cstddef>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include "libcommon/media/libav.h"
#include "patinate/core/error.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
#include <libswscale/swscale.h>
}

namespace patinate::media {

namespace {

constexpr const char* kCommentName = "comment";

/// The first that libavcodec has is taken.
std::vector<const char*> encoders_of(const std::string& extension) {
  if (extension == ".mp4") return {"libx264", "mpeg4"};
  return {"libvpx-vp9", "libvpx"};
}

struct OutputDeleter {
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
using OwnedOutput = std::unique_ptr<T, OutputDeleter>;

/// H.264 or VP9 by libavcodec.
class EncodedMovie final : public MovieEncoder {
 public:
  explicit EncodedMovie(const MovieFormat& format)
      : shown_path_(format.shown_path),
        width_(format.width),
        height_(format.height),
        encoders_(encoders_of(format.extension)) {
    const std::filesystem::path& path = format.path;
    AVFormatContext* file = nullptr;
    check(avformat_alloc_output_context2(&file, nullptr, nullptr, path.c_str()), "there is no such format");
    file_.reset(file);
    file_->flags |= AVFMT_FLAG_BITEXACT;  // No dates, versions or random numbers.
    if (!format.comment.empty()) av_dict_set(&file_->metadata, kCommentName, format.comment.c_str(), 0);
    open_encoder(format.fps);
    stream_ = avformat_new_stream(file_.get(), nullptr);
    if (stream_ == nullptr) throw std::bad_alloc();
    check(avcodec_parameters_from_context(stream_->codecpar, encoder_.get()), "the encoder failed");
    stream_->time_base = encoder_->time_base;
    stream_->avg_frame_rate = encoder_->framerate;
    check(avio_open(&file_->pb, path.c_str(), AVIO_FLAG_WRITE), "cannot be written");
    check(avformat_write_header(file_.get(), nullptr), "cannot be written");
    packet_.reset(av_packet_alloc());
    frame_ = blank_frame(encoder_->pix_fmt);
    source_ = blank_frame(AV_PIX_FMT_RGB24);
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
    fill_source(codes);
    check(av_frame_make_writable(frame_.get()), "not enough memory");
    sws_scale(scaler_.get(), source_->data, source_->linesize, 0, source_->height, frame_->data, frame_->linesize);
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

  void open_encoder(double fps) {
    const AVCodec* codec = nullptr;
    for (const char* name : encoders_) {
      if (codec == nullptr) codec = avcodec_find_encoder_by_name(name);
    }
    if (codec == nullptr) {
      throw CannotComplete(shown_path_ + ": libavcodec has no encoder " + encoders_.front() +
                           " here; use another extension or image files");
    }
    encoder_.reset(avcodec_alloc_context3(codec));
    encoder_->width = width_ + width_ % 2;
    encoder_->height = height_ + height_ % 2;
    encoder_->pix_fmt = AV_PIX_FMT_YUV420P;
    encoder_->framerate = av_d2q(fps, 1'000'000);
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

  /// A frame whose memory is defined to its end: libswscale reads, and libx264 codes, more than the picture.
  [[nodiscard]] OwnedOutput<AVFrame> blank_frame(AVPixelFormat format) const {
    OwnedOutput<AVFrame> frame(av_frame_alloc());
    if (!frame) throw std::bad_alloc();
    frame->format = format;
    frame->width = encoder_->width;
    frame->height = encoder_->height;
    check(av_frame_get_buffer(frame.get(), 0), "not enough memory");
    for (const AVBufferRef* buffer : frame->buf) {
      if (buffer != nullptr) std::fill_n(buffer->data, buffer->size, std::uint8_t{0});
    }
    return frame;
  }

  /// The picture, with its last column and row repeated up to even sizes.
  void fill_source(const ImageU8& codes) {
    for (int y = 0; y < source_->height; ++y) {
      std::uint8_t* row = source_->data[0] + std::ptrdiff_t{y} * source_->linesize[0];
      for (int x = 0; x < source_->width; ++x) {
        const auto from = codes.pixel(std::min(x, codes.width() - 1), std::min(y, codes.height() - 1));
        row = std::copy(from.begin(), from.end(), row);
      }
    }
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
  std::vector<const char*> encoders_;
  OwnedOutput<AVFormatContext> file_;
  OwnedOutput<AVCodecContext> encoder_;
  AVStream* stream_ = nullptr;
  OwnedOutput<AVFrame> source_;  ///< R, G, B.
  OwnedOutput<AVFrame> frame_;   ///< Frame as the encoder takes it.
  OwnedOutput<AVPacket> packet_;
  OwnedOutput<SwsContext> scaler_;
  std::int64_t num_pictures_ = 0;
};

}  // namespace

std::unique_ptr<MovieEncoder> create_movie(const MovieFormat& format) {
  av_log_set_level(AV_LOG_QUIET);
  return std::make_unique<EncodedMovie>(format);
}

std::string movie_comment(const std::filesystem::path& path) {
  av_log_set_level(AV_LOG_QUIET);
  AVFormatContext* file = nullptr;
  AVDictionary* limits = nullptr;  // Anything may lie there: only what create_movie() makes is looked into.
  av_dict_set(&limits, "format_whitelist", "mov,mp4,m4a,3gp,3g2,mj2,matroska,webm", 0);
  av_dict_set(&limits, "protocol_whitelist", "file", 0);
  const int error_code = avformat_open_input(&file, path.c_str(), nullptr, &limits);
  av_dict_free(&limits);
  if (error_code < 0) return "";
  const AVDictionaryEntry* entry = av_dict_get(file->metadata, kCommentName, nullptr, 0);
  std::string comment = entry == nullptr ? "" : entry->value;
  avformat_close_input(&file);
  return comment;
}

}  // namespace patinate::media
