// Lifted flakes as shells.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "patinate/atlas/texel_map.h"
#include "patinate/core/error.h"
#include "patinate/simulation/engine.h"
#include "patinate/simulation/layer_atlas.h"
#include "simulation/flakes/flake_outline.h"
#include "simulation/flakes/flake_shells.h"
#include "simulation/flakes/lifted_flakes.h"
#include "tests/support/plate_scene.h"

namespace patinate::simulation {
namespace {

constexpr int kResolution = 64;
constexpr double kThicknessMm = 0.4, kStrain = 0.05, kReliefLengths = 10.0;
constexpr double kRadiusMm = kThicknessMm / kStrain;

/// A plate under paint. Everything holds.
Scene painted_plate() {
  Scene scene = testing_support::plate_scene(kResolution);
  SceneObject& plate = scene.objects[0];
  plate.layers = {
      {.name = "steel", .look = plate.preset},
      {.name = "paint", .thickness_um = "400", .cracks = LayerCracks{.relief = kReliefLengths, .shrinkage = kStrain}}};
  plate.preset.amounts = {};
  return scene;
}

void set_map(Simulation& simulation, const std::string& name, const ImageF& values) {
  const std::vector<std::string> names = simulation.layer_map_names();
  simulation.set_layer_map(static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin()),
                           values);
}

/// The plate's state by texel: '.' holds, 'o' has lost its adhesion, '#' is cracked. The stress is 1 everywhere.
struct Drawing {
  ImageU8 state{kResolution, kResolution, 1, '.'};

  void fill(int x0, int y0, int x1, int y1, char what) {
    for (int y = y0; y < y1; ++y) {
      for (int x = x0; x < x1; ++x) state.at(x, y) = static_cast<std::uint8_t>(what);
    }
  }
  void apply_to(Simulation& simulation) const {
    ImageF adhesion(kResolution, kResolution, 1, 1.0F), crack(kResolution, kResolution),
        stress(kResolution, kResolution, 1, 1.0F);
    for (int y = 0; y < kResolution; ++y) {
      for (int x = 0; x < kResolution; ++x) {
        if (state.at(x, y) == 'o') adhesion.at(x, y) = 0.0F;
        if (state.at(x, y) == '#') crack.at(x, y) = 1.0F;
      }
    }
    set_map(simulation, "layer1.stress", stress);
    set_map(simulation, "layer1.crack", crack);
    set_map(simulation, "layer1.adhesion", adhesion);
  }
};

/// A square of `side` texels that holds on its left side alone; cracks are on the other three.
Drawing square_flake(int x0, int y0, int side) {
  Drawing drawing;
  drawing.fill(x0, y0 - 1, x0 + side + 1, y0 + side + 1, '#');
  drawing.fill(x0, y0, x0 + side, y0 + side, 'o');
  return drawing;
}

struct Made {
  LiftedFlakes flakes;
  FlakeShells shells;
  double texel_mm = 0.0;
  Vec3 normal = Vec3::UnitZ();
};

Made shells_of(const Scene& scene, const Drawing& drawing, int most = kMostFlakeTriangles, int num_threads = 0) {
  Simulation simulation(scene);
  drawing.apply_to(simulation);
  Made made{.flakes = find_lifted_flakes(*simulation.layers()), .shells = {}};
  const TexelMap map(simulation.mesh(), kResolution, kResolution);
  RunControl control;
  control.num_threads = num_threads;
  made.shells = flake_shells(made.flakes, map, {}, most, control);
  made.texel_mm = simulation.texel_size_mm();
  made.normal = map.normal(kResolution * kResolution / 2);
  return made;
}

/// Vertices - edges + triangles of a mesh in which every edge has two triangles that go along it in opposite
/// directions. -1000 where one has not.
int euler_number(const Mesh& mesh) {
  std::map<std::pair<int, int>, int> edges;
  std::vector<char> is_used(mesh.positions.size(), 0);
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      ++edges[{t[k], t[(k + 1) % 3]}];
      is_used[static_cast<std::size_t>(t[k])] = 1;
    }
  }
  for (const auto& [edge, count] : edges) {
    const auto back = edges.find({edge.second, edge.first});
    if (count != 1 || back == edges.end() || back->second != 1) return -1000;
  }
  return static_cast<int>(std::count(is_used.begin(), is_used.end(), 1)) - static_cast<int>(edges.size() / 2) +
         mesh.num_triangles();
}

