#include "libcommon/core/read_limit.h"

#include <gtest/gtest.h>

#include <fstream>

#include "libcommon/core/files.h"
#include "libcommon/core/hash.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/mesh_io.h"
#include "tests/support/temp_folder.h"

namespace patinate {
namespace {

namespace fs = std::filesystem;

/// shown/, other/, and links between them.
class ReadLimits : public ::testing::Test {
 protected:
  ReadLimits() {
    fs::create_directories(shown() / "inner");
    fs::create_directories(other());
    write_atomically(shown() / "inner/text.txt", "inside");
    write_atomically(other() / "text.txt", "outside");
    fs::create_symlink("inner/text.txt", shown() / "to_inside.txt");
    fs::create_symlink(other() / "text.txt", shown() / "to_outside.txt");
    fs::create_directory_symlink(other(), shown() / "outer");
  }
  [[nodiscard]] fs::path shown() const { return folder_.path() / "shown"; }
  [[nodiscard]] fs::path other() const { return folder_.path() / "other"; }

  testing_support::TempFolder folder_;
};

TEST_F(ReadLimits, WithoutOneEverythingIsRead) { EXPECT_EQ(read_file(shown() / "to_outside.txt"), "outside"); }

TEST_F(ReadLimits, LinksCountByWhereTheyLead) {
  const ReadLimit limit({shown()});
  EXPECT_EQ(read_file(shown() / "inner/text.txt"), "inside");
  EXPECT_EQ(read_file(shown() / "to_inside.txt"), "inside");
  EXPECT_EQ(read_file(shown() / "inner/../to_inside.txt"), "inside");
  for (const fs::path& path : {shown() / "to_outside.txt", shown() / "outer/text.txt", shown() / "../other/text.txt",
                               other() / "text.txt", shown() / "outer/missing.txt", fs::path("/etc/passwd")}) {
    EXPECT_FALSE(may_read(path)) << path;
    EXPECT_THROW((void)read_file(path), IoError) << path;
    EXPECT_THROW((void)hash_file(path), IoError) << path;
  }
}

TEST_F(ReadLimits, AFolderThatBeginsWithTheSameNameIsAnother) {
  fs::create_directories(folder_.path() / "shown_not");
  const ReadLimit limit({shown()});
  EXPECT_FALSE(may_read(folder_.path() / "shown_not/text.txt"));
}

TEST_F(ReadLimits, ItEndsWithTheObject) {
  { const ReadLimit limit({shown()}); }
  EXPECT_EQ(read_file(other() / "text.txt"), "outside");
}

TEST_F(ReadLimits, MoreFoldersMayBeAllowed) {
  const ReadLimit limit({shown(), other()});
  EXPECT_EQ(read_file(shown() / "to_outside.txt"), "outside");
  EXPECT_FALSE(may_read(folder_.path() / "text.txt"));
  EXPECT_THROW((void)ReadLimit({folder_.path() / "missing"}), IoError);
}

/// Every reader that opens files itself: pictures, and what a glTF names.
TEST_F(ReadLimits, HoldsForPicturesAndForBuffersOfMeshes) {
  write_color(other() / "picture.png", ImageF(4, 4, 3));
  fs::create_symlink(other() / "picture.png", shown() / "picture.png");
  write_atomically(other() / "triangle.bin", std::string(36, '\0'));
  const auto gltf = [](const std::string& uri) {
    return R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
      "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [0, 0, 0]}],
      "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36, "uri": ")" +
           uri + R"("}]})";
  };
  write_atomically(shown() / "mesh.gltf", gltf("../other/triangle.bin"));
  EXPECT_NO_THROW((void)probe_image(shown() / "picture.png"));
  const ReadLimit limit({shown()});
  EXPECT_THROW((void)probe_image(shown() / "picture.png"), IoError);
  EXPECT_THROW((void)read_color(shown() / "picture.png"), IoError);
  try {
    (void)read_mesh(shown() / "mesh.gltf");
    FAIL() << "read a buffer outside";
  } catch (const IoError& e) {
    EXPECT_NE(std::string(e.what()).find("triangle.bin: lies outside of"), std::string::npos) << e.what();
  }
}

TEST_F(ReadLimits, WritingHasALimitOfItsOwn) {
  const WriteLimit limit({shown()});
  write_atomically(shown() / "inner/new.txt", "x");
  EXPECT_EQ(read_file(other() / "text.txt"), "outside");
  write_atomically(shown() / "to_outside.txt", "x");  // A link that is replaced leads nowhere.
  EXPECT_EQ(read_file(other() / "text.txt"), "outside");
  for (const fs::path& path : {shown() / "outer/new.txt", shown() / "../other/new.txt", other() / "new.txt"}) {
    EXPECT_THROW(write_atomically(path, "x"), CannotComplete) << path;
    EXPECT_FALSE(fs::exists(path));
  }
}

}  // namespace
}  // namespace patinate
