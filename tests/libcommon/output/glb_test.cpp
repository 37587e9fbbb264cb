#include "patinate/output/glb.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "libcommon/core/files.h"
#include "libcommon/output/glb_tangents.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/image/color.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/mesh_io.h"
#include "tests/libcommon/output/ball.h"
#include "tests/support/errors.h"
#include "tests/support/file_size_limit.h"
#include "tests/support/temp_folder.h"

namespace patinate {
namespace {

using testing_support::ball;
using testing_support::TempFolder;

std::vector<GlbVariant> two_ages() { return {{"0 d", {ImageF(8, 4, 3, 0.5f)}}, {"12.5 d", {ImageF(8, 4, 3, 0.1f)}}}; }

TEST(Glb, ReadsBackAsTheSameMeshInMetres) {
  const TempFolder folder;
  const Mesh mesh = ball(100.0, 8);
  write_glb(folder / "ball.glb", mesh, two_ages());
  const Mesh back = read_mesh(folder / "ball.glb");
  ASSERT_EQ(back.num_triangles(), mesh.num_triangles());
  ASSERT_TRUE(back.has_uvs());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 p = mesh.positions[mesh.triangles[t][k]];
      const Vec3 q = back.positions[back.triangles[t][k]];
      EXPECT_NEAR((0.001 * p - q).norm(), 0.0, 2e-8);  // float positions of 0.1
      const Vec2 u = mesh.uvs[mesh.uv_triangles[t][k]];
      const Vec2 w = back.uvs[back.uv_triangles[t][k]];
      EXPECT_NEAR((u - w).norm(), 0.0, 2e-7);
    }
  }
}

GlbTexture even(int channels, std::uint8_t code) {
  return {4, 4, channels, [channels, code](const auto& write) {
            write(std::vector<std::uint8_t>(static_cast<std::size_t>(16 * channels), code));
          }};
}

Json document_of(const std::filesystem::path& file) {
  const std::string bytes = read_file(file);
  std::uint32_t length = 0;
  std::memcpy(&length, bytes.data() + 12, 4);
  return Json::parse(bytes.substr(20, length));
}

TEST(Glb, MetalAndReflectanceAreWhereTheExtensionsHaveThem) {
  const TempFolder folder;
  GlbAppearance look{.name = "0 d", .base_colors = {even(3, 128)}};
  write_glb(folder / "plain.glb", ball(1.0, 8), {}, std::vector<GlbAppearance>{look});
  const Json plain = document_of(folder / "plain.glb");
  EXPECT_EQ(plain["materials"][0]["pbrMetallicRoughness"]["metallicFactor"], 0);
  EXPECT_EQ(plain["extensionsUsed"].size(), 1U);
  look.gloss_and_metal = {{4, 4, 2, [](const auto& write) {
                             std::vector<std::uint8_t> codes;
                             for (int i = 0; i < 16; ++i) codes.insert(codes.end(), {255 - 77, 200});
                             write(codes);
                           }}};
  look.reflectance = 0.16;  // ((1.5 - 1) / (1.5 + 1))^2 is 0.04; of 0.16 the index is (1 + 0.4) / (1 - 0.4).
  look.reflectance_colors = {even(3, 90)};
  write_glb(folder / "metal.glb", ball(1.0, 8), {}, std::vector<GlbAppearance>{look});
  const Json metal = document_of(folder / "metal.glb");
  const Json& material = metal["materials"][0];
  EXPECT_EQ(material["pbrMetallicRoughness"]["metallicFactor"], 1);
  EXPECT_NEAR(material["extensions"]["KHR_materials_ior"]["ior"].get<double>(), 1.4 / 0.6, 1e-12);
  EXPECT_TRUE(material["extensions"]["KHR_materials_specular"].contains("specularColorTexture"));
  EXPECT_EQ(metal["extensionsUsed"], Json({"KHR_materials_variants", "KHR_materials_ior", "KHR_materials_specular"}));
  // Roughness is green, metalness blue: the texture as it is stored.
  const std::size_t texture = material["pbrMetallicRoughness"]["metallicRoughnessTexture"]["index"];
  const Json& view = metal["bufferViews"][metal["images"][texture]["bufferView"].get<std::size_t>()];
  const std::string bytes = read_file(folder / "metal.glb");
  std::uint32_t length = 0;
  std::memcpy(&length, bytes.data() + 12, 4);
  write_atomically(folder / "orm.png", bytes.substr(28 + length + view["byteOffset"].get<std::size_t>(),
                                                    view["byteLength"].get<std::size_t>()));
  const ImageF orm = read_channels(folder / "orm.png", {"G", "B"});
  EXPECT_NEAR(orm.at(1, 1, 0), 77.0f / 255.0f, 1e-6f);
  EXPECT_NEAR(orm.at(1, 1, 1), 200.0f / 255.0f, 1e-6f);
  look.reflectance = 1.0;
  EXPECT_THROW(write_glb(folder / "x.glb", ball(1.0, 8), {}, std::vector<GlbAppearance>{look}), InvalidInput);
}

