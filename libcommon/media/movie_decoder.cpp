#include "libcommon/media/movie_decoder.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "patinate/core/error.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/pixdesc.h>
#include <libswscale/swscale.h>
}

namespace patinate {

namespace {

/// Playlists, which name other files, are none of them.
constexpr const char* kContainers =
    "mov,mp4,m4a,3gp,3g2,mj2,matroska,webm,avi,asf,ogg,mpeg,mpegvideo,mpegts,m4v,h264,hevc,flv";
/// Decoding so many frames that nobody asked for is cheaper than looking for a key frame.
constexpr int kNear = 48;

struct InputDeleter {
  void operator()(AVFormatContext* p) const { avformat_close_input(&p); }
  void operator()(AVCodecContext* p) const { avcodec_free_context(&p); }
  void operator()(AVFrame* p) const { av_frame_free(&p); }
  void operator()(AVPacket* p) const { av_packet_free(&p); }
  void operator()(SwsContext* p) const { sws_freeContext(p); }
};
template <class T>
using OwnedInput = std::unique_ptr<T, InputDeleter>;

struct OpenFile {
  OwnedInput<AVFormatContext> file;
  AVStream* stream = nullptr;
};

OpenFile open_movie(const std::filesystem::path& path) {
  const std::string problem = "is no readable image (damaged, or not a movie that is known)";
  AVDictionary* limits = nullptr;
  av_dict_set(&limits, "format_whitelist", kContainers, 0);
  av_dict_set(&limits, "protocol_whitelist", "file", 0);
  AVFormatContext* opened = nullptr;
  const int result = avformat_open_input(&opened, ("file:" + path.string()).c_str(), nullptr, &limits);
  av_dict_free(&limits);
  if (result < 0) throw IoError(path.string(), problem);
  OpenFile out{OwnedInput<AVFormatContext>(opened)};
  if (avformat_find_stream_info(opened, nullptr) < 0) throw IoError(path.string(), problem);
  const int index = av_find_best_stream(opened, AVMEDIA_TYPE_VIDEO, -1, -1, nullptr, 0);
  if (index < 0) throw IoError(path.string(), "holds no pictures");
  for (unsigned i = 0; i < opened->nb_streams; ++i) {
    if (static_cast<int>(i) != index) opened->streams[i]->discard = AVDISCARD_ALL;
  }
  out.stream = opened->streams[index];
  return out;
}

/// When the frames are shown, in the stream's unit; `is_known` is false where the file does not say it of each.
struct FrameTimes {
  std::vector<std::int64_t> shown, keys;  ///< Rising; `keys` of those at which decoding can begin.
  bool is_known = true;
  int count = 0;
};

/// Reads the whole file, without decoding.
FrameTimes scan(const std::filesystem::path& path) {
  const OpenFile open = open_movie(path);
  const OwnedInput<AVPacket> packet(av_packet_alloc());
  FrameTimes times;
  for (; av_read_frame(open.file.get(), packet.get()) >= 0; av_packet_unref(packet.get())) {
    const bool is_shown =
        packet->stream_index == open.stream->index && (packet->flags & AV_PKT_FLAG_DISCARD) == 0 && packet->size > 0;
    if (!is_shown || times.count == kMaxImageFrames) continue;
    ++times.count;
    times.is_known = times.is_known && packet->pts != AV_NOPTS_VALUE;
    times.shown.push_back(packet->pts);
    if ((packet->flags & AV_PKT_FLAG_KEY) != 0) times.keys.push_back(packet->pts);
  }
  std::sort(times.shown.begin(), times.shown.end());
  std::sort(times.keys.begin(), times.keys.end());
  times.is_known = times.is_known && std::adjacent_find(times.shown.begin(), times.shown.end()) == times.shown.end();
  return times;
}

/// The number of frames where the container keeps a table of all; others have to be read through.
std::optional<int> count_of_table(const OpenFile& open) {
  if (std::string_view(open.file->iformat->name).find("mp4") == std::string_view::npos || open.stream->nb_frames <= 0)
    return std::nullopt;
  int count = 0;
  for (int i = 0; i < avformat_index_get_entries_count(open.stream); ++i) {
    count +=
        (avformat_index_get_entry(open.stream, i)->flags & AVINDEX_DISCARD_FRAME) == 0;  // Cut away by an edit list.
  }
  return count > 0 ? std::optional(std::min(count, kMaxImageFrames)) : std::nullopt;
}

/// What pixels become: 8 or 16 bits, with alpha where the movie has a plane of it.
struct Target {
  AVPixelFormat format = AV_PIX_FMT_RGB24;
  int channels = 3;
  CodedImage::Type type = CodedImage::Type::UInt8;
};

Target target_of(int format) {
  const AVPixFmtDescriptor* d = av_pix_fmt_desc_get(static_cast<AVPixelFormat>(format));
  if (d == nullptr) return {};
  const bool is_deep = d->comp[0].depth > 8;
  const bool has_alpha = (d->flags & AV_PIX_FMT_FLAG_ALPHA) != 0 && (d->flags & AV_PIX_FMT_FLAG_PLANAR) != 0;
  if (has_alpha)
    return {is_deep ? AV_PIX_FMT_RGBA64 : AV_PIX_FMT_RGBA, 4,
            is_deep ? CodedImage::Type::UInt16 : CodedImage::Type::UInt8};
  return {is_deep ? AV_PIX_FMT_RGB48 : AV_PIX_FMT_RGB24, 3,
          is_deep ? CodedImage::Type::UInt16 : CodedImage::Type::UInt8};
}

int matrix_of(const AVFrame& frame) {
  constexpr int kRowsOfHd = 720;
  switch (frame.colorspace) {
    case AVCOL_SPC_BT709:
      return SWS_CS_ITU709;
    case AVCOL_SPC_FCC:
      return SWS_CS_FCC;
    case AVCOL_SPC_SMPTE240M:
      return SWS_CS_SMPTE240M;
    case AVCOL_SPC_BT2020_NCL:
    case AVCOL_SPC_BT2020_CL:
      return SWS_CS_BT2020;
    case AVCOL_SPC_BT470BG:
    case AVCOL_SPC_SMPTE170M:
      return SWS_CS_ITU601;
    default:
      return frame.height >= kRowsOfHd ? SWS_CS_ITU709 : SWS_CS_ITU601;
  }
}

}  // namespace

struct MovieDecoder::Impl {
  std::filesystem::path path;
  ImageInfo info;
  OpenFile open;
  OwnedInput<AVCodecContext> decoder;
  OwnedInput<AVPacket> packet{av_packet_alloc()};
  OwnedInput<AVFrame> frame{av_frame_alloc()};
  OwnedInput<SwsContext> scaler;
  std::optional<FrameTimes> times;
  int next = 0;  ///< The frame that the decoder gives next.
  bool is_drained = false;

