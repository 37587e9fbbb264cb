/// \file
/// The files that a scene names: where its file says so, and a copy of all of them that a result keeps.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "patinate/core/json.h"

namespace patinate::simulation {

/// Calls `visit` with every path of a scene file that has been read: meshes, pictures (appearance, presets, maps of
/// objects), files of rules.
void for_each_scene_path(Json& root, const std::function<void(Json& path)>& visit);
/// A path of a file in `from` as one in `to` says it; what is no relative path stays. Both absolute.
void move_scene_path(Json& path, const std::filesystem::path& from, const std::filesystem::path& to);

/// A scene with what it names beside it, so that it can be read anywhere.
struct SceneCopy {
  struct File {
    std::filesystem::path from;
    std::filesystem::path to;  ///< Below the copy's folder.
    std::string key;           ///< Key of its bytes.
  };
  std::filesystem::path name;  ///< Name of the scene file in the copy's folder: as it was called.
  std::string text;            ///< Text of the scene file; its paths lead to `files`.
  std::vector<File> files;
  std::vector<std::string> excluded;  ///< Files that are not copied and stay where they are: too large, or named by a
                                      ///< glTF in a way that no copy can keep.
};

inline constexpr std::uint64_t kMaxSceneBytes =
    std::uint64_t{1} << 30;  ///< Limit of all files of a copy; what would pass it is excluded.

/// Names depend on the scene alone, not on where its files lie. @param scene  The scene file, read before without an
/// error.
/// @param root  Its content. @param folder  Where the copy will stand; what is excluded is named from there. @throws
/// IoError
[[nodiscard]] SceneCopy plan_scene_copy(const std::filesystem::path& scene, const Json& root,
                                        const std::filesystem::path& folder, std::uint64_t most_bytes = kMaxSceneBytes);
/// Makes the folder and writes it. @throws CannotComplete, also where a file is not as it was when the copy was
/// planned.
void write_scene_copy(const SceneCopy& copy, const std::filesystem::path& folder);

}  // namespace patinate::simulation