TEST(Glb, AFullDiskNamesTheFile) {
  const TempFolder folder;
  const auto file = folder / "ball.glb";
  write_glb(file, ball(1.0, 40), two_ages());
  const auto size = std::filesystem::file_size(file);
  for (const auto limit : {std::uintmax_t{0}, size / 2, size - 1}) {
    std::filesystem::remove(file);
    std::string said;
    {
      const testing_support::FileSizeLimit full(limit);
      said = testing_support::error_of<CannotComplete>([&] { write_glb(file, ball(1.0, 40), two_ages()); });
    }
    EXPECT_TRUE(said.starts_with(file.string() + ": ")) << limit << " of " << size << ": " << said;
    EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  }
}

TEST(Glb, IsEqualForEqualInput) {
  const TempFolder folder;
  write_glb(folder / "a.glb", ball(1.0, 8), two_ages());
  write_glb(folder / "b.glb", ball(1.0, 8), two_ages());
  EXPECT_EQ(read_file(folder / "a.glb"), read_file(folder / "b.glb"));
}

// Textures by rows, in pieces of any height, are the file that whole images give.
TEST(Glb, IsTheSameOfTexturesThatAreMadeByRows) {
  const TempFolder folder;
  ImageF color(8, 6, 3);
  for (std::size_t i = 0; i < color.values().size(); ++i) color.data()[i] = static_cast<float>(i) / 150.0f;
  ImageU8 gloss(8, 6), normals(8, 6, 3, 128);
  for (std::size_t i = 0; i < gloss.values().size(); ++i) gloss.data()[i] = static_cast<std::uint8_t>(5 * i);
  write_glb(folder / "whole.glb", ball(1.0, 8),
            {{.name = "0 d", .base_colors = {color}, .normals = {normals}, .speculars = {gloss}}});
  for (const std::size_t rows : {1u, 4u, 6u}) {
    const auto by_rows = [rows](const ImageU8& codes) {
      return GlbTexture{codes.width(), codes.height(), codes.channels(), [rows, codes](const auto& write) {
                          const std::size_t size = rows * 8 * static_cast<std::size_t>(codes.channels());
                          for (std::size_t i = 0; i < codes.values().size(); i += size)
                            write(codes.values().subspan(i, std::min(size, codes.values().size() - i)));
                        }};
    };
    write_glb(folder / "rows.glb", ball(1.0, 8), {},
              {GlbAppearance{"0 d", {by_rows(srgb8_from_linear(color))}, {by_rows(normals)}, {by_rows(gloss)}}});
    EXPECT_EQ(read_file(folder / "rows.glb"), read_file(folder / "whole.glb")) << rows;
  }
  for (const int rows : {5, 7}) {  // A texture that makes fewer or more than it says.
    const auto make = [rows](const auto& write) {
      write(std::vector<std::uint8_t>(static_cast<std::size_t>(rows) * 24));
    };
    EXPECT_THROW(write_glb(folder / "bad.glb", ball(1.0, 8), {}, {GlbAppearance{"0 d", {GlbTexture{8, 6, 3, make}}}}),
                 InvalidInput)
        << rows;
  }
  EXPECT_EQ(list_files(folder.path(), "*").size(), 2u) << "nothing but the two whole files";
}

