/// \file
/// Transforms of photographs that are known already: `alignment.json`, which an ingest writes and a project names.
#pragma once

#include <filesystem>
#include <string>

#include "capture/project/capture_project.h"

namespace patinate::capture {

/// Name of the file in a history, which `transforms` of a project may name.
inline constexpr const char* kAlignmentFile = "alignment.json";

/// The frame whose photo_names() name or file name is `name`.
/// @param what  What names it. @throws IoError naming the project if there is none, or several.
[[nodiscard]] int find_photo(const CaptureProject& project, const std::string& name, const std::string& what);

/// Sets the transforms of the photographs that a file of kAlignmentFile's format places, unless a frame has one of its
/// own; and the reference, unless `align_to` says it. Photographs that the project has not are passed over.
/// @throws IoError
void read_transforms(const std::filesystem::path& file, CaptureProject& project);

}  // namespace patinate::capture
