/// \file
/// A scene as an argument: a file, or what would stand in one, with meshes in memory.
#pragma once

#include <pybind11/pybind11.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "libcommon/core/temporary_file.h"
#include "patinate/core/json.h"
#include "patinate/core/run_control.h"
#include "patinate/simulation/scene_io.h"
#include "python/support/keywords.h"
#include "python/support/signature.h"
#include "python/surface/py_surface.h"

namespace patinate::python {

struct SceneArgument {
  std::filesystem::path file;        ///< Of a dict what messages call it, in the folder that its paths lead from.
  std::shared_ptr<const Json> root;  ///< A dict's content; null of a file.
  MeshesByPath meshes;               ///< In memory, by the path that the scene names.

  /// @throws IoError naming file and JSON pointer
  [[nodiscard]] simulation::SceneFile read(const RunControl& control) const;
  /// The file, or one in a folder of its own that says the same. @param room  That folder, for the time of the work.
  /// @throws as read().
  [[nodiscard]] std::filesystem::path written(std::optional<TemporaryFolder>& room, const RunControl& control) const;
};

inline constexpr const char* kSceneType = "str | os.PathLike[str] | Mapping[str, Any]";
/// Says `folder` and `meshes`.
FunctionText& scene_text(FunctionText& text);
/// @param keywords  Of the call; `folder` and `meshes` are taken. @throws TypeError
[[nodiscard]] SceneArgument scene_from(const char* function, const pybind11::object& scene, Keywords& keywords);

}  // namespace patinate::python