TEST(Glb, KeepsItsContentKey) {
  const TempFolder folder;
  write_glb(folder / "a.glb", ball(1.0, 8), two_ages(), {.key = "00ff"});
  EXPECT_EQ(read_glb_key(folder / "a.glb"), "00ff");
  write_glb(folder / "b.glb", ball(1.0, 8), two_ages());
  EXPECT_EQ(read_glb_key(folder / "b.glb"), "");
}

TEST(Glb, KeyOfADamagedFileIsEmpty) {
  const TempFolder folder;
  write_glb(folder / "a.glb", ball(1.0, 8), two_ages(), {.key = "00ff"});
  const std::string whole = read_file(folder / "a.glb");
  for (const std::size_t size : {0u, 3u, 12u, 19u, 20u, 21u, 200u}) {
    write_atomically(folder / "cut.glb", whole.substr(0, size));
    EXPECT_EQ(read_glb_key(folder / "cut.glb"), "") << size;
  }
  EXPECT_THROW((void)read_glb_key(folder / "absent.glb"), IoError);
}

TEST(Glb, NamesEveryVariant) {
  const TempFolder folder;
  write_glb(folder / "a.glb", ball(1.0, 8), two_ages());
  const std::string bytes = read_file(folder / "a.glb");
  EXPECT_NE(bytes.find(R"("KHR_materials_variants":{"variants":[{"name":"0 d"},{"name":"12.5 d"}]})"),
            std::string::npos);
  EXPECT_NE(bytes.find(R"("mappings":[{"material":0,"variants":[0]},{"material":1,"variants":[1]}])"),
            std::string::npos);
}

TEST(Glb, ShowsEveryTileWithATextureOfItsOwn) {
  const TempFolder folder;
  const Mesh mesh = ball(1.0, 8);
  GlbTiles tiles{{"1001", "1002"}, std::vector<int>(mesh.triangles.size(), 0)};
  for (std::size_t t = 0; t < tiles.triangle_tile.size() / 2; ++t) tiles.triangle_tile[t] = 1;
  const ImageF a(4, 4, 3, 0.5f), b(4, 4, 3, 0.1f);
  write_glb(folder / "a.glb", mesh, tiles, {{"0 d", {a, b}}, {"2 d", {b, a}}});
  const std::string bytes = read_file(folder / "a.glb");
  for (const char* name : {"0 d 1001", "0 d 1002", "2 d 1001", "2 d 1002"}) {
    EXPECT_NE(bytes.find("\"name\":\"" + std::string(name) + "\""), std::string::npos) << name;
  }
  EXPECT_NE(bytes.find(R"("mappings":[{"material":0,"variants":[0]},{"material":2,"variants":[1]}])"),
            std::string::npos);
  EXPECT_NE(bytes.find(R"("mappings":[{"material":1,"variants":[0]},{"material":3,"variants":[1]}])"),
            std::string::npos);
  EXPECT_EQ(read_mesh(folder / "a.glb").num_triangles(), mesh.num_triangles());
  EXPECT_THROW(write_glb(folder / "b.glb", mesh, tiles, two_ages()), InvalidInput);  // one texture for two tiles
  tiles.triangle_tile.back() = 2;
  EXPECT_THROW(write_glb(folder / "b.glb", mesh, tiles, {{"0 d", {a, b}}}), InvalidInput);
}

