// Landing spots of floating gammatons do not know how a surface is divided into triangles.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "libcommon/core/random.h"
#include "tests/libcommon/geometry/shapes.h"
#include "tests/simulation/tracing/chi_square.h"
#include "tests/simulation/tracing/landing_counts.h"
#include "tests/simulation/tracing/tracing_scene.h"

namespace patinate::simulation {
namespace {

using testing_support::chi_square_limit;
using testing_support::chi_square_of_equal;
using testing_support::LandingCounts;
using testing_support::make_icosphere;
using testing_support::scene_with;
using testing_support::TracedScene;
using testing_support::with_any_uvs;
using testing_support::Zone;

const Vec3 kDown{0, -1, 0};

/// Facets one below the other, each as long and wide, that bend by the same angle from one to the next: a strip on
/// which everything runs straight down, toward +x. Positive: it falls off ever more.
struct Facets {
  double first_slope_deg;
  double bend_deg;
  int count;
  double length_mm;
  static constexpr double kWidth = 40.0;

  [[nodiscard]] Mesh mesh() const {
    Mesh mesh;
    Vec3 p(0, 0, 0);
    for (int i = 0; i <= count; ++i) {
      for (const double z : {-0.5 * kWidth, 0.5 * kWidth}) mesh.positions.push_back(p + Vec3(0, 0, z));
      const double a = (first_slope_deg + i * bend_deg) * std::numbers::pi / 180.0;
      p += length_mm * Vec3(std::cos(a), -std::sin(a), 0);
    }
    for (int i = 0; i < count; ++i) {
      mesh.triangles.push_back({2 * i, 2 * i + 1, 2 * i + 3});
      mesh.triangles.push_back({2 * i, 2 * i + 3, 2 * i + 2});
    }
    mesh.surfaces = {{"facets", ""}};
    mesh.triangle_surface.assign(mesh.triangles.size(), 0);
    return with_any_uvs(mesh);
  }
};

Scene scene_of_running_drops(Mesh mesh, std::int64_t num_gammatons) {
  Scene scene = scene_with(std::move(mesh), 512);
  scene.gravity_mm_s2 = 9810.0 * kDown;
  scene.emitters[0].gammatons = num_gammatons;
  scene.emitters[0].is_on = false;
  scene.behavior = {
      .bounce = 0.0, .floating = 1.0, .absorb = 0.0, .deceleration_bounce = 0.0, .deceleration_float = 0.3};
  scene.tracing.rest_speed_mm_s = 0.0;
  return scene;
}

/// Chi-square of where drops are that were everywhere alike `iterations` ago, by distance below an edge and, apart from
/// that, by facet; over the limit of the 1 % level.
std::array<double, 2> unevenness(const Facets& facets, int iterations) {
  Scene scene = scene_of_running_drops(facets.mesh(), 200000);
  scene.tracing.lobe_exponent_float = 1e9;  // straight down
  scene.tracing.rest_slope_deg = 0.0;
  TracedScene run(scene);
  run.sum.emitted = scene.emitters[0].gammatons;  // they are put there
  RandomStream random(5, 0);
  for (std::size_t i = 0; i < run.gammatons.size(); ++i) {
    const int facet = static_cast<int>(random.below(static_cast<std::uint32_t>(facets.count)));
    const double along = random.uniform(), across = 0.1 + 0.8 * random.uniform();
    // Corners: 0 upper left, 1 upper right, 2 lower right; or 0 upper left, 1 lower right, 2 lower left.
    const bool is_first = across > along;
    run.gammatons.state[i] = GammatonState::Floating;
    run.gammatons.triangle[i] = 2 * facet + (is_first ? 0 : 1);
    run.gammatons.b1[i] = is_first ? across - along : across;
    run.gammatons.b2[i] = is_first ? along : along - across;
  }
  for (int k = 0; k < iterations; ++k) run.step();
  const double farthest = iterations * scene.tracing.epsilon_mm / scene.tracing.pull;
  const int first_facet = static_cast<int>(std::ceil(farthest / facets.length_mm));
  constexpr int kBins = 16;
  std::vector<double> by_place(kBins, 0.0), by_facet(static_cast<std::size_t>(facets.count - 1 - first_facet), 0.0);
  for (std::size_t i = 0; i < run.gammatons.size(); ++i) {
    if (run.gammatons.state[i] != GammatonState::Floating) continue;
    const int facet = run.gammatons.triangle[i] / 2;
    if (facet < first_facet || facet >= facets.count - 1) continue;  // not from above the strip, nor at its end
    const bool is_first = run.gammatons.triangle[i] % 2 == 0;
    const double along = is_first ? run.gammatons.b2[i] : run.gammatons.b1[i] + run.gammatons.b2[i];
    by_place[static_cast<std::size_t>(along * kBins)] += 1.0;
    by_facet[facet - first_facet] += 1.0;
  }
  return {chi_square_of_equal(by_place) / chi_square_limit(kBins - 1),
          chi_square_of_equal(by_facet) / chi_square_limit(static_cast<double>(by_facet.size()) - 1.0)};
}

void expect_even(const Facets& facets) {
  const std::array<double, 2> of_limit = unevenness(facets, 8);
  EXPECT_LT(of_limit[0], 1.0) << "by place on facets that bend by " << facets.bend_deg;
  EXPECT_LT(of_limit[1], 1.0) << "by facet on facets that bend by " << facets.bend_deg;
}

TEST(Landing, IsEvenBelowEdgesThatFallOff) {
  expect_even({.first_slope_deg = 20, .bend_deg = 5, .count = 12, .length_mm = 4});
  expect_even({.first_slope_deg = 10, .bend_deg = 15, .count = 6, .length_mm = 4});
  expect_even({.first_slope_deg = 5, .bend_deg = 40, .count = 4, .length_mm = 8});
  expect_even({.first_slope_deg = 60, .bend_deg = 2, .count = 20, .length_mm = 0.9});  // about one stride each
}

TEST(Landing, IsEvenBelowEdgesThatRise) {
  expect_even({.first_slope_deg = 85, .bend_deg = -5, .count = 12, .length_mm = 4});
  expect_even({.first_slope_deg = 85, .bend_deg = -15, .count = 5, .length_mm = 4});
  expect_even({.first_slope_deg = 88, .bend_deg = -28, .count = 4, .length_mm = 8});
  expect_even({.first_slope_deg = 85, .bend_deg = -2, .count = 20, .length_mm = 0.9});
}

/// Puts all gammatons onto a mesh as if they ran down it, everywhere alike.
void spread(const Mesh& mesh, Gammatons& gammatons) {
  std::vector<double> area_before{0.0};
  for (int t = 0; t < mesh.num_triangles(); ++t)
    area_before.push_back(area_before.back() + area_vector(mesh, t).norm());
  RandomStream random(7, 0);
  for (std::size_t i = 0; i < gammatons.size(); ++i) {
    const auto after =
        std::upper_bound(area_before.begin(), area_before.end() - 1, random.uniform() * area_before.back());
    gammatons.triangle[i] = static_cast<std::int32_t>(after - area_before.begin() - 1);
    gammatons.state[i] = GammatonState::Floating;
    const double a = std::sqrt(random.uniform());
    gammatons.b1[i] = a * random.uniform();
    gammatons.b2[i] = a - gammatons.b1[i];
  }
}

// Rain that falls straight down meets each facet in proportion to what is seen of it from above, near its edges as in
// its middle, whatever its chart: by chi-square.
TEST(Landing, OfRainOnASphereIsEvenOverFacetsAndTheirEdges) {
  constexpr int kIterations = 200;
  // Within these weights of an edge lies half of a triangle.
  const double rim = (1.0 - std::sqrt(0.5)) / 3.0;
  Scene scene = scene_with(with_any_uvs(make_icosphere(100.0, 2)));
  scene.emitters[0].shape = EmitterShape::Sky;
  scene.emitters[0].direction = -Vec3::UnitY();
  scene.emitters[0].spread_deg = 0.0;
  TracedScene run(std::move(scene));
  const Mesh& mesh = run.mesh.mesh;
  std::vector<std::array<double, 2>> met(mesh.triangles.size());
  for (int k = 0; k < kIterations; ++k) {
    run.trace();
    for (std::size_t i = 0; i < run.gammatons.size(); ++i) {
      if (run.gammatons.state[i] != GammatonState::InContact) continue;
      const double b1 = run.gammatons.b1[i], b2 = run.gammatons.b2[i];
      ++met[run.gammatons.triangle[i]][std::min({b1, b2, 1.0 - b1 - b2}) < rim ? 0 : 1];
    }
    run.respond();
  }
  double total = 0.0, seen = 0.0;
  for (int t = 0; t < mesh.num_triangles(); ++t) {
    const auto& [edge, middle] = met[t];
    total += edge + middle;
    seen += std::max(0.0, area_vector(mesh, t).y());
  }
  double chi_square = 0.0, bins = 0.0;
  for (int t = 0; t < mesh.num_triangles(); ++t) {
    const double expected = 0.5 * total * std::max(0.0, area_vector(mesh, t).y()) / seen;
    if (expected < 5.0) continue;  // Counts of less are not normal.
    for (const double count : met[t]) {
      chi_square += (count - expected) * (count - expected) / expected;
      ++bins;
    }
  }
  EXPECT_GT(total, 50'000);
  EXPECT_GT(bins, 250);
  EXPECT_LT(chi_square, chi_square_limit(bins - 1.0));
}

TEST(Landing, IsEvenBelowTheEdgesOfASphere) {
  // Edges of 15 mm; in the first ten strides of 0.75 mm, before what truly flows together and apart shows.
  TracedScene run(scene_of_running_drops(with_any_uvs(make_icosphere(100.0, 3)), 300000));
  run.sum.emitted = run.scene.emitters[0].gammatons;  // they are put there
  const Mesh& mesh = run.mesh.mesh;
  spread(mesh, run.gammatons);
  LandingCounts counts(mesh, 0.75, true, kDown);
  for (int k = 0; k < 10; ++k) {
    run.trace();
    for (std::size_t i = 0; k >= 6 && i < run.gammatons.size(); ++i) {
      if (run.gammatons.state[i] == GammatonState::InContact)
        counts.add(run.gammatons.triangle[i], run.gammatons.b1[i], run.gammatons.b2[i]);
    }
    run.respond();
  }
  std::vector<bool> is_upper, is_lower;
  for (int t = 0; t < mesh.num_triangles(); ++t) {
    const double up = area_vector(mesh, t).normalized().y();
    is_upper.push_back(up > 0.0 && up < 0.95);   // nothing runs onto the top
    is_lower.push_back(up <= 0.0 && up > -0.8);  // farther down it drips
  }
  for (const std::vector<bool>& half : {is_upper, is_lower}) {
    const LandingCounts::Ratio ratio = counts.over_middle(Zone::Below, half);
    EXPECT_LT(ratio.deviation, 0.01);
    EXPECT_NEAR(ratio.value, 1.0, 0.05);  // what the eye does not see: goal of the picture, 5 %
  }
}

/// Two facets that meet in an edge which lies `turn_deg` off level, and which falls off by `bend_deg`.
struct Fold {
  double slope_deg, turn_deg, bend_deg;
  static constexpr double kHalfEdge = 100.0, kDepth = 16.0;
  Vec3 edge, onto, on;    // unit; across the edge, along the upper facet and along the lower one
  double leaves, enters;  // cosines between flow and what lies across the edge, above and below

  Fold(double slope, double turn, double bend) : slope_deg(slope), turn_deg(turn), bend_deg(bend) {
    const double degree = std::numbers::pi / 180.0;
    const Vec3 steepest(std::cos(slope * degree), -std::sin(slope * degree), 0.0);
    edge = std::cos(turn * degree) * Vec3(0, 0, 1) + std::sin(turn * degree) * steepest;
    onto = std::cos(turn * degree) * steepest - std::sin(turn * degree) * Vec3(0, 0, 1);
    const Vec3 normal = edge.cross(onto), upper_normal = normal.y() > 0.0 ? normal : Vec3(-normal);
    on = std::cos(bend * degree) * onto - std::sin(bend * degree) * upper_normal;
    leaves = across(onto);
    enters = across(on);
  }
  [[nodiscard]] double across(const Vec3& direction) const {
    const Vec3 normal = edge.cross(direction);
    return (kDown - kDown.dot(normal) * normal).normalized().dot(direction);
  }
  [[nodiscard]] Mesh mesh() const {
    Mesh mesh;
    for (const Vec3& row : {Vec3(-kDepth * onto), Vec3(0, 0, 0), Vec3(kDepth * on)}) {
      for (const double end : {-kHalfEdge, kHalfEdge}) mesh.positions.push_back(row + end * edge);
    }
    mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {2, 4, 5}, {2, 5, 3}};
    if (area_vector(mesh, 0).y() < 0.0) {
      for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
    }
    mesh.surfaces = {{"fold", ""}};
    mesh.triangle_surface.assign(mesh.triangles.size(), 0);
    return with_any_uvs(mesh);
  }
};

/// Contacts an area at depths (i + 1/2) step below the edge over those above it. Strides, evenly [1/2, 1) of `stride`,
/// get to a depth of `leaves` times themselves while they lead over the edge, which lays them flat, and of `enters`
/// times themselves below it: u(x) = P(leaves s > x) + integral of f(y) u(x - y), f the density of enters s.
std::vector<double> renewal(const Fold& fold, double stride, double step, std::size_t count) {
  std::vector<double> u(count), until(count + 1, 0.0);  // its integral
  const auto integral = [&](double x) {
    if (!(x > 0.0)) return 0.0;
    const double at = x / step;
    const auto i = static_cast<std::size_t>(at);
    return until[i] + (at - static_cast<double>(i)) * (until[i + 1] - until[i]);
  };
  for (std::size_t i = 0; i < count; ++i) {
    const double x = (static_cast<double>(i) + 0.5) * step;
    const double reached = std::clamp(2.0 - 2.0 * x / (fold.leaves * stride), 0.0, 1.0);
    const double farthest = fold.enters * stride;
    u[i] = reached + (integral(x - 0.5 * farthest) - integral(x - farthest)) / (0.5 * farthest);
    until[i + 1] = until[i] + step * u[i];
  }
  return u;
}

TEST(Landing, GoesOverObliqueEdgesFromTheDensityAboveToTheRatioOfCosines) {
  constexpr std::int64_t kDrops = 400000;
  constexpr std::size_t kBins = 30, kSteps = 100;
  constexpr double kBin = 0.1;
  constexpr int kStrides = 14;
  for (const Fold& fold : {Fold(40, 35, 25), Fold(60, 30, 45), Fold(30, 40, 70), Fold(20, 20, 100)}) {
    Scene scene = scene_of_running_drops(fold.mesh(), kDrops);
    scene.behavior.deceleration_float = 1.0;  // each stride begins along gravity
    scene.tracing.rest_slope_deg = 0.0;
    const double stride = scene.tracing.epsilon_mm / scene.tracing.pull;
    ASSERT_GT(0.5 * stride * kStrides * fold.enters, kBin * kBins);  // what comes over the edge has passed all bins
    ASSERT_GT(Fold::kDepth, stride * kStrides * fold.leaves);
    TracedScene run(scene);
    run.sum.emitted = kDrops;  // they are put there, on the upper facet alone
    RandomStream random(6, 0);
    for (std::size_t i = 0; i < run.gammatons.size(); ++i) {
      const double along = random.uniform(), across = random.uniform();
      const bool is_first = across > along;  // triangle 0: corners (0,0), (1,0), (1,1) of depth and edge
      const double b_next = is_first ? across - along : across, b_last = is_first ? along : along - across;
      // Both triangles begin at corner 0 and share corner 3; the mesh may have swapped the other two.
      const Triangle& t = run.mesh.mesh.triangles[is_first ? 0 : 1];
      const bool is_swapped = t[1] == 3 ? is_first : !is_first;
      run.gammatons.triangle[i] = is_first ? 0 : 1;
      run.gammatons.b1[i] = is_swapped ? b_last : b_next;
      run.gammatons.b2[i] = is_swapped ? b_next : b_last;
      run.gammatons.state[i] = GammatonState::Floating;
    }
    for (int k = 0; k < kStrides; ++k) run.step();
    std::vector<double> found(kBins, 0.0), expected(kBins, 0.0);
    const double middle = Fold::kHalfEdge - stride * kStrides;
    for (std::size_t i = 0; i < run.gammatons.size(); ++i) {
      if (run.gammatons.state[i] != GammatonState::Floating || run.gammatons.triangle[i] < 2) continue;
      const Triangle& t = run.mesh.mesh.triangles[run.gammatons.triangle[i]];
      const double b1 = run.gammatons.b1[i], b2 = run.gammatons.b2[i];
      const std::array<double, 3> b{1.0 - b1 - b2, b1, b2};
      Vec3 p(0, 0, 0);
      for (std::size_t k = 0; k < 3; ++k) p += b[k] * run.mesh.mesh.positions[t[k]];
      const auto bin = static_cast<std::size_t>(p.dot(fold.on) / kBin);
      if (std::abs(p.dot(fold.edge)) < middle && bin < kBins) found[bin] += 1.0;
    }
    const std::vector<double> u = renewal(fold, stride, kBin / kSteps, kBins * kSteps);
    const double each = kDrops * (2.0 * middle * kBin) / (2.0 * Fold::kHalfEdge * Fold::kDepth) / kSteps;
    for (std::size_t i = 0; i < u.size(); ++i) expected[i / kSteps] += each * u[i];
    double chi_square = 0.0;
    for (std::size_t i = 0; i < kBins; ++i)
      chi_square += (found[i] - expected[i]) * (found[i] - expected[i]) / expected[i];
    EXPECT_LT(chi_square, chi_square_limit(kBins)) << "bend " << fold.bend_deg;
    EXPECT_NEAR(u.back(), fold.leaves / fold.enters, 0.02 * u.back()) << "far below: the ratio of cosines";
  }
}

TEST(Landing, DoesNotKnowSplitVertices) {
  const Mesh whole = with_any_uvs(make_icosphere(100.0, 2));
  Mesh split = whole;
  split.positions.clear();
  for (Triangle& t : split.triangles) {
    for (int& corner : t) {
      split.positions.push_back(whole.positions[corner]);
      corner = static_cast<int>(split.positions.size()) - 1;
    }
  }
  std::vector<std::vector<std::int32_t>> triangles;
  std::vector<std::int64_t> left;  // they drip
  for (const Mesh& mesh : {whole, split}) {
    TracedScene run(scene_of_running_drops(mesh, 5000));
    run.sum.emitted = run.scene.emitters[0].gammatons;
    spread(run.mesh.mesh, run.gammatons);
    for (int k = 0; k < 20; ++k) run.step();
    triangles.push_back(run.gammatons.triangle);
    left.push_back(run.sum.left);
  }
  EXPECT_EQ(triangles[0], triangles[1]);
  EXPECT_EQ(left[0], left[1]) << "split edges are no rims";
}

}  // namespace
}  // namespace patinate::simulation
