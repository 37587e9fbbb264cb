#include "libcommon/image/image_decoder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "libcommon/core/read_limit.h"
#include "libcommon/core/regular_file.h"
#include "libcommon/core/text.h"
#include "libcommon/image/decoder_process.h"
#include "libcommon/image/image_source.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

/// Orientations 5 to 8 exchange width and height.
[[nodiscard]] constexpr bool is_transposing(int orientation) { return orientation >= 5; }

/// The picture upright. @param orientation  EXIF's, [1, 8].
CodedImage upright(CodedImage stored, int orientation) {
  if (orientation <= 1 || orientation > 8) return stored;
  CodedImage turned = stored;
  const bool is_transposed = is_transposing(orientation);
  if (is_transposed) std::swap(turned.width, turned.height);
  // Where the stored picture is read from its end, along its own axes.
  const bool is_x_back = orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
  const bool is_y_back = orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
  const std::size_t pixel = static_cast<std::size_t>(stored.channels) * bytes_per_value(stored.type);
  std::byte* to = turned.bytes.data();
  for (int y = 0; y < turned.height; ++y) {
    for (int x = 0; x < turned.width; ++x, to += pixel) {
      int from_x = is_transposed ? y : x, from_y = is_transposed ? x : y;
      if (is_x_back) from_x = stored.width - 1 - from_x;
      if (is_y_back) from_y = stored.height - 1 - from_y;
      const std::size_t at =
          static_cast<std::size_t>(from_y) * static_cast<std::size_t>(stored.width) + static_cast<std::size_t>(from_x);
      std::memcpy(to, stored.bytes.data() + at * pixel, pixel);
    }
  }
  return turned;
}

/// Takes alpha out of color where the file has it multiplied in (EXR by its standard): of a layer, or of all channels.
void unassociate(ImageF& values, int alpha, const std::vector<std::string>& channels, const std::string& layer) {
  std::vector<bool> is_shared;
  for (const std::string& name : channels) is_shared.push_back(name.starts_with(layer));
  for (int y = 0; y < values.height(); ++y) {
    for (int x = 0; x < values.width(); ++x) {
      const auto pixel = values.pixel(x, y);
      const float a = pixel[alpha];
      for (std::size_t c = 0; c < pixel.size(); ++c) {
        if (static_cast<int>(c) != alpha && a > 0.0f && is_shared[c]) pixel[c] /= a;
      }
    }
  }
}

/// Codes as their share of the largest one.
template <class Code>
void scale_codes(const std::vector<std::byte>& bytes, ImageF& values) {
  constexpr float kStep = 1.0f / static_cast<float>(std::numeric_limits<Code>::max());
  const std::byte* from = bytes.data();
  for (float& value : values.values()) {
    Code code = 0;
    std::memcpy(&code, from, sizeof code);
    value = static_cast<float>(code) * kStep;
    from += sizeof code;
  }
}

/// By what is in it, whatever its name; the names of movies and RAW decide themselves.
std::unique_ptr<ImageSource> open_source(const std::filesystem::path& path) {
  constexpr std::string_view kPng = "\x89PNG\r\n\x1a\n", kExr = "\x76\x2f\x31\x01";
  std::array<char, 8> start{};
  std::ifstream(path, std::ios::binary).read(start.data(), start.size());
  const std::string_view magic(start.data(), start.size());
  std::unique_ptr<ImageSource> source;
  if (!is_decoded_apart(path) && magic == kPng) source = open_png(path);
  if (!is_decoded_apart(path) && magic.starts_with(kExr)) source = open_exr(path);
  return source ? std::move(source) : open_worded(path);
}

}  // namespace

DecodedImage decoded(const CodedImage& coded, const ImageInfo& info, const std::filesystem::path& path) {
  DecodedImage image{ImageF(coded.width, coded.height, coded.channels),
                     info.channels,
                     info.is_integer && !info.is_raw,
                     info.color_layer,
                     info.encoding,
                     info.color_problem};
  switch (coded.type) {
    case CodedImage::Type::UInt8:
      scale_codes<std::uint8_t>(coded.bytes, image.values);
      break;
    case CodedImage::Type::UInt16:
      scale_codes<std::uint16_t>(coded.bytes, image.values);
      break;
    case CodedImage::Type::Float:
      std::memcpy(image.values.data(), coded.bytes.data(), coded.bytes.size());
      break;
  }
  for (float v : image.values.values()) {
    if (!std::isfinite(v)) throw IoError(path.string(), "holds NaN or infinite values; every value must be a number");
  }
  if (coded.associated_alpha >= 0) unassociate(image.values, coded.associated_alpha, info.channels, info.color_layer);
  return image;
}

