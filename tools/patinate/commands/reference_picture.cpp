#include "tools/patinate/commands/reference_picture.h"

#include <algorithm>
#include <cmath>

#include "libcommon/core/parallel.h"
#include "libcommon/geometry/nearest_points.h"
#include "libcommon/geometry/ray_scene.h"
#include "libcommon/metrics/color_curves.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"
#include "patinate/metrics/difference.h"

namespace patinate::cli {

namespace {

constexpr double kSameSide = 0.5;        ///< Least cosine between the normals of a texel and its pixel.
constexpr double kSteepestView = 0.259;  ///< Cosine of 75 degrees: beyond, a pixel shows much more than a texel.
constexpr double kReach = 2.0;           ///< Pixels or texels.
constexpr std::int64_t kChunk = 4096;

Vec3 vector_at(const ImageF& image, std::int64_t pixel) {
  const auto at = static_cast<std::size_t>(3 * pixel);
  const std::span<const float> v = image.values();
  return {static_cast<double>(v[at]), static_cast<double>(v[at + 1]), static_cast<double>(v[at + 2])};
}

/// Median distance of horizontal neighbors.
double pixel_size_mm(const ImageF& position, const std::vector<std::uint8_t>& is_known) {
  std::vector<double> sizes;
  for (std::int64_t i = 1; i < position.num_pixels(); ++i) {
    if (i % position.width() == 0 || is_known[i] == 0 || is_known[i - 1] == 0) continue;
    sizes.push_back((vector_at(position, i) - vector_at(position, i - 1)).norm());
  }
  if (sizes.empty()) return 0.0;
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  return *middle;
}

}  // namespace

PixelOfTexel pixels_on_uvs(const TexelMap& map, int width, int height) {
  PixelOfTexel pixels(static_cast<std::size_t>(map.num_texels()), -1);
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    if (!map.is_covered(t)) continue;
    const std::int64_t x = t % map.width() * width / map.width(), y = t / map.width() * height / map.height();
    pixels[t] = y * width + x;
  }
  return pixels;
}

PixelOfTexel pixels_at_positions(const TexelMap& map, const ImageF& position, const ImageF& normal, const ImageU8& mask,
                                 const RunControl& control) {
  std::vector<Vec3> points;
  std::vector<std::int64_t> pixel_of;
  std::vector<std::uint8_t> is_known(static_cast<std::size_t>(position.num_pixels()));
  for (std::int64_t i = 0; i < position.num_pixels(); ++i) {
    const bool is_masked = !mask.empty() && mask.values()[i] == 0;
    // Without normals, a point at 0 is no surface.
    const bool is_surface = vector_at(normal.empty() ? position : normal, i).squaredNorm() > 0.0;
    if (is_masked || !is_surface) continue;
    is_known[i] = 1;
    points.push_back(vector_at(position, i));
    pixel_of.push_back(i);
  }
  PixelOfTexel pixels(static_cast<std::size_t>(map.num_texels()), -1);
  if (points.empty()) return pixels;
  const double reach = kReach * std::max(pixel_size_mm(position, is_known), map.median_texel_size_mm());
  const NearestPoints tree(std::move(points));
  parallel_for(map.num_texels(), kChunk, control, [&](std::int64_t begin, std::int64_t end) {
    for (TexelId t = begin; t < end; ++t) {
      if (!map.is_covered(t)) continue;
      const NearestPoints::Nearest found = tree.nearest_below(map.position_mm(t), reach);
      if (found.index < 0) continue;
      const std::int64_t pixel = pixel_of[found.index];
      if (normal.empty() || map.normal(t).dot(vector_at(normal, pixel)) > kSameSide) pixels[t] = pixel;
    }
  });
  return pixels;
}

PixelOfTexel pixels_in_view(const TexelMap& map, const Camera& camera, const RunControl& control) {
  const RayScene scene(map.mesh());
  const double epsilon = 1e-4 * bounding_box(map.mesh()).diagonal();
  const int width = camera.parameters().width, height = camera.parameters().height;
  PixelOfTexel pixels(static_cast<std::size_t>(map.num_texels()), -1);
  parallel_for(map.num_texels(), kChunk, control, [&](std::int64_t begin, std::int64_t end) {
    for (TexelId t = begin; t < end; ++t) {
      if (!map.is_covered(t)) continue;
      const Vec3 p = map.position_mm(t), to_camera = (camera.center() - p).normalized();
      if (!(map.normal(t).dot(to_camera) > kSteepestView)) continue;
      const std::optional<Vec2> seen = camera.project(p);
      if (!seen) continue;
      const double x = std::round(seen->x()), y = std::round(seen->y());
      if (!(x >= 0.0 && y >= 0.0 && x < width && y < height) || scene.is_blocked(p, camera.center(), epsilon)) continue;
      pixels[t] = static_cast<std::int64_t>(y) * width + static_cast<std::int64_t>(x);
    }
  });
  return pixels;
}

ImageF color_channel(const ImageF& color, const std::string& channel) {
  if (channel != "luminance" && channel != "saturation")
    throw InvalidInput("found `" + channel + "`; expected luminance or saturation");
  ImageF out(color.width(), color.height());
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      const std::span<const float> pixel = color.pixel(x, y);
      const auto [least, greatest] = std::minmax_element(pixel.begin(), pixel.end());
      out.at(x, y) = channel == "luminance" ? luminance(pixel)
                     : *greatest > 0.0F     ? (*greatest - *least) / *greatest
                                            : 0.0F;
    }
  }
  return out;
}

ImageF color_change(const ImageF& a, const ImageF& b) {
  const auto lab_at = [](const ImageF& image, int x, int y) {
    const std::span<const float> p = image.pixel(x, y);
    return lab_from_linear(static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2]));
  };
  ImageF out(a.width(), a.height());
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x)
      out.at(x, y) = static_cast<float>(ciede2000(lab_at(a, x, y), lab_at(b, x, y)));
  }
  return out;
}

}  // namespace patinate::cli
