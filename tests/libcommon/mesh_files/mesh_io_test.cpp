#include "patinate/mesh_files/mesh_io.h"

#include <gtest/gtest.h>

#include <cstring>
#include <map>
#include <nlohmann/json.hpp>

#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "tests/libcommon/geometry/shapes.h"
#include "tests/libcommon/mesh_files/mesh_bytes.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_data.h"

namespace patinate {
namespace {

using testing_support::error_of;
using testing_support::mesh_of;
using testing_support::TempFolder;
using testing_support::write;

double volume_of(const Mesh& mesh) {
  double volume = 0.0;
  for (int t = 0; t < mesh.num_triangles(); ++t) {
    volume += mesh.positions[mesh.triangles[static_cast<std::size_t>(t)][0]].dot(area_vector(mesh, t)) / 6;
  }
  return volume;
}

TEST(ReadMesh, NamesWhatIsWrongWithAFile) {
  const TempFolder folder;
  EXPECT_THROW((void)read_mesh(folder / "missing.obj"), IoError);
  EXPECT_THROW((void)read_mesh(folder / "missing.glb"), IoError);
  EXPECT_THROW((void)read_mesh(folder.path()), IoError);
  for (const char* name : {"a.obj", "a.ply", "a.stl", "a.gltf", "a.glb"}) {
    EXPECT_EQ(error_of(name, ""), "the file is empty (0 bytes)");
  }
  EXPECT_EQ(error_of("a.fbx", "x"), "no mesh format has the extension `.fbx`; use .obj, .ply, .stl, .gltf or .glb");
}

TEST(ReadObj, ReadsPolygonsNegativeIndicesContinuationsAndNumberForms) {
  const Mesh mesh =
      mesh_of("a.obj",
              "# box\r\no lid\nusemtl red paint\nv 0 0 0\nv +1 0. 0\nv 1e0 1 0\nv 0 1 -0\nvt 0 0\nvt 1 0\nvt 1 1\n"
              "vt 0 1\nf -4/1 -3/2 \\\n -2/3 -1/4");
  EXPECT_EQ(mesh.positions.size(), 4u);
  EXPECT_EQ(mesh.num_triangles(), 2);
  EXPECT_TRUE(mesh.has_uvs());
  EXPECT_TRUE(mesh.normals.empty());
  ASSERT_EQ(mesh.surfaces.size(), 1u);
  EXPECT_EQ(mesh.surfaces[0].node, "lid");
  EXPECT_EQ(mesh.surfaces[0].material, "red paint");
}

TEST(ReadObj, NamesTheLineOfAnError) {
  const std::string square = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  EXPECT_EQ(error_of("a.obj", square + "f 1 2 4\n"), "line 4: vertex index 4 is out of range; there are 3 so far");
  EXPECT_EQ(error_of("a.obj", square + "f 0 1 2\n"), "line 4: vertex index 0 is out of range; there are 3 so far");
  EXPECT_EQ(error_of("a.obj", square + "f 1/1 2/1 3/1\n"), "line 4: UV index 1 is out of range; there are 0 so far");
  EXPECT_EQ(error_of("a.obj", square + "f 1 2\n"), "line 4: a face has 2 corners; it needs at least 3");
  EXPECT_EQ(error_of("a.obj", square + "v 1 nan 0\nf 1 2 3\n"), "line 4: `nan` is not a finite number");
  EXPECT_EQ(error_of("a.obj", square + "v 1 1e999 0\nf 1 2 3\n"), "line 4: `1e999` is not a finite number");
  EXPECT_EQ(error_of("a.obj", square + "f 1 2 3\nv 0.5 1"), "line 5: found 2 numbers; expected 3");
  EXPECT_EQ(error_of("a.obj", square), "no faces, only 3 points (a point cloud); a surface is needed");
  EXPECT_EQ(error_of("a.obj", square + "f 1 1 2\n"), "no triangle with three different corners; a surface is needed");
  EXPECT_EQ(error_of("a.obj", "hello\n"), "no vertices and no faces; is it an OBJ file?");
  EXPECT_EQ(error_of("a.obj", std::string("v 0\0", 4)), "holds binary data; an OBJ file is text");
}

TEST(ReadObj, MergesEqualPositionsOfANodeButNotOfTwo) {
  const std::string two = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 0 0\nv 1 1 0\nv 0 1 -0.0\n";
  EXPECT_EQ(mesh_of("a.obj", two + "f 1 2 3\nf 4 5 6\n").positions.size(), 4u);
  EXPECT_EQ(mesh_of("a.obj", two + "o a\nf 1 2 3\no b\nf 4 5 6\n").positions.size(), 6u);
}

TEST(WriteObj, ReadsBackToTheSameBits) {
  Mesh mesh = testing_support::make_patch(5, 4, [](double u, double v) { return Vec3(u / 3, v * 0.1, u * v * 1e-7); });
  mesh = with_normals(mesh);
  mesh.surfaces = {{"front side", "copper"}};
  const TempFolder folder;
  write_obj(folder / "out.obj", mesh);
  const Mesh back = read_mesh(folder / "out.obj");
  ASSERT_EQ(back.num_triangles(), mesh.num_triangles());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto of = [&](const auto& values, const auto& triangles) { return values[triangles[t][k]]; };
      EXPECT_EQ(of(back.positions, back.triangles), of(mesh.positions, mesh.triangles));
      EXPECT_EQ(of(back.uvs, back.uv_triangles), of(mesh.uvs, mesh.uv_triangles));
      EXPECT_LT((of(back.normals, back.normal_triangles) - of(mesh.normals, mesh.normal_triangles)).norm(), 1e-15);
    }
  }
  EXPECT_EQ(back.surfaces[0].node, "front side");
  EXPECT_EQ(back.surfaces[0].material, "copper");
  EXPECT_THROW(write_obj(folder / "no" / "folder.obj", mesh), CannotComplete);
}

