/// \file
/// Meshes and surfaces as the module's functions take them.
#pragma once

#include <pybind11/pybind11.h>

#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "patinate/controls/control_map.h"
#include "patinate/geometry/mesh.h"
#include "patinate/transfer/age.h"

namespace patinate::python {

struct PyMesh {
  std::shared_ptr<const Mesh> value;
  std::string name = "mesh";  ///< For people: the file that it came from.
};

using MeshesByPath = std::map<std::filesystem::path, std::shared_ptr<const Mesh>>;
/// A scene's meshes in memory, by the path that its words lead to. @param given  None, or a dict of meshes by name.
/// @throws TypeError
[[nodiscard]] MeshesByPath meshes_from(const char* function, const pybind11::object& given,
                                       const std::filesystem::path& folder);

/// Equal for meshes of equal numbers, nodes and materials.
[[nodiscard]] std::string mesh_identity(const Mesh& mesh);

struct PySurface {
  transfer::AgingSurface value;
  bool has_unit = true;  ///< Somebody said the unit of the mesh; else its size was chosen.
};

/// Part of an AgeOptions: what makes a surface of a mesh.
struct SurfaceKeywords {
  transfer::AgeOptions age = {};
};
inline void describe(OptionVisitor& v, SurfaceKeywords& o) { describe_surface(v, o.age); }

}  // namespace patinate::python
