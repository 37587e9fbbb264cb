// "maps" of a scene file, masks of rules and initial amounts.
#include "simulation/files/scene_maps_json.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/support/errors.h"
#include "tests/support/plate_scene.h"

namespace patinate::simulation {
namespace {

using testing_support::error_of;
using testing_support::has;

class SceneMapJson : public ::testing::Test {
 protected:
  SceneMapJson() : scene_(testing_support::plate_scene(64)) {
    SceneObject other = scene_.objects[0];
    other.name = "rail";
    scene_.objects.push_back(other);
    context_.materials = scene_.materials;
    context_.read_picture = [this](const JsonReader& path, int) {
      pictures_.push_back(path.string());
      return ImageF(4, 4, 1, brightness_);
    };
    context_.add_input = [this](const std::string&, const std::filesystem::path& path) {
      inputs_.push_back(path.filename().string());
    };
  }

  Scene maps(const std::string& text) {
    const Json json = Json::parse(text);
    Scene scene = scene_;
    read_maps(JsonReader("scene.json", json, "/maps"), context_, scene);
    return scene;
  }
  std::string says(const std::string& text) {
    return error_of([&] { (void)maps(text); });
  }

  Scene scene_;
  SceneContext context_;
  float brightness_ = 1.0F;
  std::vector<std::string> pictures_, inputs_;
};

TEST_F(SceneMapJson, APatternIsTheNameOfAMap) {
  scene_.objects[0].preset.second_color = Vec3(0.1, 0.1, 0.1);
  const Json json = Json::parse(R"({"preset": "oak"})");
  const auto check = [&](const std::string& pattern) {
    scene_.objects[0].preset.pattern = pattern;
    return error_of([&] {
      JsonReader object("scene.json", json, "/objects/0");
      check_pattern(object.member("preset"), scene_.objects[0].preset, scene_);
    });
  };
  EXPECT_EQ(check("wood_grain"), "");
  EXPECT_TRUE(has(check("wood_grian"), "/objects/0/preset")) << check("wood_grian");
  EXPECT_TRUE(has(check("wood_grian"), "did you mean `wood_grain`")) << check("wood_grian");
  SceneMap rings;
  rings.name = "rings";
  scene_.maps.push_back(rings);
  EXPECT_EQ(check("rings"), "");
}

TEST_F(SceneMapJson, OptionsAreThoseOfTheControlWithoutItsName) {
  const Scene scene = maps(R"({
    "damp": {"kind": "distance", "from": "creases", "range_mm": 30, "metric": "euclidean"},
    "path": {"kind": "distance", "from": "way.csv"},
    "grain": {"kind": "noise", "wavelength_mm": 5, "octaves": 3, "seed": 7},
    "crevices": {"kind": "accessibility", "scale_mm": 2.5, "high_percent": 95},
    "noon": {"kind": "sun", "direction": [0, 1, 0.5], "arc": 120},
    "sky": {"kind": "exposure", "sun_share": 0.5, "sky_rays": 64},
    "front": {"kind": "facing", "direction": [0, 0, 1]},
    "rings": {"kind": "wood_grain", "ring_mm": 4, "stretch": 30, "waviness": 1, "knots_per_meter": 2, "seed": 3}})");
  ASSERT_EQ(scene.maps.size(), 8u);
  EXPECT_EQ(scene.maps[7].wood_grain.ring_mm, 4.0);
  EXPECT_EQ(scene.maps[7].wood_grain.stretch, 30.0);
  EXPECT_EQ(scene.maps[7].wood_grain.waviness, 1.0);
  EXPECT_EQ(scene.maps[7].wood_grain.knots_per_meter, 2.0);
  EXPECT_EQ(scene.maps[7].wood_grain.seed, 3);
  EXPECT_EQ(scene.maps[0].options.distance_from, "creases");
  EXPECT_EQ(scene.maps[0].options.distance.range_mm, 30.0);
  EXPECT_EQ(scene.maps[1].options.distance_from, "way.csv");
  EXPECT_EQ(inputs_, std::vector<std::string>{"way.csv"});
  EXPECT_EQ(scene.maps[2].noise.wavelength_mm, 5.0);
  EXPECT_EQ(scene.maps[2].noise.seed, 7);
  EXPECT_EQ(scene.maps[3].options.accessibility.scale_mm, 2.5);
  EXPECT_EQ(scene.maps[4].options.sun.arc_deg, 120.0);
  EXPECT_EQ(scene.maps[5].options.exposure.num_rays, 64);
  EXPECT_EQ(scene.maps[6].options.facing.direction, (std::array<double, 3>{0, 0, 1}));
}

TEST_F(SceneMapJson, PicturesAreForAllObjectsOrByName) {
  const Scene scene = maps(R"({"wet": {"kind": "image", "image": "wet.png"},
                               "worn": {"kind": "image", "images": {"rail": "worn.png"}},
                               "metal_parts": {"kind": "objects", "objects": ["rail"]}})");
  EXPECT_EQ(pictures_, (std::vector<std::string>{"wet.png", "worn.png"}));
  EXPECT_FALSE(scene.maps[0].images[0].empty());
  EXPECT_TRUE(scene.maps[1].images[0].empty());
  EXPECT_FALSE(scene.maps[1].images[1].empty());
  EXPECT_EQ(scene.maps[2].is_inside, (std::vector<bool>{false, true}));
}

