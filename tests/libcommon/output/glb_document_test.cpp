#include "libcommon/output/glb_document.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "patinate/core/error.h"
#include "tests/support/errors.h"

namespace patinate {
namespace {

using testing_support::error_of;
using testing_support::has;

std::uint32_t u32_at(const std::string& bytes, std::size_t offset) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + offset, sizeof value);  // Both are little-endian.
  return value;
}

// The layout of the file is that of glTF 2.0, section 4.4.
TEST(GlbDocument, HeadAndPiecesMakeAGlb) {
  GlbBytes bytes;
  Json gltf = Json::object();
  const std::vector<float> positions{0, 0, 0, 2, 0, -1, 0, 3, 0};
  const std::vector<std::uint32_t> indices{0, 1, 2};
  EXPECT_EQ(add_gltf_positions(gltf, bytes.add(positions, kGltfVertices), positions), 0);
  EXPECT_EQ(bytes.add("x", 1, 0), 1);
  EXPECT_EQ(add_gltf_accessor(gltf, bytes.add(indices, kGltfIndices), kGltfUint32, indices.size(), "SCALAR"), 1);
  const std::string glb = glb_head(gltf, bytes.views(), bytes.size(), "a.glb") + bytes.padded();

  EXPECT_EQ(glb.substr(0, 4), "glTF");
  EXPECT_EQ(u32_at(glb, 4), 2u);
  EXPECT_EQ(u32_at(glb, 8), glb.size());
  const std::size_t json_size = u32_at(glb, 12);
  EXPECT_EQ(json_size % 4, 0u);
  EXPECT_EQ(glb.substr(16, 4), "JSON");
  EXPECT_EQ(u32_at(glb, 20 + json_size), 52u);
  EXPECT_EQ(glb.substr(24 + json_size, 4), std::string("BIN\0", 4));
  EXPECT_EQ(glb.size(), 28 + json_size + 52);

  const Json json = Json::parse(glb.substr(20, json_size));
  EXPECT_EQ(json["asset"]["version"], "2.0");
  EXPECT_EQ(json["accessors"][0]["min"], Json({0, 0, -1}));
  EXPECT_EQ(json["accessors"][0]["max"], Json({2, 3, 0}));
  EXPECT_EQ(json["bufferViews"][1], Json({{"buffer", 0}, {"byteOffset", 36}, {"byteLength", 1}}));
  EXPECT_EQ(json["bufferViews"][2]["byteOffset"], 40);  // At a multiple of 4.
  EXPECT_EQ(json["bufferViews"][2]["target"], kGltfIndices);
  EXPECT_EQ(json["buffers"][0]["byteLength"], 52);
  EXPECT_EQ(u32_at(glb, 28 + json_size + 40 + 8), 2u);
}

TEST(GlbDocument, RefusesWhatNoGlbHolds) {
  Json gltf = Json::object();
  EXPECT_TRUE(has(error_of<InvalidInput>([&] { (void)glb_head(gltf, {}, std::uint64_t{1} << 32, "a.glb"); }),
                  "a.glb: would be more than 4 GB"));
  gltf["nodes"] = Json::array({{{"name", "\xff"}}});
  EXPECT_TRUE(has(error_of<InvalidInput>([&] { (void)glb_head(gltf, {}, 0, "a.glb"); }), "UTF-8"));
}

}  // namespace
}  // namespace patinate
