#include "patinate/image/image_io.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <mutex>
#include <new>
#include <numeric>
#include <string_view>

#include "libcommon/core/file_name.h"
#include "libcommon/core/files.h"
#include "libcommon/image/decoded_image.h"
#include "libcommon/image/decoder_process.h"
#include "libcommon/image/image_decoder.h"
#include "libcommon/image/image_rows.h"
#include "libcommon/image/image_source.h"
#include "libcommon/image/mask_pixels.h"
#include "libcommon/image/watched_file.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

DecodedImage read_raw(const std::filesystem::path& path) try {
  if (is_decoded_apart(path)) {
    DecoderProcess process(path);
    return decoded(process.read(0), process.info(), path);
  }
  ImageDecoder decoder(path);
  const CodedImage coded = decoder.read(0);
  return decoded(coded, decoder.first_info(), path);
} catch (const std::bad_alloc&) {
  throw CannotComplete(path.string() + ": does not fit into memory; use a smaller image, or fewer threads");
}

/// Encoded in memory: that the disk is full, write_atomically() notices.
void write_pixels(const std::filesystem::path& path, const EncodedFormat& format, const void* values) {
  write_atomically(path, encoded(format, values));
}

constexpr float kLargestHalf = 65504.0f;

EncodedFormat exr_format(const std::filesystem::path& path, int width, int height,
                         const std::vector<std::string>& channels, ExrDepth depth, const std::string& key) {
  const auto values = depth == ExrDepth::Half ? EncodedFormat::Values::Half : EncodedFormat::Values::Float;
  return {.name = path.string(), .width = width, .height = height, .channels = channels, .values = values, .key = key};
}

EncodedFormat code_format(const std::filesystem::path& path, int width, int height, int channels,
                          const std::string& key) {
  return {.name = path.string(),
          .width = width,
          .height = height,
          .channels = std::vector<std::string>(static_cast<std::size_t>(channels)),
          .key = key};
}

}  // namespace

std::vector<std::pair<std::string, std::string>> ImageFacts::named() const {
  std::vector<std::pair<std::string, std::string>> all{
      {"color", color}, {"orientation", orientation}, {"alpha", alpha}, {"window", window}, {"layer", layer},
      {"page", page},   {"not_used", problem}};
  std::erase_if(all, [](const auto& fact) { return fact.second.empty(); });
  return all;
}

bool ImageInfo::has_alpha() const {
  return std::any_of(channels.begin(), channels.end(),
                     [&](const std::string& name) { return name == "A" || is_color_channel(name, color_layer, "A"); });
}

ImageInfo probe_image(const std::filesystem::path& path) {
  return is_decoded_apart(path) ? DecoderProcess(path).info() : ImageDecoder(path).info();
}

ImageF read_color(const std::filesystem::path& path, const Response& response) {
  const DecodedImage raw = read_raw(path);
  if (!raw.color_problem.empty()) throw IoError(path.string(), raw.color_problem);
  return color_of(raw, response);
}

ImageF read_gray(const std::filesystem::path& path, const std::string& channel) {
  const DecodedImage raw = read_raw(path);
  if (!channel.empty() && channel_index(raw, channel) < 0)
    throw IoError(path.string(), "has no channel `" + channel + "`");
  return channel.empty() ? gray_of(raw) : channel_of(raw, channel);
}

ImageF read_channels(const std::filesystem::path& path, const std::vector<std::string>& channels) {
  const DecodedImage raw = read_raw(path);
  std::vector<int> source;
  for (const std::string& name : channels) {
    const int index = channel_index(raw, name);
    if (index < 0) {
      const std::string there =
          std::accumulate(raw.channels.begin(), raw.channels.end(), std::string(),
                          [](std::string a, const std::string& b) { return a.append(" ").append(b); });
      throw IoError(path.string(), "has no channel `" + name + "`; there are:" + there);
    }
    source.push_back(index);
  }
  ImageF picked(raw.values.width(), raw.values.height(), static_cast<int>(channels.size()));
  for (int y = 0; y < picked.height(); ++y) {
    for (int x = 0; x < picked.width(); ++x) {
      for (int c = 0; c < picked.channels(); ++c) {
        picked.at(x, y, c) = raw.values.at(x, y, source[c]);
      }
    }
  }
  return picked;
}

ImageU8 read_mask(const std::filesystem::path& path) try {
  return mask_of(read_raw(path));
} catch (const InvalidInput& e) {
  throw IoError(path.string(), e.what());
}

namespace {

void write_values(const std::filesystem::path& path, const ImageF& image, EncodedFormat format) {
  const auto& channels = format.channels;
  if (image.empty() || static_cast<int>(channels.size()) != image.channels()) {
    throw InvalidInput(path.string() + ": an image of " + std::to_string(image.channels()) + " channels was given " +
                       std::to_string(channels.size()) + " names");
  }
  for (float v : image.values()) {
    if (!std::isfinite(v) || (format.values == EncodedFormat::Values::Half && std::abs(v) > kLargestHalf)) {
      throw InvalidInput(path.string() + ": a value is NaN, infinite or too large to be stored");
    }
  }
  write_pixels(path, format, image.data());
}

}  // namespace