TEST(Glb, ObjectsHaveNodesBoundsAndMaterialsOfTheirOwnAndShareTextures) {
  const TempFolder folder;
  const Mesh mesh = ball(1.0, 8);
  GlbOptions options{.objects = {{"lid", "chest", "empty"}, std::vector<int>(mesh.triangles.size(), 0)}};
  for (std::size_t t = 0; t < mesh.triangles.size() / 2; ++t) options.objects.triangle_object[t] = 1;
  write_glb(folder / "a.glb", mesh, two_ages(), options);
  const Mesh back = read_mesh(folder / "a.glb");
  EXPECT_EQ(back.num_triangles(), mesh.num_triangles());
  ASSERT_EQ(back.surfaces.size(), 2u);  // glTF has no empty mesh.
  EXPECT_EQ(back.surfaces[0].node, "lid");
  EXPECT_EQ(back.surfaces[1].node, "chest");
  EXPECT_EQ(std::count(back.triangle_surface.begin(), back.triangle_surface.end(), 1), mesh.num_triangles() / 2);
  const std::string bytes = read_file(folder / "a.glb");
  // Three objects of two variants, in two textures.
  EXPECT_NE(bytes.find(R"("mappings":[{"material":1,"variants":[0]},{"material":4,"variants":[1]}])"),
            std::string::npos);
  EXPECT_NE(bytes.find(R"("source":1)"), std::string::npos);
  EXPECT_EQ(bytes.find(R"("source":2)"), std::string::npos);
  options.objects.triangle_object.pop_back();
  EXPECT_THROW(write_glb(folder / "b.glb", mesh, two_ages(), options), InvalidInput);
  options.objects = {{"one", "one"}, std::vector<int>(mesh.triangles.size(), 0)};
  EXPECT_THROW(write_glb(folder / "b.glb", mesh, two_ages(), options), InvalidInput);
}

TEST(Glb, RefusesWhatWouldNotBeValid) {
  const TempFolder folder;
  Mesh mesh = ball(1.0, 8);
  const auto path = folder / "a.glb";
  EXPECT_THROW(write_glb(path, mesh, {}), InvalidInput);
  EXPECT_THROW(write_glb(path, mesh, {two_ages()[0], two_ages()[0]}), InvalidInput);
  EXPECT_THROW(write_glb(path, mesh, two_ages(), {.meters_per_unit = 0.0}), InvalidInput);
  EXPECT_THROW(write_glb(path, mesh, two_ages(), {.roughness = 2.0}), InvalidInput);
  EXPECT_THROW(write_glb(path, mesh, two_ages(), {.name = "\xff"}), InvalidInput);
  EXPECT_THROW(write_glb(folder / "no/such/folder.glb", mesh, two_ages()), CannotComplete);
  mesh.positions[20].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(write_glb(path, mesh, two_ages()), InvalidInput);
  mesh = ball(1.0, 8);
  mesh.uv_triangles.clear();
  EXPECT_THROW(write_glb(path, mesh, two_ages()), InvalidInput);
  EXPECT_FALSE(std::filesystem::exists(path));
}

std::vector<GlbVariant> with_maps() {
  std::vector<GlbVariant> variants = two_ages();
  variants[0].normals = {ImageU8(8, 8, 3, 128)};
  variants[0].speculars = {ImageU8(8, 8, 1, 200)};
  return variants;
}

TEST(Glb, KeepsNormalsAndRoughnessBesideTheColor) {
  const TempFolder folder;
  write_glb(folder / "plain.glb", ball(1.0, 8), two_ages());
  write_glb(folder / "maps.glb", ball(1.0, 8), with_maps());
  const std::string plain = read_file(folder / "plain.glb"), maps = read_file(folder / "maps.glb");
  EXPECT_EQ(plain.find("TANGENT"), std::string::npos);
  EXPECT_EQ(plain.find("metallicRoughnessTexture"), std::string::npos);
  EXPECT_NE(maps.find(R"("TANGENT":3)"), std::string::npos);
  EXPECT_NE(maps.find(R"("roughnessFactor":1,"metallicRoughnessTexture":{"index":1})"), std::string::npos);
  EXPECT_NE(maps.find(R"("normalTexture":{"index":2})"), std::string::npos);
  EXPECT_EQ(read_mesh(folder / "maps.glb").num_triangles(), ball(1.0, 8).num_triangles());
}

