#include "datasets_synthetic/mold_light.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "datasets_synthetic/smooth_noise.h"
#include "libcommon/core/parallel.h"
#include "libcommon/geometry/ray_scene.h"
#include "libcommon/geometry/scan_mesh.h"

namespace patinate::datasets {

namespace {

constexpr double kTableAlbedo = 0.045;
constexpr double kMoldShadowOffset = 2e-4;  ///< Share of the radius: shadow rays start so far above the surface.
constexpr std::int64_t kLitRows = 4;

bool is_exact(const MoldOptions& o) { return !(o.noise > 0.0) && !(o.scan_noise_mm > 0.0); }

/// Point that one ray of the camera meets.
struct Seen {
  Vec3 position = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();
  MoldLook look;
  bool is_object = false;
};

class MoldPicture {
 public:
  MoldPicture(const Mold& mold, const MoldRig& rig, int step, const Mesh& surface)
      : mold_(mold),
        rig_(rig),
        back_(rig.scanner_from_object[step].inverse()),
        gain_(rig.gains[step]),
        time_d_(step * mold.options().interval_d),
        surface_(surface),
        scene_(surface),
        grain_(static_cast<std::uint64_t>(mold.options().seed), 212, 8.0, 8.0, 0.12, 0.03) {}

  [[nodiscard]] std::optional<Seen> look(const Vec2& pixel) const {
    const std::optional<CameraRay> ray = rig_.camera.ray(pixel);
    if (!ray) return std::nullopt;
    Seen seen;
    if (const std::optional<RayHit> hit = scene_.first_hit(ray->origin, ray->direction)) {
      const Triangle& t = surface_.triangles[hit->triangle];
      const std::array<double, 3> weights{1.0 - hit->b1 - hit->b2, hit->b1, hit->b2};
      seen.normal = Vec3::Zero();
      for (std::size_t k = 0; k < 3; ++k) {
        seen.position += weights[k] * surface_.positions[t[k]];
        seen.normal += weights[k] * surface_.normals[t[k]];
      }
      seen.normal.normalize();
      const Vec3 p = back_.apply(seen.position);
      seen.look = mold_.look(p.x(), p.y(), time_d_);
      seen.is_object = true;
      return seen;
    }
    const double depth = (rig_.table_mm - ray->origin.z()) / ray->direction.z();
    if (!(depth > 0.0)) return std::nullopt;
    seen.position = ray->origin + depth * ray->direction;
    const Box& card = rig_.card;
    const bool is_card = seen.position.x() > card.low.x() && seen.position.x() < card.high.x() &&
                         seen.position.y() > card.low.y() && seen.position.y() < card.high.y();
    const double radius = mold_.options().radius_mm;
    const double grain = 1.0 + 0.5 * grain_(seen.position.x() / radius + 4.0, seen.position.y() / radius + 4.0);
    seen.look.albedo =
        is_card ? Vec3(kMoldCardAlbedo * Vec3::Ones()) : Vec3(kTableAlbedo * grain * Vec3(1.0, 0.92, 0.85));
    return seen;
  }

  [[nodiscard]] bool is_lit(const Seen& seen, const Light& light) const {
    if (!(seen.normal.dot(direction_to(light, seen.position)) > 0.0)) return false;
    const double offset = kMoldShadowOffset * mold_.options().radius_mm;
    return !mold_.options().shadows || !scene_.is_blocked(seen.position + offset * seen.normal, light.position, offset);
  }

  /// Linear value under one light, without ambient light.
  [[nodiscard]] Vec3 lit(const Seen& seen, const Light& light) const {
    if (!is_lit(seen, light)) return Vec3::Zero();
    const Vec3 to_light = direction_to(light, seen.position),
               to_camera = (rig_.camera.center() - seen.position).normalized();
    const Vec3 share = seen.look.albedo / std::numbers::pi + mirror(seen, to_light, to_camera);
    return gain_.cwiseProduct(share.cwiseProduct(light_at(light, seen.position))) * seen.normal.dot(to_light);
  }
  [[nodiscard]] Vec3 dark(const Seen& seen) const {
    return mold_.options().ambient * gain_.cwiseProduct(seen.look.albedo);
  }

 private:
  [[nodiscard]] Vec3 mirror(const Seen& seen, const Vec3& to_light, const Vec3& to_camera) const {
    if (!seen.is_object) return Vec3::Zero();
    if (mold_.options().metal) return metal_lobe(seen.look, seen.normal, to_light, to_camera);
    return Vec3::Constant(mold_lobe(seen.look, seen.normal, to_light, to_camera));
  }