double volume_of(const Mesh& mesh) {
  double sum = 0.0;
  for (const Triangle& t : mesh.triangles)
    sum += mesh.positions[t[0]].dot(mesh.positions[t[1]].cross(mesh.positions[t[2]])) / 6.0;
  return sum;
}

/// Middle surface: of the upper side and the underside, whose positions stand in the same order.
Mesh middle_of(const Mesh& shell, std::size_t num_triangles) {
  Mesh middle;
  const std::size_t n = shell.positions.size() / 2;
  for (std::size_t i = 0; i < n; ++i) middle.positions.push_back(0.5 * (shell.positions[i] + shell.positions[n + i]));
  middle.triangles.assign(shell.triangles.begin(),
                          shell.triangles.begin() + static_cast<std::ptrdiff_t>(num_triangles));
  return middle;
}

double area_of(const Mesh& mesh) {
  double sum = 0.0;
  for (int t = 0; t < mesh.num_triangles(); ++t) sum += 0.5 * area_vector(mesh, t).norm();
  return sum;
}

TEST(Flakes, ASquareIsBentAlongAnArcAndKeepsItsAreaAndVolume) {
  constexpr int kSide = 12, kX = 20, kY = 24;
  const Made made = shells_of(painted_plate(), square_flake(kX, kY, kSide));
  ASSERT_EQ(made.flakes.flakes.size(), 1U);
  EXPECT_EQ(made.flakes.flakes[0].num_texels, kSide * kSide);
  constexpr double kQuantum = 1.0 / 16384.0;
  EXPECT_NEAR(made.flakes.flakes[0].thickness_mm, kThicknessMm, 1e-3 / 16.0);
  EXPECT_NEAR(made.flakes.flakes[0].radius_mm, kRadiusMm, kRadiusMm * kQuantum);
  // Half of what a crack leaves of its texel belongs to the flake.
  const double texel = made.texel_mm, crack_mm = 2.0 * kStrain * kReliefLengths * kThicknessMm;
  const double rim = 0.5 * (1.0 - crack_mm / texel) * texel;
  const double length = kSide * texel + rim, width = kSide * texel + 2.0 * rim;
  const Mesh& mesh = made.shells.mesh;
  const Mesh middle = middle_of(mesh, 2 * kSide * kSide);
  // A chord is shorter than its arc by the square of half the angle over 6; the end that is sunk is longer by the
  // square of its slope over 2, over one of the texels.
  const double turn = (texel + rim) / kRadiusMm, slope = kSunkShare * kThicknessMm / texel;
  const double rounding = turn * turn / 24.0 + slope * slope / (2.0 * kSide);
  EXPECT_NEAR(area_of(middle), length * width, rounding * length * width);
  EXPECT_NEAR(volume_of(mesh), length * width * kThicknessMm, 2.0 * rounding * length * width * kThicknessMm);
  // What lies at x from the hinge stands on the arc, and beyond kMostCurl on its tangent.
  double lowest = 1e9, highest = -1e9;
  for (const Vec3& p : middle.positions) {
    lowest = std::min(lowest, p.dot(made.normal));
    highest = std::max(highest, p.dot(made.normal));
  }
  const double straight = std::max(0.0, length - kMostCurl * kRadiusMm);
  const double angle = std::min(kMostCurl, length / kRadiusMm);
  const double rise = kRadiusMm * (1.0 - std::cos(angle)) + straight * std::sin(angle);
  EXPECT_NEAR(highest - lowest, rise + kSunkShare * kThicknessMm, 1e-3 * rise);
}