  [[noreturn]] void fail(const std::string& problem) const { throw IoError(path.string(), problem); }

  /// At the first frame.
  void begin() {
    open = open_movie(path);
    const AVCodec* codec = avcodec_find_decoder(open.stream->codecpar->codec_id);
    if (codec == nullptr) fail("cannot be decoded; libavcodec has no decoder for it here");
    decoder.reset(avcodec_alloc_context3(codec));
    if (!decoder || avcodec_parameters_to_context(decoder.get(), open.stream->codecpar) < 0)
      fail("cannot be decoded; its header is damaged");
    decoder->pkt_timebase = open.stream->time_base;
    decoder->thread_count = 1;
    if (avcodec_open2(decoder.get(), codec, nullptr) < 0) fail("cannot be decoded; its header is damaged");
    next = 0;
    is_drained = false;
  }

  void read_header() {
    const AVCodecParameters& p = *open.stream->codecpar;
    if (p.width < 1 || p.height < 1 || p.width > kMaxImageSide || p.height > kMaxImageSide)
      fail("has an unusable size; at most 65536 x 65536 pixels");
    info.width = p.width;
    info.height = p.height;
    info.channels = {"R", "G", "B"};
    if (target_of(p.format).channels == 4) info.channels.emplace_back("A");
    info.is_integer = true;
    const AVRational rate =
        open.stream->avg_frame_rate.num > 0 ? open.stream->avg_frame_rate : open.stream->r_frame_rate;
    if (rate.num > 0 && rate.den > 0) info.frame_rate = static_cast<double>(rate.num) / rate.den;
    const std::optional<int> count = count_of_table(open);
    if (!count) times = scan(path);
    info.num_frames = count ? *count : times->count;
    if (info.num_frames < 1) fail("holds no pictures");
  }

  /// The next frame in the order in which they are shown. @returns false at the end.
  bool decode() {
    while (true) {
      av_frame_unref(frame.get());
      const int got = avcodec_receive_frame(decoder.get(), frame.get());
      if (got >= 0) return true;
      if (got != AVERROR(EAGAIN) || is_drained) return false;
      feed();
    }
  }

  /// One more packet, or the news that there is none: then the decoder gives what it held back.
  void feed() {
    while (av_read_frame(open.file.get(), packet.get()) >= 0) {
      const bool is_ours = packet->stream_index == open.stream->index && packet->size > 0;
      const int sent = is_ours ? avcodec_send_packet(decoder.get(), packet.get()) : 0;
      av_packet_unref(packet.get());
      if (sent < 0) fail("image " + std::to_string(next) + " is damaged or truncated");
      if (is_ours) return;
    }
    is_drained = true;
    (void)avcodec_send_packet(decoder.get(), nullptr);
  }

