/// \file
/// What every GLB of ours is made of: the JSON that describes its pieces, and the bytes that stand before them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "libcommon/output/glb_binary.h"
#include "patinate/core/json.h"
#include "patinate/geometry/mesh.h"

namespace patinate {

inline constexpr std::uint32_t kGlbMagic = 0x46546C67;  ///< "glTF"
inline constexpr std::uint32_t kGlbJsonChunk = 0x4E4F534A;
/// Types of numbers, and what a piece is for, as glTF writes them.
inline constexpr int kGltfFloat = 5126, kGltfUint32 = 5125, kGltfVertices = 34962, kGltfIndices = 34963;

/// The binary part in memory, for what is small. Pieces as those of GlbBinary.
class GlbBytes {
 public:
  /// @returns its number.
  int add(const void* data, std::size_t size, int target);
  template <class T>
  int add(const std::vector<T>& values, int target) {
    return add(values.data(), values.size() * sizeof(T), target);
  }
  [[nodiscard]] const std::vector<GlbBinary::View>& views() const { return views_; }
  /// All of it, and zeros up to a multiple of 4.
  [[nodiscard]] std::string padded() const;
  [[nodiscard]] std::uint64_t size() const { return bytes_.size(); }

 private:
  std::string bytes_;
  std::vector<GlbBinary::View> views_;
};

// The JSON of a GLB: nodes, meshes and materials are the caller's. Members stand where they are named first.

/// Who wrote it, in glTF's words.
[[nodiscard]] Json gltf_asset();
/// `count` elements of a shape ("SCALAR", "VEC3") in the piece `view`. @returns its number.
int add_gltf_accessor(Json& gltf, int view, int type, std::size_t count, const char* shape);
/// x, y, z of every vertex, with their bounds. @param positions  Not empty.
int add_gltf_positions(Json& gltf, int view, const std::vector<float>& positions);
/// Says where a node's origin lies, in meters; nothing where it lies in the scene's.
void move_gltf_node(Json& node, const Vec3& translation);
/// All that stands before the binary part, which is padded to a multiple of 4. Adds the views, the buffer, and the
/// asset where it is missing.
/// @param subject  Of the error. @throws InvalidInput if a name is not UTF-8, or the file would exceed 4 GB.
[[nodiscard]] std::string glb_head(Json& gltf, const std::vector<GlbBinary::View>& views, std::uint64_t binary_size,
                                   const std::string& subject);

}  // namespace patinate
