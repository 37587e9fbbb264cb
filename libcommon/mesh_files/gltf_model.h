/// \file
/// glTF and GLB files as tinygltf has them. For the reader of glTF.
#pragma once

#include <filesystem>
#include <memory>

#include "patinate/core/json.h"

namespace tinygltf {
class Model;
}

namespace patinate {

/// The model with its buffers, which are read as everything else is; pictures are not.
/// @param document  Becomes the file's JSON. @throws IoError as gltf_document(); and what tinygltf finds, in one line.
[[nodiscard]] std::unique_ptr<tinygltf::Model> load_gltf_model(const std::filesystem::path& path, Json& document);

}  // namespace patinate
