// Events of a scene file: each kind is read as it was written.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "patinate/core/error.h"
#include "simulation/files/scene_json.h"
#include "tests/support/errors.h"
#include "tests/support/plate_scene.h"

namespace patinate::simulation {
namespace {

using testing_support::error_of;
using testing_support::has;

constexpr double kUnit = 8.0;  ///< mm; a power of two, so that lengths lose nothing on their way.

/// The plate in the rain, with a rule and a brush.
Scene scene_with_brush() {
  Scene scene = testing_support::plate_scene(64);
  scene.rules.push_back(testing_support::rust_rule(0.5));
  Emitter brush;
  brush.name = "brush";
  brush.shape = EmitterShape::Surface;
  brush.gammatons = 70;
  brush.is_on = false;
  scene.emitters.push_back(brush);
  return scene;
}

std::vector<SceneEvent> read(const Json& list, const Scene& scene) {
  SceneContext context;
  context.materials = scene.materials;
  context.mm_per_unit = kUnit;
  Scene with_events = scene;
  read_events(JsonReader("scene.json", list, "/events"), context, with_events);
  return with_events.events;
}

Json array_of(const Vec3& v) { return Json::array({v.x(), v.y(), v.z()}); }
Json length_of(const Vec3& mm) { return array_of(mm / kUnit); }

Json amounts_json(const MaterialValues& values, const Scene& scene) {
  Json json = Json::object();
  for (std::size_t i = 0; i < scene.materials.size(); ++i) json[scene.materials[i]] = values[i];
  return json;
}

/// An element of "emitters".
Json emitter_json(const Emitter& e, const Scene& scene) {
  Json json{{"name", e.name}, {"shape", kEmitterShapeNames[static_cast<std::size_t>(e.shape)]}};
  if (e.shape != EmitterShape::Sky) json["position"] = length_of(e.position_mm);
  json["direction"] = array_of(e.direction);
  json["size"] = {e.size_mm[0] / kUnit, e.size_mm[1] / kUnit};
  json["spread_deg"] = e.spread_deg;
  json["speed"] = e.speed_mm_s / kUnit;
  json["distance"] = e.distance_mm / kUnit;
  json["gammatons"] = e.gammatons;
  json["carries"] = amounts_json(e.carries, scene);
  json["on"] = e.is_on;
  return json;
}

// An event's own members, as a scene file has them; a kind without one does not compile.

Json members(const MoveEvent& e, const Scene&) {
  return {{"op", "move"}, {"target", e.target}, {"position", length_of(e.position_mm)}};
}
Json members(const TurnEvent& e, const Scene&) {
  return {{"op", "turn"}, {"target", e.object}, {"rotate", array_of(e.rotate_deg)}};
}
Json members(const ScaleEvent& e, const Scene&) { return {{"op", "scale"}, {"target", e.object}, {"scale", e.scale}}; }
Json members(const EmitterEvent& e, const Scene& scene) {
  return {{"op", "emitter"}, {"emitter", emitter_json(e.emitter, scene)}};
}
Json members(const SwitchEvent& e, const Scene&) { return {{"op", "switch"}, {"target", e.emitter}, {"on", e.is_on}}; }
Json members(const RatioEvent& e, const Scene&) { return {{"op", "ratio"}, {"ratio", e.ratio}}; }
Json members(const RateEvent& e, const Scene&) { return {{"op", "rate"}, {"target", e.material}, {"rate", e.rate}}; }
Json members(const BehaviorEvent& e, const Scene&) {
  const Behavior& b = e.behavior;
  return {{"op", "behavior"},
          {"behavior",
           {{"bounce", b.bounce},
            {"float", b.floating},
            {"absorb", b.absorb},
            {"deceleration_bounce", b.deceleration_bounce},
            {"deceleration_float", b.deceleration_float}}}};
}
Json members(const RuleEvent& e, const Scene& scene) {
  Json json{{"op", "rule"}, {"target", e.rule}};
  if (e.change.driver) json["driver"] = *e.change.driver;
  if (e.change.rate) json["rate"] = *e.change.rate;
  if (e.change.products) json["products"] = amounts_json(*e.change.products, scene);
  if (e.change.reactants) json["reactants"] = amounts_json(*e.change.reactants, scene);
  return json;
}
Json members(const PaintEvent& e, const Scene&) {
  Json points = Json::array();
  for (const BrushStop& stop : e.stops) {
    points.push_back(length_of(stop.position_mm));
    if (stop.steps != 1) points.back().push_back(stop.steps);
  }
  return {{"op", "paint"}, {"target", e.emitter}, {"points", points}};
}

Json event_json(const SceneEvent& event, const Scene& scene) {
  Json json{{"iteration", event.iteration}};
  json.update(std::visit([&](const auto& what) { return members(what, scene); }, event.what));
  return json;
}

/// No value is what its member begins with.
std::vector<SceneEvent> one_of_each() {
  Emitter rain;
  rain.name = "brush";
  rain.shape = EmitterShape::Rectangle;
  rain.position_mm = Vec3(10, 200, -30);
  rain.direction = Vec3(1, 0, 0);
  rain.size_mm = {12, 24};
  rain.spread_deg = 15;
  rain.speed_mm_s = 640;
  rain.distance_mm = 4;
  rain.gammatons = 70;
  rain.carries = {0.5, 0, 0.25};
  rain.is_on = true;
  RuleChange begun{.driver = "slope", .rate = 0.75, .products = MaterialValues{0, 0, 2}, .reactants = {}, .begins = {}};
  RuleChange changed{.driver = "water",
                     .rate = 0.125,
                     .products = MaterialValues{0, 0, 3},
                     .reactants = MaterialValues{1, 0, 0},
                     .begins = {}};
  return {{1, MoveEvent{.target = "plate", .position_mm = Vec3(30, -5, 1)}},
          {2, MoveEvent{.target = "rain", .position_mm = Vec3(0, 500, 0)}},
          {3, TurnEvent{.object = "plate", .rotate_deg = Vec3(10, 20, -30)}},
          {4, ScaleEvent{.object = "plate", .scale = 1.5}},
          {5, EmitterEvent{.emitter = rain}},
          {6, SwitchEvent{.emitter = "rain", .is_on = false}},
          {7, SwitchEvent{.emitter = "brush", .is_on = true}},
          {8, RatioEvent{.ratio = 0.25}},
          {9, RateEvent{.material = "rust", .rate = 0.0625}},
          {10, BehaviorEvent{.behavior = {.bounce = 0.25,
                                          .floating = 0.5,
                                          .absorb = 0.25,
                                          .deceleration_bounce = 0.75,
                                          .deceleration_float = 0.125}}},
          {11, RuleEvent{.rule = "rust", .change = changed}},
          {12, RuleEvent{.rule = "a new one", .change = begun}},
          {13, PaintEvent{.emitter = "brush",
                          .stops = {{.position_mm = Vec3(1, 2, 3), .steps = 1},
                                    {.position_mm = Vec3(-4, 5, 6), .steps = 12}}}}};
}

TEST(SceneEvents, OfEveryKindSurviveTheirJson) {
  const Scene scene = scene_with_brush();
  Json list = Json::array();
  std::set<std::size_t> kinds;
  for (const SceneEvent& event : one_of_each()) {
    kinds.insert(event.what.index());
    list.push_back(event_json(event, scene));
  }
  ASSERT_EQ(kinds.size(), std::variant_size_v<SceneAction>) << "a kind of event is not tried";
  const std::vector<SceneEvent> events = read(list, scene);
  ASSERT_EQ(events.size(), list.size());
  for (std::size_t i = 0; i < events.size(); ++i) {
    EXPECT_EQ(events[i].what.index(), one_of_each()[i].what.index()) << i;
    EXPECT_EQ(event_json(events[i], scene).dump(), list[i].dump());
  }
}

TEST(SceneEvents, ARuleThatTheSceneLacksBeginsWithWhatIsGiven) {
  const Scene scene = scene_with_brush();
  const std::vector<SceneEvent> events = read(
      Json::parse(R"([{"iteration": 5, "op": "rule", "target": "new", "driver": "slope", "products": {"rust": 2}}])"),
      scene);
  ASSERT_EQ(events.size(), 1u);
  const RuleChange& change = std::get<RuleEvent>(events[0].what).change;
  ASSERT_TRUE(change.begins);
  EXPECT_EQ(change.begins->name, "new");
  EXPECT_EQ(change.begins->driver, "slope");
  EXPECT_EQ(change.begins->products, (MaterialValues{0, 0, 2}));
  EXPECT_FALSE(change.reactants);
}

TEST(SceneEvents, AStrokeIsSwitchedOnMovesEvenlyAndIsSwitchedOff) {
  const std::vector<SceneEvent> events =
      read(Json::parse(R"([{"iteration": 10, "op": "stroke", "target": "brush", "every": 2,
                            "points": [[0, 0, 0], [2, 0, -4], [2, 1, -4]]}])"),
           scene_with_brush());
  ASSERT_EQ(events.size(), 7u);
  EXPECT_EQ(events.front().iteration, 10);
  EXPECT_TRUE(std::get<SwitchEvent>(events.front().what).is_on);
  const std::vector<Vec3> way{{0, 0, 0}, {1, 0, -2}, {2, 0, -4}, {2, 0.5, -4}, {2, 1, -4}};
  for (std::size_t i = 0; i < way.size(); ++i) {
    const auto& move = std::get<MoveEvent>(events[i + 1].what);
    EXPECT_EQ(events[i + 1].iteration, 10 + static_cast<std::int64_t>(i));
    EXPECT_EQ(move.target, "brush");
    EXPECT_EQ(move.position_mm, Vec3(kUnit * way[i])) << i;
  }
  EXPECT_EQ(events.back().iteration, 16);
  EXPECT_FALSE(std::get<SwitchEvent>(events.back().what).is_on);
}

