#include "app/fit/scene_pointer.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace patinate::cli {
namespace {

const Json kScene = Json::parse(R"({
  "rules": ["patina", {"name": "iron.rust", "rate": 2}],
  "emitters": [{"name": "rain", "carries": {"water": 0.8}, "direction": [0, -1, 0], "spread_deg": 4}, {"gammatons": 10}],
  "appearance": {"moss": {"color": [0.1, 0.2, 0.1], "strength": 1}},
  "exchange": {"rates": {"water": 0.3}},
  "behavior": {"slider": 0.5},
  "weather": {"rows": [{"rain": 1}]}})");

TEST(ScenePointer, NumbersAreCalledByTheScenesOwnWords) {
  EXPECT_EQ(app::words_of(kScene, "/rules/1/rate"), "rule iron.rust: rate");
  EXPECT_EQ(app::words_of(kScene, "/emitters/0/carries/water"), "emitter rain: carries water");
  EXPECT_EQ(app::words_of(kScene, "/emitters/0/spread_deg"), "emitter rain: spread deg");
  EXPECT_EQ(app::words_of(kScene, "/emitters/0/direction/1"), "emitter rain: direction y");
  EXPECT_EQ(app::words_of(kScene, "/appearance/moss/color/0"), "appearance of moss: color red");
  EXPECT_EQ(app::words_of(kScene, "/exchange/rates/water"), "exchange rates water");
  EXPECT_EQ(app::words_of(kScene, "/behavior/slider"), "behavior slider");
}

TEST(ScenePointer, WhatHasNoNameKeepsItsPointer) {
  for (const char* pointer :
       {"/emitters/1/gammatons", "/weather/rows/0/rain", "/emitters/7/speed", "/nothing/here", "/rules/1/speed"})
    EXPECT_EQ(app::words_of(kScene, pointer), pointer);
}

TEST(ScenePointer, NumbersHaveTheUnitThatTheSceneCountsIn) {
  Json scene = kScene;
  scene["unit"] = "cm";
  EXPECT_EQ(app::unit_of(scene, "/rules/1/rate"), "per d");  // A scene that does not say counts days.
  scene["time"] = {{"unit", "h"}};
  EXPECT_EQ(app::unit_of(scene, "/rules/0/rate"), "per h");
  EXPECT_EQ(app::unit_of(scene, "/exchange/rates/water"), "per contact");
  EXPECT_EQ(app::unit_of(scene, "/emitters/0/carries/water"), "layers");
  EXPECT_EQ(app::unit_of(scene, "/emitters/0/speed"), "cm/s");
  EXPECT_EQ(app::unit_of(scene, "/appearance/moss/strength"), "per layer");
  for (const char* pointer :
       {"/appearance/moss/color/0", "/behavior/slider", "/emitters/1/gammatons", "/rules/1/speed"})
    EXPECT_EQ(app::unit_of(scene, pointer), "") << pointer;
}

}  // namespace
}  // namespace patinate::cli