template <class T>
std::string raw(std::initializer_list<T> values, bool is_big) {
  std::string bytes;
  for (T value : values) {
    char one[sizeof(T)];
    std::memcpy(one, &value, sizeof(T));
    if (is_big) std::reverse(one, one + sizeof(T));
    bytes.append(one, sizeof(T));
  }
  return bytes;
}

/// A unit square with per-vertex (s, t), in one of three forms.
std::string ply_square(const std::string& form) {
  std::string text = "ply\nformat " + form +
                     " 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty double z\n"
                     "property float s\nproperty float t\nelement extra 1\nproperty list uchar short junk\n"
                     "element face 1\nproperty uchar flags\nproperty list uchar int vertex_indices\nend_header\n";
  if (form == "ascii") return text + "0 0 0.5 0 0\n1 0 .5 1 0\n1 1 0.5 1 1\n0 1 5e-1 0 1\n2 7 8\n9 4 0 1 2 3";
  const bool big = form == "binary_big_endian";
  for (const auto& [x, y] : {std::pair{0.F, 0.F}, {1.F, 0.F}, {1.F, 1.F}, {0.F, 1.F}}) {
    text += raw<float>({x, y}, big) + raw<double>({0.5}, big) + raw<float>({x, y}, big);
  }
  text += raw<std::uint8_t>({2}, big) + raw<std::int16_t>({7, 8}, big);
  return text + raw<std::uint8_t>({9, 4}, big) + raw<std::int32_t>({0, 1, 2, 3}, big);
}

TEST(ReadPly, ReadsAllThreeFormsAlike) {
  for (const char* form : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    const Mesh mesh = mesh_of("a.ply", ply_square(form));
    ASSERT_EQ(mesh.num_triangles(), 2) << form;
    ASSERT_TRUE(mesh.has_uvs());
    EXPECT_EQ(mesh.positions[2], Vec3(1, 1, 0.5));
    for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(mesh.uvs[i], Vec2(mesh.positions[i].head<2>()));
  }
}

TEST(ReadPly, SaysThatAFileIsTruncatedAtEveryLength) {
  for (const char* form : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    const std::string whole = ply_square(form);
    for (std::size_t length = 1; length < whole.size(); ++length) {
      EXPECT_NE(error_of("a.ply", whole.substr(0, length)), "") << form << " " << length;
    }
  }
}

