#include "capture/relit/relit_view.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

#include "libcommon/core/median.h"
#include "libcommon/core/parallel.h"
#include "libcommon/image/between_pixels.h"

namespace patinate::capture {

namespace {

constexpr std::int64_t kRowChunk = 4;
constexpr double kWhole =
    1e-3;  ///< A place so near to a pixel's center is that pixel: rounding of float maps, not motion.
constexpr double kSameSurface = 6.0;  ///< Neighboring pixels of one surface are not farther apart, in texel sizes.
/// Of the second differences around: how far a pixel's mean is off the value at its center, and what is added half a
/// pixel from the centers, across and down. For edges and ridges that are soft by a pixel (docs/algorithms/relit.md).
constexpr double kPixelMean = 0.1, kBetweenPixels = 0.085;
constexpr double kGrazing = 1e-3;  ///< Least cosine, so that a grazing ray does not leave the picture.

/// Where the pixels half a step to each side meet the plane of the triangle.
double texel_size(const Camera& camera, const Vec2& pixel, const Vec3& position, const Vec3& normal) {
  const Vec3& eye = camera.center();
  const auto on_plane = [&](const Vec2& offset) {
    const std::optional<CameraRay> ray = camera.ray(pixel + offset);
    if (!ray) return position;
    const double slope = ray->direction.dot(normal), least = std::copysign(kGrazing, slope);
    return Vec3(eye + (position - eye).dot(normal) / (std::abs(slope) < kGrazing ? least : slope) * ray->direction);
  };
  const Vec3 across = on_plane(Vec2(0.5, 0.0)) - on_plane(Vec2(-0.5, 0.0)),
             down = on_plane(Vec2(0.0, 0.5)) - on_plane(Vec2(0.0, -0.5));
  return std::sqrt(across.cross(down).norm());
}

/// Whether a pixel and the eight around it see one surface: then all of its area does, where its center alone may lie
/// on the surface and half of its area beside it.
bool is_whole(const ScanView& view, int x, int y) {
  const Vec3 p = pixel_vector(view.position_mm, x, y);
  const double reach = kSameSurface * static_cast<double>(view.texel_size_mm.at(x, y));
  for (int j = -1; j <= 1; ++j) {
    for (int i = -1; i <= 1; ++i) {
      if (!view.seen.contains(x + i, y + j) || view.seen.at(x + i, y + j) == 0) return false;
      if (!((pixel_vector(view.position_mm, x + i, y + j) - p).norm() < reach)) return false;
    }
  }
  return true;
}

/// 255 where is_whole().
ImageU8 whole_pixels(const ScanView& view, const RunControl& control) {
  ImageU8 whole(view.seen.width(), view.seen.height());
  parallel_for(whole.height(), kRowChunk, control, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < whole.width(); ++x)
        whole.at(x, y) = view.seen.at(x, y) != 0 && is_whole(view, x, y) ? 255 : 0;
    }
  });
  return whole;
}

/// Value between sixteen pixels, all of them whole and none saturated; else nothing.
std::optional<Vec3> sample_cubic(const ImageF& photo, const ImageU8& whole, const Vec2& at, float saturation) {
  const int x0 = static_cast<int>(std::floor(at.x())), y0 = static_cast<int>(std::floor(at.y()));
  const std::array<double, 4> across = between_pixels::cubic_weights(at.x() - x0),
                              down = between_pixels::cubic_weights(at.y() - y0);
  Vec3 sum = Vec3::Zero();
  for (int j = 0; j < 4; ++j) {
    for (int i = 0; i < 4; ++i) {
      const double weight = across[static_cast<std::size_t>(i)] * down[static_cast<std::size_t>(j)];
      if (weight == 0.0) continue;
      const int x = x0 + i - 1, y = y0 + j - 1;
      if (!photo.contains(x, y) || !is_inside(whole, x, y)) return std::nullopt;
      for (int c = 0; c < photo.channels(); ++c) {
        if (!(photo.at(x, y, c) < saturation)) return std::nullopt;
        sum[c] += weight * static_cast<double>(photo.at(x, y, c));
      }
    }
  }
  return sum.cwiseMax(0.0);
}

/// Value between those of the four pixels that are whole; nothing where one of the four is saturated.
std::optional<Vec3> sample_bilinear(const ImageF& photo, const ImageU8& whole, const Vec2& at, float saturation) {
  const int x0 = static_cast<int>(std::floor(at.x())), y0 = static_cast<int>(std::floor(at.y()));
  Vec3 sum = Vec3::Zero();
  double used = 0.0;
  for (int j = 0; j < 2; ++j) {
    for (int i = 0; i < 2; ++i) {
      const double weight = (i == 0 ? 1.0 - (at.x() - x0) : at.x() - x0) * (j == 0 ? 1.0 - (at.y() - y0) : at.y() - y0);
      if (!(weight > 0.0)) continue;
      if (!photo.contains(x0 + i, y0 + j)) return std::nullopt;
      if (!is_inside(whole, x0 + i, y0 + j)) continue;
      used += weight;
      for (int c = 0; c < photo.channels(); ++c) {
        const float value = photo.at(x0 + i, y0 + j, c);
        if (!(value < saturation)) return std::nullopt;
        sum[c] += weight * static_cast<double>(value);
      }
    }
  }
  return Vec3(sum / used);
}

