/// \file
/// `study.json` (docs/schema/study.schema.json).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/patinate/study/study.h"

namespace patinate::cli {

/// Reads a study and finds all of its inputs.
/// @param folder  The study's folder: paths in commands are relative to it, and no input may lie in it.
/// @param problems  Everything that is wrong, a line each; the study is to be run only if there is none.
/// @throws IoError if the file is no JSON or of another format.
[[nodiscard]] Study read_study(const std::filesystem::path& file, const std::filesystem::path& folder,
                               std::vector<std::string>& problems);

}  // namespace patinate::cli
