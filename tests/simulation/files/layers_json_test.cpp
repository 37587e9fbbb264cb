// "layers" of a scene file, and rules that act on them.
#include "simulation/files/layers_json.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "patinate/simulation/engine.h"
#include "patinate/simulation/scene_io.h"
#include "tests/simulation/engine/run_iterations.h"
#include "tests/support/errors.h"
#include "tests/support/meshes.h"

namespace patinate::simulation {
namespace {

using testing_support::error_of;
using testing_support::has;

/// A painted plate. Every test changes what it is about.
Json painted_scene() {
  return Json::parse(R"json({
    "format": "patinate.scene", "version": 2, "unit": "mm", "atlas": {"resolution": 64},
    "materials": ["water", "metal", "rust"],
    "presets": {"painted_steel": {"layers": [
      {"name": "steel", "preset": "iron"},
      {"name": "primer", "thickness_um": 40, "color": [0.4, 0.3, 0.2]},
      {"name": "paint", "thickness_um": "80*(1 - accessibility)", "adhesion": {"kind": "noise", "wavelength_mm": 20},
       "color": [0.1, 0.2, 0.1], "specular": 0.5}]
}
}
,
    "objects": [{"name": "plate", "mesh": "plate.obj", "preset": "painted_steel"}],
    "emitters": [{"name": "rain", "shape": "sky", "speed": 3000, "gammatons": 50, "carries": {"water": 1}}],
    "exchange": {"rates": {"water": 0.3}},
    "rules": [
      {"name": "wear", "driver": "top.metal + thickness", "rate": 1, "reactants": {"thickness": 2}},
      {"name": "creep", "driver": "interface.rust * below.metal * edge * adhesion * depth", "layer": "primer", "rate": 1,
       "products": {"interface.rust": 1}, "reactants": {"adhesion": 0.5, "interface.water": 1}}],
    "run": {"iterations": 10}
  })json");
}

Scene read_painted(const Json& json) {
  SceneAssets assets;
  assets.given_meshes["/scenes/plate.obj"] = std::make_shared<Mesh>(testing_support::unit_plane(100.0));
  return read_scene("/scenes/painted.json", json, assets).scene;
}

std::string says(const Json& json) {
  return error_of([&] { (void)read_painted(json); });
}

TEST(LayersJson, AreReadFromAPresetOrAnObject) {
  Json json = painted_scene();
  const Scene of_preset = read_painted(json);
  json["objects"][0]["layers"] = json["presets"]["painted_steel"]["layers"];
  json["objects"][0].erase("preset");
  json.erase("presets");
  const Scene of_object = read_painted(json);
  for (const Scene& scene : {of_preset, of_object}) {
    const std::vector<Layer>& layers = scene.objects[0].layers;
    ASSERT_EQ(layers.size(), 3U);
    EXPECT_EQ(layers[0].look.amounts[1], 1.0);
    EXPECT_EQ(scene.objects[0].preset.amounts, MaterialValues{});
    EXPECT_EQ(layers[1].thickness_um, "40");
    EXPECT_EQ(layers[1].adhesion, "1");
    EXPECT_EQ(layers[2].thickness_um, "80*(1 - accessibility)");
    EXPECT_EQ(layers[2].adhesion, "1 * paint_adhesion_1");
    EXPECT_EQ(layers[2].look.specular, 0.5);
    EXPECT_EQ(scene.rules[0].layer_reactants.thickness_um, 2.0);
    EXPECT_EQ(scene.rules[1].layer, "primer");
    EXPECT_EQ(scene.rules[1].layer_products.at_interface[2], 1.0);
    EXPECT_EQ(scene.rules[1].layer_reactants.at_interface[0], 1.0);
    EXPECT_EQ(scene.rules[1].layer_reactants.adhesion, 0.5);
  }
}

TEST(LayersJson, ASubstrateAloneIsItsPreset) {
  Json json = painted_scene();
  json["presets"]["painted_steel"]["layers"].erase(1);
  json["presets"]["painted_steel"]["layers"].erase(1);
  json["rules"] = {"rust", "evaporation"};
  Json plain = json;
  plain["objects"][0]["preset"] = "iron";
  Simulation one(read_painted(json)), other(read_painted(plain));
  testing_support::run_iterations(one, 20);
  testing_support::run_iterations(other, 20);
  EXPECT_EQ(one.layers(), nullptr);
  EXPECT_TRUE(one.snapshot() == other.snapshot());
}

TEST(LayersJson, SaysWhereAndWhatIsWrong) {
  const auto with = [](const std::string& pointer, const Json& value) {
    Json json = painted_scene();
    json[Json::json_pointer(pointer)] = value;
    return says(json);
  };
  const std::string layers = "/presets/painted_steel/layers";
  const auto expect = [](const std::string& found, const std::string& pointer, const std::string& what) {
    EXPECT_TRUE(has(found, pointer) && has(found, what)) << found;
    EXPECT_FALSE(has(found, "\n")) << found;
  };
  expect(with(layers + "/1/thickness_um", -5), layers + "/1/thickness_um", "-5");
  expect(with(layers + "/1/thickness_um", 5000), layers + "/1/thickness_um", "4000");
  expect(with(layers + "/2/thickness_um", "80*wornn"), layers + "/2", "unknown map `wornn`");
  expect(with(layers + "/1/adhesion", 1.5), layers + "/1/adhesion", "1.5");
  expect(with(layers + "/0/thickness_um", 3), layers + "/0/thickness_um", "the first layer is the substrate");
  expect(with(layers + "/0/cracks", Json::object()), layers + "/0/cracks", "the first layer is the substrate");
  expect(with(layers + "/1/cracks", {{"relief", 0}}), layers + "/1/cracks/relief", "0");
  const std::string tension = layers + "/1/cracks/tension";
  expect(with(layers + "/1/cracks", {{"tension", {{"ratio", 20}}}}), tension + "/ratio", "20");
  expect(with(layers + "/1/cracks", {{"tension", Json::object()}}), tension, "ratio");
  expect(with(layers + "/1/cracks", {{"tension", {{"ratio", 2}, {"along", {0, 0, 0}}}}}), tension + "/along",
         "a direction, not [0, 0, 0]");
  expect(with(layers + "/1/cracks", {{"strenght", 1}}), layers + "/1/cracks", "strenght");
  expect(with(layers + "/1/cracks", {{"strength", "1 + wornn"}}), layers + "/1", "unknown map `wornn`");
  expect(with(layers + "/1/cracks", {{"initial", "2*wornn"}}), layers + "/1", "unknown map `wornn`");
  expect(with(layers + "/1/cracks", {{"initial", -1}}), layers + "/1/cracks/initial", "-1");
  expect(with("/rules/0/products", {{"stress", 1}}), "painted.json", "no layer has \"cracks\"");
  expect(with(layers + "/2/name", "primer"), layers + "/2/name", "names of layers that differ");
  expect(with(layers + "/0/preset", "irn"), layers + "/0/preset", "did you mean `iron`");
  expect(with("/objects/0/layers", Json::parse(R"([{"name": "steel"}])")), "/objects/0/preset", "no preset beside");
  expect(with("/rules/1/layer", "pimer"), "/rules/1", "did you mean `primer`");
  expect(with("/rules/1/layer", "steel"), "/rules/1", "none of the layers above substrates (primer, paint)");
  expect(with("/rules/0/driver", "top.metl"), "/rules/0", "did you mean `top.metal`");
  expect(with("/rules/0/products", {{"thickness", 1}}), "/rules/0", "a layer's thickness only falls");
  expect(with("/rules/0/reactants", {{"interface.rost", 1}}), "/rules/0", "`interface.rost` is none");
  Json many = painted_scene();
  while (many["presets"]["painted_steel"]["layers"].size() < 9)
    many["presets"]["painted_steel"]["layers"].push_back(
        {{"name", "coat" + std::to_string(many["presets"]["painted_steel"]["layers"].size())}, {"thickness_um", 1}});
  expect(says(many), layers, "1 to 8 layers, the substrate included");
  Json none = painted_scene();
  none["objects"][0]["preset"] = "iron";
  expect(says(none), "/rules/0", "`thickness` is of layers, and no object of the scene has any");
}

TEST(LayersJson, HaveCracksWithDefaults) {
  Json json = painted_scene();
  Json& layers = json["presets"]["painted_steel"]["layers"];
  layers[1]["cracks"] = Json::object();
  layers[2]["cracks"] = {{"strength", "0.5 + accessibility"},
                         {"relief", 20},
                         {"shrinkage", 0.1},
                         {"tension", {{"along", {0, 2, 0}}, {"ratio", 0.4}}},
                         {"initial", "accessibility"}};
  json["rules"][0]["products"] = {{"stress", 0.5}};
  const Scene scene = read_painted(json);
  EXPECT_FALSE(scene.objects[0].layers[0].cracks);
  EXPECT_EQ(scene.objects[0].layers[1].cracks->strength, "1");
  EXPECT_EQ(scene.objects[0].layers[1].cracks->initial, "");
  EXPECT_EQ(scene.objects[0].layers[2].cracks->initial, "accessibility");
  EXPECT_EQ(scene.objects[0].layers[1].cracks->relief, LayerCracks{}.relief);
  EXPECT_FALSE(scene.objects[0].layers[1].cracks->tension);
  EXPECT_EQ(scene.objects[0].layers[2].cracks->tension->along, Vec3::UnitY());
  EXPECT_EQ(scene.objects[0].layers[2].cracks->tension->ratio, 0.4);
  EXPECT_EQ(scene.objects[0].layers[2].cracks->strength, "0.5 + accessibility");
  EXPECT_EQ(scene.objects[0].layers[2].cracks->relief, 20.0);
  EXPECT_EQ(scene.objects[0].layers[2].cracks->shrinkage, 0.1);
  EXPECT_EQ(scene.rules[0].layer_products.stress, 0.5);
}

TEST(LayersJson, AnEventChangesWhatARuleDoesToThem) {
  Json json = painted_scene();
  json["events"] = Json::parse(R"([{"iteration": 3, "op": "rule", "target": "wear", "reactants": {"thickness": 7}}])");
  Simulation simulation(read_painted(json));
  testing_support::run_iterations(simulation, 5);
  EXPECT_EQ(simulation.scene().rules[0].layer_reactants.thickness_um, 7.0);
}

}  // namespace
}  // namespace patinate::simulation
