// Hollows that light themselves, with every bounce: a bowl, in closed form, and a groove, path traced.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>

#include "libcommon/core/random.h"
#include "patinate/capture/unlight.h"
#include "patinate/core/error.h"
#include "tests/capture/unlighting/lit_relief.h"
#include "tests/capture/unlighting/pixel_vectors.h"

namespace patinate::capture {
namespace {

using namespace testing_support;

const Vec3 kPaint(0.85, 0.5, 0.2);

/// A hollow seen from above, its photographs to be rendered.
struct Hollow {
  UnlightInput input;  ///< Without blockers: point it at `scan` where wanted.
  Mesh scan;
  ImageF albedo;
};

/// Distant lamps about the vertical, none so far from it that a hollow of 60 degrees shadows itself.
std::vector<Light> overhead_lamps() {
  constexpr int kNumLamps = 6;
  constexpr double kTilt = 20.0 * std::numbers::pi / 180.0;
  std::vector<Light> lights;
  for (int k = 0; k < kNumLamps; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / kNumLamps;
    Light light;
    light.kind = Light::Kind::Directional;
    light.direction = Vec3(std::sin(kTilt) * std::cos(angle), std::sin(kTilt) * std::sin(angle), std::cos(kTilt));
    light.intensity = Vec3(3.0, 3.0, 3.0);
    lights.push_back(light);
  }
  return lights;
}

Hollow empty_hollow(int size) {
  Hollow hollow;
  hollow.albedo = ImageF(size, size, 3);
  hollow.input.lights = overhead_lamps();
  hollow.input.photos.assign(hollow.input.lights.size(), ImageF(size, size, 3));
  hollow.input.position_mm = hollow.input.normal = ImageF(size, size, 3);
  hollow.input.mask = ImageU8(size, size);
  return hollow;
}

void put_texel(Hollow& hollow, int x, int y, const Vec3& place, const Vec3& normal, const Vec3& albedo,
               const std::function<Vec3(std::size_t)>& indirect) {
  put(hollow.input.position_mm, x, y, place);
  put(hollow.input.normal, x, y, normal);
  put(hollow.albedo, x, y, albedo);
  hollow.input.mask.at(x, y) = 255;
  for (std::size_t k = 0; k < hollow.input.lights.size(); ++k) {
    const Light& light = hollow.input.lights[k];
    const Vec3 direct = light.intensity * normal.dot(light.direction);
    put(hollow.input.photos[k], x, y, albedo.cwiseProduct(direct + indirect(k)) / std::numbers::pi);
  }
}

constexpr double kBowlRadius = 50.0;                          ///< Radius of the bowl's sphere, mm.
constexpr double kOpening = 60.0 * std::numbers::pi / 180.0;  ///< From its bottom to its rim.

/// @param depth  0 = one color. @param slope  Angle from the bottom.
Vec3 bowl_paint(double depth, double slope, double turn) {
  return kPaint * (1.0 - 0.5 * depth * (1.0 + std::sin(5.0 * slope + 3.0 * turn)));
}
Vec3 bowl_normal(double slope, double turn) {
  return {-std::sin(slope) * std::cos(turn), -std::sin(slope) * std::sin(turn), std::cos(slope)};
}

Mesh bowl_mesh() {
  constexpr int kRings = 96, kSegments = 192;
  Mesh mesh;
  mesh.positions.push_back(-kBowlRadius * bowl_normal(0.0, 0.0));
  const auto vertex = [](int ring, int segment) { return 1 + (ring - 1) * kSegments + segment % kSegments; };
  for (int r = 1; r <= kRings; ++r) {
    for (int s = 0; s < kSegments; ++s) {
      mesh.positions.push_back(-kBowlRadius *
                               bowl_normal(kOpening * r / kRings, 2.0 * std::numbers::pi * s / kSegments));
      if (r == 1) {
        mesh.triangles.push_back({0, vertex(1, s), vertex(1, s + 1)});
        continue;
      }
      mesh.triangles.push_back({vertex(r - 1, s), vertex(r, s), vertex(r, s + 1)});
      mesh.triangles.push_back({vertex(r - 1, s), vertex(r, s + 1), vertex(r - 1, s + 1)});
    }
  }
  return mesh;
}

/// From every place of a sphere, every other fills the same share of the view, 1 / (4 pi R^2) of an area: what arrives
/// from the bowl is the same everywhere, and solves one equation.
std::vector<Vec3> bowl_light(const std::vector<Light>& lights, double depth) {
  constexpr int kSteps = 400;
  std::vector<Vec3> thrown(lights.size(), Vec3::Zero());
  Vec3 albedo = Vec3::Zero();
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < kSteps; ++j) {
      const double slope = kOpening * (i + 0.5) / kSteps, turn = 2.0 * std::numbers::pi * (j + 0.5) / kSteps,
                   share = std::sin(slope) * (kOpening / kSteps) * (2.0 * std::numbers::pi / kSteps) /
                           (4.0 * std::numbers::pi);
      const Vec3 paint = bowl_paint(depth, slope, turn);
      albedo += share * paint;
      for (std::size_t k = 0; k < lights.size(); ++k) {
        thrown[k] +=
            share * bowl_normal(slope, turn).dot(lights[k].direction) * paint.cwiseProduct(lights[k].intensity);
      }
    }
  }
  for (Vec3& light : thrown) light = light.cwiseQuotient(Vec3::Ones() - albedo);
  return thrown;
}

