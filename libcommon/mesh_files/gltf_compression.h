/// \file
/// Geometry of a glTF that is stored compressed: KHR_draco_mesh_compression and EXT_meshopt_compression. For the
/// reader of glTF.
#pragma once

#include <string>
#include <string_view>

#include "patinate/core/json.h"

namespace tinygltf {
class Model;
}

namespace patinate {

/// The file as tinygltf reads it, which refuses buffers without bytes, though only readers without
/// EXT_meshopt_compression need them, and indices without a buffer view, though Draco's data hold them.
/// @param document  The file's JSON. @returns "" if it is so already.
[[nodiscard]] std::string loadable_gltf(std::string_view bytes, const Json& document);

/// Decodes all that is compressed into buffers of the model; afterwards every accessor finds its elements there.
/// @throws IoError naming the part whose data are damaged, or of another size than the file says.
void decompress_gltf(const std::string& file, const Json& document, tinygltf::Model& model);

}  // namespace patinate
