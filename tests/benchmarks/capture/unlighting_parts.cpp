// Unlighting's accuracy on the rows of the goals, and its time a megapixel and lamp.
#include <cstdio>
#include <string>

#include "capture/unlighting/cast_shadows.h"
#include "patinate/capture/unlight.h"
#include "tests/benchmarks/capture/capture_parts.h"
#include "tests/benchmarks/timing.h"
#include "tests/capture/unlighting/lit_relief.h"

namespace patinate::benchmarks {

namespace {

using namespace testing_support;

void print_accuracy(const char* name, const LitReliefOptions& options) {
  LitRelief scene = lit_relief(options);
  scene.input.blockers = &scene.scan;
  capture::UnlightInput known = scene.input;  // Noise alone leaves this: the true normals and shadows.
  known.normal = scene.normal;
  for (std::size_t k = 0; k < known.valid.size(); ++k) {
    for (int y = 0; y < scene.shadow.height(); ++y) {
      for (int x = 0; x < scene.shadow.width(); ++x)
        known.valid[k].at(x, y) =
            scene.shadow.at(x, y, static_cast<int>(k)) != 0 ? std::uint8_t{0} : known.valid[k].at(x, y);
    }
  }
  const capture::UnlightResult floor = capture::unlight(known, {.normals = capture::NormalMode::Keep,
                                                                .rejection = capture::Rejection::None,
                                                                .specular = capture::SpecularMode::None});
  const double scan_deg = median_angle_deg(scene.input.normal, scene.normal, {});
  const capture::UnlightResult result = capture::unlight(scene.input);
  const capture::UnlightResult no_lobe = capture::unlight(scene.input, {.specular = capture::SpecularMode::None});
  const capture::UnlightResult keep =
      capture::unlight(scene.input, {.normals = capture::NormalMode::Keep, .specular = capture::SpecularMode::None});
  const capture::UnlightResult plain = capture::unlight(scene.input, {.normals = capture::NormalMode::Keep,
                                                                      .rejection = capture::Rejection::None,
                                                                      .specular = capture::SpecularMode::None});
  std::printf(
      "%-34s albedo %5.2f %% (without lobes %5.2f, scan's normals %5.2f, least squares %5.2f, with true normals and "
      "shadows %5.2f); normals %.2f deg (scan %.2f); determined %.2f %%; noise scale %.2f\n",
      name, relative_error_percent(result, scene.albedo), relative_error_percent(no_lobe, scene.albedo),
      relative_error_percent(keep, scene.albedo), relative_error_percent(plain, scene.albedo),
      relative_error_percent(floor, scene.albedo), median_angle_deg(result.normal, scene.normal, result.mask), scan_deg,
      100.0 * static_cast<double>(result.num_determined) / static_cast<double>(result.num_surface), result.noise_scale);
}

void print_accuracies() {
  LitReliefOptions o{
      .size = 192, .normal_noise_deg = 1.8, .scan_noise_mm = 0.05, .noise_share = 0.017, .coding = Coding::Srgb8};
  print_accuracy("8 lamps, Lambert", o);
  o.gloss = 0.1;
  print_accuracy("8 lamps, 10 % gloss", o);
  o.saturated = 0.04;
  o.lobe = Gloss::Ggx;
  print_accuracy("8 lamps, 10 % GGX", o);
  o.lobe = Gloss::BlinnPhong;
  o.saturated = 0.04;
  print_accuracy("8 lamps, 10 % gloss, 4 % saturated", o);
  o.gloss = 0.0;
  print_accuracy("8 lamps, 4 % saturated", o);
  o.saturated = 0.0;
  o.num_lights = 24;
  print_accuracy("24 lamps, Lambert", o);
  o.gloss = 0.1;
  print_accuracy("24 lamps, 10 % gloss", o);
}

void print_times() {
  LitRelief scene = lit_relief({.size = 512, .normal_noise_deg = 1.8, .noise_share = 0.005, .coding = Coding::Srgb8});
  const double megapixel_lamps = 512.0 * 512.0 * 1e-6 * static_cast<double>(scene.input.lights.size());
  const auto print = [&](const char* name, double time) {
    std::printf("%-34s %.2f s a megapixel and lamp\n", name, time / megapixel_lamps);
  };
  print("cast shadows", seconds([&] {
          (void)capture::cast_shadows(scene.scan, scene.input.position_mm, scene.input.normal, {}, scene.input.lights,
                                      capture::median_edge(scene.scan));
        }));
  print("least squares, scan's normals", seconds([&] {
          (void)capture::unlight(scene.input, {.normals = capture::NormalMode::Keep,
                                               .rejection = capture::Rejection::None,
                                               .specular = capture::SpecularMode::None});
        }));
  print("robust, scan's normals", seconds([&] {
          (void)capture::unlight(scene.input,
                                 {.normals = capture::NormalMode::Keep, .specular = capture::SpecularMode::None});
        }));
  print("robust, normals refined",
        seconds([&] { (void)capture::unlight(scene.input, {.specular = capture::SpecularMode::None}); }));
  print("robust, normals and highlights", seconds([&] { (void)capture::unlight(scene.input); }));
}

}  // namespace

void measure_unlighting() { print_accuracies(); }
void measure_unlighting_time() { print_times(); }

}  // namespace patinate::benchmarks