TEST_F(SceneMapJson, EachFaultIsOneLineThatNamesIt) {
  EXPECT_TRUE(has(says(R"({"a": {"kind": "noize"}})"),
                  "/maps/a/kind: found \"noize\"; expected a kind of map (accessibility, "));
  EXPECT_TRUE(has(says(R"({"a": {"kind": "noize"}})"), "did you mean `noise`?"));
  EXPECT_TRUE(has(says(R"({"a": {"kind": "noise", "wavelength": 5}})"),
                  "/maps/a/wavelength: unknown key; did you mean `wavelength_mm`?"));
  EXPECT_TRUE(has(says(R"({"a": {"kind": "noise", "wavelength_mm": 0}})"), "/maps/a/wavelength_mm: found 0"));
  EXPECT_TRUE(has(says(R"({"a": {"kind": "facing", "scale_mm": 3}})"), "/maps/a/scale_mm: unknown key"));
  EXPECT_TRUE(has(says(R"({"water": {"kind": "noise"}})"),
                  "/maps/water: found an object; expected a map of another name than 'water': the material of that "
                  "name would hide it"));
  EXPECT_TRUE(has(says(R"({"rain": {"kind": "noise"}})"), "another name than 'rain', which drivers have already"));
  EXPECT_TRUE(has(says(R"({"max": {"kind": "noise"}})"), "no function of expressions"));
  EXPECT_TRUE(has(says(R"({"a b": {"kind": "noise"}})"), "letters, digits and _"));
  EXPECT_TRUE(has(says(R"({"a": {"kind": "distance"}})"), "/maps/a: `from` is missing"));
  EXPECT_TRUE(has(says(R"({"a": {"kind": "distance", "from": "crease"}})"),
                  "/maps/a/from: found \"crease\"; expected boundary, creases"));
  EXPECT_TRUE(has(says(R"({"a": {"kind": "distance", "from": "a.png"}})"),
                  "a picture has no place in a scene with several objects"));
  EXPECT_TRUE(
      has(says(R"({"a": {"kind": "image"}})"), "\"image\", a picture over the UVs of each object, or \"images\""));
  EXPECT_TRUE(
      has(says(R"({"a": {"kind": "objects", "objects": ["rial"]}})"),
          "/maps/a/objects/0: found \"rial\"; expected the name of an object (plate, rail); did you mean `rail`?"));
  EXPECT_TRUE(has(says(R"({"a": 5})"), "/maps/a: found 5; expected a map"));
  brightness_ = 1.5F;
  EXPECT_TRUE(has(says(R"({"a": {"image": "bright.exr"}})"), "a picture of values in [0, 1]"));
}

TEST_F(SceneMapJson, AMaskIsAnExpressionAListOfObjectsOrAMap) {
  const auto mask = [&](const std::string& text) {
    const Json json = Json::parse(text);
    return read_mask(JsonReader("scene.json", json, "/rules/0/where"), context_, scene_);
  };
  EXPECT_EQ(mask(R"("1 - accessibility")"), "1 - accessibility");
  EXPECT_EQ(mask(R"(["rail"])"), "where_1");
  EXPECT_EQ(mask(R"({"images": {"plate": "mask.png"}})"), "where_2");
  ASSERT_EQ(scene_.maps.size(), 2u);
  EXPECT_EQ(scene_.maps[0].kind, "objects");
  EXPECT_EQ(scene_.maps[1].kind, "image");
  EXPECT_TRUE(has(error_of([&] { (void)mask("5"); }), "an expression, a list of objects, or a map"));
}

TEST_F(SceneMapJson, InitialAmountsAreNumbersExpressionsOrPictures) {
  const auto read = [&](const std::string& text) {
    const Json json = Json::parse(text);
    read_initial(JsonReader("scene.json", json, "/objects/1/initial"), context_, scene_, 1);
  };
  read(R"({"water": {"image": "wet.png", "amount": 2}, "rust": "0.3*accessibility", "metal": 0.5})");
  EXPECT_EQ(scene_.objects[1].initial[0], "2 * initial_1");
  EXPECT_EQ(scene_.objects[1].initial[1], "0.5");
  EXPECT_EQ(scene_.objects[1].initial[2], "0.3*accessibility");
  EXPECT_EQ(scene_.objects[0].initial[2], "");
  const auto refused = [&](const std::string& text) { return error_of([&] { read(text); }); };
  EXPECT_TRUE(has(refused(R"({"mud": 1})"), "one of the scene's materials (water, metal, rust)"));
  EXPECT_TRUE(has(refused(R"({"water": 5})"), "/objects/1/initial/water: found 5"));
  EXPECT_TRUE(has(refused(R"({"water": "rain"})"), "/objects/1/initial/water: initial water of object 'rail'"));
  EXPECT_TRUE(has(refused(R"({"water": "2*metal"})"), "unknown map `metal`"));
}

}  // namespace
}  // namespace patinate::simulation