/// With a scene whose iterations take 0.1 d.
Scene read_timed(const char* list, double per_iteration = 0.1) {
  Scene scene = scene_with_brush();
  SceneContext context;
  context.materials = scene.materials;
  context.time_per_iteration = per_iteration;
  const Json json = Json::parse(list);
  read_events(JsonReader("scene.json", json, "/events"), context, scene);
  return scene;
}

TEST(SceneEvents, MayComeAtATime) {
  const Scene scene =
      read_timed(R"([{"at": "3.5 a", "op": "ratio", "ratio": 0.25}, {"at": 2, "op": "ratio", "ratio": 0.5},
                                     {"at": "36 h", "for": "12 h", "op": "switch", "target": "rain", "on": false}])");
  ASSERT_EQ(scene.events.size(), 4u);
  EXPECT_EQ(scene.events[0].iteration, 15);
  EXPECT_FALSE(std::get<SwitchEvent>(scene.events[0].what).is_on);
  EXPECT_EQ(scene.events[1].iteration, 20);
  EXPECT_EQ(std::get<RatioEvent>(scene.events[1].what).ratio, 0.5);
  EXPECT_EQ(scene.events[2].iteration, 20);
  EXPECT_TRUE(std::get<SwitchEvent>(scene.events[2].what).is_on);
  EXPECT_EQ(scene.events[3].iteration, 12784);  // 3.5 * 365.25 / 0.1 = 12783.75
}

