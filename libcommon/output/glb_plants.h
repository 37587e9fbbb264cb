/// \file
/// Plants of a GLB as instances.
#pragma once

#include "libcommon/output/glb_binary.h"
#include "patinate/core/json.h"
#include "patinate/output/glb.h"

namespace patinate {

/// Nodes, meshes and materials for GlbOptions::plants, after all others: one of each for plants of like color that show
/// in the same variants. In variants where they do not show, their material is cut away whole.
/// @param gltf    With extensionsUsed, scene 0, nodes, meshes and materials.
/// @param origin  Of coordinates in single precision, in the mesh's unit (model_origin()).
void add_glb_plants(Json& gltf, GlbBinary& binary, const GlbOptions& options, const Vec3& origin, int num_variants);

}  // namespace patinate
