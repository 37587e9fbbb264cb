/// \file
/// Meshes and surfaces as the module's functions take them.
#pragma once

#include <memory>

#include "patinate/controls/control_map.h"
#include "patinate/geometry/mesh.h"
#include "patinate/transfer/age.h"

namespace patinate::python {

struct PyMesh {
  std::shared_ptr<const Mesh> value;
  std::string name = "mesh";  ///< For people: the file that it came from.
};

struct PySurface {
  transfer::AgingSurface value;
};

/// Part of an AgeOptions: what makes a surface of a mesh.
struct SurfaceKeywords {
  transfer::AgeOptions age = {};
};
inline void describe(OptionVisitor& v, SurfaceKeywords& o) { describe_surface(v, o.age); }

}  // namespace patinate::python