TEST(SceneEvents, ComeAgainEveryTimeForAWhileUntilAnEnd) {
  const Scene scene = read_timed(R"([{"every": "2 d", "for": "6 h", "op": "switch", "target": "rain", "on": true},
                                     {"at": 1, "every": 3, "until": 10, "op": "ratio", "ratio": 0.5}])");
  EXPECT_TRUE(scene.events.empty());
  ASSERT_EQ(scene.series.size(), 3u);
  EXPECT_NEAR(scene.series[0].first, 2.5, 1e-12);
  EXPECT_FALSE(std::get<SwitchEvent>(scene.series[0].what).is_on);
  EXPECT_EQ(scene.series[1].first, 0.0);
  EXPECT_NEAR(scene.series[1].every, 20.0, 1e-12);
  EXPECT_TRUE(std::get<SwitchEvent>(scene.series[1].what).is_on);
  EXPECT_NEAR(scene.series[2].first, 10.0, 1e-12);
  EXPECT_EQ(scene.series[2].count, 3);  // at 1, 4 and 7
}

TEST(SceneEvents, TimesThatCannotBeAreNamed) {
  const auto refused = [](const std::string& times, double per_iteration = 0.1) {
    const std::string list = R"([{"op": "switch", "target": "rain", "on": true, )" + times + "}]";
    return error_of([&] { (void)read_timed(list.c_str(), per_iteration); });
  };
  EXPECT_TRUE(
      has(refused(R"("every": "6 h", "for": "2 d")"), "/events/0/for: found \"2 d\"; expected less than \"every\""));
  EXPECT_TRUE(has(refused(R"("every": "6 h", "for": "6 h")"), "less than \"every\""));
  EXPECT_TRUE(
      has(refused(R"("every": "1 h")"), "/events/0/every: found \"1 h\"; expected at least the time of one iteration"));
  EXPECT_TRUE(has(refused(R"("every": "6 h", "for": "1 min")"), "/events/0/for: found \"1 min\""));
  EXPECT_TRUE(has(refused(R"("iteration": 3, "at": "1 d")"), "\"iteration\" or \"at\", not both"));
  EXPECT_TRUE(has(refused(R"("at": "1 d", "until": "2 d")"),
                  "/events/0/until: found \"2 d\"; expected an event with \"every\""));
  EXPECT_TRUE(has(refused(R"("at": "3 d", "every": 1, "until": "2 d")"), "a time after the first"));
  EXPECT_TRUE(has(refused(R"("at": "soon")"), "/events/0/at: found \"soon\"; expected a time"));
  EXPECT_TRUE(has(refused(R"("at": -1)"), "/events/0/at: found -1"));
  EXPECT_TRUE(has(refused(R"("at": "1 d")", 0.0), "the scene's iterations take none"));
  EXPECT_TRUE(has(refused(R"("on": true)"), "`iteration` is missing"));
  const char* const ratio = R"([{"op": "ratio", "ratio": 0.5, "at": 1, "for": 2}])";
  EXPECT_TRUE(has(error_of([&] { (void)read_timed(ratio); }), "only a switch ends by itself"));
}

