#include "simulation/files/scene_files.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "libcommon/core/files.h"
#include "patinate/core/error.h"
#include "tests/support/temp_folder.h"

namespace patinate::simulation {
namespace {

namespace fs = std::filesystem;

/// scenes/wall.json names a/wall.obj (100 bytes), b/wall.obj (another 100 bytes), c/wall.obj (as a's) and big.png
/// (10,000 bytes).
class SceneFiles : public ::testing::Test {
 protected:
  SceneFiles() {
    for (const char* folder : {"scenes", "a", "b", "c"}) fs::create_directories(temp_ / folder);
    write_atomically(temp_ / "a/wall.obj", std::string(100, 'a'));
    write_atomically(temp_ / "b/wall.obj", std::string(100, 'b'));
    write_atomically(temp_ / "c/wall.obj", std::string(100, 'a'));
    write_atomically(temp_ / "big.png", std::string(10'000, 'p'));
    root_ = Json{{"objects",
                  {{{"mesh", "../a/wall.obj"}},
                   {{"mesh", (temp_ / "b/wall.obj").string()}},
                   {{"mesh", "../c/wall.obj"}, {"maps", {{"color", "../big.png"}}}}}},
                 {"appearance",
                  {{"dirt", {{"color", {0.1, 0.1, 0.1}}}},
                   {"moss", {{"color", {{"image", (temp_ / "big.png").string()}, {"width_mm", 40}}}}}}},
                 {"rules", Json::array({"rust"})}};
    save_json(scene(), root_);
  }
  [[nodiscard]] fs::path scene() const { return temp_ / "scenes/wall.json"; }

  testing_support::TempFolder temp_;
  Json root_;
};

TEST_F(SceneFiles, EqualFilesAreOneAndOthersOfTheSameNameGetANumber) {
  const SceneCopy copy = plan_scene_copy(scene(), root_, temp_ / "out/scene");
  write_scene_copy(copy, temp_ / "out/scene");
  const Json written = load_json(temp_ / "out/scene/wall.json");
  EXPECT_EQ(written["objects"][0]["mesh"], "wall.obj");
  EXPECT_EQ(written["objects"][1]["mesh"], "wall-2.obj");
  EXPECT_EQ(written["objects"][2]["mesh"], "wall.obj");
  EXPECT_EQ(written["objects"][2]["maps"]["color"], "big.png");
  EXPECT_EQ(written["rules"], root_["rules"]);
  EXPECT_EQ(written["appearance"]["dirt"], root_["appearance"]["dirt"]);
  EXPECT_EQ(written["appearance"]["moss"]["color"], Json({{"image", "big.png"}, {"width_mm", 40}}));
  EXPECT_EQ(read_file(temp_ / "out/scene/wall-2.obj"), std::string(100, 'b'));
  EXPECT_EQ(copy.files.size(), 3u);
  EXPECT_TRUE(copy.excluded.empty());
}

TEST_F(SceneFiles, WhatIsTooLargeStaysWhereItIs) {
  const SceneCopy copy = plan_scene_copy(scene(), root_, temp_ / "out/scene", 5'000);
  EXPECT_EQ(copy.excluded, std::vector<std::string>{"big.png"});
  write_scene_copy(copy, temp_ / "out/scene");
  const Json written = load_json(temp_ / "out/scene/wall.json");
  EXPECT_EQ(written["objects"][2]["maps"]["color"], "../../big.png");
  EXPECT_FALSE(fs::exists(temp_ / "out/scene/big.png"));
}

TEST_F(SceneFiles, AFileThatChangedSinceIsNoCopy) {
  const SceneCopy copy = plan_scene_copy(scene(), root_, temp_ / "out/scene");
  write_atomically(temp_ / "b/wall.obj", "other");
  EXPECT_THROW(write_scene_copy(copy, temp_ / "out/scene"), CannotComplete);
}

}  // namespace
}  // namespace patinate::simulation