/// Deviation of a sample, in second differences around: 0.1 at a pixel's center, 0.27 in the middle of four pixels.
double sampled_share(const Vec2& place) {
  double share = kPixelMean;
  for (const double at : {place.x(), place.y()}) {
    const double t = at - std::floor(at), between = 4.0 * t * (1.0 - t);
    share += kBetweenPixels * between * between;
  }
  return share;
}

/// How far from a place the middle of the pixels lies that its sample is made of, px: 0 unless some of the nearest four
/// have no part in it.
double distance_from_sample(const ImageU8& whole, const Vec2& at) {
  const Vec2 corner(std::floor(at.x()), std::floor(at.y()));
  Vec2 sum = Vec2::Zero();
  double used = 0.0;
  for (const Vec2& offset : {Vec2(0, 0), Vec2(1, 0), Vec2(0, 1), Vec2(1, 1)}) {
    const Vec2 pixel = corner + offset;
    const double weight = (1.0 - std::abs(at.x() - pixel.x())) * (1.0 - std::abs(at.y() - pixel.y()));
    if (!(weight > 0.0) || !is_inside(whole, static_cast<int>(pixel.x()), static_cast<int>(pixel.y()))) continue;
    sum += weight * pixel;
    used += weight;
  }
  return used > 0.0 ? (sum / used - at).norm() : 0.0;
}

/// Mean squares of first and second differences across and down, times two: of a direction in which values change.
struct SquaredDifferences {
  Vec3 slope = Vec3::Zero(), bend = Vec3::Zero();
};

/// Of the texels around and the texel itself, as far as they have neighbors in the mask.
SquaredDifferences differences_around(const ImageF& albedo, const ImageU8& mask, int x, int y) {
  const auto is_known = [&](int i, int j) { return mask.contains(i, j) && mask.at(i, j) != 0; };
  SquaredDifferences sums;
  int num_slopes = 0, num_bends = 0;
  for (int j = y - 1; j <= y + 1; ++j) {
    for (int i = x - 1; i <= x + 1; ++i) {
      if (!is_known(i, j)) continue;
      const Vec3 here = pixel_vector(albedo, i, j);
      for (const auto& [dx, dy] : {std::pair(1, 0), std::pair(0, 1)}) {
        if (!is_known(i + dx, j + dy)) continue;
        const Vec3 next = pixel_vector(albedo, i + dx, j + dy);
        sums.slope += (next - here).cwiseAbs2();
        ++num_slopes;
        if (!is_known(i - dx, j - dy)) continue;
        sums.bend += (next - 2.0 * here + pixel_vector(albedo, i - dx, j - dy)).cwiseAbs2();
        ++num_bends;
      }
    }
  }
  sums.slope *= 2.0 / std::max(1, num_slopes);
  sums.bend *= 2.0 / std::max(1, num_bends);
  return sums;
}

}  // namespace

ScanView view_scan(const Mesh& mesh, const RayScene& scene, const Camera& camera, const RunControl& control) {
  const int width = camera.parameters().width, height = camera.parameters().height;
  ScanView view;
  view.seen = ImageU8(width, height);
  view.position_mm = view.normal = ImageF(width, height, 3);
  view.texel_size_mm = ImageF(width, height);
  std::vector<std::int64_t> behind(static_cast<std::size_t>(height), 0);
  parallel_for(height, kRowChunk, control, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < width; ++x) {
        const Vec2 pixel(x, y);
        const std::optional<CameraRay> ray = camera.ray(pixel);
        const std::optional<RayHit> hit = ray ? scene.first_hit(ray->origin, ray->direction) : std::nullopt;
        if (!hit) continue;
        const std::size_t t = hit->triangle;
        const std::array<double, 3> weights{1.0 - hit->b1 - hit->b2, hit->b1, hit->b2};
        Vec3 position = Vec3::Zero(), normal = Vec3::Zero();
        for (std::size_t k = 0; k < 3; ++k) {
          position += weights[k] * mesh.positions[mesh.triangles[t][k]];
          normal += weights[k] * mesh.normals[mesh.normal_triangles[t][k]];
        }
        const Vec3 face = area_vector(mesh, hit->triangle).normalized();
        normal = normal.norm() > 1e-9 ? Vec3(normal.normalized()) : face;
        // The side that is seen is the outside, however the triangle is wound.
        const double sign = face.dot(ray->direction) > 0.0 ? -1.0 : 1.0;
        behind[y] += sign < 0.0;
        view.seen.at(x, y) = 255;
        set_pixel_vector(view.position_mm, x, y, position);
        set_pixel_vector(view.normal, x, y, normal.dot(face) < 0.0 ? Vec3(-sign * normal) : Vec3(sign * normal));
        view.texel_size_mm.at(x, y) = static_cast<float>(texel_size(camera, pixel, position, face));
      }
    }
  });
  view.num_seen =
      std::count_if(view.seen.values().begin(), view.seen.values().end(), [](std::uint8_t v) { return v != 0; });
  view.num_from_behind = std::accumulate(behind.begin(), behind.end(), std::int64_t{0});
  return view;
}

