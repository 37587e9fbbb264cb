// A texture on a surface whose UVs are cut, turned, mirrored and stretched lies there as it would on a plain one.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "libcommon/atlas/texel_neighborhood.h"
#include "patinate/atlas/direction_field.h"
#include "patinate/transfer/transfer.h"
#include "tests/support/histories.h"
#include "tests/support/meshes.h"
#include "tests/support/temp_folder.h"

namespace patinate::transfer {
namespace {

constexpr int kSurfaceSource = 128;  // Pixels, of 1 mm.

std::shared_ptr<const FlowFrames> downward(const TexelMap& map) {
  return std::make_shared<const FlowFrames>(direction_frames(map, DirectionKind::Gravity, Vec3(0, 1, 0)));
}

/// Where on the plane a texel lies, in source pixels: right and down from the upper left corner.
Vec2 place_on_plane(const TexelMap& map, TexelId t, double side_mm) {
  const Vec3 p = map.position_mm(t);
  return {p.x() - 0.5, side_mm - p.y() - 0.5};
}

/// The plane's x and y as controls, in source pixels.
std::vector<TransferControl> place_controls(const TexelMap& map, double side_mm) {
  ImageF xs(map.width(), map.height()), ys(map.width(), map.height());
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    if (!map.is_covered(t)) continue;
    const Vec2 place = place_on_plane(map, t, side_mm);
    xs.data()[t] = static_cast<float>(place.x() / (kSurfaceSource - 1));
    ys.data()[t] = static_cast<float>(place.y() / (kSurfaceSource - 1));
  }
  const ControlRange range{0.0, kSurfaceSource - 1.0, "px"};
  return {{"x", "x", xs, range, 1.0, ControlMapping::Physical}, {"y", "y", ys, range, 1.0, ControlMapping::Physical}};
}

/// Share of neighbors a texel apart that are so in the source, over seams and inside charts.
struct Coherence {
  double over_seams = 0.0, inside = 0.0;
};
Coherence measure_coherence(const TexelMap& map, const std::shared_ptr<const FlowFrames>& frames,
                            const CoordinateMap& coordinates, double pixel_mm) {
  const double step = map.median_texel_size_mm();
  const TexelNeighborhood neighborhood(map, {{step, 0.0}, {-step, 0.0}, {0.0, step}, {0.0, -step}}, frames, pixel_mm);
  TexelNeighborhood::Cursor cursor(neighborhood);
  std::array<std::int64_t, 2> pairs{}, coherent{};
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    if (!map.is_covered(t)) continue;
    const std::int32_t s = coordinates[t];
    for (const PixelNeighbor& n : cursor.at(t)) {
      if (n.texel < 0 || n.texel == t) continue;
      const std::size_t kind = map.chart(n.texel) == map.chart(t) ? 1 : 0;
      const std::int32_t other = coordinates[n.texel];
      const Vec2 error =
          Vec2(other % kSurfaceSource - s % kSurfaceSource, other / kSurfaceSource - s / kSurfaceSource) -
          Vec2(n.x, n.y) / PixelNeighbor::kOne;
      ++pairs[kind];
      coherent[kind] += error.cwiseAbs().maxCoeff() < 0.99 ? 1 : 0;  // Both places are rounded.
    }
  }
  return {static_cast<double>(coherent[0]) / static_cast<double>(pairs[0]),
          static_cast<double>(coherent[1]) / static_cast<double>(pairs[1])};
}

// The guide says where every texel belongs: with charts turned, mirrored and scaled, its source is that place and no
// other.
TEST(OnTheSurface, TheGuidesPlacesComeThroughAnyCharts) {
  testing_support::TempFolder folder;
  testing_support::write_history(folder.path(), kSurfaceSource, kSurfaceSource, 3, testing_support::blotches);
  const auto history = std::make_shared<const HistoryReader>(folder.path());
  const auto map = std::make_shared<const TexelMap>(testing_support::patchwork_plane(kSurfaceSource, 3), 256, 256);
  for (TransferMethod method : {TransferMethod::Fast, TransferMethod::Reference}) {
    TransferOptions options;
    options.method = method;
    options.coherence_share = options.multi_level.first_coherence =
        0.01;  // Pieces may lie a pixel beside their place where that fits better: little of it.
    options.reference.first_coherence = 0.01;
    const TransferResult result = transfer({.history = history,
                                            .map = map,
                                            .texel_size_mm = 1.0,
                                            .controls = place_controls(*map, kSurfaceSource),
                                            .frames = downward(*map)},
                                           options);
    double sum = 0.0;
    std::int64_t count = 0;
    for (TexelId t = 0; t < map->num_texels(); ++t) {
      if (!map->is_covered(t)) continue;
      const Vec2 place = place_on_plane(*map, t, kSurfaceSource);
      constexpr double kBorder = 4.0;  // The source's neighborhood ends there.
      if (place.minCoeff() < kBorder || place.maxCoeff() > kSurfaceSource - 1 - kBorder) continue;
      const std::int32_t s = result.coordinates[t];
      sum += (Vec2(s % kSurfaceSource, s / kSurfaceSource) - place).cwiseAbs().maxCoeff();
      ++count;
    }
    EXPECT_LT(sum / static_cast<double>(count), 0.8) << static_cast<int>(method);
    EXPECT_GT(result.energy.coherent_share, 0.95) << static_cast<int>(method);
  }
}

