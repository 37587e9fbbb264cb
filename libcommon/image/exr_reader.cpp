#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <strings.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "libcommon/image/exr_header.h"
#include "libcommon/image/image_source.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

/// A channel "layer.suffix", and where it stands among others.
struct ExrChannel {
  std::string name;
  std::string layer;  ///< With its dot.
  std::string suffix;
  std::size_t rank = 0;
};

bool is_suffix(const ExrChannel& channel, const char* suffix) {
  return ::strcasecmp(channel.suffix.c_str(), suffix) == 0;
}

/// OpenImageIO's order, which is that of our files' readers: by layer, then color before all else, then by name.
void sort_channels(std::vector<ExrChannel>& channels) {
  constexpr std::array kUsual{"R",     "Red", "G",  "Green", "B",  "Blue", "Y",  "real", "imag",  "A",
                              "Alpha", "AR",  "RA", "AG",    "GA", "AB",   "BA", "Z",    "Depth", "Zback"};
  constexpr std::array kPlace{"R", "Red",   "G",  "Green", "B",  "Blue", "X",  "Y",  "Z",     "real", "imag",
                              "A", "Alpha", "AR", "RA",    "AG", "GA",   "AB", "BA", "Depth", "Zback"};
  std::stable_sort(channels.begin(), channels.end(),
                   [](const ExrChannel& a, const ExrChannel& b) { return a.layer < b.layer; });
  for (auto begin = channels.begin(); begin != channels.end();) {
    const auto end = std::find_if(begin, channels.end(), [&](const ExrChannel& c) { return c.layer != begin->layer; });
    const auto has = [&](const char* suffix) {
      return std::any_of(begin, end, [&](const ExrChannel& c) { return is_suffix(c, suffix); });
    };
    const bool is_place = has("X") && (has("Y") || has("Z"));
    const auto rank = [](const auto& names, const ExrChannel& c) {
      return static_cast<std::size_t>(
          std::find_if(names.begin(), names.end(), [&](const char* name) { return is_suffix(c, name); }) -
          names.begin());
    };
    for (auto c = begin; c != end; ++c) c->rank = is_place ? rank(kPlace, *c) : rank(kUsual, *c);
    std::sort(begin, end, [](const ExrChannel& a, const ExrChannel& b) {
      return a.rank != b.rank ? a.rank < b.rank : a.suffix < b.suffix;
    });
    begin = end;
  }
}

/// Nothing if a channel is one that only OpenImageIO reads as we want it.
std::optional<std::vector<std::string>> channel_names(const Imf::ChannelList& list) {
  std::vector<ExrChannel> channels;
  for (auto it = list.begin(); it != list.end(); ++it) {
    const Imf::Channel& channel = it.channel();
    if (channel.xSampling != 1 || channel.ySampling != 1 || (channel.type != Imf::HALF && channel.type != Imf::FLOAT))
      return std::nullopt;
    const std::string name = it.name();
    const std::size_t dot = name.rfind('.');
    const std::size_t start = dot == std::string::npos ? 0 : dot + 1;
    channels.push_back({.name = name, .layer = name.substr(0, start), .suffix = name.substr(start)});
  }
  if (channels.empty() || channels.size() > static_cast<std::size_t>(kMaxImageChannels)) return std::nullopt;
  sort_channels(channels);
  std::vector<std::string> names;
  for (const ExrChannel& channel : channels) names.push_back(channel.name);
  return names;
}

std::string text_of(const Imf::Header& header, const char* name) {
  const auto* attribute = header.findTypedAttribute<Imf::StringAttribute>(name);
  return attribute == nullptr ? "" : attribute->value().c_str();  // Up to a zero.
}

/// What 0 and 1 stand for, unless the header lacks a number or has one that is not finite.
std::optional<ValueScale> scale_of(const Imf::Header& header) {
  const auto* low = header.findTypedAttribute<Imf::DoubleAttribute>(kImageLowAttribute);
  const auto* high = header.findTypedAttribute<Imf::DoubleAttribute>(kImageHighAttribute);
  if (low == nullptr || high == nullptr || !std::isfinite(low->value()) || !std::isfinite(high->value())) return {};
  return ValueScale{low->value(), high->value(), text_of(header, kImageUnitAttribute)};
}

