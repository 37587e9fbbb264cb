// Compressed glTF, made here by the encoders of Draco and meshoptimizer, against the same geometry uncompressed.
#include <draco/compression/encode.h>
#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/libcommon/mesh_files/mesh_bytes.h"

namespace patinate {

namespace {

using nlohmann::json;
using testing_support::error_of;
using testing_support::mesh_of;

constexpr int kSide = 24;  ///< Quads along a side.
constexpr int kFloat = 5126, kUnsignedInt = 5125, kInt = 5124, kUnsignedShort = 5123;

/// A wavy sheet, its triangles in rows.
struct Sheet {
  std::vector<std::array<float, 3>> points;
  std::vector<std::array<float, 2>> uvs;
  std::vector<std::uint32_t> indices;
};

Sheet make_sheet() {
  Sheet sheet;
  for (int y = 0; y <= kSide; ++y) {
    for (int x = 0; x <= kSide; ++x) {
      const float u = static_cast<float>(x) / kSide, v = static_cast<float>(y) / kSide;
      sheet.points.push_back({u, v, 0.1f * std::sin(6.0f * u) * std::cos(5.0f * v)});
      sheet.uvs.push_back({u, v});
    }
  }
  for (std::uint32_t y = 0; y < kSide; ++y) {
    for (std::uint32_t x = 0; x < kSide; ++x) {
      const std::uint32_t a = y * (kSide + 1) + x, c = a + kSide + 1;
      for (const std::uint32_t i : {a, a + 1, c, c, a + 1, c + 1}) sheet.indices.push_back(i);
    }
  }
  return sheet;
}

/// A GLB that grows.
struct Glb {
  json document = {{"asset", {{"version", "2.0"}}}, {"scenes", {{{"nodes", {0}}}}},
                   {"nodes", {{{"mesh", 0}}}},      {"meshes", {{{"primitives", {{{"attributes", json::object()}}}}}}},
                   {"accessors", json::array()},    {"bufferViews", json::array()},
                   {"buffers", {json::object()}}};
  std::string bytes;

  json& primitive() { return document["meshes"][0]["primitives"][0]; }
  std::size_t add_view(const void* data, std::size_t size) {
    bytes.resize((bytes.size() + 3) / 4 * 4);
    document["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", size}});
    bytes.append(static_cast<const char*>(data), size);
    return document["bufferViews"].size() - 1;
  }
  std::size_t add_accessor(int component, std::size_t count, const char* type) {
    document["accessors"].push_back({{"componentType", component}, {"count", count}, {"type", type}});
    return document["accessors"].size() - 1;
  }
  void require(const char* extension) { document["extensionsUsed"] = document["extensionsRequired"] = {extension}; }
  [[nodiscard]] std::string file() {
    document["buffers"][0]["byteLength"] = bytes.size();
    std::string head = document.dump(), body = bytes;
    head.resize((head.size() + 3) / 4 * 4, ' ');
    body.resize((body.size() + 3) / 4 * 4, '\0');
    const auto number = [](std::size_t n) {
      const auto value = static_cast<std::uint32_t>(n);
      return std::string(reinterpret_cast<const char*>(&value), 4);
    };
    return "glTF" + number(2) + number(28 + head.size() + body.size()) + number(head.size()) + "JSON" + head +
           number(body.size()) + std::string("BIN\0", 4) + body;
  }
};

Glb plain_glb(const Sheet& sheet) {
  Glb glb;
  const auto add = [&](const void* data, std::size_t size, int component, std::size_t count, const char* type) {
    const std::size_t view = glb.add_view(data, size), accessor = glb.add_accessor(component, count, type);
    glb.document["accessors"][accessor]["bufferView"] = view;
    return accessor;
  };
  const std::size_t count = sheet.points.size();
  glb.primitive()["attributes"]["POSITION"] = add(sheet.points.data(), 12 * count, kFloat, count, "VEC3");
  glb.primitive()["attributes"]["TEXCOORD_0"] = add(sheet.uvs.data(), 8 * count, kFloat, count, "VEC2");
  const std::size_t num_indices = sheet.indices.size();
  glb.primitive()["indices"] = add(sheet.indices.data(), 4 * num_indices, kUnsignedInt, num_indices, "SCALAR");
  return glb;
}

