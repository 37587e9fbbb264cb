#include "libcommon/controls/light_set.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <tuple>

#include "libcommon/core/parallel.h"
#include "libcommon/geometry/ray_scene.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRayEdgeShare = 0.01;  ///< Longest edge under rays, in diagonals.
constexpr int kMaxLitTriangles = 400'000;
constexpr double kClearance = 2e-5;  ///< How far off the surface rays start, in diagonals.
constexpr int kPanoramaWidth = 512;  ///< Larger panoramas are averaged over blocks.

/// Bands of height, walked to and fro: neighbors in the list lie near each other in the sky.
void sort_by_place(LightSet& lights) {
  const double num_bands = std::max(1.0, std::round(std::sqrt(static_cast<double>(lights.directions.size()) / 2.0)));
  std::vector<std::tuple<int, double, std::size_t>> order;
  for (std::size_t i = 0; i < lights.directions.size(); ++i) {
    const Vec3& d = lights.directions[i];
    const int band = static_cast<int>(std::floor(0.5 * (d.z() + 1.0) * num_bands));
    const double azimuth = std::atan2(d.y(), d.x());
    order.emplace_back(band, band % 2 == 0 ? azimuth : -azimuth, i);
  }
  std::sort(order.begin(), order.end());
  LightSet sorted;
  for (const auto& [band, azimuth, i] : order) {
    sorted.directions.push_back(lights.directions[i]);
    sorted.weights.push_back(lights.weights[i]);
  }
  lights = std::move(sorted);
}

void normalize(LightSet& lights, const Vec3& up, const char* problem) {
  const double total = lights.free_light(up);
  if (!(total > 0.0) || !std::isfinite(total)) throw InvalidInput(problem);
  for (double& w : lights.weights) w /= total;
}

/// Luminance in blocks, at most kPanoramaWidth wide: light per solid angle.
ImageF shrunk_luminance(const ImageF& panorama) {
  const int block = std::max(1, (panorama.width() + kPanoramaWidth - 1) / kPanoramaWidth);
  ImageF small((panorama.width() + block - 1) / block, (panorama.height() + block - 1) / block);
  ImageF count(small.width(), small.height());
  for (int y = 0; y < panorama.height(); ++y) {
    for (int x = 0; x < panorama.width(); ++x) {
      const auto pixel = panorama.pixel(x, y);
      const float value =
          panorama.channels() >= 3 ? 0.2126F * pixel[0] + 0.7152F * pixel[1] + 0.0722F * pixel[2] : pixel[0];
      if (!(value >= 0.0F) || !std::isfinite(value))
        throw InvalidInput("sky: the panorama holds values that are not >= 0");
      small.at(x / block, y / block) += value;
      count.at(x / block, y / block) += 1.0F;
    }
  }
  for (std::size_t i = 0; i < small.values().size(); ++i) small.values()[i] /= count.values()[i];
  return small;
}

/// Neighboring texels whose rays in one direction go together.
struct TexelPacket {
  static constexpr std::size_t kMost = 8;
  std::size_t size = 0;
  std::array<TexelId, kMost> texel{};
  std::array<Vec3, kMost> origin;
  std::array<Vec3, kMost> normal;
  std::array<double, kMost> free{};
  std::array<double, kMost> blocked{};

  void add(TexelId t, const Vec3& position, const Vec3& n, double clearance) {
    texel[size] = t;
    origin[size] = position + clearance * n;
    normal[size] = n;
    free[size] = blocked[size] = 0.0;
    ++size;
  }
};

void light_packet(TexelPacket& packet, const LightSet& lights, const RayScene& scene, double reach) {
  std::array<Vec3, TexelPacket::kMost> origins;
  std::array<std::size_t, TexelPacket::kMost> which{};
  std::array<double, TexelPacket::kMost> value{};
  for (std::size_t k = 0; k < lights.directions.size(); ++k) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < packet.size; ++i) {
      const double light = lights.weights[k] * packet.normal[i].dot(lights.directions[k]);
      if (!(light > 0.0)) continue;
      packet.free[i] += light;
      origins[count] = packet.origin[i];
      value[count] = light;
      which[count++] = i;
    }
    if (count == 0) continue;
    const unsigned hit = scene.blocked_of_8(std::span(origins).first(count), lights.directions[k], reach);
    for (std::size_t j = 0; j < count; ++j) {
      if ((hit >> j & 1u) != 0) packet.blocked[which[j]] += value[j];
    }
  }
}

}  // namespace