TEST(Flakes, AreClosedAndFaceOutward) {
  const Made made = shells_of(painted_plate(), square_flake(20, 24, 9));
  EXPECT_EQ(euler_number(made.shells.mesh), 2);
  const Mesh& mesh = made.shells.mesh;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 area = area_vector(mesh, static_cast<int>(t)).normalized();
    const bool is_upper = t < 2 * 81;
    EXPECT_TRUE(!is_upper || area.dot(made.normal) > std::cos(kMostCurl) - 0.01) << t;
    for (const int n : mesh.normal_triangles[t]) EXPECT_GT(mesh.normals[n].dot(area), 0.0) << t;
  }
}

TEST(Flakes, FaceOutwardInAMirroredChart) {
  Scene scene = painted_plate();
  for (Vec2& uv : scene.objects[0].mesh.uvs) uv.x() = 1.0 - uv.x();
  const Made made = shells_of(scene, square_flake(20, 24, 9));
  EXPECT_EQ(euler_number(made.shells.mesh), 2);
  EXPECT_GT(volume_of(made.shells.mesh), 0.0);
}

TEST(Flakes, ThatHangAroundACoreAreRings) {
  Drawing drawing;
  drawing.fill(20, 20, 42, 42, '#');
  drawing.fill(21, 21, 41, 41, 'o');
  drawing.fill(26, 26, 36, 36, '.');
  const Made made = shells_of(painted_plate(), drawing);
  ASSERT_EQ(made.flakes.flakes.size(), 1U);
  EXPECT_EQ(euler_number(made.shells.mesh), 0);
}

TEST(Flakes, ThatMeetAtACornerAreApart) {
  // Two squares of one piece that touch at a corner alone, besides where they are joined.
  Drawing drawing;
  drawing.fill(10, 10, 40, 40, '#');
  drawing.fill(11, 11, 17, 17, 'o');
  drawing.fill(17, 17, 23, 23, 'o');
  drawing.fill(11, 17, 14, 26, 'o');
  drawing.fill(14, 23, 23, 26, 'o');
  drawing.fill(10, 11, 11, 17, '.');
  const Made made = shells_of(painted_plate(), drawing);
  ASSERT_EQ(made.flakes.flakes.size(), 1U);
  EXPECT_NE(euler_number(made.shells.mesh), -1000);
}

TEST(Flakes, ThatAreNarrowOrHangNowhereAreNone) {
  // One texel beside what holds; a sliver of two texels between cracks; a piece without hold.
  Drawing drawing;
  drawing.fill(10, 10, 11, 30, 'o');
  drawing.fill(11, 10, 12, 30, '#');
  drawing.fill(20, 10, 40, 14, '#');
  drawing.fill(20, 11, 39, 13, 'o');
  drawing.fill(20, 40, 32, 52, '#');
  drawing.fill(21, 41, 31, 51, 'o');
  const Made made = shells_of(painted_plate(), drawing);
  EXPECT_TRUE(made.flakes.flakes.empty());
  EXPECT_TRUE(made.shells.mesh.triangles.empty());
  EXPECT_EQ(made.flakes.lifted[made.flakes.index(10, 20)], 1);
}

TEST(Flakes, LeaveTheLayerBelowBareButForTheirHinge) {
  constexpr int kSide = 6, kX = 20, kY = 24;
  const Made made = shells_of(painted_plate(), square_flake(kX, kY, kSide));
  const LiftedFlakes& flakes = made.flakes;
  EXPECT_EQ(flakes.bare[flakes.index(kX, kY + 2)], 0);
  EXPECT_EQ(flakes.bare[flakes.index(kX + 1, kY + 2)], 1);
  EXPECT_EQ(flakes.bare[flakes.index(kX + kSide, kY + 2)], 1);  // The crack behind it.
  EXPECT_EQ(flakes.bare[flakes.index(kX - 1, kY + 2)], 0);
  EXPECT_EQ(flakes.bare[flakes.index(kX + kSide + 1, kY + 2)], 0);
}