// ---- EXT_meshopt_compression ----

/// @param view  Becomes compressed; its uncompressed bytes go.
void compress_view(Glb& glb, std::size_t view, const std::vector<unsigned char>& coded, std::size_t count,
                   std::size_t stride, const char* mode, const char* filter = nullptr) {
  const std::size_t data = glb.add_view(coded.data(), coded.size());
  json extension = {{"buffer", 0},
                    {"byteOffset", glb.document["bufferViews"][data]["byteOffset"]},
                    {"byteLength", coded.size()},
                    {"byteStride", stride},
                    {"count", count},
                    {"mode", mode}};
  if (filter != nullptr) extension["filter"] = filter;
  glb.document["bufferViews"].erase(data);
  glb.document["bufferViews"][view] = {{"buffer", 1},
                                       {"byteLength", count * stride},
                                       {"byteStride", stride},
                                       {"extensions", {{"EXT_meshopt_compression", extension}}}};
  glb.document["buffers"][1] = {{"byteLength", 1 << 20},
                                {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}};
}

template <class T>
std::vector<unsigned char> coded_vertices(const std::vector<T>& values) {
  std::vector<unsigned char> coded(meshopt_encodeVertexBufferBound(values.size(), sizeof(T)));
  coded.resize(meshopt_encodeVertexBuffer(coded.data(), coded.size(), values.data(), values.size(), sizeof(T)));
  return coded;
}

Glb meshopt_glb(const Sheet& sheet, bool is_sequence) {
  Glb glb = plain_glb(sheet);
  glb.bytes.clear();
  const std::size_t count = sheet.points.size(), num_indices = sheet.indices.size();
  std::vector<unsigned char> indices(meshopt_encodeIndexBufferBound(num_indices, count) +
                                     meshopt_encodeIndexSequenceBound(num_indices, count));
  using Encode = std::size_t (*)(unsigned char*, std::size_t, const unsigned int*, std::size_t);
  const Encode encode =
      is_sequence ? static_cast<Encode>(meshopt_encodeIndexSequence) : static_cast<Encode>(meshopt_encodeIndexBuffer);
  indices.resize(encode(indices.data(), indices.size(), sheet.indices.data(), num_indices));
  compress_view(glb, 0, coded_vertices(sheet.points), count, 12, "ATTRIBUTES");
  compress_view(glb, 1, coded_vertices(sheet.uvs), count, 8, "ATTRIBUTES");
  compress_view(glb, 2, indices, num_indices, 4, is_sequence ? "INDICES" : "TRIANGLES");
  glb.require("EXT_meshopt_compression");
  return glb;
}

TEST(MeshoptGltf, IsTheUncompressedMeshToTheBit) {
  const Sheet sheet = make_sheet();
  const Mesh expected = mesh_of("a.glb", plain_glb(sheet).file());
  for (const bool is_sequence : {false, true}) {
    const Mesh found = mesh_of("a.glb", meshopt_glb(sheet, is_sequence).file());
    EXPECT_EQ(found.positions, expected.positions);
    EXPECT_EQ(found.uvs, expected.uvs);
    // The code turns triangles; it does not turn them over.
    EXPECT_EQ(found.triangles.size(), expected.triangles.size());
    if (is_sequence) {
      EXPECT_EQ(found.triangles, expected.triangles);
    }
  }
}

TEST(MeshoptGltf, TheFilterOfExponentsIsUndone) {
  const Sheet sheet = make_sheet();
  const std::size_t count = sheet.points.size();
  std::vector<std::array<float, 3>> filtered(count);
  constexpr int kBits = 15;
  meshopt_encodeFilterExp(filtered.data(), count, 12, kBits, sheet.points[0].data());
  Glb glb = meshopt_glb(sheet, true);
  compress_view(glb, 0, coded_vertices(filtered), count, 12, "ATTRIBUTES", "EXPONENTIAL");
  const Mesh found = mesh_of("a.glb", glb.file());
  const Mesh expected = mesh_of("a.glb", plain_glb(sheet).file());
  ASSERT_EQ(found.positions.size(), expected.positions.size());
  for (std::size_t i = 0; i < found.positions.size(); ++i)
    // One exponent a value: with a sign, 15 bits of values up to 1 are steps of 2^-13.
    EXPECT_LE((found.positions[i] - expected.positions[i]).cwiseAbs().maxCoeff(), std::pow(2.0, 1 - kBits));
}

