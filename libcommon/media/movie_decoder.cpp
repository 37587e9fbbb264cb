#include "libcommon/media/movie_decoder.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "libcommon/media/movie_color.h"
#include "libcommon/media/movie_geometry.h"
#include "patinate/core/error.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/display.h>
#include <libavutil/dovi_meta.h>
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

/// Color that the container states, where the pictures say nothing.
struct ContainerColor {
  AVColorPrimaries primaries = AVCOL_PRI_UNSPECIFIED;
  AVColorTransferCharacteristic transfer = AVCOL_TRC_UNSPECIFIED;
  AVColorSpace matrix = AVCOL_SPC_UNSPECIFIED;
};

void complete_color(AVCodecParameters& movie, const ContainerColor& container) {
  if (movie.color_primaries == AVCOL_PRI_UNSPECIFIED) movie.color_primaries = container.primaries;
  if (movie.color_trc == AVCOL_TRC_UNSPECIFIED) movie.color_trc = container.transfer;
  if (movie.color_space == AVCOL_SPC_UNSPECIFIED) movie.color_space = container.matrix;
}

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
  std::vector<ContainerColor> colors;
  for (unsigned i = 0; i < opened->nb_streams; ++i) {
    const AVCodecParameters& p = *opened->streams[i]->codecpar;
    colors.push_back({p.color_primaries, p.color_trc, p.color_space});
  }
  if (avformat_find_stream_info(opened, nullptr) < 0) throw IoError(path.string(), problem);
  const int index = av_find_best_stream(opened, AVMEDIA_TYPE_VIDEO, -1, -1, nullptr, 0);
  if (index < 0) throw IoError(path.string(), "holds no pictures");
  for (unsigned i = 0; i < opened->nb_streams; ++i) {
    if (static_cast<int>(i) != index) opened->streams[i]->discard = AVDISCARD_ALL;
  }
  out.stream = opened->streams[index];
  if (static_cast<std::size_t>(index) < colors.size()) complete_color(*out.stream->codecpar, colors[index]);
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

/// When frames are shown, in s from the first one on, where the container's table gives all of them one duration: no
/// other need be read for it.
std::vector<double> times_of_table(const OpenFile& open, int count) {
  std::optional<std::int64_t> last, step;
  for (int i = 0; i < avformat_index_get_entries_count(open.stream); ++i) {
    const AVIndexEntry* entry = avformat_index_get_entry(open.stream, i);
    if ((entry->flags & AVINDEX_DISCARD_FRAME) != 0) continue;
    if (last && step && entry->timestamp - *last != *step) return {};
    if (last) step = entry->timestamp - *last;
    last = entry->timestamp;
  }
  if (step && *step <= 0) return {};
  std::vector<double> times;
  for (int i = 0; i < count; ++i)
    times.push_back(static_cast<double>(i * step.value_or(1)) * open.stream->time_base.num /
                    open.stream->time_base.den);
  return times;
}

std::vector<double> seconds_of(const FrameTimes& times, AVRational unit) {
  std::vector<double> seconds;
  if (!times.is_known) return seconds;
  for (std::int64_t shown : times.shown)
    seconds.push_back(static_cast<double>(shown - times.shown.front()) * unit.num / unit.den);
  return seconds;
}

/// Dolby Vision whose pictures mean nothing without its own metadata.
void check_dolby_vision(const AVStream* stream) {
  std::size_t size = 0;
  const auto* dovi = reinterpret_cast<const AVDOVIDecoderConfigurationRecord*>(
      av_stream_get_side_data(stream, AV_PKT_DATA_DOVI_CONF, &size));
  constexpr int kAlone = 5;
  if (dovi != nullptr && size >= sizeof *dovi && dovi->dv_profile == kAlone)
    throw InvalidInput("is Dolby Vision of profile 5, which is not read; convert it to HLG or BT.709");
}

/// Format of the decoded pixels: 8 or 16 bits, with alpha where the movie has a plane of it.
struct Target {
  AVPixelFormat format = AV_PIX_FMT_RGB24;
  int channels = 3;
  CodedImage::Type type = CodedImage::Type::UInt8;
};

Target target_of(int format, bool is_light) {
  const AVPixFmtDescriptor* d = av_pix_fmt_desc_get(static_cast<AVPixelFormat>(format));
  if (d == nullptr) return {};
  const bool is_deep = is_light || d->comp[0].depth > 8;
  const bool has_alpha = (d->flags & AV_PIX_FMT_FLAG_ALPHA) != 0 && (d->flags & AV_PIX_FMT_FLAG_PLANAR) != 0;
  if (has_alpha)
    return {is_deep ? AV_PIX_FMT_RGBA64 : AV_PIX_FMT_RGBA, 4,
            is_deep ? CodedImage::Type::UInt16 : CodedImage::Type::UInt8};
  return {is_deep ? AV_PIX_FMT_RGB48 : AV_PIX_FMT_RGB24, 3,
          is_deep ? CodedImage::Type::UInt16 : CodedImage::Type::UInt8};
}

