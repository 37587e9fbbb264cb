#include "libcommon/image/image_decoder.h"

#include <OpenImageIO/imageio.h>

#include <cmath>
#include <mutex>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>

#include "libcommon/core/read_limit.h"
#include "libcommon/core/regular_file.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

/// OpenImageIO's messages may span lines; ours are one.
std::string one_line(std::string text) {
  const std::size_t end = text.find('\n');
  if (end != std::string::npos) text.resize(end);
  return text;
}

/// Color as the file has it, not multiplied by alpha; RAW as light. Other formats ignore the hints for RAW.
OIIO::ImageSpec open_hints() {
  OIIO::ImageSpec hints;
  hints.attribute("oiio:UnassociatedAlpha", 1);
  hints.attribute("raw:ColorSpace", "sRGB-linear");
  hints.attribute("raw:auto_bright", 0);
  hints.attribute("raw:adjust_maximum_thr", 0.0f);  // It would move the white point with each picture's content.
  hints.attribute("raw:use_camera_wb", 0);
  hints.attribute("raw:use_camera_matrix", 1);
  hints.attribute("raw:HighlightMode", 0);
  hints.attribute("raw:user_flip", 0);
  hints.attribute("raw:Demosaic", "AHD");
  return hints;
}

/// What OpenImageIO says of pixels that it nevertheless counts as read: rows that are missing (TIFF, JPEG, IFF), but
/// for JPEG also what cameras do that costs no pixel. @param problem  Lines of text.
bool is_loss(const std::string& problem, std::string_view format) {
  if (format != "jpeg") return !problem.empty();
  std::istringstream lines(problem);
  for (std::string line; std::getline(lines, line);) {
    const auto says = [&](const char* words) { return line.find(words) != std::string::npos; };
    if (says("Premature end") || (says("Corrupt JPEG data") && !says("extraneous bytes"))) return true;
  }
  return false;
}

OIIO::TypeDesc type_desc(CodedImage::Type type) {
  switch (type) {
    case CodedImage::Type::UInt8:
      return OIIO::TypeDesc::UINT8;
    case CodedImage::Type::UInt16:
      return OIIO::TypeDesc::UINT16;
    case CodedImage::Type::Float:
      break;
  }
  return OIIO::TypeDesc::FLOAT;
}

/// Takes alpha out of color where the file has it multiplied in (EXR by its standard).
void unassociate(ImageF& values, int alpha) {
  for (int y = 0; y < values.height(); ++y) {
    for (int x = 0; x < values.width(); ++x) {
      const auto pixel = values.pixel(x, y);
      const float a = pixel[static_cast<std::size_t>(alpha)];
      for (std::size_t c = 0; c < pixel.size(); ++c) {
        if (static_cast<int>(c) != alpha && a > 0.0f) pixel[c] /= a;
      }
    }
  }
}

}  // namespace

void configure_image_library() {
  static std::once_flag flag;
  std::call_once(flag, [] {
    // One thread inside OpenImageIO: our loops are parallel already, and its pool outlives a caller's settings.
    OIIO::attribute("threads", 1);
    OIIO::attribute("exr_threads", -1);
    OIIO::attribute("limits:channels", kMaxImageChannels);
    OIIO::attribute("limits:imagesize_MB", 32768);
  });
}

std::size_t bytes_per_value(CodedImage::Type type) { return type_desc(type).size(); }

DecodedImage decoded(const CodedImage& coded, const ImageInfo& info, const std::filesystem::path& path) {
  DecodedImage image{ImageF(coded.width, coded.height, coded.channels), info.channels, info.is_integer && !info.is_raw};
  OIIO::convert_image(coded.channels, coded.width, coded.height, 1, coded.bytes.data(), type_desc(coded.type),
                      OIIO::AutoStride, OIIO::AutoStride, OIIO::AutoStride, image.values.data(), OIIO::TypeDesc::FLOAT,
                      OIIO::AutoStride, OIIO::AutoStride, OIIO::AutoStride);
  for (float v : image.values.values()) {
    if (!std::isfinite(v)) throw IoError(path.string(), "holds NaN or infinite values; every value must be a number");
  }
  if (coded.associated_alpha >= 0) unassociate(image.values, coded.associated_alpha);
  return image;
}

struct ImageDecoder::Impl {
  std::filesystem::path path;
  std::unique_ptr<OIIO::ImageInput> input;

  /// @throws IoError unless pixels were read, all of them. @param where  "image 3 " or "".
  void check(bool is_read, const std::string& where) const {
    const std::string problem = input->geterror();
    if (is_read && !is_loss(problem, input->format_name())) return;
    throw IoError(path.string(), where + "is damaged or truncated (" + one_line(problem) + ")");
  }
};

ImageDecoder::ImageDecoder(std::filesystem::path path) : impl_(std::make_unique<Impl>()) {
  configure_image_library();
  check_may_read(path);
  require_regular_file(path);
  std::error_code error;
  if (std::filesystem::file_size(path, error) == 0)
    throw IoError(path.string(), "is empty (0 bytes); give an image file");
  const OIIO::ImageSpec hints = open_hints();
  impl_->input = OIIO::ImageInput::open(path.string(), &hints);
  if (!impl_->input) {
    (void)OIIO::geterror();
    throw IoError(path.string(), "is no readable image (damaged, or not an image format that is known)");
  }
  const OIIO::ImageSpec& spec = impl_->input->spec();
  if (spec.width < 1 || spec.height < 1 || spec.width > kMaxImageSide || spec.height > kMaxImageSide ||
      spec.depth > 1) {
    throw IoError(path.string(), "has an unusable size; at most 65536 x 65536 pixels");
  }
  if (spec.nchannels < 1 || spec.nchannels > kMaxImageChannels) {
    throw IoError(path.string(), "has no or more than 64 channels");
  }
  impl_->path = std::move(path);
}