  const Mold& mold_;
  const MoldRig& rig_;
  RigidTransform back_;
  Vec3 gain_;
  double time_d_;
  const Mesh& surface_;
  RayScene scene_;
  SmoothNoise grain_;
};

void add(ImageF& image, int x, int y, const Vec3& value) {
  for (int c = 0; c < 3; ++c) image.at(x, y, c) += static_cast<float>(value[c]);
}

}  // namespace

Mesh mold_surface(const Mold& mold, const MoldRig& rig, int step, const RunControl& control) {
  if (is_exact(mold.options())) return mesh_of_scan(mold_scan(mold, rig, step, control));
  Mesh mesh = mold.mesh(mold.options().radius_mm / 160.0, step * mold.options().interval_d);
  const RigidTransform& motion = rig.scanner_from_object[step];
  for (Vec3& p : mesh.positions) p = motion.apply(p);
  for (Vec3& n : mesh.normals) n = motion.rotation * n;
  return mesh;
}

MoldPhotos mold_photos(const Mold& mold, const MoldRig& rig, int step, const Mesh& surface, const RunControl& control) {
  const MoldOptions& o = mold.options();
  const MoldPicture picture(mold, rig, step, surface);
  MoldPhotos photos;
  photos.dark = ImageF(o.width, o.height, 3);
  photos.lit.assign(rig.lights.size(), photos.dark);
  photos.in_light.assign(rig.lights.size(), ImageU8(o.width, o.height));
  std::vector<Vec2> offsets{Vec2(-0.25, -0.25), Vec2(0.25, -0.25), Vec2(-0.25, 0.25), Vec2(0.25, 0.25)};
  if (is_exact(o)) offsets = {Vec2::Zero()};
  const double share = 1.0 / static_cast<double>(offsets.size());
  parallel_for(o.height, kLitRows, control, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < o.width; ++x) {
        if (const std::optional<Seen> middle = picture.look(Vec2(x, y)); middle && middle->is_object) {
          for (std::size_t i = 0; i < rig.lights.size(); ++i)
            photos.in_light[i].at(x, y) = picture.is_lit(*middle, rig.lights[i]) ? 255 : 0;
        }
        for (const Vec2& offset : offsets) {
          const std::optional<Seen> seen = picture.look(Vec2(x, y) + offset);
          if (!seen) continue;
          const Vec3 dark = picture.dark(*seen);
          add(photos.dark, x, y, share * dark);
          for (std::size_t i = 0; i < rig.lights.size(); ++i)
            add(photos.lit[i], x, y, share * (dark + picture.lit(*seen, rig.lights[i])));
        }
      }
    }
  });
  return photos;
}

MoldView mold_view(const MoldRig& rig, const Mesh& surface, const RunControl& control) {
  const CameraParameters& p = rig.camera.parameters();
  MoldView view{ImageU8(p.width, p.height), ImageF(p.width, p.height, 3), ImageF(p.width, p.height, 3),
                ImageF(p.width, p.height, 2)};
  const RayScene scene(surface);
  const RigidTransform back = rig.scanner_from_object.front().inverse();
  parallel_for(p.height, kLitRows, control, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < p.width; ++x) {
        const std::optional<CameraRay> ray = rig.camera.ray(Vec2(x, y));
        const std::optional<RayHit> hit = ray ? scene.first_hit(ray->origin, ray->direction) : std::nullopt;
        if (!hit) continue;
        const Triangle& t = surface.triangles[hit->triangle];
        const std::array<double, 3> weights{1.0 - hit->b1 - hit->b2, hit->b1, hit->b2};
        Vec3 position = Vec3::Zero(), normal = Vec3::Zero();
        for (std::size_t k = 0; k < 3; ++k) {
          position += weights[k] * surface.positions[t[k]];
          normal += weights[k] * surface.normals[t[k]];
        }
        normal.normalize();
        const Vec3 in_object = back.apply(position);
        view.mask.at(x, y) = 255;
        for (int c = 0; c < 3; ++c) {
          view.position_mm.at(x, y, c) = static_cast<float>(position[c]);
          view.normal.at(x, y, c) = static_cast<float>(normal[c]);
          if (c < 2) view.object_mm.at(x, y, c) = static_cast<float>(in_object[c]);
        }
      }
    }
  });
  return view;
}

}  // namespace patinate::datasets
