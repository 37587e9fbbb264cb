#include "tools/studio/tile_planes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "patinate/simulation/engine.h"
#include "tests/support/meshes.h"
#include "tools/studio/overlay_plane.h"
#include "tools/studio/tile_messages.h"

namespace patinate::studio {
namespace {

/// A plate in two charts with gutters between, in dirty rain; rust rises. A side that is no multiple of 8.
simulation::Scene plate(int resolution = 100) {
  simulation::Scene scene;
  scene.materials = {"water", "dirt"};
  scene.appearance.resize(2);
  scene.appearance[1].color.color = Vec3(0.05, 0.04, 0.03);
  scene.appearance[1].height_mm = 0.7;
  scene.appearance[1].specular = -0.5;
  scene.resolution = resolution;
  simulation::SceneObject object;
  object.name = "plate";
  object.mesh = testing_support::cut_plane(100.0);
  object.rotate_deg = Vec3(-60, 0, 0);
  scene.objects.push_back(object);
  simulation::Emitter rain;
  rain.name = "rain";
  rain.shape = simulation::EmitterShape::Sky;
  rain.gammatons = 40;
  rain.carries = {0.8, 1.5};
  scene.emitters.push_back(rain);
  scene.exchange.rates = {0.4, 0.4};
  return scene;
}

/// A client's picture: what updates are applied to.
struct Picture {
  int width, height;
  std::vector<std::uint8_t> bytes;
  Picture(int w, int h) : width(w), height(h), bytes(static_cast<std::size_t>(w * h) * 4, 0) {}
  void apply(const TilePlanes& planes, TilePlanes::Plane plane, const std::vector<ScreenTile>& tiles) {
    const int columns = (width + 7) / 8;
    for (const ScreenTile tile : tiles) {
      for (int i = 0; i < 64; ++i) {
        const int x = static_cast<int>(tile) % columns * 8 + i % 8, y = static_cast<int>(tile) / columns * 8 + i / 8;
        if (x < width && y < height)
          std::memcpy(&bytes[static_cast<std::size_t>(y * width + x) * 4], planes.tile(plane, tile).data() + 4 * i, 4);
      }
    }
  }
};

TEST(TilePlanes, UpdatesAddUpToThePicturesThatAreExported) {
  simulation::Simulation simulation(plate());
  const ScreenLayout layout(simulation.atlas().surface());
  TilePlanes planes(layout);
  const ReliefRange range{-2.0, 2.0};
  Picture surface(100, 100), relief(100, 100);
  std::size_t num_sent = 0;
  for (int i = 0; i < 12; ++i) {
    for (int k = 0; k < i; ++k) simulation.step();
    const simulation::Composer& composer = simulation.compose();
    const TilePlanes::Changes changes = planes.update(composer, layout.showing(simulation.composed_tiles()), range);
    surface.apply(planes, TilePlanes::Surface, changes.surface);
    relief.apply(planes, TilePlanes::Relief, changes.relief);
    if (i > 0) num_sent = std::max(num_sent, changes.surface.size());
    const ImageU8 color = composer.color_srgb8(), specular = composer.specular8(), normal = composer.normal8();
    const ImageF height = composer.height_mm();
    for (int y = 0; y < 100; ++y) {
      for (int x = 0; x < 100; ++x) {
        const std::size_t at = static_cast<std::size_t>(y * 100 + x) * 4;
        for (int c = 0; c < 3; ++c) {
          ASSERT_EQ(surface.bytes[at + static_cast<std::size_t>(c)], color.at(x, y, c)) << x << " " << y;
          ASSERT_EQ(relief.bytes[at + static_cast<std::size_t>(c)], normal.at(x, y, c)) << x << " " << y;
        }
        ASSERT_EQ(surface.bytes[at + 3], specular.at(x, y));
        ASSERT_EQ(relief.bytes[at + 3], range.code(static_cast<double>(height.at(x, y))));
      }
    }
    ASSERT_TRUE(planes.rows(TilePlanes::Surface) == std::string(surface.bytes.begin(), surface.bytes.end()));
    ASSERT_TRUE(planes.rows(TilePlanes::Relief) == std::string(relief.bytes.begin(), relief.bytes.end()));
  }
  EXPECT_GT(num_sent, 0u);
  EXPECT_LT(num_sent, layout.num_tiles());  // not everything every time
}

TEST(TilePlanes, NothingNewIsNothingToSend) {
  simulation::Simulation simulation(plate());
  const ScreenLayout layout(simulation.atlas().surface());
  TilePlanes planes(layout);
  std::vector<simulation::TileIndex> all(simulation.atlas().surface().grid().num_tiles());
  for (simulation::TileIndex t = 0; t < all.size(); ++t) all[t] = t;
  EXPECT_FALSE(planes.update(simulation.compose(), layout.showing(all), {}).surface.empty());
  const TilePlanes::Changes again = planes.update(simulation.compose(), layout.showing(all), {});
  EXPECT_TRUE(again.surface.empty());
  EXPECT_TRUE(again.relief.empty());
}

TEST(TilePlanes, AnUndoneStateIsShownAgain) {
  simulation::Simulation simulation(plate());
  const ScreenLayout layout(simulation.atlas().surface());
  TilePlanes planes(layout);
  const auto show = [&] {
    const simulation::Composer& composer = simulation.compose();
    (void)planes.update(composer, layout.showing(simulation.composed_tiles()), {});
  };
  for (int i = 0; i < 20; ++i) simulation.step();
  show();
  const std::vector<std::byte> before = simulation.snapshot();
  const std::string seen = planes.rows(TilePlanes::Surface);
  for (int i = 0; i < 20; ++i) simulation.step();
  show();
  EXPECT_TRUE(planes.rows(TilePlanes::Surface) != seen);
  simulation.restore(before);
  show();
  const std::string again = planes.rows(TilePlanes::Surface);
  for (std::size_t i = 0; i < seen.size(); ++i)
    ASSERT_EQ(again[i], seen[i]) << "texel " << i / 4 % 100 << ", " << i / 400;
}

/// The byte of a value: the root of its share of the top.
double byte_of(double value, const OverlayPlane& plane) {
  return 255.0 * std::sqrt(std::clamp(value / plane.high(), 0.0, 1.0));
}

TEST(OverlayPlane, ShowsAmountsAndCountersWithTheirTop) {
  simulation::Simulation simulation(plate(), {.parameter_maps = {"hits"}});
  const ScreenLayout layout(simulation.atlas().surface());
  OverlayPlane dirt("dirt", simulation, layout), hits("hits", simulation, layout);
  for (int i = 0; i < 60; ++i) {
    simulation.step();
    (void)dirt.update(simulation);
  }
  (void)hits.update(simulation);
  const ImageF amounts = simulation.amounts(1), counts = simulation.parameter_map("hits").values;
  const simulation::TileGrid& grid = simulation.atlas().surface().grid();
  for (ScreenTile tile = 0; tile < layout.num_tiles(); ++tile) {
    const std::array<simulation::TexelIndex, 64> sources = layout.sources(tile);
    for (std::size_t i = 0; i < 64; ++i) {
      if (sources[i] == simulation::kNoTexel) continue;
      const int x = grid.x(sources[i]), y = grid.y(sources[i]);
      EXPECT_NEAR(dirt.tile(tile)[i], byte_of(static_cast<double>(amounts.at(x, y)), dirt), 0.51);
      EXPECT_NEAR(hits.tile(tile)[i], byte_of(static_cast<double>(counts.at(x, y)), hits), 0.51);
    }
  }
  EXPECT_GT(hits.high(), 1.0);
}

TEST(OverlayPlane, ItsRangeIsThatOfTheData) {
  simulation::Simulation simulation(plate(), {.parameter_maps = {"hits"}});
  const ScreenLayout layout(simulation.atlas().surface());
  OverlayPlane dirt("dirt", simulation, layout), hits("hits", simulation, layout);
  for (OverlayPlane* plane : {&dirt, &hits}) {
    (void)plane->update(simulation);
    (void)plane->measure(simulation);
    EXPECT_EQ(plane->range(), OverlayRange{}) << "nothing is there yet";
  }
  for (int i = 0; i < 60; ++i) {
    simulation.step();
    (void)dirt.update(simulation);
  }
  (void)hits.update(simulation);
  const ImageF amounts = simulation.amounts(1), counts = simulation.parameter_map("hits").values;
  for (auto [plane, image] : {std::pair(&dirt, &amounts), std::pair(&hits, &counts)}) {
    EXPECT_TRUE(plane->is_stale());
    EXPECT_TRUE(plane->measure(simulation));
    EXPECT_FALSE(plane->is_stale());
    EXPECT_FALSE(plane->measure(simulation)) << "the same again";
    std::vector<float> found;  // the slow truth: all of them, sorted
    for (const float v : image->values()) {
      if (v > 0.0f) found.push_back(v);
    }
    std::sort(found.begin(), found.end());
    constexpr double kThreeDigits = 0.006;
    EXPECT_NEAR(plane->range().most, static_cast<double>(found.back()), kThreeDigits * plane->range().most);
    const double high = static_cast<double>(found[static_cast<std::size_t>(0.98 * static_cast<double>(found.size()))]);
    EXPECT_NEAR(plane->range().high, high, kThreeDigits * high);
    EXPECT_LE(plane->range().most, plane->high());
    EXPECT_GT(plane->range().most, 0.25 * plane->high()) << "bytes are not wasted";
  }
}

TEST(OverlayPlane, FollowsABrushWhileTimeStandsStill) {
  simulation::Scene scene = plate();
  simulation::Emitter brush;
  brush.name = "brush";
  brush.shape = simulation::EmitterShape::Surface;
  brush.gammatons = 100;
  brush.size_mm = {20.0, 0.0};
  brush.carries = {2.0, 2.0};
  brush.is_on = false;
  scene.emitters.push_back(brush);
  simulation::Simulation simulation(scene, {.parameter_maps = {"hits"}});
  const ScreenLayout layout(simulation.atlas().surface());
  OverlayPlane dirt("dirt", simulation, layout), hits("hits", simulation, layout);
  (void)dirt.update(simulation);
  (void)hits.update(simulation);
  for (int i = 0; i < 3; ++i) {
    simulation.paint("brush", Vec3(0, 0, 0));
    EXPECT_FALSE(dirt.update(simulation).empty()) << i;
    EXPECT_FALSE(hits.update(simulation).empty()) << i;
  }
}

TEST(DirtyTiles, HoldATileOnceAndGiveAllOnce) {
  DirtyTiles dirty(130);
  EXPECT_TRUE(dirty.empty());
  for (int i = 0; i < 3; ++i) dirty.add(std::vector<ScreenTile>{129, 5, 64, 5});
  EXPECT_EQ(dirty.take(), (std::vector<ScreenTile>{5, 64, 129}));
  EXPECT_TRUE(dirty.empty());
  dirty.add_all();
  EXPECT_EQ(dirty.take().size(), 130u);
}

TEST(TileMessages, StayWithinFourMegabytesAndSayWhichIsLast) {
  std::vector<ScreenTile> tiles(40'000);
  for (ScreenTile t = 0; t < tiles.size(); ++t) tiles[t] = t;
  const std::vector<std::uint8_t> bytes(256, 7);
  const std::vector<std::string> messages =
      tile_messages(Json{{"type", "tiles"}, {"plane", "surface"}}, tiles, true,
                    [&](ScreenTile) { return std::span<const std::uint8_t>(bytes); });
  ASSERT_EQ(messages.size(), 3u);
  std::size_t count = 0;
  for (std::size_t i = 0; i < messages.size(); ++i) {
    EXPECT_LE(messages[i].size(), kMaxMessageBytes);
    std::uint32_t size = 0;
    std::memcpy(&size, messages[i].data(), 4);
    EXPECT_EQ((4 + size) % 4, 0u);
    const Json header = Json::parse(messages[i].substr(4, size));
    EXPECT_EQ(header["last"].get<bool>(), i + 1 == messages.size());
    EXPECT_EQ(messages[i].size(), 4 + size + header["count"].get<std::size_t>() * 260);
    std::uint32_t first = 0;
    std::memcpy(&first, messages[i].data() + 4 + size, 4);
    EXPECT_EQ(first, count);
    count += header["count"].get<std::size_t>();
  }
  EXPECT_EQ(count, tiles.size());
}

}  // namespace
}  // namespace patinate::studio
