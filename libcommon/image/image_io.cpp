#include "libcommon/image/image_io.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <array>
#include <cctype>
#include <memory>
#include <mutex>
#include <numeric>
#include <string_view>

#include "libcommon/core/error.h"
#include "libcommon/core/files.h"

namespace patinate {

namespace {

constexpr int kMaxSide = 65536;
constexpr int kMaxChannels = 64;
constexpr const char* kKeyAttribute = "patinate:key";
constexpr const char* kKeyDescription = "patinate key ";
/// Fixed, so that equal images give equal bytes: OpenImageIO would write the current time.
constexpr const char* kNoDate = "1970:01:01 00:00:00";

/// One thread inside OpenImageIO: our loops are parallel already, and its pool outlives a caller's settings.
void configure_once() {
  static std::once_flag flag;
  std::call_once(flag, [] {
    OIIO::attribute("threads", 1);
    OIIO::attribute("exr_threads", -1);
    OIIO::attribute("limits:channels", kMaxChannels);
    OIIO::attribute("limits:imagesize_MB", 32768);
  });
}

/// OpenImageIO's messages may span lines; ours are one.
std::string one_line(std::string text) {
  const std::size_t end = text.find('\n');
  if (end != std::string::npos) text.resize(end);
  return text;
}

std::unique_ptr<OIIO::ImageInput> open_image(const std::filesystem::path& path) {
  configure_once();
  std::error_code error;
  if (!std::filesystem::exists(path, error)) throw IoError(path.string(), "does not exist");
  if (std::filesystem::is_directory(path, error)) throw IoError(path.string(), "is a folder; give an image file");
  if (std::filesystem::file_size(path, error) == 0) throw IoError(path.string(), "is empty (0 bytes); give an image file");
  OIIO::ImageSpec config;
  config.attribute("oiio:UnassociatedAlpha", 1);  // Colour as the file has it, not multiplied by alpha.
  auto input = OIIO::ImageInput::open(path.string(), &config);
  if (!input) {
    (void)OIIO::geterror();
    throw IoError(path.string(), "is no readable image (damaged, or not an image format that is known)");
  }
  const OIIO::ImageSpec& spec = input->spec();
  if (spec.width < 1 || spec.height < 1 || spec.width > kMaxSide || spec.height > kMaxSide || spec.depth > 1) {
    throw IoError(path.string(), "has an unusable size; at most 65536 x 65536 pixels");
  }
  if (spec.nchannels < 1 || spec.nchannels > kMaxChannels) throw IoError(path.string(), "has no or more than 64 channels");
  return input;
}

struct RawImage {
  ImageF values;
  std::vector<std::string> channels;
  bool is_integer = true;
};

/// Takes alpha out of colour where the file has it multiplied in (EXR by its standard).
void unassociate(RawImage& raw, int alpha) {
  for (int y = 0; y < raw.values.height(); ++y) {
    for (int x = 0; x < raw.values.width(); ++x) {
      const auto pixel = raw.values.pixel(x, y);
      const float a = pixel[static_cast<std::size_t>(alpha)];
      for (std::size_t c = 0; c < pixel.size(); ++c) {
        if (static_cast<int>(c) != alpha && a > 0.0f) pixel[c] /= a;
      }
    }
  }
}

/// All channels, colour not multiplied by alpha; integer codes scaled to [0, 1].
RawImage read_raw(const std::filesystem::path& path) {
  const auto input = open_image(path);
  const OIIO::ImageSpec spec = input->spec();
  RawImage raw{ImageF(spec.width, spec.height, spec.nchannels), spec.channelnames, !spec.format.is_floating_point()};
  if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, raw.values.data())) {
    throw IoError(path.string(), "is damaged or truncated (" + one_line(input->geterror()) + ")");
  }
  (void)input->geterror();
  for (float v : raw.values.values()) {
    if (!std::isfinite(v)) throw IoError(path.string(), "holds NaN or infinite values; every value must be a number");
  }
  // A damaged file may name a channel that it does not have.
  const bool has_alpha = spec.alpha_channel >= 0 && spec.alpha_channel < spec.nchannels;
  if (has_alpha && spec.get_int_attribute("oiio:UnassociatedAlpha") == 0) unassociate(raw, spec.alpha_channel);
  return raw;
}

