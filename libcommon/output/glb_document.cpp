#include "libcommon/output/glb_document.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "patinate/core/error.h"

namespace patinate {

namespace {

constexpr std::uint32_t kBinaryChunk = 0x004E4942;

std::uint64_t padded_size(std::uint64_t size) { return (size + 3) / 4 * 4; }

void append_u32(std::string& bytes, std::uint64_t value) {
  for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>((value >> shift) & 0xFF);
}

}  // namespace

int GlbBytes::add(const void* data, std::size_t size, int target) {
  bytes_.resize(padded_size(bytes_.size()));
  views_.push_back({.offset = bytes_.size(), .size = size, .target = target});
  bytes_.append(static_cast<const char*>(data), size);
  return static_cast<int>(views_.size()) - 1;
}

std::string GlbBytes::padded() const {
  std::string bytes = bytes_;
  bytes.resize(padded_size(bytes.size()));
  return bytes;
}

Json gltf_asset() { return {{"version", "2.0"}, {"generator", "patinate"}}; }

int add_gltf_accessor(Json& gltf, int view, int type, std::size_t count, const char* shape) {
  gltf["accessors"].push_back({{"bufferView", view}, {"componentType", type}, {"count", count}, {"type", shape}});
  return static_cast<int>(gltf["accessors"].size()) - 1;
}

int add_gltf_positions(Json& gltf, int view, const std::vector<float>& positions) {
  const int index = add_gltf_accessor(gltf, view, kGltfFloat, positions.size() / 3, "VEC3");
  std::array<float, 3> low = {positions[0], positions[1], positions[2]}, high = low;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    low[i % 3] = std::min(low[i % 3], positions[i]);
    high[i % 3] = std::max(high[i % 3], positions[i]);
  }
  gltf["accessors"].back()["min"] = low;
  gltf["accessors"].back()["max"] = high;
  return index;
}

void move_gltf_node(Json& node, const Vec3& translation) {
  if (!translation.isZero(0.0)) node["translation"] = {translation.x(), translation.y(), translation.z()};
}

std::string glb_head(Json& gltf, const std::vector<GlbBinary::View>& views, std::uint64_t binary_size,
                     const std::string& subject) {
  if (!gltf.contains("asset")) gltf["asset"] = gltf_asset();
  if (!views.empty()) gltf["bufferViews"] = Json::array();
  for (const GlbBinary::View& view : views) {
    gltf["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", view.offset}, {"byteLength", view.size}});
    if (view.target != 0) gltf["bufferViews"].back()["target"] = view.target;
  }
  gltf["buffers"] = Json::array({{{"byteLength", binary_size}}});
  std::string text;
  try {
    text = gltf.dump();
  } catch (const nlohmann::json::exception&) {
    throw InvalidInput("glb: a name is not UTF-8");
  }
  text.resize(padded_size(text.size()), ' ');
  const std::uint64_t total = 12 + 8 + text.size() + 8 + padded_size(binary_size);
  if (total > 0xFFFFFFFFu)
    throw InvalidInput(subject + ": would be more than 4 GB; use smaller textures or fewer variants");
  std::string head;
  append_u32(head, kGlbMagic);
  append_u32(head, 2);
  append_u32(head, total);
  append_u32(head, text.size());
  append_u32(head, kGlbJsonChunk);
  head += text;
  append_u32(head, padded_size(binary_size));
  append_u32(head, kBinaryChunk);
  return head;
}

}  // namespace patinate
