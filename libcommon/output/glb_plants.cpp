#include "libcommon/output/glb_plants.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "libcommon/output/glb_document.h"
#include "libcommon/output/plantlets.h"

namespace patinate {

namespace {

constexpr std::size_t kNumColors = 6;
/// A node is this small and its instances as much larger, so that viewers which know no instances show a speck in place
/// of one plant at the origin. A power of two: nothing is rounded.
constexpr double kNodeScale = 1.0 / 1024;
constexpr double kLightest = 1.15;  ///< Largest shade of a leaf; vertex colors end at 1.

using Variants = std::pair<int, int>;
using Group = std::pair<Variants, std::size_t>;  ///< And number of the color.

/// Number of each plant's color, of few: from dark to light, as many plants of each.
std::vector<std::size_t> color_numbers(const std::vector<GlbPlant>& plants) {
  std::vector<std::size_t> order(plants.size()), number(plants.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return plants[a].color.sum() < plants[b].color.sum(); });
  for (std::size_t k = 0; k < order.size(); ++k) number[order[k]] = k * kNumColors / order.size();
  return number;
}

void append(std::vector<float>& values, const Vec3& v) {
  for (int i = 0; i < 3; ++i) values.push_back(static_cast<float>(v[i]));
}

/// Accessors of the shape's vertices, as a primitive without material.
Json add_shape(Json& gltf, GlbBinary& binary) {
  const PlantShape shape = plant_shape();
  std::vector<Vec3> normal(shape.positions.size(), Vec3::Zero());
  std::vector<float> positions, normals, colors;
  std::vector<std::uint32_t> indices;
  for (const Triangle& t : shape.triangles) {
    const auto at = [&](std::size_t c) -> const Vec3& { return shape.positions[static_cast<std::size_t>(t[c])]; };
    const Vec3 area = (at(1) - at(0)).cross(at(2) - at(0));
    for (const int corner : t) {
      normal[static_cast<std::size_t>(corner)] += area;
      indices.push_back(static_cast<std::uint32_t>(corner));
    }
  }
  for (std::size_t i = 0; i < shape.positions.size(); ++i) {
    append(positions, shape.positions[i]);
    append(normals, normal[i].normalized());
    append(colors, Vec3::Constant(shape.shades[i] / kLightest));
  }
  const auto add = [&](const std::vector<float>& values) {
    return add_gltf_accessor(gltf, binary.add(values, kGltfVertices), kGltfFloat, values.size() / 3, "VEC3");
  };
  Json primitive;
  Json& attributes = primitive["attributes"];
  attributes["POSITION"] = add_gltf_positions(gltf, binary.add(positions, kGltfVertices), positions);
  attributes["NORMAL"] = add(normals);
  attributes["COLOR_0"] = add(colors);
  primitive["indices"] =
      add_gltf_accessor(gltf, binary.add(indices, kGltfIndices), kGltfUint32, indices.size(), "SCALAR");
  return primitive;
}

/// Where plants stand, as the attributes of instances.
Json add_instances(Json& gltf, GlbBinary& binary, const std::vector<const GlbPlant*>& plants, const Vec3& origin,
                   double meters_per_unit) {
  std::vector<float> places, turns, sizes;
  for (const GlbPlant* plant : plants) {
    append(places, meters_per_unit / kNodeScale * (plant->root - origin));
    const Eigen::Quaterniond turn(plant_frame(plant->up, plant->turn));
    for (const double q : {turn.x(), turn.y(), turn.z(), turn.w()}) turns.push_back(static_cast<float>(q));
    append(sizes, Vec3::Constant(meters_per_unit / kNodeScale * plant->size));
  }
  const auto add = [&](const std::vector<float>& values, const char* shape) {
    return add_gltf_accessor(gltf, binary.add(values, 0), kGltfFloat, plants.size(), shape);
  };
  Json attributes;
  attributes["TRANSLATION"] = add(places, "VEC3");
  attributes["ROTATION"] = add(turns, "VEC4");
  attributes["SCALE"] = add(sizes, "VEC3");
  return attributes;
}

Json leaf_material(const std::string& name, const Vec3& color, double alpha) {
  Json material = {{"name", name}, {"doubleSided", true}};
  material["pbrMetallicRoughness"] = {
      {"baseColorFactor", {color[0], color[1], color[2], alpha}}, {"metallicFactor", 0}, {"roughnessFactor", 0.9}};
  if (alpha == 0.0) material["alphaMode"] = "MASK";
  return material;
}

}  // namespace

void add_glb_plants(Json& gltf, GlbBinary& binary, const GlbOptions& options, const Vec3& origin, int num_variants) {
  const std::vector<GlbPlant>& plants = options.plants;
  if (plants.empty()) return;
  const std::vector<std::size_t> number = color_numbers(plants);
  std::map<Group, std::vector<const GlbPlant*>> groups;
  std::array<Vec3, kNumColors> sum;
  sum.fill(Vec3::Zero());
  std::array<int, kNumColors> count{};
  for (std::size_t i = 0; i < plants.size(); ++i) {
    groups[{{plants[i].first_variant, plants[i].last_variant}, number[i]}].push_back(&plants[i]);
    sum[number[i]] += plants[i].color;
    ++count[number[i]];
  }
  gltf["extensionsUsed"].push_back("EXT_mesh_gpu_instancing");
  const std::size_t first_material = gltf["materials"].size(), hidden = first_material + kNumColors;
  for (std::size_t k = 0; k < kNumColors; ++k) {
    const Vec3 color = count[k] == 0 ? Vec3(Vec3::Zero()) : Vec3(kLightest * sum[k] / count[k]).cwiseMin(1.0);
    gltf["materials"].push_back(leaf_material("leaves " + std::to_string(k), color, 1.0));
  }
  const bool shows_always = std::all_of(groups.begin(), groups.end(), [&](const auto& group) {
    return group.first.first == Variants(0, num_variants - 1);
  });
  if (!shows_always) gltf["materials"].push_back(leaf_material("no leaves", Vec3::Zero(), 0.0));
  const Json shape = add_shape(gltf, binary);
  for (const auto& [group, members] : groups) {
    const auto& [variants, color] = group;
    Json primitive = shape;
    std::vector<int> shown, others;
    for (int v = 0; v < num_variants; ++v) (v >= variants.first && v <= variants.second ? shown : others).push_back(v);
    primitive["material"] = variants.first == 0 ? first_material + color : hidden;
    Json mappings = Json::array({{{"material", first_material + color}, {"variants", shown}}});
    if (!others.empty()) mappings.push_back({{"material", hidden}, {"variants", others}});
    primitive["extensions"]["KHR_materials_variants"]["mappings"] = mappings;
    const std::string name = "plants " + std::to_string(variants.first) + " " + std::to_string(color);
    const std::size_t node = gltf["nodes"].size();
    gltf["scenes"][0]["nodes"].push_back(node);
    gltf["nodes"].push_back(
        {{"name", name}, {"mesh", gltf["meshes"].size()}, {"scale", {kNodeScale, kNodeScale, kNodeScale}}});
    gltf["nodes"].back()["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] =
        add_instances(gltf, binary, members, origin, options.meters_per_unit);
    move_gltf_node(gltf["nodes"].back(), options.meters_per_unit * origin);
    gltf["meshes"].push_back({{"name", name}, {"primitives", Json::array({primitive})}});
  }
}

}  // namespace patinate
