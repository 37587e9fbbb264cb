/// \file
/// The JSON of a glTF or GLB file, with what tinygltf takes on trust checked. For the readers of glTF.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace patinate {

inline constexpr std::uint64_t kLargestGltf = 0xffffffffu;  ///< Bytes: tinygltf counts them in 32 bits.

/// A part of `bytes`: all of a glTF, the first chunk of a GLB. Chunks lie inside the file, and nothing is nested too
/// deeply to be parsed.
/// @param file  Named in errors. @throws IoError
[[nodiscard]] std::string_view gltf_json(const std::string& file, std::string_view bytes);

}  // namespace patinate
