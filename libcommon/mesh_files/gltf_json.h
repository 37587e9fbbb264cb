/// \file
/// The JSON of a glTF or GLB file, with what tinygltf takes on trust checked. For the readers of glTF.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "patinate/core/json.h"

namespace patinate {

inline constexpr std::uint64_t kLargestGltf = 0xffffffffu;  ///< Bytes: tinygltf counts them in 32 bits.

/// A part of `bytes`: all of a glTF, the first chunk of a GLB. Chunks lie inside the file, and nothing is nested too
/// deeply to be parsed.
/// @param file  Named in errors. @throws IoError
[[nodiscard]] std::string_view gltf_json(const std::string& file, std::string_view bytes);
/// gltf_json() parsed. @throws IoError also for another version than 2, and for an extension that the file requires and
/// read_gltf() does not know, by its name.
[[nodiscard]] Json gltf_document(const std::string& file, std::string_view bytes);

/// Treatment of an extension: its geometry is read, it concerns only what is not read (materials, textures, lights,
/// descriptions), or neither.
enum class GltfExtension { Read, NotOfSurface, Unknown };
[[nodiscard]] GltfExtension gltf_extension(std::string_view name);

}  // namespace patinate