int matrix_of(AVColorSpace matrix, AVColorPrimaries primaries, int height) {
  constexpr int kRowsOfHd = 720;
  switch (matrix) {
    case AVCOL_SPC_BT709:
      return SWS_CS_ITU709;
    case AVCOL_SPC_FCC:
      return SWS_CS_FCC;
    case AVCOL_SPC_SMPTE240M:
      return SWS_CS_SMPTE240M;
    case AVCOL_SPC_BT2020_NCL:
      return SWS_CS_BT2020;
    case AVCOL_SPC_BT470BG:
    case AVCOL_SPC_SMPTE170M:
      return SWS_CS_ITU601;
    default:
      if (primaries == AVCOL_PRI_BT2020) return SWS_CS_BT2020;
      return height >= kRowsOfHd ? SWS_CS_ITU709 : SWS_CS_ITU601;
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
  std::optional<MovieLight> light;  ///< Nothing: codes stay codes.
  DisplayTurn turn;
  int width = 0, height = 0;  ///< Size as decoded.
  int scaled_width = 0;       ///< With square pixels, not yet turned.
  int next = 0;               ///< The frame that the decoder gives next.
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
    width = p.width;
    height = p.height;
    try {
      check_dolby_vision(open.stream);
      light = movie_light(p);
      turn = display_turn(open.stream);
      scaled_width = square_width(open.file.get(), open.stream, width);
    } catch (const InvalidInput& e) {
      fail(e.what());
    }
    if (scaled_width > kMaxImageSide) fail("has an unusable size; at most 65536 x 65536 pixels");
    info.width = turn.is_swapped ? height : scaled_width;
    info.height = turn.is_swapped ? scaled_width : height;
    info.channels = {"R", "G", "B"};
    if (target_of(p.format, light.has_value()).channels == 4) info.channels.emplace_back("A");
    info.is_integer = !light.has_value();
    info.facts.color = movie_color_text(p);
    const AVRational rate =
        open.stream->avg_frame_rate.num > 0 ? open.stream->avg_frame_rate : open.stream->r_frame_rate;
    if (rate.num > 0 && rate.den > 0) info.frame_rate = static_cast<double>(rate.num) / rate.den;
    const std::optional<int> count = count_of_table(open);
    if (count) info.frame_times_s = times_of_table(open, *count);
    if (info.frame_times_s.empty()) times = scan(path);
    info.num_frames = count ? *count : times->count;
    if (info.num_frames < 1) fail("holds no pictures");
    if (info.frame_times_s.empty() && times->count == info.num_frames)
      info.frame_times_s = seconds_of(*times, open.stream->time_base);
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
    const std::int64_t target = times->shown[wanted];
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
    const Target target = target_of(frame->format, light.has_value());
    if (frame->width != width || frame->height != height || target.channels != static_cast<int>(info.channels.size()))
      fail(where + "differs from the first one in size or channels");
    if ((frame->flags & AV_FRAME_FLAG_CORRUPT) != 0 || frame->decode_error_flags != 0)
      fail(where + "is damaged or truncated");
    const AVFrameSideData* matrix = av_frame_get_side_data(frame.get(), AV_FRAME_DATA_DISPLAYMATRIX);
    if (matrix != nullptr && turn_of_matrix(reinterpret_cast<const std::int32_t*>(matrix->data)) != turn)
      fail(where +
           "is shown at another rotation than its file says; convert the movie, so that its pictures lie upright");
    CodedImage image = scaled(target, where);
    if (light) image = as_light(image);
    return turn.is_none() ? std::move(image) : turned(image, turn);
  }

  /// The frame in R, G, B, with square pixels.
  CodedImage scaled(const Target& target, const std::string& where) {
    scaler.reset(sws_getCachedContext(scaler.release(), frame->width, frame->height,
                                      static_cast<AVPixelFormat>(frame->format), scaled_width, frame->height,
                                      target.format, SWS_BICUBIC | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INT | SWS_BITEXACT,
                                      nullptr, nullptr, nullptr));
    if (!scaler) fail("its colors cannot be converted");
    const AVCodecParameters& p = *open.stream->codecpar;
    const AVColorSpace said = frame->colorspace == AVCOL_SPC_UNSPECIFIED ? p.color_space : frame->colorspace;
    const int* matrix = sws_getCoefficients(matrix_of(said, p.color_primaries, frame->height));
    (void)sws_setColorspaceDetails(scaler.get(), matrix, frame->color_range == AVCOL_RANGE_JPEG ? 1 : 0, matrix, 1, 0,
                                   1 << 16, 1 << 16);
    CodedImage image{scaled_width, frame->height, target.channels, target.type, -1, {}};
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

  [[nodiscard]] CodedImage as_light(const CodedImage& image) const {
    CodedImage out{image.width, image.height, image.channels, CodedImage::Type::Float, -1, {}};
    const std::size_t num_pixels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    out.bytes.resize(num_pixels * static_cast<std::size_t>(image.channels) * sizeof(float));
    light->convert(reinterpret_cast<const std::uint16_t*>(image.bytes.data()), num_pixels, image.channels,
                   reinterpret_cast<float*>(out.bytes.data()));
    return out;
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
