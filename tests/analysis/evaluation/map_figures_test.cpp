#include "analysis/evaluation/map_figures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "libcommon/core/files.h"
#include "patinate/atlas/direction_field.h"
#include "patinate/core/error.h"
#include "tests/support/histories.h"
#include "tests/support/meshes.h"
#include "tests/support/temp_folder.h"

namespace patinate::analysis {
namespace {

using testing_support::TempFolder;

constexpr int kTileSide = 96;

/// Blotches under a grid of dark lines. The control grows along x.
SynthesisSource lined_source() {
  SynthesisSource source;
  source.frames = {ImageF(kTileSide, kTileSide, 3), ImageF(kTileSide, kTileSide, 3)};
  source.control = ImageF(kTileSide, kTileSide);
  for (int y = 0; y < kTileSide; ++y) {
    for (int x = 0; x < kTileSide; ++x) {
      const bool is_line = x % 24 < 2 || y % 24 < 2;
      for (int c = 0; c < 3; ++c) {
        const float blotch = 150.0f + 40.0f * std::clamp(testing_support::blotches(x, y, 2, c), 0.0f, 1.0f);
        source.frames[0].at(x, y, c) = std::round(blotch);
        source.frames[1].at(x, y, c) = is_line ? 40.0f : std::round(blotch);
      }
      source.control.at(x, y) = static_cast<float>(x) / static_cast<float>(kTileSide - 1);
    }
  }
  return source;
}

/// Where a texel of a tile comes from: blocks of 16 x 16 in another order.
std::array<float, 2> shuffled(int x, int y) {
  const int block = (5 * (x / 16) + 7 * (y / 16) + 3) % 36;
  return {static_cast<float>(block % 6 * 16 + x % 16), static_cast<float>(block / 6 * 16 + y % 16)};
}

/// `num_tiles` flat squares of kTileSide texels, apart from each other, each alone in its tile.
SynthesizedMap squares(int num_tiles, const SynthesisSource& source) {
  Sheet sheet{.tile_width = kTileSide, .tile_height = kTileSide, .columns = num_tiles > 1 ? 2 : 1, .names = {}};
  for (int i = 0; i < num_tiles; ++i) sheet.names.push_back(num_tiles > 1 ? std::to_string(1001 + i) : "");
  Mesh mesh;
  mesh.normals = {{0, 0, 1}};
  for (int tile = 0; tile < num_tiles; ++tile) {
    const int first = static_cast<int>(mesh.positions.size());
    for (const auto& [u, v] : {std::pair{0.0, 0.0}, std::pair{1.0, 0.0}, std::pair{1.0, 1.0}, std::pair{0.0, 1.0}}) {
      mesh.positions.emplace_back(kTileSide * u + 2.0 * kTileSide * tile, kTileSide * v, 0.0);
      mesh.uvs.push_back(sheet.sheet_uv(tile, {u, v}));
    }
    for (const auto& c : {std::array{0, 1, 2}, std::array{0, 2, 3}}) {
      mesh.triangles.push_back({first + c[0], first + c[1], first + c[2]});
      mesh.uv_triangles.push_back(mesh.triangles.back());
      mesh.normal_triangles.push_back({0, 0, 0});
    }
  }
  SynthesizedMap map{.name = "map",
                     .surface = std::make_shared<TexelMap>(std::move(mesh), sheet),
                     .coordinates = ImageF(sheet.width(), sheet.height(), 2, -1.0f),
                     .control = ImageF(sheet.width(), sheet.height())};
  for (int tile = 0; tile < num_tiles; ++tile) {
    for (int y = 0; y < kTileSide; ++y) {
      for (int x = 0; x < kTileSide; ++x) {
        const int sx = sheet.first_x(tile) + x, sy = sheet.first_y(tile) + y;
        const std::array<float, 2> from = shuffled(x, y);
        map.coordinates.at(sx, sy, 0) = from[0];
        map.coordinates.at(sx, sy, 1) = from[1];
        map.control.at(sx, sy) = source.control.at((x + 7) % kTileSide, y);
      }
    }
  }
  return map;
}

EvaluationOptions quick_map_figures() { return {.num_samples = 1000, .num_directions = 8}; }

void expect_same(const Evaluation& a, const Evaluation& b, const std::set<std::string>& but = {},
                 double relative = 0.0) {
  ASSERT_EQ(a.figures.size(), b.figures.size());
  for (std::size_t i = 0; i < a.figures.size(); ++i) {
    const Figure &p = a.figures[i], &q = b.figures[i];
    ASSERT_EQ(p.name, q.name);
    EXPECT_EQ(p.value.has_value(), q.value.has_value()) << p.name;
    if (but.contains(p.name) || !p.value || !q.value) continue;
    // Quantiles of more values lie between other two of them: a bin of 2^-10 codes at most.
    const double gradient = p.name == "gradient_emd" ? 1.0 / 1024.0 : 0.0;
    EXPECT_NEAR(*p.value, *q.value, relative * std::abs(*p.value) + gradient) << p.name;
  }
}

/// Windows are drawn by chance, and end where a tile does.
std::set<std::string> and_windows(std::set<std::string> names) {
  names.insert({"line_share_surface", "dead_ends_surface", "closed_share_surface"});
  return names;
}

// Sums of four equal numbers are exactly four times one of them; what is drawn by chance differs, and a percentile of
// four times as many values may be the next value.
TEST(MapFigures, FourTilesThatAreAlikeHaveTheFiguresOfOne) {
  const SynthesisSource source = lined_source();
  const Evaluation one = evaluate(source, squares(1, source), quick_map_figures(), 1),
                   four = evaluate(source, squares(4, source), quick_map_figures(), 1);
  expect_same(one, four,
              and_windows({"patch_swd", "joint_swd", "control_error_p95", "control_error_s3_p95", "scale_error_p99"}));
  for (const char* defined : {"control_error_p95", "coherent_share", "gradient_emd", "spectrum", "scale_error_p99",
                              "line_share", "closed_share_crops", "border_contrast", "rep_all"}) {
    const auto found =
        std::find_if(four.figures.begin(), four.figures.end(), [&](const Figure& f) { return f.name == defined; });
    ASSERT_NE(found, four.figures.end()) << defined;
    EXPECT_TRUE(found->value) << defined;
  }
  EXPECT_EQ(one.pictures.size(), four.pictures.size());
  EXPECT_EQ(four.pictures.front().image.width(), 2 * kTileSide + 2);
}

/// A square whose two halves lie in two charts; in one tile both, or one in each of two.
SynthesizedMap cut_square(bool is_in_two_tiles, const SynthesisSource& source) {
  constexpr int kCells = 8;
  Mesh mesh = testing_support::cut_plane(kTileSide, kCells);
  Sheet sheet{.tile_width = 192, .tile_height = 192, .columns = is_in_two_tiles ? 2 : 1, .names = {}};
  sheet.names = is_in_two_tiles ? std::vector<std::string>{"1001", "1002"} : std::vector<std::string>{""};
  std::vector<Vec2> uvs;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    double x = 0.0;
    for (const int corner : mesh.triangles[i]) x += mesh.positions[corner].x() / 3.0;
    const int tile = is_in_two_tiles && x > kTileSide / 2.0 ? 1 : 0;
    for (int& corner : mesh.uv_triangles[i]) {
      const Vec2 uv = sheet.sheet_uv(tile, mesh.uvs[corner]);
      const auto known = std::find(uvs.begin(), uvs.end(), uv);
      corner = static_cast<int>(known - uvs.begin());
      if (known == uvs.end()) uvs.push_back(uv);
    }
  }
  mesh.uvs = uvs;
  SynthesizedMap map{.name = "cut",
                     .surface = std::make_shared<TexelMap>(std::move(mesh), sheet),
                     .coordinates = ImageF(sheet.width(), sheet.height(), 2, -1.0f),
                     .control = {}};
  for (TexelId t = 0; t < map.surface->num_texels(); ++t) {
    if (!map.surface->is_covered(t)) continue;
    const Vec3 p = map.surface->position_mm(t);
    const double y = p.x() > kTileSide / 2.0 ? std::fmod(p.y() + 13.0, kTileSide) : p.y();
    map.coordinates.data()[2 * t] = static_cast<float>(std::clamp(std::floor(p.x()), 0.0, kTileSide - 1.0));
    map.coordinates.data()[2 * t + 1] = static_cast<float>(std::clamp(std::floor(y), 0.0, kTileSide - 1.0));
  }
  (void)source;
  return map;
}

// Equal texels are beside each other, so that only sums are rounded in another order.
TEST(MapFigures, ASeamBetweenTilesIsWhatItIsWithinOne) {
  const SynthesisSource source = lined_source();
  const Evaluation within = evaluate(source, cut_square(false, source), quick_map_figures(), 1),
                   between = evaluate(source, cut_square(true, source), quick_map_figures(), 1);
  const auto seam = std::find_if(within.figures.begin(), within.figures.end(),
                                 [](const Figure& f) { return f.name == "seam_gradient_ratio"; });
  ASSERT_TRUE(seam->value);
  EXPECT_GT(*seam->value, 1.1);
  expect_same(within, between, and_windows({"patch_swd", "joint_swd", "rep64"}), 1e-9);
}

}  // namespace
}  // namespace patinate::analysis
