#include "libcommon/image/decoded_image.h"

#include <strings.h>

#include <algorithm>
#include <array>
#include <map>
#include <vector>

#include "libcommon/image/color_encoding.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

/// 0-based position of R, G, B, or the first channel three times for gray.
std::array<int, 3> color_channels(const DecodedImage& image) {
  const std::array<int, 3> rgb{channel_index(image, "R"), channel_index(image, "G"), channel_index(image, "B")};
  if (rgb[0] >= 0 && rgb[1] >= 0 && rgb[2] >= 0) return rgb;
  const int gray = std::max(0, channel_index(image, "Y"));
  return {gray, gray, gray};
}

/// Response::linear_from_code() of the codes of one image, each computed once: a photograph has few different ones.
class LinearOfCode {
 public:
  explicit LinearOfCode(const Response& response) : response_(response), entries_(kSteps + 1) {}

  float operator()(float code) {
    if (!(code >= 0.0f && code <= 1.0f)) return response_.linear_from_code(code);
    // Any entry would do; lround is slower.
    Entry& entry = entries_[static_cast<std::size_t>(code * static_cast<float>(kSteps) +
                                                     0.5f)];  // NOLINT(bugprone-incorrect-roundings)
    if (entry.code != code) entry = {code, response_.linear_from_code(code)};
    return entry.linear;
  }

 private:
  static constexpr int kSteps = 65535;  // Each 8 or 16-bit code has an entry of its own.
  struct Entry {
    float code = -1.0f, linear = 0.0f;
  };
  const Response& response_;
  std::vector<Entry> entries_;
};

}  // namespace

bool is_color_channel(const std::string& name, const std::string& layer, const std::string& color) {
  static const std::map<std::string, const char*> kLongNames{
      {"R", "Red"}, {"G", "Green"}, {"B", "Blue"}, {"A", "Alpha"}};
  const auto found = kLongNames.find(color);
  if (found == kLongNames.end() || !name.starts_with(layer)) return false;
  const char* suffix = name.c_str() + layer.size();
  return ::strcasecmp(suffix, color.c_str()) == 0 || ::strcasecmp(suffix, found->second) == 0;
}

int channel_index(const DecodedImage& image, const std::string& name) {
  auto it = std::find(image.channels.begin(), image.channels.end(), name);
  if (it == image.channels.end()) {
    it = std::find_if(image.channels.begin(), image.channels.end(),
                      [&](const std::string& other) { return is_color_channel(other, image.color_layer, name); });
  }
  return it == image.channels.end() ? -1 : static_cast<int>(it - image.channels.begin());
}

ImageF color_of(const DecodedImage& image, const Response& response) {
  const std::array<int, 3> source = color_channels(image);
  ImageF color(image.values.width(), image.values.height(), 3);
  const bool is_encoded = image.encoding != nullptr && (!image.is_integer || response.kind == Response::Kind::File);
  LinearOfCode linear(response);
  for (int y = 0; y < color.height(); ++y) {
    for (int x = 0; x < color.width(); ++x) {
      for (int c = 0; c < 3; ++c) {
        const float value = image.values.at(x, y, source[c]);
        color.at(x, y, c) = image.is_integer && !is_encoded ? linear(value) : value;
      }
    }
  }
  if (is_encoded) image.encoding->to_linear(color);
  return color;
}

ImageF channel_of(const DecodedImage& image, const std::string& name) {
  const int index = channel_index(image, name);
  if (index < 0) throw InvalidInput("has no channel `" + name + "`");
  ImageF channel(image.values.width(), image.values.height());
  for (int y = 0; y < channel.height(); ++y) {
    for (int x = 0; x < channel.width(); ++x) channel.at(x, y) = image.values.at(x, y, index);
  }
  return channel;
}

ImageF gray_of(const DecodedImage& image) {
  if (channel_index(image, "Y") >= 0) return channel_of(image, "Y");
  const std::array<int, 3> color = color_channels(image);
  ImageF gray(image.values.width(), image.values.height());
  for (int y = 0; y < gray.height(); ++y) {
    for (int x = 0; x < gray.width(); ++x) {
      const auto value = [&](std::size_t c) { return image.values.at(x, y, color[c]); };
      gray.at(x, y) = color[0] == color[1] ? value(0) : (value(0) + value(1) + value(2)) / 3.0f;
    }
  }
  return gray;
}

}  // namespace patinate