TEST(ReadPly, ReadsTexcoordListsPerFaceAndStrips) {
  const std::string vertices =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string values = "end_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n";
  const Mesh faces = mesh_of("a.ply", vertices +
                                          "element face 2\nproperty list uchar int vertex_index\n"
                                          "property list uchar float texcoord\n" +
                                          values + "3 0 1 2 6 0 0 1 0 0 1\n3 1 3 2 6 .5 .5 1 1 0 1\n");
  ASSERT_TRUE(faces.has_uvs());
  EXPECT_EQ(faces.positions.size(), 4u);
  EXPECT_EQ(faces.uvs.size(), 5u);  // vertex 1 has two, vertex 2 the same one twice
  const Mesh strip = mesh_of(
      "b.ply", vertices + "element tristrips 1\nproperty list int int vertex_indices\n" + values + "6 0 1 2 3 -1 0");
  ASSERT_EQ(strip.num_triangles(), 2);
  for (int t = 0; t < 2; ++t) EXPECT_EQ(area_vector(strip, t), Vec3(0, 0, 1));
}

TEST(ReadPly, NamesWhatIsWrong) {
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string faces = "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n";
  EXPECT_EQ(error_of("a.ply", header + faces + "0 1 0\n3 0 1 3\n"),
            "line 13: element `face`, row 0: a vertex index is out of range; there are 3 vertices before it");
  EXPECT_EQ(error_of("a.ply", header + faces + "0 1 0\n3 0 1 -1\n"),
            "line 13: element `face`, row 0: a vertex index is out of range; there are 3 vertices before it");
  EXPECT_EQ(error_of("a.ply", header + faces + "0 nan 0\n3 0 1 2\n"),
            "a position is not finite or beyond 1e30; NaN and infinity are not allowed");
  EXPECT_EQ(error_of("a.ply", header + faces + "0 x 0\n3 0 1 2\n"),
            "line 12: element `vertex`, row 2: `x` is not a number");
  EXPECT_EQ(error_of("a.ply", header + "end_header\n0 0 0\n1 0 0\n0 1 0\n"),
            "no faces, only 3 points (a point cloud); a surface is needed");
  EXPECT_EQ(error_of("a.ply", "ply\nformat ascii 1.0\nelement vertex 99999999999\nproperty float x\nend_header\n"),
            "truncated: ends in element `vertex`, row 0 of 99999999999");
  EXPECT_EQ(error_of("a.ply", "obj\n"), "is not a PLY file; its first line must be `ply`");
}

/// A tetrahedron (0, x, y, z), outward, in a GLB-ready model with its buffer: 48 bytes positions, 32 bytes UVs, 12
/// indices.
struct TetrahedronGltf {
  std::string buffer = raw<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, false) +
                       raw<float>({0, 0, 1, 0, 0, 1, 1, 0.25F}, false) +
                       raw<std::uint8_t>({0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3}, false);
  nlohmann::json json = nlohmann::json::parse(R"({
    "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
    "nodes": [{"name": "shape", "mesh": 0}],
    "materials": [{"name": "iron"}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
                  {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
                  {"bufferView": 2, "componentType": 5121, "count": 12, "type": "SCALAR"}],
    "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 32},
                    {"buffer": 0, "byteOffset": 80, "byteLength": 12}],
    "buffers": [{"byteLength": 92}]})");

  [[nodiscard]] std::string text() const {
    nlohmann::json copy = json;
    if (!copy["buffers"][0].contains("uri")) {
      copy["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64(buffer);
    }
    return copy.dump();
  }
  [[nodiscard]] std::string glb() const {
    std::string chunk = json.dump();
    while (chunk.size() % 4 != 0) chunk += ' ';
    const auto size = [](std::size_t n) { return static_cast<std::uint32_t>(n); };
    return "glTF" + raw<std::uint32_t>({2, size(28 + chunk.size() + buffer.size()), size(chunk.size())}, false) +
           "JSON" + chunk + raw<std::uint32_t>({size(buffer.size())}, false) + std::string("BIN\0", 4) + buffer;
  }
};

TEST(ReadGltf, ReadsDataUrisAndGlbAlikeWithVUp) {
  const TetrahedronGltf gltf;
  for (const Mesh& mesh : {mesh_of("a.gltf", gltf.text()), mesh_of("a.glb", gltf.glb())}) {
    EXPECT_EQ(mesh.num_triangles(), 4);
    EXPECT_NEAR(volume_of(mesh), 1.0 / 6, 1e-15);
    ASSERT_TRUE(mesh.has_uvs());
    EXPECT_EQ(mesh.uvs[0], Vec2(0, 1));
    EXPECT_EQ(mesh.surfaces[0].node, "shape");
    EXPECT_EQ(mesh.surfaces[0].material, "iron");
  }
}

