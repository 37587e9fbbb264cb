// Pictures of one scene on atlases of several sizes.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "libcommon/metrics/color_curves.h"
#include "patinate/simulation/engine.h"
#include "tests/support/object_scenes.h"

namespace patinate::simulation {
namespace {

constexpr int kSide = 1024, kBlurredIterations = 60;

/// The wall with sills under which dirt runs down. @param attraction  Of wet paths.
Scene wall(int resolution, double attraction, std::uint64_t seed) {
  Scene scene = testing_support::wall_scene(resolution);
  scene.seed = seed;
  scene.tracing.wet_attraction = attraction;
  return scene;
}

/// Linear color after a while, averaged to kSide; texels that are not covered have none.
ImageF blurred_picture(const Scene& scene, int num_iterations = kBlurredIterations) {
  Simulation simulation(scene);
  for (int i = 0; i < num_iterations; ++i) simulation.step();
  const ImageF color = simulation.compose().color_linear();
  const ImageU8 coverage = simulation.coverage();
  const int n = scene.resolution / kSide;
  ImageF out(kSide, kSide, 4);
  for (int y = 0; y < scene.resolution; ++y) {
    for (int x = 0; x < scene.resolution; ++x) {
      if (coverage.at(x, y) == 0) continue;
      for (int c = 0; c < 3; ++c) out.at(x / n, y / n, c) += color.at(x, y, c) / static_cast<float>(n * n);
      out.at(x / n, y / n, 3) += 1.0f / static_cast<float>(n * n);
    }
  }
  return out;
}

struct Difference {
  double rms = 0.0;              ///< Delta E 1976.
  std::array<double, 3> mean{};  ///< L*, a*, b*.
};

/// Where both are whole.
Difference difference(const ImageF& a, const ImageF& b) {
  Difference out;
  std::int64_t num = 0;
  for (std::int64_t i = 0; i < a.num_pixels(); ++i) {
    const float *p = a.data() + 4 * i, *q = b.data() + 4 * i;
    if (p[3] < 0.999f || q[3] < 0.999f) continue;
    const auto lab = [](const float* v) {
      return lab_from_linear(static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2]));
    };
    const auto u = lab(p), v = lab(q);
    for (std::size_t c = 0; c < 3; ++c) {
      out.rms += (u[c] - v[c]) * (u[c] - v[c]);
      out.mean[c] += u[c] - v[c];
    }
    ++num;
  }
  out.rms = std::sqrt(out.rms / static_cast<double>(num));
  for (double& m : out.mean) m /= static_cast<double>(num);
  return out;
}

/// Pictures of the same drops at two and four times the size, against two pictures at 1k of other drops.
/// @param most  Of the difference that independent drops make.
void check_sizes(double attraction, double most) {
  // A step of an 8-bit picture is 0.35 L* or more: a mean that is off by a quarter of it is never seen.
  constexpr double kMeanL = 0.09;
  const ImageF fresh = blurred_picture(wall(kSide, attraction, 1), 0),
               at_1k = blurred_picture(wall(kSide, attraction, 1));
  const double of_seeds = difference(blurred_picture(wall(kSide, attraction, 2)), at_1k).rms;
  for (const int resolution : {2 * kSide, 4 * kSide}) {
    // New parts are not the same either: grain that is finer than a texel at 1k.
    const Difference now = difference(blurred_picture(wall(resolution, attraction, 1)), at_1k),
                     before = difference(blurred_picture(wall(resolution, attraction, 1), 0), fresh);
    const double aged = std::sqrt(std::max(0.0, now.rms * now.rms - before.rms * before.rms));
    EXPECT_LT(aged, most * of_seeds) << resolution << ": " << now.rms << ", new " << before.rms;
    EXPECT_NEAR(now.mean[0], 0.0, kMeanL) << resolution;
    testing::Test::RecordProperty("difference_" + std::to_string(resolution), std::to_string(aged / of_seeds));
  }
}

// A drop's middle is its texel's: at 1k displaced by up to half a texel each way, a variance of 1/6 texel^2 in all. A
// drop is a Gaussian of 0.83 texels there; moved so far it differs from itself by sqrt(1/6 / (2 * 0.83^2)) = 0.35 of
// its own size, and two independent ones by sqrt(2) of it: a quarter of what seeds differ by. Twice that leaves room
// for what follows from it: less is picked up again where a drop's middle is sharper.
TEST(Resolution, PicturesAt1k2kAnd4kDifferInSharpnessAlone) { check_sizes(0.0, 0.5); }

// Where drops are drawn to wet ways, one that has missed another's way by a little goes another one: sizes are as
// seeds.
TEST(Resolution, PicturesOfRivuletsAreAsOtherSeedsAtMost) { check_sizes(1.0, 1.0); }

}  // namespace
}  // namespace patinate::simulation
