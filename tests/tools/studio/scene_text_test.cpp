#include "tools/studio/scene_text.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "patinate/core/error.h"
#include "simulation/files/scene_event.h"
#include "tests/support/errors.h"
#include "tests/support/plate_scene.h"

namespace patinate::studio {
namespace {

using testing_support::error_of;
using testing_support::has;

constexpr double kUnit = 8.0;  ///< mm; a power of two, so that lengths lose nothing on their way.

/// Event that a client asks for, as it happens.
simulation::SceneEvent sent(const Json& event, const simulation::Scene& scene) {
  return parse_event(event_of_file(event, kUnit, 7), scene, kUnit);
}

TEST(SceneText, AnEventThatAClientSendsInMillimetersHappensInMillimeters) {
  const simulation::Scene scene = testing_support::plate_scene(64);
  const simulation::SceneEvent event =
      sent(Json{{"op", "move"}, {"target", "plate"}, {"position", {30, -5, 0.5}}}, scene);
  EXPECT_EQ(event.iteration, 7);
  EXPECT_EQ(std::get<simulation::MoveEvent>(event.what).position_mm, Vec3(30, -5, 0.5));
}

TEST(SceneText, AnEmitterIsWhatItWasAfterItsJson) {
  const simulation::Scene scene = testing_support::plate_scene(64);
  simulation::Emitter asked = scene.emitters[0];
  asked.shape = simulation::EmitterShape::Disk;
  asked.position_mm = Vec3(1, 20, 3);
  asked.size_mm = {5, 0};
  asked.speed_mm_s = 700;
  asked.distance_mm = 3;
  const Json of_file = emitter_of_file(asked, scene.materials, kUnit);
  const Json event{{"iteration", 7}, {"op", "emitter"}, {"emitter", of_file}};
  const simulation::SceneEvent parsed = parse_event(event, scene, kUnit);
  const simulation::Emitter& got = std::get<simulation::EmitterEvent>(parsed.what).emitter;
  EXPECT_EQ(emitter_of_file(got, scene.materials, kUnit).dump(), of_file.dump());
  EXPECT_EQ(got.position_mm, asked.position_mm);
  EXPECT_EQ(got.size_mm, asked.size_mm);
  EXPECT_EQ(got.speed_mm_s, asked.speed_mm_s);
  EXPECT_EQ(got.distance_mm, asked.distance_mm);
}

TEST(SceneText, AnEventIsOneThingThatHappensNow) {
  const simulation::Scene scene = testing_support::plate_scene(64);
  EXPECT_TRUE(has(error_of([&] {
                    (void)sent(Json{{"op", "ratio"}, {"ratio", 0.5}, {"iteration", 3}}, scene);
                  }),
                  "an event happens now"));
  EXPECT_TRUE(has(error_of([&] {
                    (void)sent(
                        Json{{"op", "stroke"}, {"target", "rain"}, {"points", Json::array({Json::array({0, 0, 0})})}},
                        scene);
                  }),
                  "stands for 3 events; send one at a time"));
}

TEST(SceneText, AReadableDocumentHasShortPartsInOneLineAndReadsBackTheSame) {
  const Json document{{"unit", "mm"},
                      {"gravity", {0, -9810, 0}},
                      {"nothing", Json::array()},
                      {"rules", {{{"name", "a"}, {"rate", 0.1}}, {{"name", std::string(120, 'b')}, {"rate", 1}}}}};
  const std::string text = readable_text(document);
  EXPECT_TRUE(has(text, "\n  \"gravity\": [0, -9810, 0],\n  \"nothing\": [],\n"));
  EXPECT_TRUE(has(text, "\n    {\"name\": \"a\", \"rate\": 0.1},\n    {\n      \"name\": \"bbb"));
  EXPECT_EQ(Json::parse(text), document);
}

}  // namespace
}  // namespace patinate::studio