TEST(Flakes, HaveAtMostSoManyTriangles) {
  Drawing drawing = square_flake(20, 8, 12);
  const Drawing other = square_flake(20, 40, 9);
  for (std::int64_t i = 0; i < drawing.state.num_pixels(); ++i) {
    if (other.state.data()[i] != '.') drawing.state.data()[i] = other.state.data()[i];
  }
  const int all = shells_of(painted_plate(), drawing).shells.mesh.num_triangles();
  EXPECT_EQ(all, 4 * (144 + 81) + 2 * 4 * (12 + 9));
  for (const int most : {all, all - 1, 300, 100, 30, 11}) {
    const Made made = shells_of(painted_plate(), drawing, most);
    EXPECT_LE(made.shells.mesh.num_triangles(), most);
    EXPECT_GE(made.shells.mesh.num_triangles(), most < 12 ? 0 : most / 8) << most;
    EXPECT_NE(euler_number(made.shells.mesh), -1000) << most;  // 0 of none.
  }
}

TEST(Flakes, HaveTheSameBitsForAnyNumberOfThreads) {
  const Made one = shells_of(painted_plate(), square_flake(20, 24, 12), kMostFlakeTriangles, 1);
  for (const int threads : {2, 3}) {
    const Made other = shells_of(painted_plate(), square_flake(20, 24, 12), kMostFlakeTriangles, threads);
    EXPECT_TRUE(one.shells.mesh.positions == other.shells.mesh.positions &&
                one.shells.mesh.normals == other.shells.mesh.normals &&
                one.shells.mesh.triangles == other.shells.mesh.triangles);
  }
}

TEST(Flakes, OutlinesHaveNoStepsOfTexels) {
  // The free edge of a triangle of texels is a diagonal: places on it are nearer to the line than the steps, whose
  // corners lie 0.35 texels off.
  Drawing drawing;
  for (int y = 0; y < 30; ++y) {
    drawing.fill(10, 10 + y, 10 + y + 1, 11 + y, 'o');
    drawing.fill(10 + y + 1, 10 + y, 10 + y + 2, 11 + y, '#');
  }
  Simulation simulation(painted_plate());
  drawing.apply_to(simulation);
  const std::vector<FlakeOutline> outlines = flake_outlines(find_lifted_flakes(*simulation.layers()), 1);
  ASSERT_EQ(outlines.size(), 1U);
  double most = 0.0, mean = 0.0;
  int num = 0;
  for (const OutlineEdge& e : outlines[0].edges) {
    const Vec2& p = outlines[0].places[e.a];
    if (e.is_hinge || p.y() < 16.0 || p.y() > 34.0) continue;
    mean += (p.x() - p.y()) / std::sqrt(2.0);
    ++num;
  }
  ASSERT_GT(num, 10);
  mean /= num;
  for (const OutlineEdge& e : outlines[0].edges) {
    const Vec2& p = outlines[0].places[e.a];
    if (!e.is_hinge && p.y() >= 16.0 && p.y() <= 34.0)
      most = std::max(most, std::abs((p.x() - p.y()) / std::sqrt(2.0) - mean));
  }
  EXPECT_LT(most, 0.1);
}

TEST(Flakes, OfAnotherSizeThanTheirSurfaceAreRefused) {
  Simulation simulation(painted_plate());
  square_flake(20, 24, 6).apply_to(simulation);
  const LiftedFlakes flakes = find_lifted_flakes(*simulation.layers());
  EXPECT_THROW((void)flake_shells(flakes, TexelMap(simulation.mesh(), 32, 32)), InvalidInput);
}

}  // namespace
}  // namespace patinate::simulation
