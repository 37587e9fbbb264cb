#include "libcommon/image/mask_pixels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

constexpr const char* kWhatAMaskIs = "; a mask is black outside and white inside, or transparent outside";
/// Levels and colors that cover less are edges.
constexpr double kFlatShare = 0.01;
constexpr std::int64_t kFlatPixels = 32;
/// Codes of 255 by which lossy formats and editors change a flat color.
constexpr int kTolerance = 8;

int code_of(float value) { return static_cast<int>(std::lround(std::clamp(value, 0.0f, 1.0f) * 255.0f)); }

/// Codes of the color of an image, for one pixel after the other.
class ColorCodes {
 public:
  explicit ColorCodes(const DecodedImage& image) : image_(image) {
    const std::array<int, 3> rgb{channel_index(image, "R"), channel_index(image, "G"), channel_index(image, "B")};
    const bool is_rgb = std::all_of(rgb.begin(), rgb.end(), [](int c) { return c >= 0; });
    const int gray = std::max(0, channel_index(image, "Y"));
    channels_ = is_rgb ? rgb : std::array<int, 3>{gray, gray, gray};
  }
  [[nodiscard]] bool is_one_channel() const { return channels_[0] == channels_[1]; }
  [[nodiscard]] float value(int x, int y) const { return image_.values.at(x, y, channels_[0]); }
  [[nodiscard]] std::array<int, 3> at(int x, int y) const {
    std::array<int, 3> codes{};
    for (std::size_t c = 0; c < 3; ++c) codes[c] = code_of(image_.values.at(x, y, channels_[c]));
    return codes;
  }

 private:
  const DecodedImage& image_;
  std::array<int, 3> channels_{};
};

template <class Use>
void for_each_pixel(const ImageF& image, const Use& use) {
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) use(x, y);
  }
}

template <class Inside>
ImageU8 mask_where(const DecodedImage& image, const Inside& is_inside) {
  ImageU8 mask(image.values.width(), image.values.height());
  for_each_pixel(image.values, [&](int x, int y) { mask.at(x, y) = is_inside(x, y) ? 255 : 0; });
  return mask;
}

bool is_flat(std::int64_t count, std::int64_t num_pixels) {
  return count >= kFlatPixels && static_cast<double>(count) >= kFlatShare * static_cast<double>(num_pixels);
}

/// Refuses a cut-out whose colors are a mask too, and another one.
void check_cut_out(const DecodedImage& image, const ImageU8& opaque) {
  const ColorCodes colors(image);
  std::int64_t num_opaque = 0, num_white = 0, num_black = 0;
  for_each_pixel(image.values, [&](int x, int y) {
    if (opaque.at(x, y) == 0) return;
    const auto codes = colors.at(x, y);
    const auto [low, high] = std::minmax_element(codes.begin(), codes.end());
    ++num_opaque;
    num_white += *low >= 255 - kTolerance;
    num_black += *high <= kTolerance;
  });
  constexpr double kBlackAndWhite = 0.98, kSame = 0.01;
  const auto share = [&](std::int64_t count) { return static_cast<double>(count) / static_cast<double>(num_opaque); };
  const bool is_two = share(num_white + num_black) >= kBlackAndWhite;
  if (is_two && share(num_white) > kSame && share(num_black) > kSame) {
    throw InvalidInput(
        "has a transparent part, and is black and white where it is opaque: two masks in one; save it "
        "without transparency");
  }
}

/// Up to 16 different values, 0 among them.
bool are_dim_labels(const ImageF& image, const ColorCodes& colors) {
  constexpr std::size_t kMaxLabels = 16;
  std::set<float> values;
  for (int y = 0; y < image.height() && values.size() <= kMaxLabels; ++y) {
    for (int x = 0; x < image.width() && values.size() <= kMaxLabels; ++x) values.insert(colors.value(x, y));
  }
  return values.size() <= kMaxLabels && values.contains(0.0f);
}

