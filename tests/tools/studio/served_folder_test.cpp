#include "tools/studio/served_folder.h"

#include <gtest/gtest.h>

#include <fstream>

#include "patinate/core/error.h"
#include "tests/support/temp_folder.h"

namespace patinate::studio {
namespace {

namespace fs = std::filesystem;

/// served/inside/file.txt, secret/file.txt, and links in served: out -> secret, in -> inside, file -> secret/file.txt
class ServedFolderTest : public ::testing::Test {
 protected:
  ServedFolderTest() {
    fs::create_directories(temp_ / "served/inside");
    fs::create_directories(temp_ / "secret");
    fs::create_directories(temp_ / "served2");
    for (const char* file : {"served/inside/file.txt", "secret/file.txt", "served2/file.txt"})
      std::ofstream(temp_ / file) << "x";
    fs::create_directory_symlink(temp_ / "secret", temp_ / "served/out");
    fs::create_directory_symlink(temp_ / "served/inside", temp_ / "served/in");
    fs::create_symlink(temp_ / "secret/file.txt", temp_ / "served/file");
  }
  testing_support::TempFolder temp_;
};

TEST_F(ServedFolderTest, FindsWhatLiesInsideAlsoThroughLinks) {
  const ServedFolder folder(temp_ / "served");
  EXPECT_EQ(folder.find("inside/file.txt"), folder.path() / "inside/file.txt");
  EXPECT_EQ(folder.find("./inside//file.txt"), folder.path() / "inside/file.txt");
  EXPECT_EQ(folder.find("in/file.txt"), folder.path() / "inside/file.txt");
  EXPECT_EQ(folder.find("."), folder.path());
  EXPECT_EQ(folder.find(""), folder.path());
  EXPECT_EQ(folder.name_of(folder.path() / "inside"), "inside");
  EXPECT_EQ(folder.name_of(folder.path()), ".");
}

TEST_F(ServedFolderTest, FindsNothingThatLeavesIt) {
  const ServedFolder folder(temp_ / "served");
  const std::string absolute = (temp_ / "secret/file.txt").string();
  for (const std::string& name :
       {std::string("../secret/file.txt"), std::string("inside/../../secret/file.txt"), std::string("inside/.."),
        absolute, "/" + absolute, std::string("out/file.txt"), std::string("out"), std::string("file"),
        std::string("../served2/file.txt"), std::string("..\\secret"), std::string("inside/file.txt\0.png", 20),
        std::string("/"), std::string("//etc/passwd"), std::string("missing")}) {
    EXPECT_FALSE(folder.find(name).has_value()) << name;
  }
}

TEST_F(ServedFolderTest, APlaceIsNotLeftEither) {
  const ServedFolder folder(temp_ / "served");
  const fs::path place = *folder.find("inside");
  EXPECT_TRUE(folder.find_below(place, "file.txt").has_value());
  EXPECT_FALSE(folder.find_below(place, "../file").has_value());
  EXPECT_FALSE(folder.find_below(temp_ / "secret", "file.txt").has_value());
  EXPECT_TRUE(folder.find_below(place / "file.txt", "file.txt").has_value());  // a file stands for its folder
}

TEST_F(ServedFolderTest, NewPathsAreNewAndInside) {
  const ServedFolder folder(temp_ / "served");
  EXPECT_EQ(folder.new_path("inside/scene.json"), folder.path() / "inside/scene.json");
  EXPECT_EQ(folder.new_path("scene.json"), folder.path() / "scene.json");
  for (const char* name :
       {"", ".", "..", "../x", "out/x", "missing/x", "inside/file.txt", "file", "/tmp/x", "inside/"}) {
    EXPECT_THROW((void)folder.new_path(name), InvalidInput) << name;
  }
}

TEST_F(ServedFolderTest, NothingNewGetsIntoAFinishedResult) {
  const ServedFolder folder(temp_ / "served");
  constexpr const char* kManifests[][2] = {{"history.json", R"({"format": "patinate.history"})"},
                                           {"transfer.json", R"({"format": "patinate.transfer"})"},
                                           {"simulation.json", R"({"format": "patinate.simulation"})"},
                                           {"registration.json", R"({"format": "patinate.registration"})"},
                                           {"unlight.json", R"({"format": "patinate.unlit"})"},
                                           {"recomposed.json", R"({"format": "patinate.recomposed"})"},
                                           {"sequence.json", R"({"time_unit": "d"})"},
                                           {"factorization.json", R"({"format": "patinate.factorization"})"},
                                           {"evaluation.json", R"({"format": "patinate.evaluation"})"},
                                           {"report.json", R"({"format": "patinate.fit"})"}};
  for (const auto& [manifest, text] : kManifests) {
    fs::create_directories(temp_ / "served/made/deeper");
    std::ofstream(temp_ / "served/made" / manifest) << text;
    for (const char* name : {"made/x.json", "made/deeper/x"})
      EXPECT_THROW((void)folder.new_path(name), InvalidInput) << manifest << " " << name;
    const ServedFolder inner(temp_ /
                             "served/made/deeper");  // also where the result itself is what is served, or a part of it
    EXPECT_THROW((void)inner.new_path("x"), InvalidInput) << manifest;
    fs::remove_all(temp_ / "served/made");
  }
  fs::create_directories(temp_ / "served/half.partial");
  EXPECT_THROW((void)folder.new_path("half.partial/x"), InvalidInput);
  // Captures and what a user writes for `unlight` are the user's.
  std::ofstream(temp_ / "served/inside/capture.json") << R"({"format": "patinate.capture"})";
  std::ofstream(temp_ / "served/inside/unlight.json") << R"({"format": "patinate.unlight"})";
  EXPECT_NO_THROW((void)folder.new_path("inside/x"));
}

TEST(ServedFolder, WantsAFolder) { EXPECT_THROW(ServedFolder("/nowhere/at/all"), IoError); }

TEST_F(ServedFolderTest, ANewFileNeverTakesTheNameOfAnother) {
  const ServedFolder folder(temp_ / "served");
  fs::create_symlink(temp_ / "secret/none.txt", temp_ / "served/inside/dangling.txt");
  EXPECT_EQ(folder.make_file("inside", "file", ".txt"), folder.path() / "inside/file-2.txt");
  EXPECT_EQ(folder.make_file("inside", "file", ".txt"), folder.path() / "inside/file-3.txt");
  EXPECT_EQ(folder.make_file("inside", "dangling", ".txt"), folder.path() / "inside/dangling-2.txt");
  EXPECT_FALSE(fs::exists(temp_ / "secret/none.txt"));
  for (const char* elsewhere : {"..", "out", "/", "nowhere"})
    EXPECT_THROW((void)folder.make_file(elsewhere, "x", ".txt"), InvalidInput) << elsewhere;
}

}  // namespace
}  // namespace patinate::studio
