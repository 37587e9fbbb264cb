/// \file
/// Scene files (`patinate.scene`, docs/simulation.md) and everything they name: meshes, pictures, rules.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "patinate/core/json.h"
#include "patinate/core/run_control.h"
#include "patinate/history/history.h"
#include "patinate/simulation/scene.h"

namespace patinate::simulation {

/// A scene as a file says it, and how long it runs.
struct SceneFile {
  std::filesystem::path file;
  std::string name;  ///< Of the file, without extension.
  Scene scene;
  double mm_per_unit = 1000.0;  ///< Of the file's lengths.
  TimeUnit time_unit = TimeUnit::Days;
  std::int64_t iterations = 1000;    ///< >= 0; none: what is painted at the start.
  std::int64_t history_every = 100;  ///< >= 1.
  std::vector<std::string>
      controls;  ///< Parameter maps asked for: "hits", "last_hit", "rust.deposited", "rust.final", ...
  std::vector<std::pair<std::string, std::filesystem::path>> inputs;  ///< Role and path of every file that was read.
  std::vector<std::string> notes;  ///< What a user should know: repaired or unwrapped meshes, open and inside-out ones.

  /// Says whether a frame of the history is due after this iteration: every `history_every`, and at the end.
  [[nodiscard]] bool is_frame(std::int64_t iteration) const {
    return iteration % history_every == 0 || iteration == iterations;
  }
  /// In `time_unit`, with 12 digits; in a scene whose iterations take no time frames still have an order.
  [[nodiscard]] double frame_time(std::int64_t iteration) const;
};

/// A mesh of a scene with UVs in one square.
struct LaidOutMesh {
  Mesh mesh;                 ///< mm.
  bool has_file_uvs = true;  ///< SceneObject::has_file_uvs.
};

/// Meshes and pictures that were read once, for reading many variants of a scene. Thread-safe.
struct SceneAssets {
  std::mutex mutex = {};
  std::map<std::string, LaidOutMesh> meshes =
      {};  ///< By path, selection, atlas and resolution; mm, laid out on the sheet.
  std::map<std::string, ImageF> pictures = {};  ///< By path and number of channels.
  /// In place of files, by the path that the scene's words lead to: in the scene's unit.
  std::map<std::filesystem::path, std::shared_ptr<const Mesh>> given_meshes = {};
};

/// Reads and checks a scene (check_scene()), its meshes and its pictures. Lengths become mm, colors linear.
/// @throws IoError naming file and JSON pointer (unknown key, wrong type, out of range), mesh or picture; InvalidInput.
[[nodiscard]] SceneFile read_scene(const std::filesystem::path& path, const RunControl& control = {});
/// The same of a scene in memory. @param path  What it is called in errors; paths in it are relative to its folder.
/// @param assets  Taken from when there, and added to; notes about meshes are of the first reading only.
[[nodiscard]] SceneFile read_scene(const std::filesystem::path& path, const Json& as_written, SceneAssets& assets,
                                   const RunControl& control = {});

}  // namespace patinate::simulation
