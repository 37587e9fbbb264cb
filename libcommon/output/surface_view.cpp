#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>

#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"
#include "libcommon/output/backdrop.h"
#include "libcommon/output/light_field.h"
#include "libcommon/output/render_light.h"
#include "libcommon/output/sampling.h"
#include "libcommon/output/surface_material.h"
#include "libcommon/output/surface_scene.h"
#include "patinate/core/error.h"
#include "patinate/output/render_surface.h"

namespace patinate {

namespace {

constexpr int kLampRays = 8;  // Per ray of the camera; fewer for what a mirror shows.
constexpr int kMirroredLampRays = 3;
constexpr int kMirrorRays = 4;  // Per ray of the camera, where the mirror is nearly all that is seen; fewer elsewhere.
constexpr int kFewGroundRays = 4;         // Where the pixel's other rays saw all lamps, or none.
constexpr double kMirrorBlur = 2.0;       // Solid angles of rays overlap by this, so that they do not show.
constexpr double kDullRoughness = 0.6;    // Above it, where little is reflected, ambient visibility
constexpr double kDullReflection = 0.15;  // stands for what a ray would meet.
constexpr double kDither = 0.011;  // A step of an 8-bit code at the backdrop's gray, as a share of its linear value.
constexpr double kFaintMirror = 1e-4;  // Share of reflected light for which no ray is cast.
constexpr std::int64_t kSurfaceRowsAChunk = 2;
constexpr std::uint32_t kPixel = 33;  // Purpose of random streams.
constexpr double kGolden = 0.6180339887498949;

/// Draws that one ray of the camera may use of its pixel's sequences.
struct Draws {
  std::array<LightField::Lamp, kLampRays> lamps = {};
  std::array<Vec2, kMirrorRays> mirrors = {};
  std::array<double, kMirrorRays> choices = {};
  Vec2 lamp_shift = Vec2::Zero();
  int sample = 0;
  int num_samples = 1;  ///< Number of samples of the pixel.
  double dither = 0.0;  ///< [-0.5, 0.5), of the pixel.
  std::optional<double> seen_share =
      std::nullopt;  ///< Share of lamps that the pixel's last full look at the ground saw.
};

/// Light of a few lamps at one place, as far as nothing stands between.
class LampRays {
 public:
  LampRays(const SurfaceScene& scene, const Vec3& from) : scene_(scene), from_(from) {}

  /// @param light  What the lamp gives where nothing hides it. At most kCapacity lamps.
  void add(const LightField::Sample& lamp, const Vec3& light) {
    directions_[num_] = lamp.direction;
    distances_[num_] = lamp.distance;
    lights_[num_++] = light;
  }
  /// @returns the share of lamps that are seen; 1 of none.
  double add_unblocked_to(Vec3& sum) const {
    constexpr std::size_t kAtOnce = 8;
    std::size_t num_seen = 0;
    for (std::size_t i = 0; i < num_; i += kAtOnce) {
      const std::size_t n = std::min(kAtOnce, num_ - i);
      const unsigned blocked =
          scene_.blocked_of_8(from_, std::span(directions_).subspan(i, n), std::span(distances_).subspan(i, n));
      for (std::size_t k = 0; k < n; ++k) {
        if ((blocked >> k & 1u) != 0u) continue;
        sum += lights_[i + k];
        ++num_seen;
      }
    }
    return num_ == 0 ? 1.0 : static_cast<double>(num_seen) / static_cast<double>(num_);
  }

 private:
  static constexpr std::size_t kCapacity = std::max(kLampRays, kGroundRays);

  const SurfaceScene& scene_;
  Vec3 from_;
  std::size_t num_ = 0;
  std::array<Vec3, kCapacity> directions_, lights_;
  std::array<double, kCapacity> distances_;
};

/// One picture of a scene.
class Painter {
 public:
  Painter(const SurfaceScene& scene, const RenderOptions& options, const SurfaceOptions& surface,
          const Surroundings* surroundings, const OrbitCamera& camera)
      : scene_(scene),
        options_(options),
        light_(options, surface, surroundings, scene.box().center()),
        shows_surroundings_(options.backdrop == Backdrop::Environment && surroundings != nullptr),
        camera_(camera),
        // Seen from below, the ground would hide the object.
        has_ground_(options.ground && camera.position.dot(scene.ground().up()) > scene.ground().height()) {}

