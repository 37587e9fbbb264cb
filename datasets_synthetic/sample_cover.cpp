#include "datasets_synthetic/sample_cover.h"

#include <algorithm>
#include <cmath>

namespace patinate::datasets {

namespace {

constexpr std::uint64_t kFirstColumn = 0x0101010101010101ULL, kFirstRow = 0xffULL;

/// For each pixel along a side: bits of the samples at least `edge_px` from both of its ends.
std::vector<std::uint64_t> samples_between(int length, double edge_px, std::uint64_t first, int shift) {
  std::vector<std::uint64_t> out(static_cast<std::size_t>(length), 0);
  for (int p = 0; p < length; ++p) {
    for (int i = 0; i < kSamplesPerSide; ++i) {
      const double place = sample_place(p, i);
      if (place >= edge_px && place <= length - edge_px) out[static_cast<std::size_t>(p)] |= first << (shift * i);
    }
  }
  return out;
}

}  // namespace

PixelBox pixel_box(double left, double top, double right, double bottom, int width, int height) {
  const auto pixel = [](double place, int length) {
    return static_cast<int>(std::clamp(place, 0.0, static_cast<double>(length)));
  };
  return {pixel(std::floor(left), width), pixel(std::floor(top), height), pixel(std::ceil(right), width),
          pixel(std::ceil(bottom), height)};
}

SampleFrame::SampleFrame(int width, int height, double edge_px)
    : columns_(samples_between(width, edge_px, kFirstColumn, 1)),
      rows_(samples_between(height, edge_px, kFirstRow, kSamplesPerSide)) {
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) num_samples_ += sample_count(at(x, y));
  }
}

std::int64_t count_samples(const SampleImage& image) {
  std::int64_t sum = 0;
  for (const std::uint64_t bits : image.values()) sum += sample_count(bits);
  return sum;
}

std::int64_t count_samples(const SampleImage& image, const SampleFrame& inside) {
  std::int64_t sum = 0;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) sum += sample_count(image.at(x, y) & inside.at(x, y));
  }
  return sum;
}

ImageF sample_shares(const SampleImage& image) {
  ImageF out(image.width(), image.height());
  for (std::size_t i = 0; i < out.values().size(); ++i)
    out.values()[i] = static_cast<float>(sample_share(image.values()[i]));
  return out;
}

}  // namespace patinate::datasets
