// Pieces that turn against a direction field lie flat where it turns.
#include "transfer/synthesis/turns.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <numbers>
#include <vector>

#include "patinate/atlas/atlas_mesh.h"
#include "patinate/atlas/direction_field.h"
#include "patinate/datasets/objects.h"
#include "patinate/transfer/transfer.h"
#include "tests/support/histories.h"
#include "tests/support/meshes.h"
#include "transfer/exemplar/directedness.h"
#include "transfer/files/flow_io.h"
#include "transfer/synthesis/surface_patch.h"

namespace patinate::transfer {
namespace {

TEST(Turned, IsARotationInSourcePixels) {
  EXPECT_EQ(turned({300, -20}, 0), (FixedPoint{300, -20}));
  EXPECT_EQ(turned({1000, 0}, turn_of(std::numbers::pi / 2)), (FixedPoint{0, 1000}));
  EXPECT_EQ(turned({0, 1000}, turn_of(std::numbers::pi / 2)), (FixedPoint{-1000, 0}));
  EXPECT_EQ(turned({1000, -7}, turn_of(std::numbers::pi)), (FixedPoint{-1000, 7}));
  for (double radians = -3.0; radians < 3.1; radians += 0.37) {
    const FixedPoint p = turned({25600, 6400}, turn_of(radians));
    const double c = std::cos(radians), s = std::sin(radians);
    EXPECT_NEAR(p.x, c * 25600 - s * 6400, 25.0);  // A tenth of a pixel at the end of a hundred.
    EXPECT_NEAR(p.y, s * 25600 + c * 6400, 25.0);
  }
}

TEST(FrameTurns, AreWhatFramesDifferByInThePlaneOfOne) {
  FlowFrame flat, quarter, tilted;
  flat << 1, 0, 0, 1, 0, 0;
  quarter << 0, -1, 1, 0, 0, 0;                           // Its x is the other's y.
  tilted << 0, -1, std::sqrt(0.5), 0, std::sqrt(0.5), 0;  // The same, tilted by 45 degrees about the x axis.
  const FlowFrames frames{flat, quarter, tilted};
  Mesh apart;  // Triangles that are no neighbors are compared as those that are.
  apart.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0},  {5, 0, 0}, {6, 0, 0},
                     {5, 1, 0}, {9, 0, 0}, {10, 0, 0}, {9, 1, 0}};
  apart.triangles = {{0, 1, 2}, {3, 4, 5}, {6, 7, 8}};
  const FrameTurns turns(apart, frames);
  EXPECT_EQ(turns.between(0, 0), 0);
  EXPECT_NEAR(radians_of(turns.between(0, 1)), std::numbers::pi / 2, 1e-3);
  EXPECT_NEAR(radians_of(turns.between(1, 0)), -std::numbers::pi / 2, 1e-3);
  EXPECT_NEAR(radians_of(turns.between(0, 2)), std::numbers::pi / 2, 1e-3);
}

/// Of the pairs of neighbors in windows all over the mesh: how many lie as the piece has them, to half a pixel.
double flat_share(const TexelMap& map, bool may_turn) {
  const auto frames = std::make_shared<const FlowFrames>(direction_frames(map, DirectionKind::Gravity, Vec3(0, 1, 0)));
  const TexelNeighborhood beside(map, {}, frames, map.median_texel_size_mm());
  const FrameTurns turns(map.mesh(), *frames);
  PatchFinder finder(map, beside, may_turn ? &turns : nullptr);
  std::int64_t num = 0, flat = 0;
  for (TexelId t = 0; t < map.num_texels(); t += 997) {
    if (!map.is_covered(t)) continue;
    SurfacePatch patch;
    finder.find_texels(t, 20, patch);
    finder.find_edges(patch);
    for (const PatchEdge& e : patch.edges) {
      if (e.second < 0) continue;
      const PatchTexel &a = patch.texels[e.first], &b = patch.texels[e.second];
      const FixedPoint step = turned(e.step, a.turn);
      ++num;
      flat += std::max(std::abs(a.offset.x + step.x - b.offset.x), std::abs(a.offset.y + step.y - b.offset.y)) <=
              PixelNeighbor::kOne / 2;
    }
  }
  return static_cast<double>(flat) / static_cast<double>(num);
}

TEST(SurfacePatch, LiesFlatOnACurvedShapeIfPiecesTurn) {
  const AtlasMesh atlas = make_atlas_mesh(datasets::sculpture(), AtlasMethod::Auto, 512);
  const TexelMap map = make_texel_map(atlas, 512);
  const double following = flat_share(map, false), turning = flat_share(map, true);
  // What is left is the surface's own curvature, which no way of laying it flat takes away.
  EXPECT_LT(1.0 - turning, 0.25 * (1.0 - following)) << following << " " << turning;
}

