/// \file
/// Pictures of how a surface has aged, brought onto its atlas: an image on its UVs, a photograph with its camera, a
/// history, transfer or simulation.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>

#include "analysis/explanation/explanation_job.h"
#include "app/mesh/mesh_source.h"
#include "patinate/atlas/texel_map.h"

namespace patinate::cli {

enum class AgedEnd { High, Low };

/// Options on which part of a picture says how aged a place is, and where.
struct ReferenceOptions {
  std::string channel;  ///< "" = change where there is a before, else luminance.
  std::string before;   ///< An image of the same kind; "" = none, or a history's first frame.
  AgedEnd aged = AgedEnd::High;
  std::string mask;            ///< 8-bit image on the UVs; "" = everywhere.
  std::string camera;          ///< Camera of a photograph; "" = the picture lies on the UVs.
  std::optional<double> time;  ///< Time of a history; not given: the last frame's.
};
void describe(OptionVisitor& v, ReferenceOptions& o);

/// Whether the picture needs the mesh's own UVs: no photograph, and no history that knows its positions.
/// @throws IoError if it is none of them.
[[nodiscard]] bool lies_on_uvs(const std::filesystem::path& reference, const ReferenceOptions& options);

/// @param map  In mm. @param mm  Per unit of the mesh, for the camera.
/// @throws IoError, InvalidInput, UsageError: what is wrong and what would be right.
[[nodiscard]] analysis::SurfaceReference read_surface_reference(const std::filesystem::path& reference,
                                                                const ReferenceOptions& options, const TexelMap& map,
                                                                double mm, const RunControl& control);

}  // namespace patinate::cli
