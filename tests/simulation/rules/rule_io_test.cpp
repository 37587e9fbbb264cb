#include "simulation/rules/rule_io.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "libcommon/core/files.h"
#include "tests/support/errors.h"
#include "tests/support/temp_folder.h"

namespace patinate::simulation {
namespace {

using testing_support::error_of;
using testing_support::has;

const std::vector<std::string> kSceneMaterials{"water", "metal", "rust", "dirt"};

Rule read(const std::string& text, const std::filesystem::path& file = "scene.json") {
  const Json json = Json::parse(text);
  return read_scene_rule(JsonReader(file.string(), json, "/rules/0"), kSceneMaterials);
}
std::string says(const std::string& text) {
  return error_of([&] { (void)read(text); });
}

TEST(RuleIo, EveryBuiltInRuleCanBeReadAndSaysWhatItIs) {
  const std::vector<std::string> names = built_in_rule_names();
  EXPECT_EQ(names.size(), 12u);
  const std::vector<std::string> materials{"water", "metal", "wood", "dirt", "rust", "organic", "patina", "moss"};
  for (const std::string& name : names) {
    const RuleAsset asset = built_in_rule(name);
    EXPECT_EQ(asset.name, name);
    EXPECT_FALSE(asset.about.empty());
    std::vector<std::string> scene = materials;
    if (name == "dust") scene.back() = "dust";
    if (name == "fading") scene = {"pigment", "bleached"};
    EXPECT_EQ(resolve_rule(asset, scene).driver, asset.driver);
  }
}

TEST(RuleIo, BuiltInRulesHaveTheReactantsAndProductsOfTheirPage) {
  EXPECT_EQ(built_in_rule("rust").driver, "min(water, metal)");
  EXPECT_TRUE(built_in_rule("rust").reactants.empty());
  EXPECT_EQ(built_in_rule("rust_consuming").reactants, (std::vector<std::pair<std::string, double>>{{"metal", 1.0}}));
  EXPECT_EQ(built_in_rule("decay").products,
            (std::vector<std::pair<std::string, double>>{{"organic", 1.0}, {"dirt", 1.0}}));
  EXPECT_EQ(built_in_rule("evaporation").reactants, (std::vector<std::pair<std::string, double>>{{"water", 1.0}}));
}

TEST(RuleIo, PublishedFormsAreThereByName) {
  EXPECT_EQ(built_in_rule("evaporation_constant").driver, "1");
  EXPECT_EQ(built_in_rule("evaporation_constant").reactants,
            (std::vector<std::pair<std::string, double>>{{"water", 1.0}}));
  const RuleAsset decay = built_in_rule("decay_two_rates");
  EXPECT_EQ(decay.driver, built_in_rule("decay").driver);
  ASSERT_EQ(decay.products.size(), 2u);
  EXPECT_NE(decay.products[0].second, decay.products[1].second);
}

TEST(RuleIo, ASceneNamesABuiltInRuleOneWithChangesAFileOrANewOne) {
  EXPECT_EQ(read(R"("rust")").products[2], 1.0);
  const Rule slow = read(R"({"name": "evaporation", "rate": 0.02})");
  EXPECT_EQ(slow.rate, 0.02);
  EXPECT_EQ(slow.driver, "water");
  EXPECT_EQ(slow.reactants[0], 1.0);
  const Rule own = read(
      R"({"name": "mud", "driver": "water*dirt", "rate": 2, "products": {"dirt": 0.5}, "reactants": {"water": 0.25}})");
  EXPECT_EQ(own.name, "mud");
  EXPECT_EQ(own.products[3], 0.5);
  EXPECT_EQ(own.reactants[0], 0.25);

  const testing_support::TempFolder folder;
  std::filesystem::create_directory(folder / "rules");
  write_atomically(folder / "rules/mine.json",
                   "// mine\n{\"format\": \"patinate.rule\", \"version\": 2, \"name\": \"mine\", \"driver\": "
                   "\"!water\", \"products\": {\"dirt\": 2}}");
  EXPECT_EQ(read(R"("rules/mine.json")", folder / "scene.json").products[3], 2.0);
  EXPECT_EQ(read(R"({"file": "rules/mine.json", "rate": 4})", folder / "scene.json").rate, 4.0);
}

TEST(RuleIo, SaysWhereAndWhatIsWrong) {
  EXPECT_TRUE(has(says(R"("rusty")"),
                  "scene.json: /rules/0: found \"rusty\"; expected a built-in rule (rust, rust_consuming, "));
  EXPECT_TRUE(has(says(R"("rusty")"), "did you mean `rust`?"));
  EXPECT_EQ(says(R"("decay")"),
            "scene.json: /rules/0: products of rule 'decay': `organic` is none of the scene's materials");
  EXPECT_TRUE(has(says(R"({"name": "evaporation", "rate": -1})"), "scene.json: /rules/0/rate: found -1"));
  EXPECT_TRUE(has(says(R"({"name": "evaporation", "rade": 1})"), "/rules/0/rade: unknown key; did you mean `rate`?"));
  EXPECT_TRUE(has(says(R"_({"name": "rust", "driver": "min(watr, metal)"})_"),
                  "position 5: unknown material or parameter `watr`; there are `water`"));
  EXPECT_TRUE(has(says(R"({"name": "rust", "products": {"rusd": 1}})"),
                  "`rusd` is none of the scene's materials; did you mean `rust`?"));
  EXPECT_TRUE(has(says(R"({"name": "rust", "products": {"rust": "much"}})"), "/rules/0/products/rust: found \"much\""));
  EXPECT_TRUE(has(says("5"), "expected the name of a rule, a path, or an object"));
  EXPECT_TRUE(has(says(R"("nowhere/rule.json")"), "nowhere/rule.json"));
}

TEST(RuleIo, AFileNeedsItsFormatADriverAndAnEffect) {
  const testing_support::TempFolder folder;
  const auto load = [&](const std::string& text) {
    write_atomically(folder / "rule.json", text);
    return error_of([&] { (void)load_rule(folder / "rule.json"); });
  };
  EXPECT_EQ(load(R"({"format": "patinate.rule", "version": 2, "name": "x", "driver": "1", "reactants": {"water": 1}})"),
            "");
  EXPECT_TRUE(has(load(R"({"format": "patinate.scene", "version": 1})"), "/format"));
  EXPECT_TRUE(has(load(R"({"format": "patinate.rule", "version": 2, "name": "x", "products": {"water": 1}})"),
                  "`driver` is missing"));
  EXPECT_TRUE(has(load(R"({"format": "patinate.rule", "version": 2, "name": "x", "driver": "1"})"),
                  "has products or reactants"));
}

TEST(RuleIo, AFileOfVersion1SaysTheSameInItsWords) {
  const testing_support::TempFolder folder;
  write_atomically(folder / "rule.json",
                   R"({"format": "patinate.rule", "version": 1, "name": "mud", "driver": "water*dirt", "alpha": 2,
                       "makes": {"dirt": 0.5}, "uses": {"water": 0.25}})");
  const RuleAsset rule = load_rule(folder / "rule.json");
  EXPECT_EQ(rule.rate, 2.0);
  EXPECT_EQ(rule.products, (std::vector<std::pair<std::string, double>>{{"dirt", 0.5}}));
  EXPECT_EQ(rule.reactants, (std::vector<std::pair<std::string, double>>{{"water", 0.25}}));
}

}  // namespace
}  // namespace patinate::simulation