TEST(MeshoptGltf, UncompressedValuesThatStandBesideAreTaken) {
  Glb glb = plain_glb(make_sheet());
  const std::string coded = "nonsense";
  const std::size_t data = glb.add_view(coded.data(), coded.size());
  glb.document["bufferViews"][0]["extensions"]["EXT_meshopt_compression"] = {
      {"buffer", 0},
      {"byteOffset", glb.document["bufferViews"][data]["byteOffset"]},
      {"byteLength", coded.size()},
      {"byteStride", 12},
      {"count", 625},
      {"mode", "ATTRIBUTES"}};
  glb.document["extensionsUsed"] = {"EXT_meshopt_compression"};
  EXPECT_EQ(mesh_of("a.glb", glb.file()).positions, mesh_of("a.glb", plain_glb(make_sheet()).file()).positions);
}

TEST(MeshoptGltf, DamageIsNamed) {
  const Sheet sheet = make_sheet();
  const auto error_with = [&](const std::function<void(json&)>& change) {
    Glb glb = meshopt_glb(sheet, false);
    change(glb.document["bufferViews"][0]["extensions"]["EXT_meshopt_compression"]);
    return error_of("a.glb", glb.file());
  };
  const std::string damaged = "buffer view 0: its compressed data are damaged";
  EXPECT_EQ(error_with([](json& e) { e["byteLength"] = 40; }), damaged);
  EXPECT_EQ(error_with([](json& e) { e["mode"] = "TRIANGLES"; }), damaged);
  EXPECT_EQ(error_with([](json& e) { e["mode"] = 7; }), damaged);
  EXPECT_EQ(error_with([](json& e) { e["filter"] = "OCTAHEDRAL"; }), damaged);
  EXPECT_EQ(error_with([](json& e) { e["count"] = 2'000'000'000; }),
            "buffer view 0: its compressed data have a wrong size");
  EXPECT_EQ(error_with([](json& e) { e["byteStride"] = 0; }), "buffer view 0: its compressed data have a wrong size");
  EXPECT_EQ(error_with([](json& e) { e["count"] = -1; }), "buffer view 0: count is no count");
  EXPECT_EQ(error_with([](json& e) { e.erase("buffer"); }), "buffer view 0: its compressed data have no buffer");
  EXPECT_EQ(
      error_with([](json& e) { e["byteOffset"] = 1 << 30; }).find("buffer view 0: its compressed data end behind"), 0U);
}

// ---- KHR_draco_mesh_compression ----

template <class T, std::size_t kSize>
int add_attribute(draco::Mesh& mesh, draco::GeometryAttribute::Type type, draco::DataType data_type,
                  const std::vector<std::array<T, kSize>>& values) {
  draco::GeometryAttribute attribute;
  attribute.Init(type, nullptr, kSize, data_type, false, kSize * sizeof(T), 0);
  const auto count = static_cast<std::uint32_t>(values.size());
  const int id = mesh.AddAttribute(attribute, true, count);
  for (std::uint32_t i = 0; i < count; ++i)
    mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(i), values[i].data());
  return id;
}

/// @param bits  Of a quantized position. @param method  Draco's.
Glb draco_glb(const Sheet& sheet, int bits, int method) {
  draco::Mesh mesh;
  mesh.set_num_points(static_cast<std::uint32_t>(sheet.points.size()));
  const int points = add_attribute(mesh, draco::GeometryAttribute::POSITION, draco::DT_FLOAT32, sheet.points);
  const int uvs = add_attribute(mesh, draco::GeometryAttribute::TEX_COORD, draco::DT_FLOAT32, sheet.uvs);
  for (std::size_t i = 0; i + 2 < sheet.indices.size(); i += 3) {
    mesh.AddFace({draco::PointIndex(sheet.indices[i]), draco::PointIndex(sheet.indices[i + 1]),
                  draco::PointIndex(sheet.indices[i + 2])});
  }
  draco::Encoder encoder;
  encoder.SetTrackEncodedProperties(true);
  encoder.SetEncodingMethod(method);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, bits);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::TEX_COORD, bits);
  draco::EncoderBuffer coded;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(mesh, &coded).ok());
  Glb glb;
  const std::size_t view = glb.add_view(coded.data(), coded.size());
  const std::size_t count = encoder.num_encoded_points();
  json& primitive = glb.primitive();
  primitive["attributes"]["POSITION"] = glb.add_accessor(kFloat, count, "VEC3");
  primitive["attributes"]["TEXCOORD_0"] = glb.add_accessor(kFloat, count, "VEC2");
  primitive["indices"] = glb.add_accessor(kUnsignedShort, sheet.indices.size(), "SCALAR");
  const json ids = {{"POSITION", mesh.attribute(points)->unique_id()},
                    {"TEXCOORD_0", mesh.attribute(uvs)->unique_id()}};
  primitive["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", view}, {"attributes", ids}};
  glb.require("KHR_draco_mesh_compression");
  return glb;
}