TEST(ReadGltf, AppliesNestedTransformsAndKeepsMirroredSurfacesOutward) {
  TetrahedronGltf gltf;
  // A parent that turns by 90 degrees about z and moves, a child that mirrors x and doubles: volume 8 / 6, still
  // outward.
  gltf.json["nodes"] = nlohmann::json::parse(R"([
    {"name": "parent", "children": [1], "translation": [10, 0, 0], "rotation": [0, 0, 0.70710678118654752, 0.70710678118654752]},
    {"name": "child", "mesh": 0, "matrix": [-2,0,0,0, 0,2,0,0, 0,0,2,0, 0,0,1,1]}])");
  const Mesh mesh = mesh_of("a.gltf", gltf.text());
  EXPECT_NEAR(volume_of(mesh), 8.0 / 6, 1e-9);
  const Box box = bounding_box(mesh);  // x' = 10 - 2 y, y' = -2 x, z' = 2 z + 1
  EXPECT_LT((box.low - Vec3(8, -2, 1)).norm(), 1e-12);
  EXPECT_LT((box.high - Vec3(10, 0, 3)).norm(), 1e-12);
}

TEST(ReadGltf, KeepsNodesAndMaterialsApart) {
  TetrahedronGltf gltf;
  gltf.json["nodes"] =
      nlohmann::json::parse(R"([{"name": "a", "mesh": 0}, {"name": "b", "mesh": 0, "translation": [5, 0, 0]}])");
  gltf.json["scenes"][0]["nodes"] = {0, 1};
  auto second = gltf.json["meshes"][0]["primitives"][0];
  second.erase("material");
  gltf.json["meshes"][0]["primitives"].push_back(second);
  const Mesh mesh = mesh_of("a.gltf", gltf.text());
  EXPECT_EQ(mesh.surfaces.size(), 4u);
  EXPECT_EQ(mesh.num_triangles(), 16);
  EXPECT_EQ(mesh.positions.size(), 8u);  // both primitives of a node share theirs
  EXPECT_EQ(select_surfaces(mesh, "b", "iron").num_triangles(), 4);
  EXPECT_NEAR(bounding_box(select_surfaces(mesh, "b", "")).low.x(), 5.0, 1e-12);
}

TEST(ReadGltf, ReadsStripsFansAndPrimitivesWithoutIndices) {
  TetrahedronGltf gltf;
  auto& primitive = gltf.json["meshes"][0]["primitives"][0];
  primitive.erase("indices");
  primitive["mode"] = 5;  // 0 1 2, then 2 1 3
  EXPECT_EQ(mesh_of("a.gltf", gltf.text()).triangles, (std::vector<Triangle>{{0, 1, 2}, {2, 1, 3}}));
  primitive["mode"] = 6;
  EXPECT_EQ(mesh_of("a.gltf", gltf.text()).triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}));
  primitive["mode"] = 0;
  EXPECT_EQ(error_of("a.gltf", gltf.text()), "no faces, only points or lines (a point cloud); a surface is needed");
}

/// The error after one member of the model was set to something wrong.
std::string error_with(const std::string& pointer, const nlohmann::json& value) {
  TetrahedronGltf gltf;
  gltf.json[nlohmann::json::json_pointer(pointer)] = value;
  return error_of("a.gltf", gltf.text());
}