/// Whether the header says what OpenImageIO understands and read_words() does not: other spellings, dates of cameras,
/// frame rates.
bool has_other_words(const Imf::Header& header) {
  constexpr std::array kElsewhere{"DateTime", "Exif:DateTimeOriginal", "ImageDescription", "FramesPerSecond",
                                  "oiio:UnassociatedAlpha"};
  for (auto it = header.begin(); it != header.end(); ++it) {
    const char* name = it.name();
    const bool is_key = std::string_view(name) == kImageKeyAttribute;
    if (is_key ? std::string_view(it.attribute().typeName()) != "string" : ::strcasecmp(name, kImageKeyAttribute) == 0)
      return true;
    if (std::any_of(kElsewhere.begin(), kElsewhere.end(),
                    [&](const char* other) { return ::strcasecmp(name, other) == 0; }))
      return true;
  }
  return false;
}

class ExrSource final : public ImageSource {
 public:
  explicit ExrSource(const std::filesystem::path& path)
      : path_(path), file_(path.c_str(), 0) {}  // On the thread that calls.

  [[nodiscard]] bool open() {
    if (file_.parts() != 1) return false;
    const Imf::Header& header = file_.header(0);
    if ((header.hasType() && header.type() != Imf::SCANLINEIMAGE) || has_other_words(header)) return false;
    auto names = channel_names(header.channels());
    if (!names) return false;
    const Imath::Box2i window = header.dataWindow();
    left_ = window.min.x;
    top_ = window.min.y;
    info_.width = window.max.x - window.min.x + 1;
    info_.height = window.max.y - window.min.y + 1;
    info_.channels = std::move(*names);
    info_.is_integer = false;
    set_words(info_, text_of(header, kImageKeyAttribute), text_of(header, "comments"));
    info_.scale = scale_of(header);
    part_.emplace(file_, 0);
    return true;
  }

  [[nodiscard]] ImageInfo first_info() const override { return info_; }
  [[nodiscard]] int count_frames() override { return 1; }

  [[nodiscard]] CodedImage read(int frame) override {
    if (frame != 0) throw IoError(path_.string(), "has no image " + std::to_string(frame) + " that can be read");
    return read_rows(0, info_.height);
  }

  [[nodiscard]] CodedImage read_rows(int begin, int end) override {
    const std::size_t num_channels = info_.channels.size(), width = static_cast<std::size_t>(info_.width);
    CodedImage coded{info_.width, end - begin, static_cast<int>(num_channels), CodedImage::Type::Float, -1, {}};
    const auto alpha = std::find(info_.channels.begin(), info_.channels.end(), "A");
    if (alpha != info_.channels.end()) coded.associated_alpha = static_cast<int>(alpha - info_.channels.begin());
    coded.bytes.resize(num_channels * width * static_cast<std::size_t>(end - begin) * sizeof(float));
    const std::size_t pixel = num_channels * sizeof(float), row = pixel * width;
    try {
      Imf::FrameBuffer buffer;
      for (std::size_t c = 0; c < num_channels; ++c) {
        // OpenEXR wants the place of the pixel (0, 0), which may lie outside.
        buffer.insert(info_.channels[c],
                      Imf::Slice::Make(Imf::FLOAT, coded.bytes.data() + c * sizeof(float),
                                       Imath::V2i(left_, top_ + begin), info_.width, end - begin, pixel, row));
      }
      part_->setFrameBuffer(buffer);
      part_->readPixels(top_ + begin, top_ + end - 1);
    } catch (const std::exception& e) {
      const std::string problem = e.what();
      throw IoError(path_.string(), "is damaged or truncated (" + problem.substr(0, problem.find('\n')) + ")");
    }
    return coded;
  }

 private:
  std::filesystem::path path_;
  Imf::MultiPartInputFile file_;
  std::optional<Imf::InputPart> part_;
  int left_ = 0, top_ = 0;
  ImageInfo info_;
};

}  // namespace

std::unique_ptr<ImageSource> open_exr(const std::filesystem::path& path) {
  if (!is_plain_exr(path)) return nullptr;
  try {
    auto source = std::make_unique<ExrSource>(path);
    if (source->open()) return source;
  } catch (const std::exception&) {  // OpenImageIO's words for what is damaged.
  }
  return nullptr;
}

}  // namespace patinate