Mesh with_scan_normals(Mesh mesh, int num_rounds) {
  if (!mesh.normals.empty() && mesh.normal_triangles.size() == mesh.triangles.size()) return mesh;
  mesh.normals = vertex_normals(mesh);
  mesh.normal_triangles = mesh.triangles;
  for (int round = 0; round < num_rounds; ++round) {
    std::vector<Vec3> sums(mesh.normals.size(), Vec3::Zero());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const double area = area_vector(mesh, static_cast<int>(t)).norm();
      Vec3 sum = Vec3::Zero();
      for (int corner : mesh.triangles[t]) sum += mesh.normals[corner];
      for (int corner : mesh.triangles[t]) sums[corner] += area * sum;
    }
    for (std::size_t i = 0; i < sums.size(); ++i) {
      if (sums[i].norm() > 0.0) mesh.normals[i] = sums[i].normalized();
    }
  }
  return mesh;
}

StepPlaces find_places(const ScanView& reference, const ScanView& step, const Camera& camera,
                       const RigidTransform& step_from_reference, const RunControl& control) {
  const int width = reference.seen.width(), height = reference.seen.height();
  StepPlaces places{ImageF(width, height, 2), ImageU8(width, height), whole_pixels(step, control.silent())};
  ImageF offsets(width, height, 1, -1.0f);
  parallel_for(height, kRowChunk, control, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < width; ++x) {
        if (reference.seen.at(x, y) == 0) continue;
        const Vec3 p = step_from_reference.apply(pixel_vector(reference.position_mm, x, y));
        const std::optional<Vec2> at = camera.project(p);
        if (!at) continue;
        const double u = std::abs(at->x() - std::round(at->x())) < kWhole ? std::round(at->x()) : at->x();
        const double v = std::abs(at->y() - std::round(at->y())) < kWhole ? std::round(at->y()) : at->y();
        const int column = static_cast<int>(std::lround(std::clamp(u, -2.0, width + 2.0))),
                  row = static_cast<int>(std::lround(std::clamp(v, -2.0, height + 2.0)));
        if (!step.seen.contains(column, row) || step.seen.at(column, row) == 0) continue;
        const Vec3 away = p - pixel_vector(step.position_mm, column, row);
        offsets.at(x, y) = static_cast<float>(std::abs(away.dot(pixel_vector(step.normal, column, row))));
        const double reach = kSameSurface * static_cast<double>(step.texel_size_mm.at(column, row));
        if (places.whole.at(column, row) == 0 || !(away.norm() < reach)) continue;
        places.place_px.at(x, y, 0) = static_cast<float>(u);
        places.place_px.at(x, y, 1) = static_cast<float>(v);
        places.seen.at(x, y) = 255;
      }
    }
  });
  std::vector<float> found;
  std::copy_if(offsets.values().begin(), offsets.values().end(), std::back_inserter(found),
               [](float v) { return v >= 0.0f; });
  places.num_on_scan = static_cast<std::int64_t>(found.size());
  if (!found.empty()) places.offset_mm = static_cast<double>(median(std::move(found)));
  return places;
}

PlacedPhoto place_photo(const ImageF& photo, const StepPlaces& places, float saturation) {
  const int width = places.seen.width(), height = places.seen.height(), channels = photo.channels();
  PlacedPhoto out{ImageF(width, height, channels), ImageU8(width, height)};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (places.seen.at(x, y) == 0) continue;
      const Vec2 at(static_cast<double>(places.place_px.at(x, y, 0)), static_cast<double>(places.place_px.at(x, y, 1)));
      std::optional<Vec3> value = sample_cubic(photo, places.whole, at, saturation);
      if (!value) value = sample_bilinear(photo, places.whole, at, saturation);
      if (!value) continue;
      for (int c = 0; c < channels; ++c) out.values.at(x, y, c) = static_cast<float>((*value)[c]);
      out.valid.at(x, y) = 255;
    }
  }
  return out;
}

void add_sampling_deviation(const ImageF& albedo, const ImageU8& mask, const StepPlaces& places, ImageF& stddev) {
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      if (mask.at(x, y) == 0) continue;
      const Vec2 at(static_cast<double>(places.place_px.at(x, y, 0)), static_cast<double>(places.place_px.at(x, y, 1)));
      const double share = sampled_share(at), distance = distance_from_sample(places.whole, at);
      const SquaredDifferences around = differences_around(albedo, mask, x, y);
      for (int c = 0; c < 3; ++c) {
        float& deviation = stddev.at(x, y, c);
        const double variance = share * share * around.bend[c] + distance * distance * around.slope[c];
        deviation = std::hypot(deviation, static_cast<float>(std::sqrt(variance)));
      }
    }
  }
}

}  // namespace patinate::capture