TEST(ReadGltf, ChecksEveryBoundOfAnAccessor) {
  EXPECT_NE(error_with("/accessors/0/count", 5).find("5 elements do not fit into its buffer view of 48 bytes"),
            std::string::npos);
  EXPECT_NE(error_with("/accessors/0/byteOffset", 4).find("do not fit"), std::string::npos);
  EXPECT_NE(error_with("/accessors/0/count", 4000000000000000000).find("do not fit"), std::string::npos);
  EXPECT_NE(error_with("/bufferViews/0/byteStride", 16).find("do not fit"), std::string::npos);
  EXPECT_NE(error_with("/bufferViews/0/byteStride", 4).find("wrong byteStride"), std::string::npos);
  EXPECT_NE(error_with("/bufferViews/0/byteLength", 93).find("ends behind its buffer"), std::string::npos);
  EXPECT_NE(error_with("/bufferViews/0/byteOffset", 50).find("ends behind its buffer"), std::string::npos);
  EXPECT_NE(error_with("/bufferViews/0/buffer", 3), "");
  EXPECT_NE(error_with("/accessors/0/bufferView", 9).find("has no buffer view"), std::string::npos);
  EXPECT_NE(error_with("/accessors/0/type", "VEC2").find("POSITION has 2 components; expected 3"), std::string::npos);
  EXPECT_NE(error_with("/accessors/1/count", 3).find("TEXCOORD_0 has 3 entries; POSITION has 4"), std::string::npos);
  EXPECT_NE(error_with("/accessors/2/componentType", 5120).find("not unsigned integers"), std::string::npos);
  const auto sparse = [](int count, int indices, int values) {
    return error_with("/accessors/0/sparse", {{"count", count},
                                              {"indices", {{"bufferView", indices}, {"componentType", 5121}}},
                                              {"values", {{"bufferView", values}}}});
  };
  EXPECT_EQ(sparse(1, 2, 0), "");
  EXPECT_NE(sparse(4, 2, 0).find("its sparse indices do not increase"), std::string::npos);  // 0, 2, 1, 0
  EXPECT_NE(sparse(13, 2, 0).find("13 elements do not fit"), std::string::npos);
  EXPECT_NE(sparse(2, 2, 2).find("2 elements do not fit"), std::string::npos);
  EXPECT_NE(sparse(1, 9, 0).find("has no buffer view"), std::string::npos);
  EXPECT_NE(sparse(-1, 2, 0), "");
  EXPECT_NE(error_with("/meshes/0/primitives/0/attributes/POSITION", 7).find("does not exist"), std::string::npos);
  EXPECT_NE(error_with("/meshes/0/primitives/0/indices", 7), "");  // tinygltf has words of its own for it
  EXPECT_NE(error_with("/meshes/0/primitives/0/mode", 8).find("mode 8 is unknown"), std::string::npos);
  EXPECT_NE(error_with("/nodes/0/mesh", 4).find("mesh 4 does not exist"), std::string::npos);
  EXPECT_NE(error_with("/nodes/0/children", nlohmann::json::array({0})).find("must form a tree"), std::string::npos);
  EXPECT_NE(error_with("/scenes/0/nodes", nlohmann::json::array({6})).find("node 6 does not exist"), std::string::npos);
  EXPECT_NE(error_with("/extensionsRequired", nlohmann::json::array({"KHR_meshopt_compression"})).find("compression"),
            std::string::npos);
}

TEST(ReadGltf, RejectsIndicesOutOfRangeAndNan) {
  TetrahedronGltf gltf;
  gltf.buffer[85] = 4;
  EXPECT_EQ(error_of("a.gltf", gltf.text()), "mesh 0: vertex index 4 is out of range; there are 4 vertices");
  gltf = {};
  gltf.buffer.replace(12, 4, "\xff\xff\xff\x7f");
  EXPECT_NE(error_of("a.glb", gltf.glb()).find("not finite"), std::string::npos);
}

TEST(ReadGltf, NamesABufferFileThatIsMissingOrTruncated) {
  TetrahedronGltf gltf;
  gltf.json["buffers"][0]["uri"] = "data.bin";
  const TempFolder folder;
  write(folder / "a.gltf", gltf.text());
  EXPECT_THROW((void)read_mesh(folder / "a.gltf"), IoError);
  write(folder / "data.bin", gltf.buffer.substr(0, 91));
  EXPECT_THROW((void)read_mesh(folder / "a.gltf"), IoError);
  write(folder / "data.bin", gltf.buffer);
  EXPECT_EQ(read_mesh(folder / "a.gltf").num_triangles(), 4);
}

TEST(ReadGltf, DoesNotNeedItsImages) {
  TetrahedronGltf gltf;
  gltf.json["images"] = nlohmann::json::parse(R"([{"uri": "missing.png"}])");
  EXPECT_EQ(mesh_of("a.gltf", gltf.text()).num_triangles(), 4);
}

TEST(ReadGltf, SaysThatAFileIsTruncatedAtEveryLength) {
  const TetrahedronGltf gltf;
  for (const auto& [name, whole] :
       {std::pair<std::string, std::string>{"a.gltf", gltf.text()}, {"a.glb", gltf.glb()}}) {
    for (std::size_t length = 1; length < whole.size(); length += length < 64 ? 1 : 7) {
      EXPECT_NE(error_of(name, whole.substr(0, length)), "") << name << " " << length;
    }
  }
}