  [[nodiscard]] Vec3 pixel(int x, int y) const {
    const int side = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(options_.samples))));
    RandomStream random(
        kRenderSeed, (static_cast<std::uint64_t>(static_cast<std::uint32_t>(y)) << 32) + static_cast<std::uint32_t>(x),
        kPixel);
    const Vec2 lamp_shift = pixel_shift(x, y), mirror_shift(random.uniform(), random.uniform());
    const double choice_shift = random.uniform();
    Draws draws{.lamp_shift = lamp_shift, .num_samples = side * side, .dither = random.uniform() - 0.5};
    Vec3 sum = Vec3::Zero();
    for (int k = 0; k < draws.num_samples; ++k) {
      draws.sample = k;
      const double u = (x + (k % side + 0.5) / side) / options_.width;
      const double v = (y + (k / side + 0.5) / side) / options_.height;
      for (int i = 0; i < kMirrorRays; ++i) {
        // Without the later rays of all samples the first ones still lie evenly.
        const int place = draws.num_samples * i + k;
        const double choice = choice_shift + kGolden * place;
        draws.mirrors[i] = sequence_point(place, mirror_shift);
        draws.choices[i] = choice - std::floor(choice);
      }
      sum += ray(u, v, draws);
    }
    return sum / draws.num_samples;
  }

 private:
  [[nodiscard]] Vec3 ray(double u, double v, Draws& draws) const {
    const Vec3 direction = camera_.direction(u, v);
    if (const std::optional<SeenPoint> hit = scene_.first_hit(camera_.position, direction)) {
      for (int i = 0; light_.has_lamps() && i < kLampRays; ++i)
        draws.lamps[i] = light_.lamp(sequence_point(kLampRays * draws.sample + i, draws.lamp_shift));
      return surface(*hit, draws);
    }
    const Vec3 behind = shows_surroundings_
                            ? light_.around(direction, pixel_angle())
                            : Vec3::Constant(dithered(draws) * static_cast<double>(backdrop(options_, u, v)));
    const double fall = direction.dot(scene_.ground().up());
    if (!has_ground_ || !(fall < -1e-6)) return behind;
    const double distance = (scene_.ground().height() - camera_.position.dot(scene_.ground().up())) / fall;
    return ground_light(camera_.position + distance * direction, draws) * behind;
  }

  /// The studio's backdrop changes so slowly that codes of 8 bits would show as rings.
  [[nodiscard]] double dithered(const Draws& draws) const {
    return options_.backdrop == Backdrop::Studio ? 1.0 + kDither * draws.dither : 1.0;
  }

  [[nodiscard]] double pixel_angle() const {
    return 4.0 * camera_.tan_x * camera_.tan_y / (static_cast<double>(options_.width) * options_.height);
  }

  // Share of the light on open ground that arrives at a place of it. Where the first ray of a pixel sees all lamps or
  // none, few lamps tell whether another of its rays does.
  [[nodiscard]] double ground_light(const Vec3& p, Draws& draws) const {
    if (draws.seen_share == 0.0 || draws.seen_share == 1.0) {
      const GroundLight few = ground_light(p, draws, kFewGroundRays);
      if (few.seen_share == *draws.seen_share) return few.light;
    }
    const GroundLight all = ground_light(p, draws, kGroundRays);
    draws.seen_share = all.seen_share;
    return all.light;
  }
  struct GroundLight {
    double light, seen_share;
  };
  [[nodiscard]] GroundLight ground_light(const Vec3& p, const Draws& draws, int num_rays) const {
    const Vec3& up = scene_.ground().up();
    const double smooth = luminance_of(light_.smooth_on(up));
    double whole = smooth;
    Vec3 lit = Vec3::Constant(smooth * scene_.ground().visibility(p));
    LampRays rays(scene_, p + scene_.ray_offset() * up);
    for (int i = 0; light_.has_lamps() && i < num_rays; ++i) {
      const Vec2 square = sequence_point(kGroundRays * draws.sample + i, draws.lamp_shift);
      const LightField::Sample lamp = light_.seen(light_.lamp(square), p);
      const double share =
          luminance_of(lamp.weight) / std::numbers::pi / num_rays * std::max(0.0, lamp.direction.dot(up));
      whole += share;
      if (share > 0.0) rays.add(lamp, Vec3::Constant(share));
    }
    const double seen_share = rays.add_unblocked_to(lit);
    return {whole > 0.0 ? lit.x() / whole : 1.0, seen_share};
  }

  // Where a place is lit: rays begin off the surface, which a near lamp would show.
  [[nodiscard]] Vec3 on_surface(const SeenPoint& p) const { return p.place - scene_.ray_offset() * p.face; }

  static int num_mirrors(const SurfaceMaterial& material) {
    if (!(material.reflected() > kFaintMirror)) return 0;
    const double all = material.reflected() + material.diffuse().sum() / 3.0;
    return std::clamp(static_cast<int>(std::ceil(kMirrorRays * material.reflected() / all)), 1, kMirrorRays);
  }

  [[nodiscard]] Vec3 surface(const SeenPoint& p, const Draws& draws) const {
    const SurfaceMaterial material(p);
    const int mirrors = num_mirrors(material);
    Vec3 sum = p.open * material.diffuse().cwiseProduct(light_.smooth_on(p.normal));
    if (light_.has_lamps()) {
      LampRays rays(scene_, p.place);
      for (const LightField::Lamp& drawn : draws.lamps) {
        const LightField::Sample lamp = light_.seen(drawn, on_surface(p));
        const double facing = p.normal.dot(lamp.direction);
        if (!(lamp.pdf > 0.0)) continue;
        const SurfaceMaterial::Reflection mirror = material.reflection(lamp.direction);
        Vec3 seen = std::max(0.0, facing) / std::numbers::pi * material.diffuse();
        // Balance heuristic [Veach and Guibas 1995] with the mirror's own rays, where these look for lamps.
        if (!light_.has_lamps_around())
          seen += mirror.value * (is_dull(p, material) ? 1.0 : balance(kLampRays * lamp.pdf, mirrors * mirror.pdf));
        if (seen.maxCoeff() > 0.0) rays.add(lamp, lamp.weight.cwiseProduct(seen) / kLampRays);
      }
      rays.add_unblocked_to(sum);
    }
    for (int i = 0; i < mirrors; ++i) sum += mirrored(p, material, draws, i, mirrors) / mirrors;
    return sum;
  }

  static bool is_dull(const SeenPoint& p, const SurfaceMaterial& material) {
    return p.roughness > kDullRoughness && material.reflected() < kDullReflection;
  }

  static double balance(double mine, double other) { return std::isinf(mine) ? 1.0 : mine / (mine + other); }

  // Light of the rough mirror: one of its rays, one bounce.
  [[nodiscard]] Vec3 mirrored(const SeenPoint& p, const SurfaceMaterial& material, const Draws& draws, int i,
                              int mirrors) const {
    Vec3 direction = material.sample(draws.mirrors[i], draws.choices[i]);
    const SurfaceMaterial::Reflection mirror = material.reflection(direction);
    if (!(mirror.pdf > 0.0)) return Vec3::Zero();
    const Vec3 weight = mirror.value / mirror.pdf;
    // Normals of a map may reflect into the surface itself: along it then.
    const double below = direction.dot(p.face);
    if (below < 0.0) direction = (direction - 1.02 * below * p.face).normalized();
    const bool dull = is_dull(p, material);
    const LightField::Sample lamp = light_.lamp_along(direction, p.place);
    const Vec3 of_lamp =
        lamp.pdf > 0.0 ? Vec3(lamp.weight * balance(mirrors * mirror.pdf, kLampRays * lamp.pdf)) : Vec3(Vec3::Zero());
    if (!dull) {
      if (const std::optional<SeenPoint> hit = scene_.first_hit(p.place, direction)) {
        const bool is_behind = (hit->place - p.place).norm() > lamp.distance;  // A near lamp hides nothing.
        return weight.cwiseProduct(second(*hit, draws) + (is_behind ? of_lamp : Vec3(Vec3::Zero())));
      }
    }
    // Averaged over what the other rays leave to this one [Krivanek and Colbert 2008].
    const Vec3 light = light_.around(direction, kMirrorBlur / (mirrors * draws.num_samples * mirror.pdf));
    if (dull) return p.open * weight.cwiseProduct(light);
    return weight.cwiseProduct(light + of_lamp);
  }

  // Light that another surface sends into the mirror: its own mirror counts as dull.
  [[nodiscard]] Vec3 second(const SeenPoint& p, const Draws& draws) const {
    Vec3 light = p.open * light_.smooth_on(p.normal);
    if (light_.has_lamps()) {
      LampRays rays(scene_, p.place);
      for (const LightField::Lamp& drawn : std::span(draws.lamps).first<kMirroredLampRays>()) {
        const LightField::Sample lamp = light_.seen(drawn, on_surface(p));
        const double facing = p.normal.dot(lamp.direction);
        if (facing > 0.0) rays.add(lamp, facing / std::numbers::pi / kMirroredLampRays * lamp.weight);
      }
      rays.add_unblocked_to(light);
    }
    return SurfaceMaterial(p).all().cwiseProduct(light);
  }

  const SurfaceScene& scene_;
  RenderOptions options_;
  LightField light_;
  bool shows_surroundings_;
  OrbitCamera camera_;
  bool has_ground_;
};

}  // namespace

