#include <algorithm>
#include <cmath>

#include "libcommon/output/light_field.h"
#include "libcommon/output/sampling.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

constexpr double kLampRadiance = 4.0;  // Times the mean: what is above is a lamp.

Vec3 pixel(const ImageF& image, int x, int y) {
  return {static_cast<double>(image.at(x, y, 0)), static_cast<double>(image.at(x, y, 1)),
          static_cast<double>(image.at(x, y, 2))};
}

void set_pixel(ImageF& image, int x, int y, const Vec3& c) {
  for (int k = 0; k < 3; ++k) image.at(x, y, k) = static_cast<float>(c[k]);
}

double solid_angle(const ImageF& image, int y) {
  const double top = std::cos(std::numbers::pi * y / image.height()),
               low = std::cos(std::numbers::pi * (y + 1) / image.height());
  return 2.0 * std::numbers::pi / image.width() * (top - low);
}

Vec3 direction_of(double u, double v) {
  const double around = 2.0 * std::numbers::pi * (u - 0.5), down = std::numbers::pi * v;
  return {std::sin(down) * std::sin(around), std::cos(down), -std::sin(down) * std::cos(around)};
}

Vec2 place_of(const Vec3& d) {
  return {0.5 + std::atan2(d.x(), -d.z()) / (2.0 * std::numbers::pi),
          std::acos(std::clamp(d.y(), -1.0, 1.0)) / std::numbers::pi};
}

Vec3 bilinear(const ImageF& image, const Vec2& place) {
  const double x = place.x() * image.width() - 0.5;
  const double y = std::clamp(place.y() * image.height() - 0.5, 0.0, image.height() - 1.0);
  const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(y), y1 = std::min(y0 + 1, image.height() - 1);
  const auto column = [&](int i) { return (i % image.width() + image.width()) % image.width(); };
  const double fx = x - x0, fy = y - y0;
  return (1.0 - fy) * ((1.0 - fx) * pixel(image, column(x0), y0) + fx * pixel(image, column(x0 + 1), y0)) +
         fy * ((1.0 - fx) * pixel(image, column(x0), y1) + fx * pixel(image, column(x0 + 1), y1));
}

ImageF halved(const ImageF& image) {
  ImageF half(std::max(1, image.width() / 2), std::max(1, image.height() / 2), 3);
  for (int y = 0; y < half.height(); ++y) {
    for (int x = 0; x < half.width(); ++x) {
      Vec3 sum = Vec3::Zero();
      double weight = 0.0;
      const int y_end = image.height() * (y + 1) / half.height(), x_end = image.width() * (x + 1) / half.width();
      for (int j = image.height() * y / half.height(); j < y_end; ++j) {
        for (int i = image.width() * x / half.width(); i < x_end; ++i) {
          sum += solid_angle(image, j) * pixel(image, i, j);
          weight += solid_angle(image, j);
        }
      }
      set_pixel(half, x, y, sum / weight);
    }
  }
  return half;
}

// The first nine real spherical harmonics.
std::array<double, 9> harmonics(const Vec3& d) {
  return {0.282095,
          0.488603 * d.y(),
          0.488603 * d.z(),
          0.488603 * d.x(),
          1.092548 * d.x() * d.y(),
          1.092548 * d.y() * d.z(),
          0.315392 * (3.0 * d.z() * d.z() - 1.0),
          1.092548 * d.x() * d.z(),
          0.546274 * (d.x() * d.x() - d.y() * d.y())};
}

// Share of each band that a cosine lobe keeps, over pi.
constexpr std::array<double, 9> kCosineShare = {1.0, 2.0 / 3, 2.0 / 3, 2.0 / 3, 0.25, 0.25, 0.25, 0.25, 0.25};

}  // namespace

