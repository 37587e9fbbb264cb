/// \file
/// An appearance as JSON: the member `appearance` of a capture project, or a file of its own.
#pragma once

#include <filesystem>
#include <string>

#include "libcommon/history/appearance.h"
#include "patinate/core/json.h"

namespace patinate {

/// @param json  The object. @throws IoError naming what is wrong: a number outside [0, 1], times that do not rise, a
/// material without metalness or roughness, both materials and a value of the same name, nothing at all.
[[nodiscard]] Appearance read_appearance(JsonReader json);
/// A file `patinate.appearance` (docs/schema/appearance.schema.json). @throws IoError
[[nodiscard]] Appearance read_appearance_file(const std::filesystem::path& file);

/// All that it says but the masks' names: their content counts. Equal appearances give equal texts. @throws IoError
[[nodiscard]] std::string appearance_key(const Appearance& appearance);

}  // namespace patinate