void describe(OptionVisitor& v, SurfaceOptions& o) {
  v.visit({"relief", "Factor for heights and for the slopes of normal maps; 0 = flat", "", between(0, 100)}, o.relief);
  v.visit({"plants", "Factor of the number of small plants where much has grown; 0 = none", "", between(0, 100)},
          o.plants);
  v.visit(
      {"plant_size", "Mean height of a plant, in the mesh's unit; 0 = 1/220 of the mesh's diagonal", "", at_least(0)},
      o.plant_size);
  v.visit({"plant_cushion", "Diameter of the largest cushions of plants, in plant heights; 0 = no cushions", "",
           between(0, 1000)},
          o.plant_cushion);
  v.visit({"environment_azimuth", "Turns the surroundings around the up axis; 0: their middle is behind the object",
           "deg", between(-3600, 3600)},
          o.environment_azimuth_deg);
  v.visit({"environment_light", "Mean radiance to which the surroundings are scaled; 0 = as they are", "",
           between(0, 1000)},
          o.environment_light);
}

struct SurfaceView::Impl {
  RenderOptions options;
  SurfaceOptions surface;
  Mesh mesh;
  std::unique_ptr<const Surroundings> surroundings = {};
  std::shared_ptr<const SurfaceShape> shape = {};
  std::unique_ptr<const SurfaceScene> scene = {};
};

