/// \file
/// A first capture project from what lies in a folder.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace patinate::capture {

struct ProjectDraft {
  std::string text;                   ///< A capture.json, plain.
  std::vector<std::string> hints;     ///< Meaning of its members, and which others there are; one line each.
  std::vector<std::string> found;     ///< Findings, one line each.
  std::vector<std::string> to_check;  ///< Guesses and exclusions to check, one line each.
};

/// Looks at the images and movies in `folder` and in the folders directly in it. The frames are all photographs, which
/// share folder, format and size, or a movie; a back-light photograph, its blank and a mask are known by their names.
/// Times come from dates in the names or EXIF, else an interval of 1 stands in their place.
/// @param project_folder  Where the project will lie: paths in it are relative to that.
/// @param only  Names (or paths from `folder` on) of the frames, with `*` and `?`; "" = all.
/// @throws IoError if the folder cannot be listed, holds no photographs, or more than one set of them: it lists the
/// sets.
[[nodiscard]] ProjectDraft draft_capture_project(const std::filesystem::path& folder,
                                                 const std::filesystem::path& project_folder,
                                                 const std::string& only = "");

}  // namespace patinate::capture
