#include "libcommon/output/microfacet.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "libcommon/output/sampling.h"

namespace patinate {
namespace {

Vec3 seen_at(double cosine) { return {std::sqrt(1.0 - cosine * cosine), 0.0, cosine}; }

struct Sum {
  double value = 0.0;
  double pdf = 0.0;
};

// Midpoint rule over the upper hemisphere, finer where a lobe of this roughness is.
Sum integrate(const Lobe& lobe) {
  constexpr int kAround = 360, kDown = 720;
  Sum sum;
  for (int j = 0; j < kDown; ++j) {
    const double angle = 0.5 * std::numbers::pi * (j + 0.5) / kDown;
    const double area = 2.0 * std::numbers::pi / kAround * std::sin(angle) * 0.5 * std::numbers::pi / kDown;
    for (int i = 0; i < kAround; ++i) {
      const double a = 2.0 * std::numbers::pi * (i + 0.5) / kAround;
      const Lobe::Value v = lobe.value({std::sin(angle) * std::cos(a), std::sin(angle) * std::sin(a), std::cos(angle)});
      sum.value += area * v.shape;
      sum.pdf += area * v.pdf;
    }
  }
  return sum;
}

TEST(Lobe, ReflectsAsMuchAsItsTableSaysAndNeverMoreThanArrives) {
  for (const double roughness : {0.3, 0.5, 0.8, 1.0}) {
    for (const double cosine : {0.2, 0.6, 1.0}) {
      const Sum sum = integrate(Lobe(Vec3::UnitZ(), seen_at(cosine), roughness));
      const LobeEnergy energy = lobe_energy(roughness, cosine);
      // The table is bilinear over 32 x 32 places of 256 samples each: a percent.
      EXPECT_NEAR(energy.scale + energy.bias, sum.value, 0.012) << roughness << " " << cosine;
      EXPECT_LE(sum.value, 1.0 + 1e-3);  // The sum's own error.
      EXPECT_LE(sum.pdf, 1.0 + 1e-3);    // The missing part was sampled below the surface.
      EXPECT_NEAR(energy.reflected(1.0), 1.0, 1e-12);
    }
  }
}

// A lobe sends as much from one direction into another as back [Helmholtz]. Its value is BRDF times cosine.
// The energy that is made good depends on the viewer alone: with it colors are right and this is not.
TEST(Lobe, IsReciprocal) {
  for (const double roughness : {0.1, 0.45, 1.0}) {
    for (int i = 0; i < 50; ++i) {
      const Vec2 p = sequence_point(i, {0.3, 0.7}), q = sequence_point(i, {0.9, 0.2});
      const auto direction = [](const Vec2& s) {
        const double z = 0.05 + 0.95 * s.x(), r = std::sqrt(1.0 - z * z), a = 2.0 * std::numbers::pi * s.y();
        return Vec3(r * std::cos(a), r * std::sin(a), z);
      };
      const Vec3 view = direction(p), light = direction(q);
      const double there = Lobe(Vec3::UnitZ(), view, roughness).value(light).shape / light.z();
      const double back = Lobe(Vec3::UnitZ(), light, roughness).value(view).shape / view.z();
      EXPECT_NEAR(there, back, 1e-9 * (there + back)) << roughness << " " << i;
    }
  }
}

TEST(Lobe, SamplesByItsDensity) {
  const Lobe lobe(Vec3::UnitZ(), seen_at(0.7), 0.6);
  constexpr int kSamples = 40000;
  int above = 0;
  double right = 0.0;
  for (int i = 0; i < kSamples; ++i) {
    const Vec3 d = lobe.sample(sequence_point(i, {0.5, 0.5}));
    above += d.z() > 0.0 ? 1 : 0;
    right += d.z() > 0.0 && d.x() < 0.0 ? 1 : 0;
  }
  const Sum sum = integrate(lobe);
  EXPECT_NEAR(above / double{kSamples}, sum.pdf, 0.01);  // 4 sigma of independent samples; these are more even.
  EXPECT_GT(right / kSamples, 0.5);                      // The mirror direction is at -x.
}

TEST(Lobe, OfAMirrorReflectsIntoTheMirrorDirection) {
  const Vec3 view = seen_at(0.8);
  const Lobe lobe(Vec3::UnitZ(), view, 0.05);
  for (int i = 0; i < 64; ++i) {
    const Vec3 d = lobe.sample(sequence_point(i, {0.1, 0.2}));
    EXPECT_GT(d.dot(Vec3(-view.x(), 0.0, view.z())), std::cos(0.08));  // Alpha is 0.0025: tails reach 30 times that.
  }
}

}  // namespace
}  // namespace patinate