// Pieces cross seams nearly as they cross any other line. (Pairs over a seam lie up to 1.5 times as far apart, where a
// chart's texels are larger.)
TEST(OnTheSurface, PiecesGoOnOverSeams) {
  testing_support::TempFolder folder;
  testing_support::write_history(folder.path(), kSurfaceSource, kSurfaceSource, 3, testing_support::blotches);
  const auto history = std::make_shared<const HistoryReader>(folder.path());
  const auto map = std::make_shared<const TexelMap>(testing_support::patchwork_plane(kSurfaceSource, 3), 256, 256);
  TransferControl guide = place_controls(*map, kSurfaceSource)[0];
  guide.mapping = ControlMapping::Rank;
  const std::shared_ptr<const FlowFrames> frames = downward(*map);
  const Coherence with = measure_coherence(
      *map, frames,
      transfer({.history = history, .map = map, .texel_size_mm = 1.0, .controls = {guide}, .frames = frames})
          .coordinates,
      1.0);
  const auto uv = std::make_shared<const FlowFrames>(uv_frames(*map));
  const Coherence without = measure_coherence(
      *map, uv, transfer({.history = history, .map = map, .texel_size_mm = 1.0, .controls = {guide}}).coordinates, 1.0);
  RecordProperty("over_seams", std::to_string(with.over_seams));
  RecordProperty("inside", std::to_string(with.inside));
  RecordProperty("over_seams_by_uv", std::to_string(without.over_seams));
  EXPECT_GT(with.over_seams, 0.9 * with.inside);
  EXPECT_LT(without.over_seams, 0.7 * without.inside) << "without frames, charts cut pieces";
}

// Squares of 8 mm, texels of 0.5 mm x 2 mm: stretched 4 : 1.
TEST(OnTheSurface, ACheckerKeepsItsPitchOnAStretchedAtlas) {
  constexpr int kPitch = 8;
  const auto is_light = [](int x, int y) { return ((x / kPitch + y / kPitch) & 1) != 0; };
  testing_support::TempFolder folder;
  testing_support::write_history(folder.path(), kSurfaceSource, kSurfaceSource, 2,
                                 [&](int x, int y, int, int) { return is_light(x, y) ? 0.9f : 0.1f; });
  const auto history = std::make_shared<const HistoryReader>(folder.path());
  const auto map = std::make_shared<const TexelMap>(testing_support::unit_plane(kSurfaceSource), 2 * kSurfaceSource,
                                                    kSurfaceSource / 2);
  TransferControl guide = place_controls(*map, kSurfaceSource)[0];
  guide.mapping = ControlMapping::Rank;
  const TransferResult result =
      transfer({.history = history, .map = map, .texel_size_mm = 1.0, .controls = {guide}, .frames = downward(*map)},
               {.coherence_share = 0.9});
  const auto light_at = [&](int x, int y) {
    const std::int32_t s = result.coordinates[y * map->width() + x];
    return is_light(s % kSurfaceSource, s / kSurfaceSource);
  };
  // The median length of a run: pieces that end inside a square make shorter ones, and at the source's borders
  // something else stands.
  const auto median_run = [](int lines, int length, auto&& light) {
    std::vector<int> runs;
    for (int line = 0; line < lines; ++line) {
      int last = -1;
      for (int i = 1; i < length; ++i) {
        if (light(line, i) == light(line, i - 1)) continue;
        if (last >= 0) runs.push_back(i - last);
        last = i;
      }
    }
    std::nth_element(runs.begin(), runs.begin() + static_cast<std::ptrdiff_t>(runs.size() / 2), runs.end());
    return runs[runs.size() / 2];
  };
  const double pitch_x = 0.5 * median_run(map->height(), map->width(), [&](int y, int x) { return light_at(x, y); });
  const double pitch_y = 2.0 * median_run(map->width(), map->height(), [&](int x, int y) { return light_at(x, y); });
  RecordProperty("pitch_x", std::to_string(pitch_x));
  RecordProperty("pitch_y", std::to_string(pitch_y));
  EXPECT_NEAR(pitch_x, kPitch, 0.05 * kPitch);
  EXPECT_NEAR(pitch_y, kPitch, 0.05 * kPitch);
}

}  // namespace
}  // namespace patinate::transfer