SurfaceView::SurfaceView(const Mesh& mesh, SurfaceMaps maps, const RenderOptions& options,
                         const SurfaceOptions& surface, ImageF environment, const RunControl& control) {
  check_render_options(options);
  check_ranges(surface);
  const double diagonal = bounding_box(mesh).diagonal();
  if (!(diagonal > 0.0) || !std::isfinite(diagonal)) throw InvalidInput("render: the mesh has no extent");
  auto impl = std::make_unique<Impl>(Impl{.options = options, .surface = surface, .mesh = mesh});
  if (!environment.empty())
    impl->surroundings = std::make_unique<const Surroundings>(environment, surface.environment_light);
  impl_ = std::move(impl);
  show(std::move(maps), control);
}

void SurfaceView::show(SurfaceMaps maps, const RunControl& control) {
  const ImageF& height = SurfaceScene::heights(maps, impl_->surface);
  if (!impl_->shape || !impl_->shape->fits(height))
    impl_->shape = std::make_shared<const SurfaceShape>(impl_->mesh, height, impl_->options, control);
  impl_->scene = std::make_unique<const SurfaceScene>(impl_->mesh, impl_->shape, std::move(maps), impl_->options,
                                                      impl_->surface, control.silent());
  control.report(1.0);
}

SurfaceView::~SurfaceView() = default;
SurfaceView::SurfaceView(SurfaceView&&) noexcept = default;
SurfaceView& SurfaceView::operator=(SurfaceView&&) noexcept = default;

ImageF SurfaceView::picture(const RunControl& control) const {
  return picture(impl_->options.azimuth_deg, impl_->options.elevation_deg, control);
}

ImageF SurfaceView::picture(double azimuth_deg, double elevation_deg, const RunControl& control) const {
  RenderOptions options = impl_->options;
  options.azimuth_deg = azimuth_deg;
  options.elevation_deg = elevation_deg;
  const OrbitCamera camera = fitted_camera(impl_->mesh, options);
  const Painter painter(*impl_->scene, options, impl_->surface, impl_->surroundings.get(), camera);
  ImageF picture(options.width, options.height, 3);
  parallel_for(options.height, kSurfaceRowsAChunk, control, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < end; ++y) {
      for (int x = 0; x < options.width; ++x) {
        control.throw_if_stopped();
        const Vec3 color = painter.pixel(x, y);
        for (int c = 0; c < 3; ++c) picture.at(x, y, c) = static_cast<float>(color[c]);
      }
    }
  });
  return picture;
}

}  // namespace patinate
