/// \file
/// What the module `patinate-draco` does: Draco's decoder. Debian's library holds a tinygltf of its own under the same
/// names, so that it stands apart. For the reader of glTF.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace patinate {

inline constexpr const char* kDracoEntry = "patinate_draco_1";

class DracoMesh {
 public:
  virtual ~DracoMesh() = default;
  [[nodiscard]] virtual std::uint32_t num_points() const = 0;
  [[nodiscard]] virtual std::vector<std::uint32_t> indices() const = 0;  ///< Three a triangle.
  [[nodiscard]] virtual bool has_attribute(std::uint32_t id) const = 0;
  /// All points' values of an attribute, as an accessor of this type has them.
  /// @param component_type  glTF's. @param num_components  [1, 16]. @returns nothing where it is of another type.
  [[nodiscard]] virtual std::vector<unsigned char> values(std::uint32_t id, int component_type,
                                                          int num_components) const = 0;
};

/// The module's function. @returns null for damaged data; who calls it owns the mesh.
using DecodeDraco = DracoMesh*(const unsigned char* bytes, std::size_t size);

}  // namespace patinate