double LightSet::free_light(const Vec3& n) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < directions.size(); ++i) sum += weights[i] * std::max(0.0, n.dot(directions[i]));
  return sum;
}

LightSet even_sphere(int num) {
  constexpr double kGoldenAngle = kPi * (3.0 - 2.23606797749978969641);
  LightSet lights;
  for (int i = 0; i < num; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / num, r = std::sqrt(1.0 - z * z), angle = kGoldenAngle * i;
    lights.directions.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
    lights.weights.push_back(1.0);
  }
  sort_by_place(lights);
  return lights;
}

LightSet even_sky(const Vec3& up, int num) {
  // The lattice's axis is turned onto `up`, which makes its upper half exact in number.
  const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), up);
  const LightSet sphere = even_sphere(2 * num);
  LightSet sky;
  for (const Vec3& d : sphere.directions) {
    if (!(d.z() > 0.0)) continue;
    sky.directions.push_back((turn * d).normalized());
    sky.weights.push_back(1.0);
  }
  normalize(sky, up, "sky: no direction is above the horizon");
  return sky;
}

LightSet panorama_sky(const Vec3& up, int num, const ImageF& panorama) {
  if (panorama.empty()) throw InvalidInput("sky: the panorama is empty");
  const ImageF light = shrunk_luminance(panorama);
  const LightSet cells = even_sphere(2 * num);
  std::vector<Vec3> sum(cells.directions.size(), Vec3::Zero());
  std::vector<double> total(cells.directions.size(), 0.0);
  for (int y = 0; y < light.height(); ++y) {
    const double polar = kPi * (y + 0.5) / light.height();
    for (int x = 0; x < light.width(); ++x) {
      const double azimuth = 2.0 * kPi * ((x + 0.5) / light.width() - 0.5);
      const Vec3 d(std::sin(polar) * std::sin(azimuth), std::cos(polar), -std::sin(polar) * std::cos(azimuth));
      const double energy = static_cast<double>(light.at(x, y)) * std::sin(polar);
      const auto nearer = [&](const Vec3& a, const Vec3& b) { return a.dot(d) < b.dot(d); };
      const auto cell = static_cast<std::size_t>(
          std::max_element(cells.directions.begin(), cells.directions.end(), nearer) - cells.directions.begin());
      sum[cell] += energy * d;
      total[cell] += energy;
    }
  }
  const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(Vec3::UnitY(), up);
  LightSet sky;
  for (std::size_t i = 0; i < total.size(); ++i) {
    if (!(total[i] > 0.0) || !(sum[i].norm() > 0.0)) continue;
    sky.directions.push_back((turn * sum[i]).normalized());
    sky.weights.push_back(total[i]);
  }
  normalize(sky, up, "sky: no light of the panorama reaches a surface that faces up");
  return sky;
}

ImageF shadowed_light(const SmoothSurface& surface, const LightSet& lights, double reach_mm, bool share_of_free,
                      const RunControl& control) {
  const TexelMap& map = surface.map();
  const RayScene scene(surface.mesh());
  const double clearance = kClearance * bounding_box(surface.mesh()).diagonal();
  ImageF out(map.width(), map.height());
  parallel_for(map.num_texels(), 512, control, [&](TexelId begin, TexelId end) {
    TexelPacket packet;
    for (TexelId t = begin; t < end; ++t) {
      if (map.is_covered(t)) packet.add(t, surface.position_mm(t), surface.normal(t), clearance);
      if (packet.size < TexelPacket::kMost && t + 1 < end) continue;
      light_packet(packet, lights, scene, reach_mm);
      for (std::size_t i = 0; i < packet.size; ++i) {
        const double free = packet.free[i], blocked = packet.blocked[i];
        const double value = share_of_free ? (free > 0.0 ? blocked / free : 0.0) : free - blocked;
        out.values()[packet.texel[i]] = static_cast<float>(value);
      }
      packet.size = 0;
    }
  });
  return out;
}

SmoothSurface surface_for_rays(const TexelMap& map, const RunControl& control) {
  return SmoothSurface(map, kRayEdgeShare * bounding_box(map.mesh()).diagonal(), kMaxLitTriangles, control);
}

}  // namespace patinate