int channel_index(const RawImage& raw, const std::string& name) {
  const auto it = std::find(raw.channels.begin(), raw.channels.end(), name);
  return it == raw.channels.end() ? -1 : static_cast<int>(it - raw.channels.begin());
}

std::unique_ptr<OIIO::ImageOutput> create_output(const std::filesystem::path& path) {
  configure_once();
  auto output = OIIO::ImageOutput::create(path.string());
  if (!output || !output->supports("ioproxy")) {
    (void)OIIO::geterror();
    throw UsageError(path.string() + ": unknown image format; use .png, .jpg, .tif or .exr");
  }
  return output;
}

void write_pixels(const std::filesystem::path& path, const OIIO::ImageSpec& spec, OIIO::TypeDesc type, const void* pixels) {
  const auto output = create_output(path);
  // Encoded in memory: OpenImageIO's PNG writer does not notice a full disk, write_atomically() does.
  OIIO::Filesystem::IOVecOutput memory;
  if (!output->set_ioproxy(&memory) || !output->open(path.string(), spec) || !output->write_image(type, pixels) || !output->close()) {
    throw CannotComplete(path.string() + ": cannot be written; " + output->geterror());
  }
  write_atomically(path, std::string_view(reinterpret_cast<const char*>(memory.buffer().data()), memory.buffer().size()));
}

OIIO::ImageSpec make_spec(int width, int height, int channels, OIIO::TypeDesc type, const std::string& key) {
  OIIO::ImageSpec spec(width, height, channels, type);
  spec.attribute("DateTime", kNoDate);
  spec.attribute("Software", "patinate");
  if (!key.empty()) {
    spec.attribute(kKeyAttribute, key);                          // EXR and PNG keep it,
    spec.attribute("ImageDescription", kKeyDescription + key);   // JPEG and TIFF this.
  }
  return spec;
}

/// 0-based position of R, G, B, or the first channel three times for gray.
std::array<int, 3> color_channels(const RawImage& raw) {
  const std::array<int, 3> rgb{channel_index(raw, "R"), channel_index(raw, "G"), channel_index(raw, "B")};
  if (rgb[0] >= 0 && rgb[1] >= 0 && rgb[2] >= 0) return rgb;
  const int gray = std::max(0, channel_index(raw, "Y"));
  return {gray, gray, gray};
}

}  // namespace

ImageInfo probe_image(const std::filesystem::path& path) {
  const auto input = open_image(path);
  const OIIO::ImageSpec spec = input->spec();
  ImageInfo info;
  info.width = spec.width;
  info.height = spec.height;
  info.channels = spec.channelnames;
  info.is_integer = !spec.format.is_floating_point();
  info.date_time = spec.get_string_attribute("Exif:DateTimeOriginal", spec.get_string_attribute("DateTime"));
  if (info.date_time == kNoDate) info.date_time.clear();
  info.key = spec.get_string_attribute(kKeyAttribute);
  const std::string description = spec.get_string_attribute("ImageDescription");
  if (info.key.empty() && description.starts_with(kKeyDescription)) info.key = description.substr(std::string_view(kKeyDescription).size());
  constexpr int kMaxFrames = 100'000;
  while (info.num_frames < kMaxFrames && input->seek_subimage(info.num_frames, 0)) ++info.num_frames;
  (void)input->geterror();
  return info;
}

ImageF read_color(const std::filesystem::path& path, const Response& response) {
  const RawImage raw = read_raw(path);
  const std::array<int, 3> source = color_channels(raw);
  ImageF color(raw.values.width(), raw.values.height(), 3);
  for (int y = 0; y < color.height(); ++y) {
    for (int x = 0; x < color.width(); ++x) {
      for (int c = 0; c < 3; ++c) {
        const float value = raw.values.at(x, y, source[static_cast<std::size_t>(c)]);
        color.at(x, y, c) = raw.is_integer ? response.linear_from_code(value) : value;
      }
    }
  }
  return color;
}

ImageF read_gray(const std::filesystem::path& path, const std::string& channel) {
  const RawImage raw = read_raw(path);
  const std::string wanted = channel.empty() ? "Y" : channel;
  const int index = channel_index(raw, wanted);
  if (index < 0 && !channel.empty()) throw IoError(path.string(), "has no channel `" + channel + "`");
  const std::array<int, 3> color = color_channels(raw);
  ImageF gray(raw.values.width(), raw.values.height(), 1);
  for (int y = 0; y < gray.height(); ++y) {
    for (int x = 0; x < gray.width(); ++x) {
      const auto pixel = raw.values.pixel(x, y);
      const auto value = [&](int c) { return pixel[static_cast<std::size_t>(c)]; };
      gray.at(x, y) = index >= 0                ? value(index)
                      : color[0] == color[1]    ? value(color[0])
                                                : (value(color[0]) + value(color[1]) + value(color[2])) / 3.0f;
    }
  }
  return gray;
}