TEST(ReadMesh, ReadsOrRejectsFilesWithFlippedBytes) {
  const TetrahedronGltf gltf;
  const std::vector<std::pair<std::string, std::string>> files = {{"a.gltf", gltf.text()},
                                                                  {"a.glb", gltf.glb()},
                                                                  {"a.ply", ply_square("binary_little_endian")},
                                                                  {"b.ply", ply_square("ascii")}};
  for (const auto& [name, whole] : files) {
    for (std::size_t i = 0; i < whole.size(); ++i) {
      std::string flipped = whole;
      flipped[i] = static_cast<char>(flipped[i] ^ (1 << (i % 8)));
      (void)error_of(name, flipped);  // fails on anything but IoError
    }
  }
}

TEST(ReadGltf, RejectsJsonThatIsNestedWithoutEnd) {
  EXPECT_NE(error_of("a.gltf", std::string(100'000, '[')).find("nested more than"), std::string::npos);
}

TEST(ReadMesh, ReadsTheMeshesThatPeopleUse) {
  struct Expected {
    const char* file;
    int num_triangles;
    std::size_t num_positions;  // 0 = not stated by the source
    bool has_uvs;
  };
  PATINATE_REQUIRE_DATA(meshes, "meshes");
  const Expected files[] = {
      {"spot/spot_triangulated.obj", 5856, 2930, true},       {"spot/spot_quadrangulated.obj", 5856, 2930, true},
      {"blub/blub_triangulated.obj", 14208, 7106, true},      {"sphere/icosphere5_smart_uv.obj", 5120, 2562, true},
      {"marble_bust/marble_bust_01_1k.gltf", 17456, 0, true}, {"robustness_assimp/cube_uv.ply", 12, 0, true},
      {"robustness_assimp/cube_binary.ply", 12, 8, false},    {"robustness_assimp/Wuson.ply", 3732, 0, true},
  };
  for (const Expected& e : files) {
    const Mesh mesh = read_mesh(meshes / e.file);
    EXPECT_EQ(mesh.num_triangles(), e.num_triangles) << e.file;
    EXPECT_TRUE(e.num_positions == 0 || mesh.positions.size() == e.num_positions) << e.file;
    EXPECT_EQ(mesh.has_uvs(), e.has_uvs) << e.file;
  }
}

TEST(ReadMesh, SelectsTheCleanSurfacesOfTheFireHydrant) {
  PATINATE_REQUIRE_DATA(path, "meshes/fire_hydrant/fire_hydrant_1k.gltf");
  const Mesh mesh = read_mesh(path);
  const Mesh clean = select_surfaces(mesh, "", "fire_hydrant");
  EXPECT_EQ(clean.surfaces.size(), 5u);
  EXPECT_EQ(clean.num_triangles() * 2, mesh.num_triangles());
  for (const Mesh::Surface& s : clean.surfaces) EXPECT_EQ(s.node.find("aged"), std::string::npos) << s.node;
  EXPECT_LT(bounding_box(clean).high.x(), 0.0);  // the clean nodes stand at x = -0.3
  EXPECT_TRUE(clean.has_uvs());
}

TEST(ReadMesh, ReadsOrRejectsEveryFileThatImportersBreakOn) {
  PATINATE_REQUIRE_DATA(folder, "meshes/robustness_assimp");
  std::map<std::string, bool> is_read;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    try {
      const Mesh mesh = read_mesh(entry.path());
      EXPECT_GT(mesh.num_triangles(), 0);
      for (const Vec3& p : mesh.positions) EXPECT_TRUE(p.allFinite());
      is_read[name] = true;
    } catch (const IoError&) {
      is_read[name] = false;
    }
  }
  for (const char* good : {"box_longline.obj", "box_without_lineending.obj", "concave_polygon.obj",
                           "number_formats.obj", "spider.obj", "float-color.ply"}) {
    EXPECT_TRUE(is_read.at(good)) << good;
  }
  for (const char* bad :
       {"empty.obj", "empty.ply", "malformed.obj", "malformed2.obj", "point_cloud.obj", "points.ply"}) {
    EXPECT_FALSE(is_read.at(bad)) << bad;
  }
}

}  // namespace
}  // namespace patinate
