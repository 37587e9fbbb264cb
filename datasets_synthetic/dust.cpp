#include "datasets_synthetic/dust.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "datasets_synthetic/posed_camera.h"
#include "libcommon/core/parallel.h"
#include "libcommon/output/microfacet.h"
#include "patinate/controls/exposure.h"
#include "patinate/datasets/objects.h"

namespace patinate::datasets {

namespace {

constexpr double kElevation = 28.0 * std::numbers::pi / 180.0;  ///< Elevation of the camera.
constexpr std::uint32_t kDustStream = 320;                      // Purpose of random streams.
constexpr std::int64_t kDustRows = 4;
constexpr double kGlassF0 = 0.04, kGlazeRoughness = 0.18, kDustRoughness = 0.9;
constexpr double kDustLamp = 1.2;           ///< Its irradiance, over pi times that of even light.
constexpr double kDustShadowOffset = 1e-4;  ///< Share of the height: shadow rays start so far above the surface.
const std::array<double, 3> kLampSide{-0.55, 0.70, 0.75};  ///< From the object.

DustOptions checked_dust(const DustOptions& o) {
  check_ranges(o);
  return o;
}

Vec3 unit(const std::array<double, 3>& v) { return Vec3(v[0], v[1], v[2]).normalized(); }

/// In front of the urn and above it, so that all of it is seen.
Camera urn_camera(const DustOptions& o) {
  const double size = o.height_mm, distance = 5.0 * size;
  const Vec3 target(0.0, 0.49 * size, 0.0),
      eye = target + distance * Vec3(0.0, std::sin(kElevation), std::cos(kElevation));
  CameraParameters p = posed_camera(eye, target, o.width, o.height);
  p.fx = p.fy = std::min(o.height / 1.30, o.width / 0.95) * distance / size;
  return Camera(p);
}

TexelMap urn_map(const DustOptions& o, const RunControl& control) {
  return {sculpture({.height_mm = o.height_mm}), dust_atlas_side(o), dust_atlas_side(o), control};
}

}  // namespace

void describe(OptionVisitor& v, DustOptions& o) {
  v.visit({"width", "Width of the photographs", "px", between(32, 4096)}, o.width);
  v.visit({"height", "Height of the photographs", "px", between(32, 4096)}, o.height);
  v.visit({"num_frames", "Photographs over time", "", between(2, 10000)}, o.num_frames);
  v.visit({"interval", "Time between photographs", "d", above(0)}, o.interval_d);
  v.visit({"object_height", "Height of the urn", "mm", above(0)}, o.height_mm);
  v.visit_choice(
      {"follows", "Dust settles where the surface faces up (facing), or where it sees much of the sky (exposure)"},
      o.follows, kDustFollowsNames);
  v.visit({"rate", "Grains that come to lie over each point of a level place under an open sky", "1/d", above(0)},
          o.rate);
  v.visit(
      {"steepness", "Exponent of facing or exposure: a larger one keeps dust off steep places", "", between(0.1, 20)},
      o.steepness);
  v.visit({"unevenness", "Unevenness of glaze and dust; 0 = none", "", between(0, 2)}, o.unevenness);
  v.visit({"shading", "How far one side is lit more than others; 0 = light is even", "", between(0, 1)}, o.shading);
  v.visit({"gloss", "Strength of the lamp's reflection; 1 = glass, 0 = none", "", between(0, 10)}, o.gloss);
  v.visit({"noise", "Standard deviation of the noise that is added to the photographs; 1 = full scale", "",
           between(0, 0.5)},
          o.noise);
  v.visit({"seed", "Every random choice derives from it", "", at_least(0)}, o.seed);
}

int dust_atlas_side(const DustOptions& o) { return std::clamp(2 * o.height, 256, 2048); }

DustyObject::DustyObject(const DustOptions& o, const RunControl& control)
    : options_(checked_dust(o)),
      camera_(urn_camera(o)),
      map_(urn_map(o, control)),
      scene_(map_.mesh()),
      exposure_(exposure_map(map_, {0.0, 1.0, 0.0}, {.num_rays = 128}, {}, {}, control).values),
      light_(exposure_map(map_, kLampSide, {.num_rays = 128}, {}, {}, control).values),
      glaze_(static_cast<std::uint64_t>(o.seed), kDustStream, 1.2, 2.0, 0.09, 0.09),
      dust_(static_cast<std::uint64_t>(o.seed), kDustStream + 1, 1.2, 2.0, 0.04, 0.04) {}

std::optional<DustPlace> DustyObject::place(const Vec2& pixel) const {
  const std::optional<CameraRay> ray = camera_.ray(pixel);
  const std::optional<RayHit> hit = ray ? scene_.first_hit(ray->origin, ray->direction) : std::nullopt;
  if (!hit) return std::nullopt;
  const Mesh& mesh = map_.mesh();
  const auto triangle = static_cast<std::size_t>(hit->triangle);
  const std::array<double, 3> weights{1.0 - hit->b1 - hit->b2, hit->b1, hit->b2};
  DustPlace place;
  place.normal = Vec3::Zero();
  for (std::size_t k = 0; k < 3; ++k) {
    place.position_mm += weights[k] * mesh.positions[mesh.triangles[triangle][k]];
    place.normal += weights[k] * mesh.normals[mesh.normal_triangles[triangle][k]];
  }
  place.normal.normalize();
  place.facing = std::max(0.0, place.normal.y());
  if (const TexelId t = map_.texel_of({hit->triangle, hit->b1, hit->b2}); t >= 0) {
    const auto index = static_cast<std::size_t>(t);
    place.exposure = static_cast<double>(exposure_.values()[index]);
    place.light = 1.0 + options_.shading * (1.1 * static_cast<double>(light_.values()[index]) - 0.75);
  }
  return place;
}

double DustyObject::noise(const SmoothNoise& field, const Vec3& p) const {
  // Over the plane that the camera faces.
  const double across = p.x(), up = std::cos(kElevation) * p.y() - std::sin(kElevation) * p.z();
  return options_.unevenness * field(across / options_.height_mm + 0.6, up / options_.height_mm + 0.5);
}

double DustyObject::amount(const DustPlace& place, double time_d) const {
  const double value = options_.follows == DustFollows::Facing ? place.facing : place.exposure;
  const double uneven = std::max(0.0, 1.0 + 0.9 * noise(dust_, place.position_mm));
  return options_.rate * std::pow(value, options_.steepness) * uneven * time_d;
}

DustLook DustyObject::look(const DustPlace& place, double time_d) const {
  DustLook look;
  look.cover = -std::expm1(-amount(place, time_d));
  const Vec3 glaze = Vec3(0.045, 0.085, 0.16) * (1.0 + 0.5 * noise(glaze_, place.position_mm));
  look.albedo = (1.0 - look.cover) * glaze + look.cover * kDustAlbedo;
  look.specular = kGlassF0 * (1.0 - look.cover);
  look.roughness = (1.0 - look.cover) * kGlazeRoughness + look.cover * kDustRoughness;
  return look;
}

Vec3 DustyObject::seen(const DustPlace& place, double time_d) const {
  const DustLook look = this->look(place, time_d);
  Vec3 value = place.light * look.albedo;
  const Vec3 to_lamp = unit(kLampSide), to_camera = (camera_.center() - place.position_mm).normalized();
  if (options_.gloss > 0.0 && place.normal.dot(to_lamp) > 0.0 && place.normal.dot(to_camera) > 0.0) {
    const double offset = kDustShadowOffset * options_.height_mm;
    const Vec3 from = place.position_mm + offset * place.normal;
    if (!scene_.is_blocked(from, from + 10.0 * options_.height_mm * to_lamp, offset)) {
      const Lobe::Value lobe = Lobe(place.normal, to_camera, look.roughness).value(to_lamp);
      value += Vec3::Constant(options_.gloss * kDustLamp * fresnel(look.specular, lobe.half_cosine) * lobe.shape);
    }
  }
  return value;
}

namespace {

/// Where in a pixel rays go.
std::vector<Vec2> rays_of(const DustOptions& o) {
  if (!(o.noise > 0.0)) return {Vec2::Zero()};
  return {Vec2(-0.25, -0.25), Vec2(0.25, -0.25), Vec2(-0.25, 0.25), Vec2(0.25, 0.25)};
}

/// A wall behind it, lighter below.
Vec3 backdrop(double y, int height) { return Vec3(0.20, 0.195, 0.185) * (0.7 + 0.6 * y / height); }

}  // namespace

DustView dust_view(const DustyObject& object, const RunControl& control) {
  const DustOptions& o = object.options();
  const ImageF one(o.width, o.height), three(o.width, o.height, 3);
  DustView view{ImageU8(o.width, o.height), three, three, one, one, one};
  const std::vector<Vec2> rays = rays_of(o);
  parallel_for(o.height, kDustRows, control, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < o.width; ++x) {
        const std::optional<DustPlace> place = object.place(Vec2(x, y));
        if (!place) continue;
        const bool is_whole = std::all_of(rays.begin(), rays.end(), [&](const Vec2& offset) {
          return object.place(Vec2(x, y) + offset).has_value();
        });
        view.mask.at(x, y) = is_whole ? 255 : 0;
        for (int c = 0; c < 3; ++c) {
          view.position_mm.at(x, y, c) = static_cast<float>(place->position_mm[c]);
          view.normal.at(x, y, c) = static_cast<float>(place->normal[c]);
        }
        view.facing.at(x, y) = static_cast<float>(place->facing);
        view.exposure.at(x, y) = static_cast<float>(place->exposure);
        view.light.at(x, y) = static_cast<float>(place->light);
      }
    }
  });
  return view;
}

ImageF dust_photo(const DustyObject& object, double time_d, const RunControl& control) {
  const DustOptions& o = object.options();
  ImageF out(o.width, o.height, 3);
  const std::vector<Vec2> rays = rays_of(o);
  parallel_for(o.height, kDustRows, control, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < o.width; ++x) {
        Vec3 sum = Vec3::Zero();
        for (const Vec2& offset : rays) {
          const std::optional<DustPlace> place = object.place(Vec2(x, y) + offset);
          sum += place ? object.seen(*place, time_d) : backdrop(y, o.height);
        }
        for (int c = 0; c < 3; ++c) out.at(x, y, c) = static_cast<float>(sum[c] / static_cast<double>(rays.size()));
      }
    }
  });
  return out;
}

}  // namespace patinate::datasets
