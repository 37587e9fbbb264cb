#include "libcommon/controls/control_cache.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/libcommon/controls/control_shapes.h"
#include "tests/support/temp_folder.h"

namespace patinate {
namespace {

namespace fs = std::filesystem;

using testing_support::plane;
using testing_support::TempFolder;

std::vector<fs::path> kept_maps(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".exr") files.push_back(entry.path());
  return files;
}

struct ControlCacheTest : testing::Test {
  TempFolder folder;
  ControlCache cache{.folder = folder.path() / "deep" / "controls", .least_seconds = 0.0};
  TexelMap map{plane(10), 16, 16};
};

TEST_F(ControlCacheTest, AKeptMapIsTheMadeOneToTheBit) {
  for (const char* kind : {"accessibility", "ray_share", "height", "spray"}) {
    const ControlMap made = make_control(kind, map);
    const ControlMap first = cached_control(kind, map, {}, cache), again = cached_control(kind, map, {}, cache);
    for (const ControlMap* m : {&first, &again}) {
      EXPECT_EQ(m->values, made.values) << kind;
      EXPECT_EQ(m->low, made.low);
      EXPECT_EQ(m->high, made.high);
      EXPECT_EQ(m->unit, made.unit);
      EXPECT_EQ(m->notes, made.notes);
    }
  }
  EXPECT_EQ(kept_maps(cache.folder).size(), 4U);
}

TEST_F(ControlCacheTest, AMapIsReadAndNotMadeAgain) {
  (void)cached_control("height", map, {}, cache);
  bool is_made = false;
  RunControl control;
  control.on_progress = [&](double f) { is_made = is_made || f < 1.0; };
  (void)cached_control("ray_share", map, {}, cache, control);
  EXPECT_TRUE(is_made);
  is_made = false;
  (void)cached_control("ray_share", map, {}, cache, control);
  EXPECT_FALSE(is_made);
}

TEST_F(ControlCacheTest, OnlyOptionsThatTheKindLooksAtChangeItsKey) {
  ControlKindOptions options;
  const std::string height = control_content_key("height", map, options),
                    share = control_content_key("ray_share", map, options);
  options.ray_share.num_rays = 64;
  EXPECT_EQ(control_content_key("height", map, options), height);
  EXPECT_NE(control_content_key("ray_share", map, options), share);
  options.up = {0, 0, 1};
  EXPECT_NE(control_content_key("height", map, options), height);
  EXPECT_NE(control_content_key("height", TexelMap(plane(10), 8, 8), {}), height);
  EXPECT_NE(control_content_key("height", TexelMap(plane(11), 16, 16), {}), height);
}

TEST_F(ControlCacheTest, ADamagedFileIsMadeAgain) {
  const ControlMap made = cached_control("ray_share", map, {}, cache);
  const fs::path file = kept_maps(cache.folder).front();
  for (const std::uintmax_t size : {std::uintmax_t{0}, fs::file_size(file) / 2}) {
    fs::resize_file(file, size);
    EXPECT_EQ(cached_control("ray_share", map, {}, cache).values, made.values);
  }
  const fs::path facts = fs::path(file).replace_extension(".json");
  std::ofstream(facts) << "{\"low\": 3}";
  EXPECT_EQ(cached_control("ray_share", map, {}, cache).low, made.low);
}

TEST_F(ControlCacheTest, AFolderThatCannotBeMadeIsNoHarm) {
  std::ofstream(folder.path() / "file") << "x";
  cache.folder = folder.path() / "file" / "controls";
  EXPECT_EQ(cached_control("height", map, {}, cache).values, make_control("height", map).values);
}

TEST_F(ControlCacheTest, WhatIsFastIsNotKept) {
  cache.least_seconds = 1e9;
  (void)cached_control("height", map, {}, cache);
  EXPECT_FALSE(fs::exists(cache.folder));
}

TEST_F(ControlCacheTest, NoMoreAreKeptThanThereIsRoomFor) {
  ControlKindOptions options;
  for (std::size_t i = 0; i < kMaxKeptControls + 5; ++i) {
    options.up = {0.0, 1.0, 0.01 * static_cast<double>(i)};
    (void)cached_control("height", map, options, cache);
  }
  EXPECT_EQ(kept_maps(cache.folder).size(), kMaxKeptControls);
}

TEST_F(ControlCacheTest, AnExpressionAsksItForEachKind) {
  const ControlMap made = make_control_expression("0.5*height + 0.5*!ray_share", map);
  const ControlMap kept = make_control_expression("0.5*height + 0.5*!ray_share", map, {}, {}, control_source(cache));
  EXPECT_EQ(kept.values, made.values);
  EXPECT_EQ(kept_maps(cache.folder).size(), 2U);
}

}  // namespace
}  // namespace patinate
