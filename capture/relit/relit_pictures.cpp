#include "capture/relit/relit_pictures.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "capture/unlighting/unlight_report.h"
#include "libcommon/image/filters.h"
#include "libcommon/output/contact_strip.h"
#include "libcommon/output/map_legend.h"

namespace patinate::capture {

namespace {

constexpr int kWidth = 480, kSampleWidth = 240;
constexpr double kFullShare = 0.10;
constexpr float kPlain = 0.18f;  // Where there is no surface.

ImageF at_most(const ImageF& image, int width) {
  if (image.width() <= width) return image;
  const int height =
      std::max(1, static_cast<int>(std::lround(static_cast<double>(image.height()) * width / image.width())));
  return downscale_area(image, width, height);
}

void put_color(ImageF& image, int x, int y, const std::array<float, 3>& color) {
  std::copy(color.begin(), color.end(), image.pixel(x, y).begin());
}

}  // namespace

ImageF report_albedo(const ImageF& color) { return at_most(color, kWidth); }

ImageF report_samples(const ImageU8& samples, const ImageU8& mask) {
  std::vector<ImageF> pictures;
  std::vector<std::string> labels;
  for (int light = 0; light < std::max(1, samples.channels()); ++light) {
    ImageF picture(mask.width(), mask.height(), 3);
    for (int y = 0; y < mask.height(); ++y) {
      for (int x = 0; x < mask.width(); ++x) {
        const SampleState ready = mask.at(x, y) != 0 ? SampleState::Clean : SampleState::Outside;
        put_color(picture, x, y,
                  sample_state_color(samples.empty() ? ready : static_cast<SampleState>(samples.at(x, y, light))));
      }
    }
    pictures.push_back(at_most(picture, kSampleWidth));
    labels.push_back("light " + std::to_string(light));
  }
  return contact_strip(pictures, labels, {.columns = 4, .gap_px = 4});
}

ImageF report_stddev(const ImageF& albedo, const ImageF& stddev, const ImageU8& surface) {
  ImageF picture(albedo.width(), albedo.height(), 3, kPlain);
  for (int y = 0; y < albedo.height(); ++y) {
    for (int x = 0; x < albedo.width(); ++x) {
      float value = 0.0f, deviation = 0.0f;
      for (int c = 0; c < 3; ++c) {
        value += albedo.at(x, y, c);
        if (!stddev.empty()) deviation += stddev.at(x, y, c);
      }
      if (value > 0.0f) {
        put_color(picture, x, y,
                  ramp_color(ColorRamp::Sequential, static_cast<double>(deviation / value) / kFullShare));
      } else if (surface.at(x, y) != 0) {
        put_color(picture, x, y, {0.55f, 0.04f, 0.03f});
      }
    }
  }
  return with_legend(at_most(picture, kWidth), {.ramp = ColorRamp::Sequential,
                                                .high = 100.0 * kFullShare,
                                                .unit = "%",
                                                .more = "gray: no surface; red: not determined"});
}

}  // namespace patinate::capture