TEST(SceneEvents, NameWhatTheSceneDoesNotHave) {
  const Scene scene = scene_with_brush();
  const auto refused = [&](const char* event) {
    return error_of([&] { (void)read(Json::array({Json::parse(event)}), scene); });
  };
  EXPECT_TRUE(has(refused(R"({"iteration": 1, "op": "move", "target": "plat", "position": [0, 0, 0]})"),
                  "the name of an object or emitter; did you mean `plate`"));
  EXPECT_TRUE(has(refused(R"({"iteration": 1, "op": "turn", "target": "rain", "rotate": [0, 0, 0]})"),
                  "/events/0/target: found \"rain\"; expected the name of an object"));
  EXPECT_TRUE(has(refused(R"({"iteration": 1, "op": "switch", "target": "plate", "on": true})"),
                  "/events/0/target: found \"plate\"; expected the name of an emitter"));
  EXPECT_TRUE(has(refused(R"({"iteration": 1, "op": "ratio", "ratio": 0.5, "target": "rain"})"),
                  "/events/0/target: unknown key"));
  EXPECT_TRUE(has(refused(R"({"iteration": 1, "op": "emitter", "emitter":
                              {"name": "rain", "shape": "sky", "gammatons": 201}})"),
                  "the same number of gammatons as before (200)"));
}

}  // namespace
}  // namespace patinate::simulation
