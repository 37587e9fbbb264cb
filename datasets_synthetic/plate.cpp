#include "datasets_synthetic/plate.h"

#include <cmath>
#include <numbers>

#include "libcommon/core/parallel.h"
#include "libcommon/output/microfacet.h"

namespace patinate::datasets {

namespace {

constexpr std::uint32_t kPlateStream = 1300;  // Purposes of random streams.
constexpr std::int64_t kPlateRows = 8;
constexpr double kExposure = 0.5;       ///< Light that a white matte surface shows in the middle of the plate.
constexpr double kMetalExposure = 0.1;  ///< Light beside bare metal, which is far brighter where it mirrors.

PlateOptions checked_plate(const PlateOptions& o) {
  check_ranges(o);
  return o;
}

/// Light that a lobe shows under irradiance pi that faces the surface.
Vec3 shine(const Vec3& f0, double roughness, const Vec3& to_lamp, const Vec3& to_camera) {
  const Vec3 normal = Vec3::UnitZ();
  const double shape = Lobe(normal, to_camera, roughness).value(to_lamp).shape;
  const LobeEnergy energy = lobe_energy(roughness, to_camera.z());
  Vec3 out;
  for (int c = 0; c < 3; ++c) out[c] = std::numbers::pi * shape * f0[c] * energy.compensation(f0[c]);
  return out;
}

}  // namespace

void describe(OptionVisitor& v, PlateOptions& o) {
  v.visit({"size", "Pixels along a side of the photographs", "px", between(32, 2048)}, o.size);
  v.visit({"side", "Side of the plate", "mm", above(0)}, o.side_mm);
  v.visit({"num_frames", "Photographs over time", "", between(2, 10000)}, o.num_frames);
  v.visit({"interval", "Time between photographs", "h", above(0)}, o.interval_h);
  v.visit({"roughness", "Roughness of the polish at the start", "", between(0.15, 0.9)}, o.roughness);
  v.visit({"roughness_end", "Roughness of the polish at the end", "", between(0.15, 0.9)}, o.roughness_end);
  v.visit({"specular", "Reflectance of the polish at normal incidence", "", between(0, 1)}, o.specular);
  v.visit({"metal", "Bare copper instead of a lacquer"}, o.metal);
  v.visit({"moving", "The lamp stands elsewhere at every photograph"}, o.moving);
  v.visit({"lamp_x", "How far right of the middle the lamp stands", "mm", between(-1e5, 1e5)}, o.lamp_x_mm);
  v.visit({"lamp_y", "How far above the middle it stands in the photograph", "mm", between(-1e5, 1e5)}, o.lamp_y_mm);
  v.visit({"lamp_z", "How high it stands over the plate", "mm", above(0)}, o.lamp_z_mm);
  v.visit({"texture", "How uneven the colors are; 0 = one color each", "", between(0, 2)}, o.texture);
  v.visit({"noise", "Standard deviation of the noise that is added to the photographs; 1 = full scale", "",
           between(0, 0.5)},
          o.noise);
  v.visit({"seed", "Every random choice derives from it", "", at_least(0)}, o.seed);
}

GlossyPlate::GlossyPlate(const PlateOptions& o)
    : options_(checked_plate(o)),
      texel_mm_(o.side_mm / o.size),
      broad_(static_cast<std::uint64_t>(o.seed), kPlateStream, o.size, o.size, o.size / 7.0, o.size / 7.0),
      grain_(static_cast<std::uint64_t>(o.seed), kPlateStream + 1, o.size, o.size, 2.4, 2.4),
      patches_(static_cast<std::uint64_t>(o.seed), kPlateStream + 2, o.size, o.size, o.size / 9.0, o.size / 9.0) {}

PlateLook GlossyPlate::look(double x, double y, int frame) const {
  const double age = static_cast<double>(frame) / (options_.num_frames - 1);
  const double shade = 1.0 + options_.texture * (0.12 * broad_(x, y) + 0.2 * grain_(x, y));
  PlateLook look;
  // Nothing is covered at the start, and a little more than half in the end.
  look.patina = smoother_step(0.0, 0.5, 1.7 * age - 0.75 + 1.2 * patches_(x, y));
  const Vec3 paint(0.34, 0.24, 0.17), patina(0.20, 0.37, 0.31);
  const Vec3 bare = options_.metal ? Vec3(Vec3::Zero()) : Vec3(shade * paint);
  look.albedo = (1.0 - look.patina) * bare + look.patina * shade * patina;
  look.polish_f0 = options_.metal ? Vec3(0.93, 0.60, 0.47) : Vec3(Vec3::Constant(options_.specular));
  look.polish_roughness = options_.roughness + age * (options_.roughness_end - options_.roughness);
  return look;
}

Vec3 GlossyPlate::position(double x, double y) const {
  const double middle = 0.5 * (options_.size - 1);
  return {texel_mm_ * (x - middle), texel_mm_ * (middle - y), 0.0};
}

Light GlossyPlate::lamp(int frame) const {
  constexpr double kGoldenAngle = 2.399963229728653;
  const double turn = options_.moving ? kGoldenAngle * frame : 0.0;
  const double x = options_.lamp_x_mm, y = options_.lamp_y_mm;
  Light lamp;
  lamp.position = {std::cos(turn) * x - std::sin(turn) * y, std::sin(turn) * x + std::cos(turn) * y,
                   options_.lamp_z_mm};
  const double exposure = options_.metal ? kMetalExposure : kExposure;
  lamp.intensity = Vec3::Constant(exposure * std::numbers::pi * options_.lamp_z_mm * options_.lamp_z_mm);
  return lamp;
}

ImageF plate_photo(const GlossyPlate& plate, int frame, const RunControl& control) {
  const int size = plate.options().size;
  const Light lamp = plate.lamp(frame);
  ImageF out(size, size, 3);
  parallel_for(size, kPlateRows, control, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < size; ++x) {
        const Vec3 p = plate.position(x, y), to_lamp = direction_to(lamp, p),
                   to_camera = (plate.camera() - p).normalized();
        const PlateLook look = plate.look(x, y, frame);
        const Vec3 lobes =
            (1.0 - look.patina) * shine(look.polish_f0, look.polish_roughness, to_lamp, to_camera) +
            look.patina * shine(Vec3::Constant(look.kPatinaF0), look.kPatinaRoughness, to_lamp, to_camera);
        const Vec3 light = light_at(lamp, p) / std::numbers::pi;
        const Vec3 value = light.cwiseProduct(look.albedo * to_lamp.z() + lobes);
        for (int c = 0; c < 3; ++c) out.at(x, y, c) = static_cast<float>(value[c]);
      }
    }
  });
  return out;
}

}  // namespace patinate::datasets