  /// Takes the decoder to the key frame before `wanted`. @returns whether the frame that was decoded is known to come
  /// at or before it
  bool seek(int wanted) {
    if (!times) times = scan(path);
    if (!times->is_known || times->keys.empty() || times->count != info.num_frames) return false;
    const std::int64_t target = times->shown[static_cast<std::size_t>(wanted)];
    const auto after = std::upper_bound(times->keys.begin(), times->keys.end(), target);
    if (after == times->keys.begin() ||
        av_seek_frame(open.file.get(), open.stream->index, *(after - 1), AVSEEK_FLAG_BACKWARD) < 0)
      return false;
    avcodec_flush_buffers(decoder.get());
    is_drained = false;
    while (decode()) {
      const auto at = std::lower_bound(times->shown.begin(), times->shown.end(), frame->best_effort_timestamp);
      if (at == times->shown.end() || *at != frame->best_effort_timestamp) return false;
      next = static_cast<int>(at - times->shown.begin());
      if (next >= wanted) return next == wanted;
    }
    return false;
  }

  /// Decodes `wanted`; afterwards it is in `frame`.
  void go_to(int wanted) {
    const bool is_near = wanted >= next && wanted - next <= kNear;
    if (is_near || !seek(wanted)) {
      if (!is_near) begin();
      for (; decode(); ++next) {
        if (next == wanted) break;
      }
      if (next != wanted || frame->width == 0) fail("image " + std::to_string(wanted) + " is damaged or truncated");
    }
    next = wanted + 1;
  }

  CodedImage coded(int number) {
    const std::string where = "image " + std::to_string(number) + " ";
    if (frame->width != info.width || frame->height != info.height)
      fail(where + "differs from the first one in size or channels");
    if ((frame->flags & AV_FRAME_FLAG_CORRUPT) != 0 || frame->decode_error_flags != 0)
      fail(where + "is damaged or truncated");
    const Target target = target_of(frame->format);
    if (target.channels != static_cast<int>(info.channels.size()))
      fail(where + "differs from the first one in size or channels");
    scaler.reset(sws_getCachedContext(scaler.release(), frame->width, frame->height,
                                      static_cast<AVPixelFormat>(frame->format), frame->width, frame->height,
                                      target.format, SWS_BICUBIC | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INT | SWS_BITEXACT,
                                      nullptr, nullptr, nullptr));
    if (!scaler) fail("its colors cannot be converted");
    const int* matrix = sws_getCoefficients(matrix_of(*frame));
    (void)sws_setColorspaceDetails(scaler.get(), matrix, frame->color_range == AVCOL_RANGE_JPEG ? 1 : 0, matrix, 1, 0,
                                   1 << 16, 1 << 16);
    CodedImage image{frame->width, frame->height, target.channels, target.type, -1, {}};
    const std::size_t row =
        static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.channels) * bytes_per_value(image.type);
    // The scaler may write a little beyond a row's end.
    constexpr std::size_t kBeyond = 64;
    image.bytes.resize(row * static_cast<std::size_t>(image.height) + kBeyond);
    std::uint8_t* planes[4] = {reinterpret_cast<std::uint8_t*>(image.bytes.data()), nullptr, nullptr, nullptr};
    const int strides[4] = {static_cast<int>(row), 0, 0, 0};
    if (sws_scale(scaler.get(), frame->data, frame->linesize, 0, frame->height, planes, strides) != frame->height)
      fail(where + "is damaged or truncated");
    image.bytes.resize(image.bytes.size() - kBeyond);
    return image;
  }
};

MovieDecoder::MovieDecoder(std::filesystem::path path) : impl_(std::make_unique<Impl>()) {
  impl_->path = std::move(path);
  std::error_code error;
  if (!std::filesystem::exists(impl_->path, error)) impl_->fail("does not exist");
  if (!std::filesystem::is_regular_file(impl_->path, error)) impl_->fail("is no regular file; give a movie");
  if (std::filesystem::file_size(impl_->path, error) == 0) impl_->fail("is empty (0 bytes); give a movie");
  av_log_set_level(AV_LOG_QUIET);
  impl_->begin();
  impl_->read_header();
}

MovieDecoder::~MovieDecoder() = default;

const ImageInfo& MovieDecoder::info() const { return impl_->info; }

CodedImage MovieDecoder::read(int frame) {
  if (frame < 0 || frame >= impl_->info.num_frames)
    impl_->fail("has no image " + std::to_string(frame) + " that can be read");
  try {
    impl_->go_to(frame);
    return impl_->coded(frame);
  } catch (...) {
    impl_->next = kMaxImageFrames;  // Whatever is asked for next is looked for again.
    throw;
  }
}

}  // namespace patinate