Hollow bowl(double depth) {
  constexpr int kSize = 64;
  Hollow hollow = empty_hollow(kSize);
  hollow.scan = bowl_mesh();
  const std::vector<Vec3> arriving = bowl_light(hollow.input.lights, depth);
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const double rim = kBowlRadius * std::sin(kOpening), px = rim * ((2.0 * x + 1.0) / kSize - 1.0),
                   py = rim * ((2.0 * y + 1.0) / kSize - 1.0), off = std::hypot(px, py);
      if (off >= rim) continue;
      const double slope = std::asin(off / kBowlRadius), turn = std::atan2(py, px);
      const Vec3 normal = bowl_normal(slope, turn);
      put_texel(hollow, x, y, -kBowlRadius * normal, normal, bowl_paint(depth, slope, turn),
                [&](std::size_t k) { return arriving[k]; });
    }
  }
  return hollow;
}

constexpr double kHalf = 50.0;  ///< Half side of the groove z = |x|, mm.
const Vec3 kGroovePaint(0.8, 0.5, 0.2);

Vec3 groove_normal(double side) { return Vec3(-side, 0, 1).normalized(); }

/// Where a ray from one side of the groove meets the other; false where it leaves.
bool crosses_groove(const Vec3& from, const Vec3& direction, double side, Vec3& place) {
  // On the other side z = -side x.
  const double closing = direction.z() + side * direction.x();
  if (!(closing < 0.0)) return false;
  place = from - (from.z() + side * from.x()) / closing * direction;
  return std::abs(place.x()) <= kHalf && std::abs(place.y()) <= kHalf;
}

/// Light that arrives at a place of the groove from the rest of it: of all bounces, over the lamps' intensity.
std::vector<Vec3> groove_light(const std::vector<Light>& lights, const Vec3& start, double start_side,
                               std::uint64_t item) {
  constexpr int kPaths = 1500, kBounces = 12;
  std::vector<Vec3> sum(lights.size(), Vec3::Zero());
  RandomStream random(1, item);
  for (int i = 0; i < kPaths; ++i) {
    Vec3 place = start, carried = Vec3::Ones();
    double side = start_side;
    for (int bounce = 0; bounce < kBounces; ++bounce) {
      const Vec3 n = groove_normal(side), t(0, 1, 0), b = n.cross(t);
      const double radius = std::sqrt(random.uniform()), angle = 2.0 * std::numbers::pi * random.uniform();
      const Vec3 direction = radius * std::cos(angle) * t + radius * std::sin(angle) * b +
                             std::sqrt(std::max(0.0, 1.0 - radius * radius)) * n;
      if (!crosses_groove(place, direction, side, place)) break;
      side = -side;
      carried = carried.cwiseProduct(kGroovePaint);
      for (std::size_t k = 0; k < lights.size(); ++k)
        sum[k] += groove_normal(side).dot(lights[k].direction) * carried.cwiseProduct(lights[k].intensity) / kPaths;
    }
  }
  return sum;
}

