#include "patinate/atlas/direction_field.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "patinate/core/error.h"
#include "tests/libcommon/atlas/up.h"
#include "tests/libcommon/geometry/shapes.h"
#include "tests/support/meshes.h"

namespace patinate {
namespace {

using testing_support::kUp;
using testing_support::patchwork_plane;
using testing_support::unit_plane;

void expect_right_and_down(const TexelMap& map, const FlowFrames& frames) {
  for (std::size_t t = 0; t < frames.size(); ++t) {
    const Vec3 area = area_vector(map.mesh(), static_cast<int>(t)), normal = area.normalized();
    if (!(area.norm() > 1e-9)) continue;
    EXPECT_LT((frames[t].transpose() * frames[t] - Eigen::Matrix2d::Identity()).norm(), 1e-9);
    EXPECT_LT((frames[t].col(0).cross(frames[t].col(1)) + normal).norm(), 1e-9)
        << "right x down looks away from the surface";
  }
}

TEST(DirectionField, GravityRunsDownAPlaneWhateverItsCharts) {
  const TexelMap map(patchwork_plane(64.0, 4), 128, 128);
  const FlowFrames frames = direction_frames(map, DirectionKind::Gravity, kUp);
  expect_right_and_down(map, frames);
  // The UVs' share of the guide is 1e-4.
  for (const FlowFrame& f : frames) EXPECT_LT((f.col(1) - Vec3(0, -1, 0)).norm(), 2e-4);
}

TEST(DirectionField, AFlatFloorKeepsTheDirectionOfItsUvs) {
  Mesh floor = unit_plane(64.0);
  for (Vec3& p : floor.positions) p = Vec3(p.x(), 0.0, -p.y());  // Normal up.
  const TexelMap map(floor, 64, 64);
  const FlowFrames frames = direction_frames(map, DirectionKind::Gravity, kUp), uv = uv_frames(map);
  for (std::size_t t = 0; t < frames.size(); ++t) EXPECT_LT((frames[t] - uv[t]).norm(), 1e-9);
}

/// Angle between directions of neighboring triangles, largest over a mesh's edges away from `poles`.
double worst_bend(const Mesh& mesh, const FlowFrames& frames, const std::vector<Vec3>& poles, double keep_away) {
  const auto neighbors = triangle_neighbors(mesh);
  double worst = 0.0;
  for (std::size_t t = 0; t < frames.size(); ++t) {
    const Vec3& at = mesh.positions[mesh.triangles[t][0]];
    bool is_near = false;
    for (const Vec3& pole : poles) is_near |= (at - pole).norm() < keep_away;
    for (int n : neighbors[t]) {
      if (n >= 0 && !is_near)
        worst = std::max(worst, std::acos(std::clamp(frames[t].col(1).dot(frames[n].col(1)), -1.0, 1.0)));
    }
  }
  return worst;
}

TEST(DirectionField, OnASphereItRunsDownTheMeridiansAndIsSmoothButForItsPoles) {
  constexpr double kRadius = 50.0;
  const Mesh mesh = testing_support::make_patch(48, 24, [&](double u, double v) -> Vec3 {
    const double across = 2.0 * std::numbers::pi * u, up = std::numbers::pi * (v - 0.5);
    return kRadius * Vec3(std::sin(across) * std::cos(up), std::sin(up), std::cos(across) * std::cos(up));
  });
  const TexelMap map(mesh, 256, 128);
  const FlowFrames frames = direction_frames(map, DirectionKind::Gravity, kUp);
  expect_right_and_down(map, frames);
  for (std::size_t t = 0; t < frames.size(); ++t) {
    Vec3 at = Vec3::Zero();
    const Vec3 area = area_vector(mesh, static_cast<int>(t));
    if (!(area.norm() > 1e-9)) continue;  // At the poles.
    for (int c : mesh.triangles[t]) at += mesh.positions[c] / 3.0;
    if (std::abs(at.y()) > 0.5 * kRadius) continue;  // Nearer to the poles meridians run together, which is not smooth.
    const Vec3 n = area.normalized();
    const Vec3 down = (Vec3(0, -1, 0) + n * n.y()).normalized();
    EXPECT_GT(frames[t].col(1).dot(down), std::cos(0.12));
  }
  // Facets of 7.5 degrees.
  EXPECT_LT(worst_bend(mesh, frames, {Vec3(0, kRadius, 0), Vec3(0, -kRadius, 0)}, 0.4 * kRadius), 0.35);
}

TEST(DirectionField, LeastCurvatureOfALyingCylinderIsItsAxis) {
  const Mesh mesh = testing_support::make_patch(40, 16, [](double u, double v) -> Vec3 {  // Axis along x.
    return Vec3(80.0 * v, 10.0 * std::cos(2.0 * std::numbers::pi * u), 10.0 * std::sin(2.0 * std::numbers::pi * u));
  });
  const TexelMap map(mesh, 256, 256);
  const FlowFrames frames =
      direction_frames(map, DirectionKind::Curvature, Vec3(-1, 1, 0));  // "Down" has a part along the axis.
  expect_right_and_down(map, frames);
  for (const FlowFrame& f : frames) EXPECT_GT(f.col(1).x(), std::cos(0.05));
}

TEST(DirectionField, FollowsACurveAndGoesOnBesideIt) {
  const TexelMap map(unit_plane(64.0, 16), 64, 64);
  const Vec3 along = Vec3(2.0, 1.0, 0.0).normalized();
  const FlowFrames frames = curve_frames(map, {{Vec3(20, 20, 0), Vec3(20, 20, 0) + 20.0 * along}});
  expect_right_and_down(map, frames);
  for (const FlowFrame& f : frames) EXPECT_GT(f.col(1).dot(along), std::cos(0.02));
  EXPECT_THROW((void)curve_frames(map, {{Vec3(1, 1, 0)}}), InvalidInput);
}

TEST(DirectionField, FramesSurviveTheWayThroughUvs) {
  const TexelMap map(patchwork_plane(64.0, 4), 128, 128);
  const FlowFrames frames = direction_frames(map, DirectionKind::Gravity, kUp);
  int num_mirrored = 0;
  for (int t = 0; t < map.mesh().num_triangles(); ++t) {
    const FlowFrame uv = map.tangents(t);
    const FrameInUv in_uv = frame_in_uv(frames[t], uv);
    num_mirrored += in_uv.is_mirrored ? 1 : 0;
    EXPECT_LT((frame_from_uv(in_uv, uv) - frames[t]).norm(), 1e-12);
  }
  EXPECT_EQ(num_mirrored, map.mesh().num_triangles() / 2);
  // A quarter turn to the left where v is up: the frame's right is the UVs' up.
  FlowFrame uv = FlowFrame::Zero(), turned = FlowFrame::Zero();
  uv.col(0) = Vec3(1, 0, 0);
  uv.col(1) = Vec3(0, -1, 0);
  turned.col(0) = Vec3(0, 1, 0);
  turned.col(1) = Vec3(1, 0, 0);
  EXPECT_NEAR(frame_in_uv(turned, uv).angle, std::numbers::pi / 2.0, 1e-12);
  EXPECT_FALSE(frame_in_uv(turned, uv).is_mirrored);
}

}  // namespace
}  // namespace patinate