ImageDecoder::~ImageDecoder() = default;

ImageInfo ImageDecoder::first_info() const {
  OIIO::ImageInput& input = *impl_->input;
  const OIIO::ImageSpec spec = input.spec(0, 0);
  ImageInfo info;
  info.width = spec.width;
  info.height = spec.height;
  info.channels = spec.channelnames;
  info.is_integer = !spec.format.is_floating_point();
  info.is_raw = std::string_view(input.format_name()) == "raw";
  info.date_time = spec.get_string_attribute("Exif:DateTimeOriginal", spec.get_string_attribute("DateTime"));
  if (info.date_time == kNoImageDate) info.date_time.clear();
  info.key = spec.get_string_attribute(kImageKeyAttribute);
  const std::string description = spec.get_string_attribute("ImageDescription");
  if (info.key.empty() && description.starts_with(kImageKeyDescription)) {
    info.key = description.substr(std::string_view(kImageKeyDescription).size());
  }
  // Set for movies as a rational number.
  const float rate = spec.get_float_attribute("FramesPerSecond");
  if (std::isfinite(rate) && rate > 0.0f) info.frame_rate = static_cast<double>(rate);
  int rational[2] = {0, 0};
  if (spec.getattribute("FramesPerSecond", OIIO::TypeRational, rational) && rational[0] > 0 && rational[1] > 0) {
    info.frame_rate = static_cast<double>(rational[0]) / rational[1];
  }
  return info;
}

ImageInfo ImageDecoder::info() {
  ImageInfo info = first_info();
  OIIO::ImageInput& input = *impl_->input;
  while (info.num_frames < kMaxImageFrames && input.seek_subimage(info.num_frames, 0)) ++info.num_frames;
  (void)input.geterror();
  return info;
}

namespace {

/// What is to be decoded, its bytes made.
CodedImage blank(const OIIO::ImageSpec& spec, int height) {
  CodedImage coded{spec.width, height, spec.nchannels, CodedImage::Type::Float, -1, {}};
  if (spec.format == OIIO::TypeDesc::UINT8) coded.type = CodedImage::Type::UInt8;
  if (spec.format == OIIO::TypeDesc::UINT16) coded.type = CodedImage::Type::UInt16;
  const int alpha = spec.channelindex("A");  // The GIF reader's own number points behind the channels.
  if (alpha >= 0 && spec.get_int_attribute("oiio:UnassociatedAlpha") == 0) coded.associated_alpha = alpha;
  coded.bytes.resize(static_cast<std::size_t>(coded.width) * static_cast<std::size_t>(height) *
                     static_cast<std::size_t>(coded.channels) * bytes_per_value(coded.type));
  return coded;
}

}  // namespace

CodedImage ImageDecoder::read_rows(int begin, int end) {
  OIIO::ImageInput& input = *impl_->input;
  const OIIO::ImageSpec spec = input.spec(0, 0);
  if (!(begin >= 0 && begin < end && end <= spec.height)) {
    throw IoError(impl_->path.string(), "has no rows " + std::to_string(begin) + " to " + std::to_string(end - 1));
  }
  CodedImage coded = blank(spec, end - begin);
  const bool is_read = input.read_scanlines(0, 0, spec.y + begin, spec.y + end, 0, 0, spec.nchannels,
                                            type_desc(coded.type), coded.bytes.data());
  impl_->check(is_read, "");
  return coded;
}

CodedImage ImageDecoder::read(int frame) {
  OIIO::ImageInput& input = *impl_->input;
  const std::string where = frame == 0 ? "" : "image " + std::to_string(frame) + " ";
  if (frame < 0 || !input.seek_subimage(frame, 0)) {
    throw IoError(impl_->path.string(), "has no image " + std::to_string(frame) + " that can be read");
  }
  const OIIO::ImageSpec spec = input.spec();
  const OIIO::ImageSpec first = input.spec(0, 0);
  if (spec.width != first.width || spec.height != first.height || spec.nchannels != first.nchannels) {
    throw IoError(impl_->path.string(), where + "differs from the first one in size or channels");
  }
  const auto num_values = static_cast<std::uint64_t>(spec.width) * static_cast<std::uint64_t>(spec.height) *
                          static_cast<std::uint64_t>(spec.nchannels);
  if (num_values > kMaxImageValues) {
    throw IoError(impl_->path.string(), "is " + size_text(spec.width, spec.height) + " pixels of " +
                                            std::to_string(spec.nchannels) + " channels, " +
                                            std::to_string((num_values * sizeof(float)) >> 30) +
                                            " GiB when decoded; at most 4 GiB can be read at once");
  }
  CodedImage coded = blank(spec, spec.height);
  impl_->check(input.read_image(frame, 0, 0, spec.nchannels, type_desc(coded.type), coded.bytes.data()), where);
  return coded;
}

}  // namespace patinate