ImageF read_channels(const std::filesystem::path& path, const std::vector<std::string>& channels) {
  const RawImage raw = read_raw(path);
  std::vector<int> source;
  for (const std::string& name : channels) {
    const int index = channel_index(raw, name);
    if (index < 0) {
      const std::string there = std::accumulate(raw.channels.begin(), raw.channels.end(), std::string(),
                                                [](std::string a, const std::string& b) { return a.append(" ").append(b); });
      throw IoError(path.string(), "has no channel `" + name + "`; there are:" + there);
    }
    source.push_back(index);
  }
  ImageF picked(raw.values.width(), raw.values.height(), static_cast<int>(channels.size()));
  for (int y = 0; y < picked.height(); ++y) {
    for (int x = 0; x < picked.width(); ++x) {
      for (int c = 0; c < picked.channels(); ++c) {
        picked.at(x, y, c) = raw.values.at(x, y, source[static_cast<std::size_t>(c)]);
      }
    }
  }
  return picked;
}

ImageU8 read_mask(const std::filesystem::path& path) {
  const RawImage raw = read_raw(path);
  int source = 0;
  const int alpha = channel_index(raw, "A");
  if (alpha > 0) {
    const float first = raw.values.at(0, 0, 0);
    bool color_varies = false;
    for (int y = 0; y < raw.values.height() && !color_varies; ++y) {
      for (int x = 0; x < raw.values.width() && !color_varies; ++x) color_varies = raw.values.at(x, y, 0) != first;
    }
    if (!color_varies) source = alpha;
  }
  ImageU8 mask(raw.values.width(), raw.values.height());
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) mask.at(x, y) = raw.values.at(x, y, source) >= 0.5f ? 255 : 0;
  }
  return mask;
}

void write_exr(const std::filesystem::path& path, const ImageF& image, const std::vector<std::string>& channels,
               ExrDepth depth, const std::string& key) {
  if (image.empty() || static_cast<int>(channels.size()) != image.channels()) {
    throw InvalidInput(path.string() + ": an image of " + std::to_string(image.channels()) + " channels was given " +
                       std::to_string(channels.size()) + " names");
  }
  constexpr float kLargestHalf = 65504.0f;
  for (float v : image.values()) {
    if (!std::isfinite(v) || (depth == ExrDepth::Half && std::abs(v) > kLargestHalf)) {
      throw InvalidInput(path.string() + ": a value is NaN, infinite or too large to be stored");
    }
  }
  OIIO::ImageSpec spec = make_spec(image.width(), image.height(), image.channels(),
                                   depth == ExrDepth::Half ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::FLOAT, key);
  spec.channelnames = channels;
  spec.attribute("compression", "zip");
  write_pixels(path, spec, OIIO::TypeDesc::FLOAT, image.data());
}

void write_codes(const std::filesystem::path& path, const ImageU8& codes, const std::string& key) {
  OIIO::ImageSpec spec = make_spec(codes.width(), codes.height(), codes.channels(), OIIO::TypeDesc::UINT8, key);
  spec.attribute("oiio:UnassociatedAlpha", 1);
  spec.attribute("CompressionQuality", 92);
  write_pixels(path, spec, OIIO::TypeDesc::UINT8, codes.data());
}

void write_srgb8(const std::filesystem::path& path, const ImageF& linear, const std::string& key) {
  write_codes(path, srgb8_from_linear(linear), key);
}

void write_color(const std::filesystem::path& path, const ImageF& linear, const std::string& key) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension == ".exr") {
    write_exr(path, linear, {"R", "G", "B"}, ExrDepth::Half, key);
  } else {
    const std::array<std::string_view, 5> known{".png", ".jpg", ".jpeg", ".tif", ".tiff"};
    if (std::find(known.begin(), known.end(), extension) == known.end()) {
      throw UsageError(path.string() + ": unknown image format; use .png, .jpg, .tif or .exr");
    }
    write_srgb8(path, linear, key);
  }
}

}  // namespace patinate
