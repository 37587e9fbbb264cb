/// \file
/// Small meshes from bytes, for algorithms that must take whatever a reader gives them.
#pragma once

#include "patinate/geometry/mesh.h"
#include "tests/fuzz/fuzz_target.h"

namespace patinate::fuzz {

/// Finite, as readers give it; everything else may be as odd as it likes. At most 24 triangles.
[[nodiscard]] Mesh any_mesh(ByteSource& source);

}  // namespace patinate::fuzz
