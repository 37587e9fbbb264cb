// How well photographs under lamps that were left out are foretold, step by step of a mold of metal: matt, with today's
// lobes, and with materials; and how far materials are from the truth.
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "tests/benchmarks/capture/capture_parts.h"
#include "tests/capture/unlighting/metal_scene.h"

namespace patinate::benchmarks {

namespace {

using capture::SpecularMode;
using capture::UnlightOptions;
using capture::UnlightResult;
using testing_support::ForetoldErrors;
using testing_support::MetalStep;

void print(const char* what, std::size_t step, const ForetoldErrors& e) {
  std::printf("  step %zu %-9s mean %5.1f %%, median %5.1f %%\n", step, what, 100.0 * e.mean, 100.0 * e.median);
  std::fflush(stdout);
}

void print_truth(const MetalStep& step, const UnlightResult& found) {
  double f0 = 0.0, f0_bias = 0.0, f0_true = 0.0, roughness = 0.0, metal = 0.0, count = 0.0, glossy = 0.0;
  for (int y = 0; y < found.mask.height(); ++y) {
    for (int x = 0; x < found.mask.width(); ++x) {
      if (found.mask.at(x, y) == 0) continue;
      count += 1.0;
      for (int c = 0; c < 3; ++c) {
        f0_bias += static_cast<double>(found.reflectance.at(x, y, c) - step.reflectance.at(x, y, c)) / 3.0;
        f0 += std::abs(static_cast<double>(found.reflectance.at(x, y, c) - step.reflectance.at(x, y, c))) / 3.0;
        f0_true += static_cast<double>(step.reflectance.at(x, y, c)) / 3.0;
      }
      metal += std::abs(static_cast<double>(found.metalness.at(x, y) - step.metalness.at(x, y)));
      if (!(found.specular.at(x, y, 0) > 0.0f)) continue;
      glossy += 1.0;
      roughness += std::abs(static_cast<double>(found.specular.at(x, y, 1) - step.roughness.at(x, y)));
    }
  }
  std::printf("         truth: F0 off by %.3f (%+.3f) of %.3f, roughness by %.3f, metalness by %.3f\n", f0 / count,
              f0_bias / count, f0_true / count, roughness / glossy, metal / count);
}

void measure_mold(int width, std::int64_t seed, std::size_t lamp) {
  const std::vector<MetalStep> steps =
      testing_support::metal_steps({.width = width, .height = width * 3 / 4, .num_lights = 8, .seed = seed});
  std::printf(" mold of metal, seed %d, %d px, lamp %zu left out\n", static_cast<int>(seed), width, lamp);
  UnlightOptions options;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    options.specular = SpecularMode::None;
    print("matt", i, testing_support::foretold(steps[i].input, options, lamp));
    options.specular = SpecularMode::Auto;
    print("auto", i, testing_support::foretold(steps[i].input, options, lamp));
    options.specular = SpecularMode::Material;
    const UnlightResult found = unlight(testing_support::without_lamp(steps[i].input, lamp), options);
    print("material", i, testing_support::foretold(steps[i].input, options, found, lamp));
    print_truth(steps[i], found);
    for (const capture::SurfaceMaterial& m : found.materials) {
      std::printf("         %-10s %4.1f %%, roughness %.2f, strength %.3f %.3f %.3f, evidence %.1f\n",
                  std::string(name_of(m.kind)).c_str(), 100.0 * m.share, m.roughness, m.strength[0], m.strength[1],
                  m.strength[2], m.evidence);
    }
  }
}

}  // namespace

void measure_materials() {
  measure_mold(96, 1, 1);
  measure_mold(128, 2, 3);
}

}  // namespace patinate::benchmarks