Hollow groove() {
  constexpr int kSize = 48, kCells = 100;
  Hollow hollow = empty_hollow(kSize);
  for (int j = 0; j <= kCells; ++j) {
    for (int i = 0; i <= kCells; ++i) {
      const double x = kHalf * (2.0 * i / kCells - 1.0);
      hollow.scan.positions.emplace_back(x, kHalf * (2.0 * j / kCells - 1.0), std::abs(x));
      if (i == kCells || j == kCells) continue;
      const int a = j * (kCells + 1) + i, above = a + kCells + 1;
      hollow.scan.triangles.push_back({a, a + 1, above + 1});
      hollow.scan.triangles.push_back({a, above + 1, above});
    }
  }
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const double px = kHalf * ((2.0 * x + 1.0) / kSize - 1.0), py = kHalf * ((2.0 * y + 1.0) / kSize - 1.0),
                   side = px < 0.0 ? -1.0 : 1.0;
      const Vec3 place(px, py, std::abs(px));
      const std::vector<Vec3> light =
          groove_light(hollow.input.lights, place, side, static_cast<std::uint64_t>(y * kSize + x));
      put_texel(hollow, x, y, place, groove_normal(side), kGroovePaint, [&](std::size_t k) { return light[k]; });
    }
  }
  return hollow;
}

/// Mean of (found - truth) / truth of each channel, over determined texels that count.
Vec3 bias(const UnlightResult& result, const Hollow& hollow, const std::function<bool(int x, int y)>& counts) {
  Vec3 sum = Vec3::Zero();
  double count = 0.0;
  for (int y = 0; y < result.mask.height(); ++y) {
    for (int x = 0; x < result.mask.width(); ++x) {
      if (result.mask.at(x, y) == 0 || !counts(x, y)) continue;
      for (int c = 0; c < 3; ++c)
        sum[c] += static_cast<double>(result.albedo.at(x, y, c)) / static_cast<double>(hollow.albedo.at(x, y, c)) - 1.0;
      count += 1.0;
    }
  }
  return sum / count;
}
bool everywhere(int, int) { return true; }

void print(const char* what, const Vec3& without, const Vec3& with, const UnlightResult& result) {
  std::printf(
      "%s: albedo %+.1f %+.1f %+.1f %% off without, %+.2f %+.2f %+.2f %% with; taken off %.1f %% (p95 %.1f %%), "
      "%.0f %% of the rays met unseen places\n",
      what, 100.0 * without[0], 100.0 * without[1], 100.0 * without[2], 100.0 * with[0], 100.0 * with[1],
      100.0 * with[2], 100.0 * result.interreflection->median, 100.0 * result.interreflection->p95,
      100.0 * result.interreflection->unseen);
}

UnlightOptions matt(bool interreflection, NormalMode normals = NormalMode::Refine) {
  return {.normals = normals, .specular = SpecularMode::None, .interreflection = interreflection};
}

/// Looks at the bias without and with interreflection, of kept and of refined normals.
///
/// What is left where one exact bounce is taken off light that is thrown again and again is the share of it that was
/// thrown more than once: the albedo times the share of the view that the hollow fills. Photographs hold all bounces,
/// so that what is left must be less; and a third of a percent for rays and float photographs. A refined normal is one
/// for all channels: what the brightest one turns it by is in all of them.
/// @returns the last result.
UnlightResult expect_less_than_one_bounce_leaves(const char* what, Hollow& hollow, const Vec3& albedo,
                                                 double view_share, const std::function<bool(int, int)>& counts) {
  hollow.input.blockers = &hollow.scan;
  UnlightResult result;
  for (const NormalMode normals : {NormalMode::Keep, NormalMode::Refine}) {
    const UnlightResult plain = unlight(hollow.input, matt(false, normals));
    result = unlight(hollow.input, matt(true, normals));
    const Vec3 without = bias(plain, hollow, counts), with = bias(result, hollow, counts);
    print(what, without, with, result);
    EXPECT_FALSE(plain.interreflection.has_value());
    Vec3 most = (view_share * albedo.cwiseProduct(without)).array() + 0.0033;
    if (normals == NormalMode::Refine) most = Vec3::Constant(most.maxCoeff());
    for (int c = 0; c < 3; ++c) EXPECT_LT(std::abs(with[c]), most[c]);
    EXPECT_GT(without[0], 0.1);
    EXPECT_FALSE(result.notes.empty());
  }
  return result;
}