TEST(Glb, RefusesMapsThatDoNotFit) {
  const TempFolder folder;
  std::vector<GlbVariant> variants = with_maps();
  variants[0].normals[0] = ImageU8(8, 8, 1);
  EXPECT_THROW(write_glb(folder / "a.glb", ball(1.0, 8), variants), InvalidInput);
  variants = with_maps();
  variants[0].speculars.emplace_back(8, 8);
  EXPECT_THROW(write_glb(folder / "a.glb", ball(1.0, 8), variants), InvalidInput);
}

TEST(GlbTangents, PointAlongGrowingUAndTellMirroredUvs) {
  Mesh mesh = with_normals(testing_support::plate(2.0, 0.0));  // u along x, v along -z, facing y
  CornerTangents found = corner_tangents(mesh);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    EXPECT_FALSE(found.is_mirrored[t]);
    for (const Vec3& tangent : found.tangent[t]) EXPECT_NEAR((tangent - Vec3(1, 0, 0)).norm(), 0.0, 1e-12);
  }
  for (Vec2& uv : mesh.uvs) uv.x() = 1.0 - uv.x();
  found = corner_tangents(mesh);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    EXPECT_TRUE(found.is_mirrored[t]);
    for (const Vec3& tangent : found.tangent[t]) EXPECT_NEAR((tangent - Vec3(-1, 0, 0)).norm(), 0.0, 1e-12);
  }
}

TEST(GlbTangents, AreUnitAndAcrossTheNormalWhateverTheUvs) {
  for (const bool is_flat : {false, true}) {
    Mesh mesh = ball(1.0, 12);
    if (is_flat) mesh.uvs.assign(mesh.uvs.size(), Vec2(0.3, 0.3));
    const CornerTangents found = corner_tangents(mesh);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_NEAR(found.tangent[t][k].norm(), 1.0, 1e-12);
        EXPECT_NEAR(found.tangent[t][k].dot(mesh.normals[mesh.normal_triangles[t][k]]), 0.0, 1e-12);
      }
    }
  }
}

/// Contents of a whole file in memory.
struct GlbContents {
  explicit GlbContents(const std::string& bytes) {
    std::uint32_t size = 0;
    std::memcpy(&size, bytes.data() + 12, 4);
    json = Json::parse(bytes.substr(20, size));
    binary = bytes.substr(20 + size + 8);
  }
  [[nodiscard]] std::vector<float> floats(const Json& accessor, std::size_t channels) const {
    const Json& of = json.at("accessors").at(accessor.get<std::size_t>());
    const Json& view = json.at("bufferViews").at(of.at("bufferView").get<std::size_t>());
    std::vector<float> values(of.at("count").get<std::size_t>() * channels);
    std::memcpy(values.data(), binary.data() + view.at("byteOffset").get<std::size_t>(), values.size() * 4);
    return values;
  }
  Json json;
  std::string binary;
};

// tests/gltf/run.sh validates what this leaves.
TEST(Glb, SampleForTheKhronosValidator) {
  const char* folder = std::getenv("PATINATE_GLTF_SAMPLES");
  if (folder == nullptr) GTEST_SKIP() << "PATINATE_GLTF_SAMPLES is not set";
  write_glb(std::filesystem::path(folder) / "ball.glb", ball(100.0, 24), two_ages(), {.key = "00ff"});
  write_glb(std::filesystem::path(folder) / "maps.glb", ball(100.0, 24), with_maps());
}

}  // namespace
}  // namespace patinate