TEST(DracoGltf, IsTheMeshWithinItsQuantization) {
  const Sheet sheet = make_sheet();
  constexpr int kBits = 14;
  for (const int method :
       {static_cast<int>(draco::MESH_SEQUENTIAL_ENCODING), static_cast<int>(draco::MESH_EDGEBREAKER_ENCODING)}) {
    const Mesh found = mesh_of("a.glb", draco_glb(sheet, kBits, method).file());
    ASSERT_EQ(found.positions.size(), sheet.points.size());
    EXPECT_EQ(found.triangles.size(), sheet.indices.size() / 3);
    ASSERT_EQ(found.uvs.size(), found.positions.size());
    // The sheet is a function of its UVs, whatever the order of its vertices; it is flatter than 45 degrees.
    const double tolerance = 2.0 / (1 << kBits);
    for (std::size_t i = 0; i < found.positions.size(); ++i) {
      const double u = found.uvs[i].x(), v = 1.0 - found.uvs[i].y();
      EXPECT_NEAR(found.positions[i].x(), u, tolerance);
      EXPECT_NEAR(found.positions[i].y(), v, tolerance);
      EXPECT_NEAR(found.positions[i].z(), 0.1 * std::sin(6.0 * u) * std::cos(5.0 * v), 2.0 * tolerance);
    }
  }
}

TEST(DracoGltf, AnAccessorThatIsSharedKeepsItsOwnValues) {
  const Sheet sheet = make_sheet();
  Glb glb = draco_glb(sheet, 14, draco::MESH_SEQUENTIAL_ENCODING);
  json& primitives = glb.document["meshes"][0]["primitives"];
  primitives.push_back(primitives[0]);
  EXPECT_EQ(mesh_of("a.glb", glb.file()).triangles.size(), 2 * sheet.indices.size() / 3);
}

TEST(DracoGltf, DamageIsNamed) {
  const Sheet sheet = make_sheet();
  const auto error_with = [&](const std::function<void(Glb&, json&)>& change) {
    Glb glb = draco_glb(sheet, 14, draco::MESH_EDGEBREAKER_ENCODING);
    change(glb, glb.primitive()["extensions"]["KHR_draco_mesh_compression"]);
    return error_of("a.glb", glb.file());
  };
  EXPECT_EQ(error_with([](Glb& glb, json&) { glb.document["bufferViews"][0]["byteLength"] = 60; }),
            "mesh 0: its Draco data are damaged");
  EXPECT_EQ(error_with([](Glb& glb, json&) { glb.bytes[0] = 'X'; }), "mesh 0: its Draco data are damaged");
  EXPECT_EQ(error_with([](Glb&, json& e) { e.erase("bufferView"); }), "mesh 0: its Draco data have no buffer view");
  EXPECT_EQ(error_with([](Glb&, json& e) { e["attributes"]["POSITION"] = 9; }),
            "mesh 0: POSITION is missing in its Draco data");
  EXPECT_EQ(error_with([](Glb& glb, json&) { glb.document["accessors"][0]["count"] = 7; }),
            "mesh 0: its Draco data have 625 entries; accessor 0 has 7");
  EXPECT_EQ(error_with([](Glb& glb, json&) { glb.document["accessors"][0]["componentType"] = kInt; }),
            "mesh 0: POSITION is of another type than its Draco data");
}

}  // namespace

}  // namespace patinate