TEST(Interreflection, ABowlHasItsAlbedoWithAllBouncesTakenOff) {
  constexpr double kDepth = 0.6, kViewShare = 0.25;  // (1 - cos 60) / 2.
  Hollow hollow = bowl(kDepth);
  const UnlightResult result =
      expect_less_than_one_bounce_leaves("bowl", hollow, kPaint * (1.0 - 0.5 * kDepth), kViewShare, everywhere);
  EXPECT_EQ(result.num_determined, result.num_surface);
  EXPECT_LT(result.interreflection->unseen, 0.02);
}

TEST(Interreflection, WhatTheCameraDoesNotSeeThrowsLightToo) {
  Hollow hollow = bowl(0.0);
  for (int y = 0; y < hollow.input.mask.height(); ++y) {
    for (int x = hollow.input.mask.width() / 2; x < hollow.input.mask.width(); ++x) hollow.input.mask.at(x, y) = 0;
  }
  // The half that is not seen has one bounce, of the first fit's albedo.
  const UnlightResult result = expect_less_than_one_bounce_leaves("half a bowl", hollow, kPaint, 0.25, everywhere);
  EXPECT_GT(result.interreflection->unseen, 0.4);
}

TEST(Interreflection, ACreaseHasItsAlbedo) {
  Hollow hollow = groove();
  const auto is_crease = [](int x, int) { return x >= 20 && x < 28; };
  // A long wall at right angles fills (1 - cos 90) / 2 of the view at its foot.
  (void)expect_less_than_one_bounce_leaves("crease", hollow, kGroovePaint, 0.5, is_crease);
}

TEST(Interreflection, APlaneKeepsEveryBit) {
  LitRelief scene = lit_relief({.size = 48, .height_mm = 0.0, .cast_shadows = false, .noise_share = 0.005});
  scene.input.blockers = &scene.scan;
  const UnlightResult plain = unlight(scene.input), result = unlight(scene.input, {.interreflection = true});
  EXPECT_EQ(plain.albedo, result.albedo);
  EXPECT_EQ(plain.stddev, result.stddev);
  EXPECT_EQ(result.interreflection->p95, 0.0);
}

TEST(Interreflection, NoiseOfAScanIsNoHollow) {
  LitRelief scene = lit_relief({.size = 48, .height_mm = 0.0, .cast_shadows = false, .scan_noise_mm = 0.1});
  scene.input.blockers = &scene.scan;
  const UnlightResult result = unlight(scene.input, {.specular = SpecularMode::None, .interreflection = true});
  std::printf("noisy plane: taken off %.3f %% (p95 %.3f %%)\n", 100.0 * result.interreflection->median,
              100.0 * result.interreflection->p95);
  // Rays begin an edge off the surface, several times the noise: next to none meets a bump.
  EXPECT_LT(result.interreflection->p95, 0.005);
}

TEST(Interreflection, TheSameBitsForAnyNumberOfThreads) {
  Hollow hollow = bowl(0.6);
  hollow.input.blockers = &hollow.scan;
  RunControl one, three;
  one.num_threads = 1, three.num_threads = 3;
  const UnlightResult a = unlight(hollow.input, matt(true), one), b = unlight(hollow.input, matt(true), three);
  EXPECT_EQ(a.albedo, b.albedo);
  EXPECT_EQ(a.indirect, b.indirect);
  EXPECT_EQ(a.notes, b.notes);
}

TEST(Interreflection, NeedsAScan) {
  const Hollow hollow = bowl(0.0);
  try {
    (void)unlight(hollow.input, matt(true));
    FAIL() << "nothing was said";
  } catch (const InvalidInput& e) {
    EXPECT_NE(std::string(e.what()).find("--interreflection needs a scan"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace patinate::capture
