#include "datasets_synthetic/drying.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "datasets_synthetic/smooth_noise.h"
#include "libcommon/core/parallel.h"
#include "libcommon/output/microfacet.h"
#include "patinate/geometry/mesh.h"

namespace patinate::datasets {

namespace {

constexpr std::uint32_t kDryingStream = 300;  // Purposes of random streams.
constexpr std::int64_t kDryingRows = 8;
constexpr double kWaterIndex = 1.333;
constexpr double kDiffuseReflection = 0.066;  ///< Share of diffuse light that comes from air.
constexpr double kRim = 0.03;                 ///< Share of the radius: where the stone is not yet soaked at the start.
constexpr double kGrainMm = 0.04;             ///< A film that is thinner is pierced.
constexpr double kFilmRoughness = 0.22, kStoneRoughness = 0.9;
constexpr double kWaterF0 = 0.02;
constexpr double kRipple = 0.6;  ///< Height of the film's ripples, pixels.
constexpr double kDryingLamp =
    1.8;  ///< The lamp's irradiance from straight above, over pi times that of the even light.

DryingOptions checked_drying(const DryingOptions& o) {
  check_ranges(o);
  return o;
}

}  // namespace

void describe(OptionVisitor& v, DryingOptions& o) {
  v.visit({"width", "Width of the photographs", "px", between(32, 4096)}, o.width);
  v.visit({"height", "Height of the photographs", "px", between(32, 4096)}, o.height);
  v.visit({"texel_size", "Length on the stone that a pixel shows", "mm", above(0)}, o.texel_size_mm);
  v.visit({"num_frames", "Photographs over time", "", between(2, 10000)}, o.num_frames);
  v.visit({"interval", "Time between photographs", "min", above(0)}, o.interval_min);
  v.visit_choice({"order", "Where the film of water goes first: at the rim, or where it is thin"}, o.order,
                 kDryingOrderNames);
  v.visit({"film", "Water on the stone, where there is most", "mm", above(0)}, o.film_mm);
  v.visit({"evaporation", "How fast the film goes; with order `rim` in the middle of the patch", "mm/h", above(0)},
          o.evaporation_mm_h);
  v.visit({"pores", "Time constant in which the stone's pores dry once the film is gone", "min", above(0)},
          o.pores_min);
  v.visit({"texture", "How uneven the stone's color is; 0 = one color", "", between(0, 2)}, o.texture);
  v.visit({"gloss", "Strength of the lamp's reflection; 1 = water, 0 = none", "", between(0, 10)}, o.gloss);
  v.visit({"noise", "Standard deviation of the noise that is added to the photographs; 1 = full scale", "",
           between(0, 0.5)},
          o.noise);
  v.visit({"seed", "Every random choice derives from it", "", at_least(0)}, o.seed);
}

double wet_albedo(double dry) {
  constexpr double kBack = 1.0 - (1.0 - kDiffuseReflection) / (kWaterIndex * kWaterIndex);
  return (1.0 - kDiffuseReflection) * (1.0 - kBack) * dry / (1.0 - kBack * dry);
}

DryingPatch::DryingPatch(const DryingOptions& o)
    : options_(checked_drying(o)),
      radius_(0.36 * std::min(o.width, o.height)),
      outline_(static_cast<std::uint64_t>(o.seed), kDryingStream, o.width, o.height, 0.8 * radius_, 0.8 * radius_),
      ragged_(static_cast<std::uint64_t>(o.seed), kDryingStream + 1, o.width, o.height, 0.13 * radius_, 0.13 * radius_),
      puddles_(static_cast<std::uint64_t>(o.seed), kDryingStream + 2, o.width, o.height, 0.45 * radius_,
               0.45 * radius_),
      stone_(static_cast<std::uint64_t>(o.seed), kDryingStream + 3, o.width, o.height, 24.0, 16.0),
      grain_(static_cast<std::uint64_t>(o.seed), kDryingStream + 4, o.width, o.height, 2.6, 2.2),
      ripples_(static_cast<std::uint64_t>(o.seed), kDryingStream + 5, o.width, o.height, 7.0, 6.0) {}

double DryingPatch::depth(double x, double y) const {
  const double dx = (x - 0.5 * (options_.width - 1)) / 1.15, dy = y - 0.5 * (options_.height - 1);
  const double reach = radius_ * (1.0 + 0.55 * outline_(x, y) + 0.10 * ragged_(x, y));
  return 1.0 - std::hypot(dx, dy) / reach;
}

double DryingPatch::film_mm(double x, double y) const {
  const double inside = depth(x, y);
  if (!(inside > 0.0)) return 0.0;
  if (options_.order == DryingOrder::Rim) return options_.film_mm;
  // Puddles over uneven ground, drawn thin at the rim.
  const double ground = std::clamp(0.55 + 0.8 * puddles_(x, y) + 0.25 * ragged_(y, x), 0.05, 1.0);
  return options_.film_mm * ground * smooth_step(0.0, 0.35, inside);
}

double DryingPatch::onset_min(double x, double y) const {
  const double inside = depth(x, y);
  if (!(inside > 0.0)) return -1.0;
  const double faster = options_.order == DryingOrder::Rim ? 1.0 / std::sqrt(inside) : 1.0;
  return 60.0 * film_mm(x, y) / (options_.evaporation_mm_h * faster);
}

Vec3 DryingPatch::dry_albedo(double x, double y) const {
  // Sandstone, in beds.
  const double shade = 1.0 + options_.texture * (0.16 * stone_(x, y) + 0.24 * grain_(x, y));
  const double warm = options_.texture * 0.10 * stone_(y, x);
  return (shade * Vec3(0.47 * (1.0 + warm), 0.40, 0.32 * (1.0 - warm))).cwiseMin(1.0);
}

Vec3 DryingPatch::film_normal(double x, double y) const {
  return Vec3(kRipple * (ripples_(x - 0.5, y) - ripples_(x + 0.5, y)),
              kRipple * (ripples_(x, y - 0.5) - ripples_(x, y + 0.5)), 1.0)
      .normalized();
}

DryingLook DryingPatch::look(double x, double y, double time_min) const {
  DryingLook look;
  look.albedo = dry_albedo(x, y);
  look.roughness = kStoneRoughness;
  const double inside = depth(x, y);
  if (!(inside > 0.0)) return look;
  const double onset = onset_min(x, y), soaked = std::min(1.0, inside / kRim);
  look.wetness = soaked * (time_min > onset ? std::exp(-(time_min - onset) / options_.pores_min) : 1.0);
  const double left_mm = onset > 0.0 ? film_mm(x, y) * std::max(0.0, 1.0 - time_min / onset) : 0.0;
  look.film = soaked * std::min(1.0, left_mm / kGrainMm);
  look.specular = kWaterF0 * look.film;
  look.roughness = kFilmRoughness * look.film + kStoneRoughness * (1.0 - look.film);
  for (int c = 0; c < 3; ++c)
    look.albedo[c] = (1.0 - look.wetness) * look.albedo[c] + look.wetness * wet_albedo(look.albedo[c]);
  return look;
}

ImageF drying_photo(const DryingPatch& patch, double time_min, const RunControl& control) {
  const DryingOptions& o = patch.options();
  const double size = std::max(o.width, o.height);
  // Above the middle, and a lamp whose mirror image lies a little above and left of it.
  const Vec3 camera(0.5 * o.width, 0.5 * o.height, 2.2 * size), lamp(0.30 * o.width, 0.28 * o.height, 1.5 * size);
  ImageF out(o.width, o.height, 3);
  parallel_for(o.height, kDryingRows, control, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < o.width; ++x) {
        const DryingLook look = patch.look(x, y, time_min);
        double mirror = 0.0;
        if (o.gloss > 0.0 && look.film > 0.0) {
          const Vec3 place(x, y, 0.0), normal = patch.film_normal(x, y);
          const Vec3 to_lamp = (lamp - place).normalized(), to_camera = (camera - place).normalized();
          const Lobe::Value lobe = Lobe(normal, to_camera, look.roughness).value(to_lamp);
          mirror = o.gloss * kDryingLamp * fresnel(look.specular, lobe.half_cosine) * lobe.shape;
        }
        for (int c = 0; c < 3; ++c) out.at(x, y, c) = static_cast<float>(look.albedo[c] + mirror);
      }
    }
  });
  return out;
}

}  // namespace patinate::datasets