/// Dark lines that run every way between cells, and a control along x.
std::shared_ptr<const History> net_of_lines() {
  const auto color = [](int x, int y, int, int) {
    const double u = 0.11 * x + 1.3 * std::sin(0.07 * y), v = 0.13 * y + 1.1 * std::sin(0.06 * x);
    return std::min(std::abs(std::sin(u)), std::abs(std::sin(v))) < 0.12 ? 0.05f : 0.5f;
  };
  return std::make_shared<const MemoryHistory>(testing_support::half_images(128, 128, 1, color));
}

/// Onto a plate whose directions run along circles around a point below its middle.
struct CircledPlate {
  std::shared_ptr<const TexelMap> map =
      std::make_shared<const TexelMap>(testing_support::unit_plane(128.0, 32), 128, 128);
  TransferTask task;

  CircledPlate() {
    std::vector<Vec3> arc;
    for (int k = 0; k <= 20; ++k) {
      const double angle = std::numbers::pi * (0.25 + 0.025 * k);
      arc.emplace_back(64.0 + 100.0 * std::cos(angle), 100.0 * std::sin(angle) - 36.0, 0.0);
    }
    ImageF along(128, 128);
    for (int y = 0; y < 128; ++y) {
      for (int x = 0; x < 128; ++x) along.at(x, y) = static_cast<float>(x) / 127.0f;
    }
    task.input = {.history = net_of_lines(),
                  .map = map,
                  .controls = {{"x", "along", along, {0.0, 1.0, ""}, 1.0, ControlMapping::Rank}},
                  .frames = std::make_shared<const FlowFrames>(curve_frames(*map, {arc}))};
  }
};

TEST(TurnedPieces, AreToldTexelByTexel) {
  const CircledPlate plate;
  const TransferResult result = transfer(plate.task.input, {.turning = PieceTurning::Free});
  ASSERT_EQ(result.used.turning, PieceTurning::Free);
  ASSERT_EQ(result.turns.size(), result.coordinates.size());
  const LaidFlow flow = as_stored(plate.task.input.frames, result.turns, *plate.map);
  std::int64_t num = 0, in_place = 0, turned_ones = 0;
  for (TexelId t = 0; t < plate.map->num_texels(); ++t) {
    if (t % 128 == 127) continue;
    turned_ones += result.turns[t] != 0;
    const auto position = [&](TexelId of) {
      const SourcePlace p = result.place(of);
      return Vec2(p.pixel % 128 + p.beside_x / 256.0, p.pixel / 128 + p.beside_y / 256.0);
    };
    // A step along texel x, which is the plate's x, in the source's axes there: what was made, and what the flow tells.
    const FlowFrame& frame = (*flow.frames)[plate.map->triangle(t)];
    const Vec2 told = Eigen::Rotation2Dd(radians_of(flow.turns[t])) * Vec2(frame.transpose() * Vec3(1.0, 0.0, 0.0));
    ++num;
    in_place += (position(t + 1) - position(t) - told).cwiseAbs().maxCoeff() <= 0.6;
  }
  EXPECT_GT(turned_ones, num / 4);
  EXPECT_GT(in_place, num * 8 / 10) << "all but borders of pieces";
}

TEST(TurnedPieces, AreThoseOfLinesThatRunEveryWay) {
  const CircledPlate plate;
  const ImageU8 whole;
  EXPECT_LT(directedness(*plate.task.input.history, whole), kDirected);
  const TransferResult never = transfer(plate.task.input, {.turning = PieceTurning::Never});
  EXPECT_TRUE(never.turns.empty());
  TransferInput as_uvs = plate.task.input;
  as_uvs.frames = nullptr;  // Charts may be mirrored.
  EXPECT_EQ(transfer(as_uvs, {.turning = PieceTurning::Free}).used.turning, PieceTurning::Never);
}

TEST(Directedness, TellsStreaksAndGridsFromNets) {
  const auto picture = [](const auto& value) {
    ImageF lightness(128, 128);
    for (int y = 0; y < 128; ++y) {
      for (int x = 0; x < 128; ++x) lightness.at(x, y) = value(x, y) ? 30.0f : 70.0f;
    }
    return lightness;
  };
  const auto streak = [](int x, int) { return x % 11 < 3; };
  const auto grid = [](int x, int y) { return x % 16 < 2 || y % 16 < 2; };
  const auto ring = [](int x, int y) {
    const int dx = x - 64, dy = y - 64;
    return static_cast<int>(std::sqrt(dx * dx + dy * dy)) % 12 < 3;
  };
  EXPECT_GT(directedness(picture(streak), {}), kDirected);
  EXPECT_GT(directedness(picture(grid), {}), kDirected);
  EXPECT_LT(directedness(picture(ring), {}), kDirected);
  EXPECT_EQ(directedness(ImageF(32, 32, 1, 50.0f), {}), 0.0);
}

}  // namespace
}  // namespace patinate::transfer