void write_exr(const std::filesystem::path& path, const ImageF& image, const std::vector<std::string>& channels,
               ExrDepth depth, const std::string& key) {
  write_values(path, image, exr_format(path, image.width(), image.height(), channels, depth, key));
}

void write_scaled_exr(const std::filesystem::path& path, const ImageF& map, const ValueScale& scale,
                      const std::string& key) {
  if (!std::isfinite(scale.low) || !std::isfinite(scale.high))
    throw InvalidInput(path.string() + ": what 0 and 1 stand for must be finite");
  EncodedFormat format = exr_format(path, map.width(), map.height(), {"Y"}, ExrDepth::Float, key);
  format.scale = scale;
  write_values(path, map, std::move(format));
}

void write_codes(const std::filesystem::path& path, const ImageU8& codes, const std::string& key) {
  write_pixels(path, code_format(path, codes.width(), codes.height(), codes.channels(), key), codes.data());
}

void write_srgb8(const std::filesystem::path& path, const ImageF& linear, const std::string& key) {
  write_codes(path, srgb8_from_linear(linear), key);
}

bool is_coded_image(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  if (extension == ".exr") return false;
  constexpr std::array<std::string_view, 5> kCoded{".png", ".jpg", ".jpeg", ".tif", ".tiff"};
  if (std::find(kCoded.begin(), kCoded.end(), extension) != kCoded.end()) return true;
  throw ParseError(path.string() + ": unknown image format; use .png, .jpg, .tif or .exr");
}

void write_color(const std::filesystem::path& path, const ImageF& linear, const std::string& key) {
  if (is_coded_image(path)) {
    write_srgb8(path, linear, key);
  } else {
    write_exr(path, linear, {"R", "G", "B"}, ExrDepth::Half, key);
  }
}

struct ImageRowWriter::Impl {
  std::filesystem::path path;
  int width, height;
  std::size_t num_channels;
  ExrDepth depth;
  bool takes_codes;
  AtomicFile place;
  WatchedFile file;
  std::unique_ptr<ImageEncoder> encoder;
  int row = 0;

  Impl(const std::filesystem::path& target, int w, int h, const RowFormat& format)
      : path(target),
        width(w),
        height(h),
        num_channels(format.channels.size()),
        depth(format.depth),
        takes_codes(is_coded_image(target)),
        place(target),
        file(place.temporary()) {
    EncodedFormat encoded = takes_codes ? code_format(path, width, height, static_cast<int>(num_channels), format.key)
                                        : exr_format(path, width, height, format.channels, depth, format.key);
    encoded.unit = format.unit;
    encoded.num_threads = format.num_threads;
    watched([&] { encoder = create_encoder(encoded, file); });
  }

  /// A failure of the disk is the reason for whatever the encoder says then.
  template <class Work>
  void watched(const Work& work) {
    try {
      work();
    } catch (const CannotComplete&) {
      if (!file.has_failed()) throw;
    }
    if (file.has_failed()) {
      throw CannotComplete(path.string() + ": cannot be written; is the folder writable and the disk not full?");
    }
  }

  void write(const void* values, std::size_t size) {
    const std::size_t row_size = num_channels * static_cast<std::size_t>(width);
    const std::size_t num_rows = size / row_size;
    if (size == 0 || size % row_size != 0 || num_rows > static_cast<std::size_t>(height - row)) {
      throw InvalidInput(path.string() + ": rows of " + std::to_string(width) +
                         " pixels are expected, and no more than there are");
    }
    watched([&] { encoder->write(static_cast<int>(num_rows), values); });
    row += static_cast<int>(num_rows);
  }

  void finish() {
    watched([&] {
      encoder->finish();
      file.close();
    });
    place.finish();
  }
};

ImageRowWriter::ImageRowWriter(const std::filesystem::path& path, int width, int height, const RowFormat& format)
    : impl_(std::make_unique<Impl>(path, width, height, format)) {}
ImageRowWriter::~ImageRowWriter() = default;

bool ImageRowWriter::takes_codes() const { return impl_->takes_codes; }

void ImageRowWriter::write(std::span<const std::uint8_t> codes) {
  if (!impl_->takes_codes) throw InvalidInput(impl_->path.string() + ": takes values");
  impl_->write(codes.data(), codes.size());
}

void ImageRowWriter::write(std::span<const float> values) {
  if (impl_->takes_codes) throw InvalidInput(impl_->path.string() + ": takes codes");
  const float largest = impl_->depth == ExrDepth::Half ? kLargestHalf : std::numeric_limits<float>::max();
  for (float v : values) {
    if (!(std::abs(v) <= largest))
      throw InvalidInput(impl_->path.string() + ": a value is NaN, infinite or too large to be stored");
  }
  impl_->write(values.data(), values.size());
}

void ImageRowWriter::finish() {
  if (impl_->row != impl_->height) throw InvalidInput(impl_->path.string() + ": rows are missing");
  impl_->finish();
}

}  // namespace patinate
