#include "tests/capture/unlighting/metal_scene.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "capture/unlighting/unlight_work.h"
#include "datasets_synthetic/mold_light.h"
#include "libcommon/core/median.h"
#include "libcommon/core/random.h"
#include "libcommon/output/microfacet.h"
#include "patinate/datasets/crackle.h"
#include "patinate/image/color.h"
#include "tests/capture/unlighting/pixel_vectors.h"

namespace patinate::testing_support {

using capture::UnlightInput;
using capture::UnlightOptions;
using capture::UnlightResult;
using datasets::Mold;
using datasets::MoldOptions;
using datasets::MoldRig;

namespace {

/// @param lit  Of one lamp. @param in_light  Where its light arrives.
void add_coat(const datasets::MoldView& view, const MoldRig& rig, std::size_t lamp, double roughness,
              const ImageU8& in_light, ImageF& lit) {
  for (int y = 0; y < lit.height(); ++y) {
    for (int x = 0; x < lit.width(); ++x) {
      if (view.mask.at(x, y) == 0) continue;
      const Vec3 p = vector_at(view.position_mm, x, y), n = vector_at(view.normal, x, y).normalized(),
                 to_lamp = direction_to(rig.lights[lamp], p), to_camera = (rig.camera.center() - p).normalized();
      const double passes = (1.0 - fresnel(kCoatF0, n.dot(to_lamp))) * (1.0 - fresnel(kCoatF0, n.dot(to_camera)));
      const double shape = in_light.at(x, y) != 0 ? Lobe(n, to_camera, roughness).value(to_lamp).shape : 0.0;
      const Vec3 value = passes * vector_at(lit, x, y) + kCoatF0 * shape * light_at(rig.lights[lamp], p);
      put(lit, x, y, value);
    }
  }
}

MetalStep metal_step(const Mold& mold, const MoldRig& rig, int step, std::optional<double> coat_roughness) {
  constexpr double kOffDeg = 1.0;
  const MoldOptions& o = mold.options();
  MetalStep out{.surface = std::make_unique<const Mesh>(mold_surface(mold, rig, step)),
                .input = {},
                .albedo = ImageF(o.width, o.height, 3),
                .reflectance = ImageF(o.width, o.height, 3),
                .roughness = ImageF(o.width, o.height),
                .metalness = ImageF(o.width, o.height)};
  datasets::MoldPhotos photos = mold_photos(mold, rig, step, *out.surface);
  datasets::MoldView view = mold_view(rig, *out.surface);
  UnlightInput& in = out.input;
  in.lights = rig.lights;
  in.camera_center = rig.camera.center();
  in.blockers = out.surface.get();
  in.mask = view.mask;
  in.position_mm = view.position_mm;
  in.normal = ImageF(o.width, o.height, 3);
  for (int y = 0; y < o.height; ++y) {
    for (int x = 0; x < o.width; ++x) {
      if (in.mask.at(x, y) == 0) continue;
      RandomStream random(77, static_cast<std::uint64_t>(y * o.width + x), 900u + static_cast<std::uint32_t>(step));
      const double off = kOffDeg * std::numbers::pi / 180.0 / std::sqrt(2.0);
      const double dx = random.normal(), dy = random.normal();
      put(in.normal, x, y, (vector_at(view.normal, x, y) + off * Vec3(dx, dy, 0.0)).normalized());
      const datasets::MoldLook look = mold.look(static_cast<double>(view.object_mm.at(x, y, 0)),
                                                static_cast<double>(view.object_mm.at(x, y, 1)), step * o.interval_d);
      put(out.albedo, x, y, look.albedo);
      put(out.reflectance, x, y, look.reflectance);
      out.roughness.at(x, y) = static_cast<float>(look.roughness);
      out.metalness.at(x, y) = static_cast<float>(look.metalness);
    }
  }
  for (std::size_t k = 0; k < photos.lit.size(); ++k) {
    if (coat_roughness) add_coat(view, rig, k, *coat_roughness, photos.in_light[k], photos.lit[k]);
    const ImageU8 codes = datasets::photograph(photos.lit[k], o.noise, o.seed, step * 100 + static_cast<int>(k));
    ImageF linear(o.width, o.height, 3);
    ImageU8 valid(o.width, o.height, 1, 255);
    for (std::int64_t i = 0; i < 3 * linear.num_pixels(); ++i) {
      linear.data()[i] = linear_from_srgb(static_cast<float>(codes.data()[i]) / 255.0f);
      if (codes.data()[i] >= 254) valid.data()[i / 3] = 0;
    }
    in.photos.push_back(std::move(linear));
    in.valid.push_back(std::move(valid));
  }
  return out;
}

}  // namespace

std::vector<MetalStep> metal_steps(MoldOptions options, std::optional<double> coat_roughness) {
  options.motion_deg = options.motion_mm = options.ambient = options.drift = 0.0;
  options.metal = true;
  const Mold mold(checked_mold(options));
  const MoldRig rig = mold_rig(options);
  std::vector<MetalStep> steps;
  for (int step = 0; step < options.num_steps; ++step) steps.push_back(metal_step(mold, rig, step, coat_roughness));
  return steps;
}

UnlightInput without_lamp(const UnlightInput& input, std::size_t lamp) {
  UnlightInput others = input;
  const auto at = static_cast<std::ptrdiff_t>(lamp);
  others.photos.erase(others.photos.begin() + at);
  if (!others.valid.empty()) others.valid.erase(others.valid.begin() + at);
  others.lights.erase(others.lights.begin() + at);
  return others;
}

ForetoldErrors foretold(const UnlightInput& input, const UnlightOptions& options, const UnlightResult& of_others,
                        std::size_t lamp) {
  const capture::UnlightWork work(input, options, RunControl{});
  capture::TexelSamples texel;
  double off_sum = 0.0, seen_sum = 0.0;
  std::vector<double> ratios;
  for (int y = 0; y < work.height; ++y) {
    for (int x = 0; x < work.width; ++x) {
      if (!work.is_surface(x, y) || of_others.mask.at(x, y) == 0) continue;
      if (work.samples.at(x, y, static_cast<int>(lamp)) != static_cast<std::uint8_t>(capture::SampleState::Clean))
        continue;
      work.load_raw(x, y, texel);
      const Vec3 n = vector_at(of_others.normal, x, y);
      const Vec3& l = texel.direction[lamp];
      const double strength = of_others.specular.empty() ? 0.0 : static_cast<double>(of_others.specular.at(x, y, 0));
      double lobe = 0.0;
      if (strength > 0.0)
        lobe = strength * capture::specular_lobe(of_others.form, n, l, work.to_camera(x, y),
                                                 static_cast<double>(of_others.specular.at(x, y, 1)));
      double mean = 0.0;
      for (int c = 0; c < work.num_channels; ++c)
        mean += static_cast<double>(of_others.albedo.at(x, y, c)) / work.num_channels;
      for (int c = 0; c < work.num_channels; ++c) {
        const auto at = texel.index(static_cast<int>(lamp), c);
        double tint = 1.0;
        if (!of_others.tint.empty())
          tint = static_cast<double>(of_others.tint.at(x, y, c));
        else if (of_others.form.tint == capture::SpecularTint::Base && mean > 0.0)
          tint = static_cast<double>(of_others.albedo.at(x, y, c)) / mean;
        const double seen = texel.value[at];
        const double said =
            texel.irradiance[at] * (static_cast<double>(of_others.albedo.at(x, y, c)) * std::max(0.0, n.dot(l)) +
                                    std::numbers::pi * lobe * tint);
        const double off = std::abs(std::min(said, 1.0) - seen);
        off_sum += off;
        seen_sum += seen;
        ratios.push_back(off / (seen + 0.02));
      }
    }
  }
  return {off_sum / seen_sum, median(std::move(ratios))};
}

ForetoldErrors foretold(const UnlightInput& input, const UnlightOptions& options, std::size_t lamp) {
  const UnlightInput others = without_lamp(input, lamp);
  return foretold(input, options, capture::unlight(others, options), lamp);
}

}  // namespace patinate::testing_support