Surroundings::Surroundings(const ImageF& image, double mean) {
  harmonics_.fill(Vec3::Zero());
  if (image.width() < 2 || image.height() < 1 || image.channels() != 3)
    throw InvalidInput("render: surroundings are a picture of three channels, at least 2 x 1 pixels");
  double found = 0.0;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x)
      found += solid_angle(image, y) / (4.0 * std::numbers::pi) * luminance_of(pixel(image, x, y).cwiseMax(0.0));
  }
  if (!std::isfinite(found) || (mean > 0.0 && !(found > 0.0)))
    throw InvalidInput("render: the surroundings are black, or brighter than can be summed");
  const double factor = mean > 0.0 ? mean / found : 1.0, limit = kLampRadiance * factor * found;
  ImageF all(image.width(), image.height(), 3);
  lamps_ = ImageF(image.width(), image.height(), 3);
  for (int y = 0; y < image.height(); ++y) {
    double row = 0.0;
    for (int x = 0; x < image.width(); ++x) {
      const Vec3 radiance = factor * pixel(image, x, y).cwiseMax(0.0);
      const double share = luminance_of(radiance) > limit ? 1.0 - limit / luminance_of(radiance) : 0.0;
      set_pixel(all, x, y, radiance);
      set_pixel(lamps_, x, y, share * radiance);
      row += solid_angle(image, y) * share * luminance_of(radiance);
      pixel_sums_.push_back(row);
      const std::array<double, 9> basis =
          harmonics(direction_of((x + 0.5) / image.width(), (y + 0.5) / image.height()));
      for (std::size_t k = 0; k < 9; ++k)
        harmonics_[k] += kCosineShare[k] * basis[k] * solid_angle(image, y) * (1.0 - share) * radiance;
    }
    lamp_total_ += row;
    row_sums_.push_back(lamp_total_);
  }
  levels_.push_back(std::move(all));
  while (levels_.back().width() > 2 && levels_.back().height() > 1) levels_.push_back(halved(levels_.back()));
}

Vec3 Surroundings::radiance(const Vec3& direction, double solid_angle) const {
  const double of_pixel = 2.0 * std::numbers::pi * std::numbers::pi / static_cast<double>(levels_.front().num_pixels());
  const double level = std::clamp(0.5 * std::log2(std::max(1e-12, solid_angle / of_pixel)), 0.0,
                                  static_cast<double>(levels_.size()) - 1.0);
  const std::size_t low = static_cast<std::size_t>(level), high = std::min(low + 1, levels_.size() - 1);
  const Vec2 place = place_of(direction);
  const double share = level - static_cast<double>(low);
  return (1.0 - share) * bilinear(levels_[low], place) + share * bilinear(levels_[high], place);
}

Vec3 Surroundings::smooth_on(const Vec3& normal) const {
  const std::array<double, 9> basis = harmonics(normal);
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 0; k < 9; ++k) sum += basis[k] * harmonics_[k];
  return sum.cwiseMax(0.0);
}

Vec3 Surroundings::lamps(const Vec3& direction, double& pdf) const {
  pdf = 0.0;
  if (!has_lamps()) return Vec3::Zero();
  const Vec2 place = place_of(direction);
  const int x = std::clamp(static_cast<int>(place.x() * lamps_.width()), 0, lamps_.width() - 1);
  const int y = std::clamp(static_cast<int>(place.y() * lamps_.height()), 0, lamps_.height() - 1);
  const Vec3 radiance = pixel(lamps_, x, y);
  pdf = luminance_of(radiance) / lamp_total_;
  return radiance;
}

Vec3 Surroundings::sample(const Vec2& square) const {
  const auto place_in = [](auto begin, auto end, double total, double share, double& inside) {
    const double aim = share * total;
    auto found = std::min(std::upper_bound(begin, end, aim), end - 1);
    const double before = found == begin ? 0.0 : *(found - 1), width = *found - before;
    inside = width > 0.0 ? std::clamp((aim - before) / width, 0.0, 1.0) : 0.5;
    return static_cast<int>(found - begin);
  };
  double in_row = 0.5, in_pixel = 0.5;
  const int y = place_in(row_sums_.begin(), row_sums_.end(), lamp_total_, square.y(), in_row);
  const auto row = pixel_sums_.begin() + static_cast<std::ptrdiff_t>(y) * lamps_.width();
  const int x = place_in(row, row + lamps_.width(), *(row + lamps_.width() - 1), square.x(), in_pixel);
  // Even over the pixel's solid angle.
  const double top = std::cos(std::numbers::pi * y / lamps_.height()),
               low = std::cos(std::numbers::pi * (y + 1) / lamps_.height());
  const double keep = 1e-9;  // Off the pixel's rims, which belong to its neighbors.
  const double up = top + std::clamp(in_row, keep, 1.0 - keep) * (low - top);
  const double u = (x + std::clamp(in_pixel, keep, 1.0 - keep)) / lamps_.width();
  return direction_of(u, std::acos(std::clamp(up, -1.0, 1.0)) / std::numbers::pi);
}

}  // namespace patinate
