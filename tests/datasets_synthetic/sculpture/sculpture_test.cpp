#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "datasets_synthetic/curve2.h"
#include "libcommon/geometry/curvature.h"
#include "patinate/atlas/texel_map.h"
#include "patinate/core/error.h"
#include "patinate/datasets/objects.h"

namespace patinate::datasets {
namespace {

double signed_uv_area(const Mesh& m, std::size_t t) {
  const Vec2 a = m.uvs[m.uv_triangles[t][0]], b = m.uvs[m.uv_triangles[t][1]], c = m.uvs[m.uv_triangles[t][2]];
  return 0.5 * ((b - a).x() * (c - a).y() - (b - a).y() * (c - a).x());
}

TEST(Sculpture, IsClosedAndConsistentlyOriented) {
  for (const int resolution : {24, 76}) {
    const Mesh m = sculpture({.resolution = resolution});
    std::map<std::pair<int, int>, int> directed;
    for (const Triangle& t : m.triangles) {
      for (std::size_t k = 0; k < 3; ++k) ++directed[{t[k], t[(k + 1) % 3]}];
    }
    for (const auto& [edge, count] : directed) {
      ASSERT_EQ(count, 1);
      ASSERT_EQ(directed.count({edge.second, edge.first}), 1u);
    }
    double volume = 0.0;  // Divergence theorem: positive when normals point outward.
    for (std::size_t t = 0; t < m.triangles.size(); ++t) {
      volume += m.positions[m.triangles[t][0]].dot(area_vector(m, static_cast<int>(t))) / 6.0;
    }
    EXPECT_GT(volume, 0.0);
    // Three bodies without holes: V - E + F = 6.
    const std::int64_t euler = static_cast<std::int64_t>(m.positions.size()) -
                               static_cast<std::int64_t>(directed.size() / 2) + m.num_triangles();
    EXPECT_EQ(euler, 6);
  }
}

TEST(Sculpture, StandsOnTheGroundAtTheHeightAskedFor) {
  const Box box = bounding_box(sculpture({.height_mm = 150.0}));
  EXPECT_NEAR(box.low.y(), 0.0, 0.5);
  EXPECT_NEAR(box.high.y(), 150.0, 0.5);
}

TEST(Sculpture, HasTheSizeThatItsHeaderSays) {
  const int triangles = sculpture().num_triangles();
  EXPECT_GT(triangles, 40'000);
  EXPECT_LT(triangles, 65'000);
}

TEST(Sculpture, ChartsDoNotOverlapAndAreNotMirrored) {
  const Mesh m = sculpture();
  for (const Vec2& uv : m.uvs) {
    ASSERT_GE(uv.minCoeff(), 0.0);
    ASSERT_LE(uv.maxCoeff(), 1.0);
  }
  double area = 0.0;
  for (std::size_t t = 0; t < m.triangles.size(); ++t) {
    ASSERT_GT(signed_uv_area(m, t), 0.0) << t;
    area += signed_uv_area(m, t);
  }
  const TexelMap map(m, 1024, 1024);
  EXPECT_EQ(map.num_overlapping(), 0);
  EXPECT_NEAR(static_cast<double>(map.num_covered()) / (1024.0 * 1024.0), area, 0.002);
  EXPECT_GT(area, 0.55);
  std::set<int> charts;
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    if (map.is_covered(t)) charts.insert(map.chart(t));
  }
  EXPECT_EQ(charts.size(), 16u);
}

TEST(Sculpture, TexelsHaveSimilarSizesEverywhere) {
  const Mesh m = sculpture();
  std::vector<double> lengths;  // mm per unit of the atlas, largest and smallest at every triangle.
  for (std::size_t t = 0; t < m.triangles.size(); ++t) {
    Eigen::Matrix<double, 3, 2> edges;
    Eigen::Matrix2d uv;
    for (int k = 0; k < 2; ++k) {
      const std::size_t i = static_cast<std::size_t>(k) + 1;
      edges.col(k) = m.positions[m.triangles[t][i]] - m.positions[m.triangles[t][0]];
      uv.col(k) = m.uvs[m.uv_triangles[t][i]] - m.uvs[m.uv_triangles[t][0]];
    }
    const Eigen::Matrix<double, 3, 2> jacobian = edges * uv.inverse();
    const Eigen::Matrix2d g = jacobian.transpose() * jacobian;
    const double mean = 0.5 * (g(0, 0) + g(1, 1)), spread = std::hypot(0.5 * (g(0, 0) - g(1, 1)), g(0, 1));
    lengths.push_back(std::sqrt(mean + spread));
    lengths.push_back(std::sqrt(mean - spread));
  }
  std::sort(lengths.begin(), lengths.end());
  EXPECT_LT(lengths[lengths.size() * 99 / 100] / lengths[lengths.size() / 100], 3.0);
  EXPECT_LT(lengths.back() / lengths.front(), 6.0);
  RecordProperty("extreme_ratio", std::to_string(lengths.back() / lengths.front()));
}

TEST(Sculpture, HasConcavitiesAndConvexities) {
  const Mesh m = sculpture();
  const std::vector<double> curvature = mean_curvature(m, 3.0);
  const auto num_concave = std::count_if(curvature.begin(), curvature.end(), [](double h) { return h > 0.03; });
  const auto num_convex = std::count_if(curvature.begin(), curvature.end(), [](double h) { return h < -0.03; });
  EXPECT_GT(num_concave, static_cast<std::ptrdiff_t>(curvature.size() / 20));
  EXPECT_GT(num_convex, static_cast<std::ptrdiff_t>(curvature.size() / 10));
}

TEST(Sculpture, CanBePlain) {
  const Mesh m = sculpture({.resolution = 24, .num_flutes = 0, .relief = 0.0});
  EXPECT_GT(m.num_triangles(), 1000);
  EXPECT_THROW((void)sculpture({.height_mm = 0.0}), InvalidInput);
  EXPECT_THROW((void)sculpture({.resolution = 4000}), InvalidInput);
}

TEST(Curve2, PassesThroughItsPointsByArcLength) {
  const std::vector<Vec2> points = {{0, 0}, {10, 0}, {20, 5}, {20, 30}};
  const Curve2 curve(points);
  for (int i = 0; i < 4; ++i) EXPECT_NEAR((curve.at(curve.length_at(i)) - points[i]).norm(), 0.0, 1e-9);
  // Equal steps of s are equal steps of length: to second order in the step.
  for (double s = 0.0; s + 0.1 < curve.length(); s += 0.1)
    EXPECT_NEAR((curve.at(s + 0.1) - curve.at(s)).norm(), 0.1, 2e-3);
}

}  // namespace
}  // namespace patinate::datasets