void set_color_words(ImageInfo& info, const FileWords& words) {
  const bool is_rgb = std::find(info.channels.begin(), info.channels.end(), "R") != info.channels.end();
  SaidColor color = said_color(words, is_rgb ? 3 : 1, !info.is_integer);
  info.facts.color = color.name;
  info.encoding = std::move(color.encoding);
  for (const std::string& problem : words.problems)
    info.facts.problem += (info.facts.problem.empty() ? "" : "; ") + problem;
  if (!color.problem.empty())
    info.facts.problem += (info.facts.problem.empty() ? "" : "; ") + color.problem + " and is not used";
}

struct ImageDecoder::Impl {
  std::filesystem::path path;
  std::unique_ptr<ImageSource> source;
  ImageInfo info;  ///< Facts of the picture upright.
  int orientation = 1;
  std::optional<CodedImage> whole;  ///< A picture that had to be turned, of which rows are asked for.
};

ImageDecoder::ImageDecoder(std::filesystem::path path) : impl_(std::make_unique<Impl>()) {
  check_may_read(path);
  require_regular_file(path);
  std::error_code error;
  if (std::filesystem::file_size(path, error) == 0)
    throw IoError(path.string(), "is empty (0 bytes); give an image file");
  impl_->source = open_source(path);
  impl_->info = impl_->source->first_info();
  impl_->orientation = impl_->source->orientation();
  if (impl_->orientation != 1) impl_->info.facts.orientation = orientation_text(impl_->orientation);
  if (is_transposing(impl_->orientation)) std::swap(impl_->info.width, impl_->info.height);
  const ImageInfo& info = impl_->info;
  if (info.width < 1 || info.height < 1 || info.width > kMaxImageSide || info.height > kMaxImageSide) {
    throw IoError(path.string(), "has an unusable size; at most 65536 x 65536 pixels");
  }
  if (info.channels.empty() || info.channels.size() > static_cast<std::size_t>(kMaxImageChannels)) {
    throw IoError(path.string(), "has no or more than 64 channels");
  }
  impl_->path = std::move(path);
}

ImageDecoder::~ImageDecoder() = default;

ImageInfo ImageDecoder::first_info() const { return impl_->info; }

ImageInfo ImageDecoder::info() {
  ImageInfo info = first_info();
  info.num_frames = impl_->source->count_frames();
  return info;
}

CodedImage ImageDecoder::read_rows(int begin, int end) {
  if (!(begin >= 0 && begin < end && end <= impl_->info.height)) {
    throw IoError(impl_->path.string(), "has no rows " + std::to_string(begin) + " to " + std::to_string(end - 1));
  }
  if (impl_->orientation == 1) return impl_->source->read_rows(begin, end);
  if (!impl_->whole) impl_->whole = read(0);
  const CodedImage& whole = *impl_->whole;
  const std::size_t row = whole.bytes.size() / static_cast<std::size_t>(whole.height);
  const auto at = [&](int y) { return whole.bytes.begin() + static_cast<std::ptrdiff_t>(row) * y; };
  return {whole.width, end - begin, whole.channels, whole.type, whole.associated_alpha, {at(begin), at(end)}};
}

CodedImage ImageDecoder::read(int frame) {
  const ImageInfo& info = impl_->info;
  const std::uint64_t num_values =
      static_cast<std::uint64_t>(info.width) * static_cast<std::uint64_t>(info.height) * info.channels.size();
  if (num_values > kMaxImageValues) {
    throw IoError(impl_->path.string(), "is " + size_text(info.width, info.height) + " pixels of " +
                                            std::to_string(info.channels.size()) + " channels, " +
                                            std::to_string((num_values * sizeof(float)) >> 30) +
                                            " GiB when decoded; at most 4 GiB can be read at once");
  }
  return upright(impl_->source->read(frame), impl_->orientation);
}

}  // namespace patinate