ImageU8 gray_mask(const DecodedImage& image, const ColorCodes& colors) {
  std::array<std::int64_t, 256> counts{};
  float highest = 0.0f;
  for_each_pixel(image.values, [&](int x, int y) {
    ++counts[code_of(colors.value(x, y))];
    highest = std::max(highest, colors.value(x, y));
  });
  const std::int64_t num_pixels = image.values.num_pixels();
  if (highest > 0.0f && highest < 0.5f) {
    if (!are_dim_labels(image.values, colors))
      throw InvalidInput(std::string("has no code of 128 or more") + kWhatAMaskIs);
    return mask_where(image, [&](int x, int y) { return colors.value(x, y) > 0.0f; });
  }
  std::vector<int> flat;
  std::int64_t num_between = 0;
  constexpr int kEdge = 16;
  for (int code = 0; code < 256; ++code) {
    const std::int64_t count = counts[code];
    if (code > kEdge && code < 255 - kEdge) num_between += count;
    // Codes beside a larger level belong to it.
    if (is_flat(count, num_pixels) && (flat.empty() || code - flat.back() > kTolerance)) flat.push_back(code);
  }
  const bool is_between = std::any_of(
      flat.begin(), flat.end(), [&](int code) { return code != flat.front() && code < 128 && flat.back() >= 128; });
  const bool is_two = flat.size() == 2 && flat.front() < 128 && flat.back() >= 128;
  constexpr double kMaxBetween = 0.4;
  const bool is_picture =
      !is_two && flat.size() > 1 && static_cast<double>(num_between) > kMaxBetween * static_cast<double>(num_pixels);
  if (is_picture || is_between) {
    std::string levels;
    for (int code : flat) levels += (levels.empty() ? "" : ", ") + std::to_string(code);
    throw InvalidInput("has several levels of gray (" + levels + ")" + kWhatAMaskIs);
  }
  return mask_where(image, [&](int x, int y) { return colors.value(x, y) >= 0.5f; });
}

/// Colors that cover an area, each as a corner of a coarse grid.
ImageU8 label_mask(const DecodedImage& image, const ColorCodes& colors) {
  constexpr int kSteps = 32, kStep = 256 / kSteps;
  std::vector<std::int64_t> counts(std::size_t{kSteps} * kSteps * kSteps);
  for_each_pixel(image.values, [&](int x, int y) {
    const auto c = colors.at(x, y);
    ++counts[(c[0] / kStep * kSteps + c[1] / kStep) * kSteps + c[2] / kStep];
  });
  const std::int64_t num_pixels = image.values.num_pixels();
  std::int64_t num_flat = 0;
  int num_labels = 0, dimmest = 255;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (!is_flat(counts[i], num_pixels)) continue;
    num_flat += counts[i];
    const auto part = [&](std::size_t divisor) { return static_cast<int>(i / divisor % kSteps) * kStep; };
    const int brightest = std::max({part(std::size_t{kSteps} * kSteps), part(kSteps), part(1)});
    if (i > 0) dimmest = std::min(dimmest, brightest);
    num_labels += i > 0;
  }
  constexpr double kMinFlat = 0.95;
  constexpr int kMaxLabels = 32;
  if (static_cast<double>(num_flat) < kMinFlat * static_cast<double>(num_pixels) || num_labels > kMaxLabels)
    throw InvalidInput(std::string("is a picture in color without transparency, and no mask") + kWhatAMaskIs);
  if (!is_flat(counts[0], num_pixels)) {
    throw InvalidInput("has " + std::to_string(num_labels) +
                       " colors, none of them black, so that it does not say which is outside" + kWhatAMaskIs);
  }
  return mask_where(image, [&](int x, int y) {
    const auto c = colors.at(x, y);
    return 2 * std::max({c[0], c[1], c[2]}) >= dimmest;
  });
}

bool is_gray(const DecodedImage& image, const ColorCodes& colors) {
  if (colors.is_one_channel()) return true;
  std::int64_t num_colored = 0;
  for_each_pixel(image.values, [&](int x, int y) {
    const auto codes = colors.at(x, y);
    const auto [low, high] = std::minmax_element(codes.begin(), codes.end());
    num_colored += *high - *low > kTolerance;
  });
  constexpr double kFew = 0.001;
  return static_cast<double>(num_colored) <= kFew * static_cast<double>(image.values.num_pixels());
}

}  // namespace

ImageU8 mask_of(const DecodedImage& image) {
  const int alpha = channel_index(image, "A");
  if (alpha > 0) {
    ImageU8 opaque = mask_where(image, [&](int x, int y) { return image.values.at(x, y, alpha) >= 0.5f; });
    const auto values = opaque.values();
    const bool is_part = std::any_of(values.begin(), values.end(), [&](std::uint8_t v) { return v != values[0]; });
    if (is_part) {
      check_cut_out(image, opaque);
      return opaque;
    }
  }
  const ColorCodes colors(image);
  return is_gray(image, colors) ? gray_mask(image, colors) : label_mask(image, colors);
}

}  // namespace patinate
