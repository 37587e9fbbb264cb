/// \file
/// How commands are told which mesh, which of its surfaces, its unit and its atlas.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "libcommon/atlas/texel_map.h"
#include "libcommon/geometry/mesh.h"
#include "tools/patinate/command_line.h"

namespace patinate {

struct MeshSource {
  std::filesystem::path path;
  std::string unit;      ///< "" = not said.
  std::string node;      ///< "" = all.
  std::string material;  ///< "" = all.
  /// What was said; "m" for glTF. @throws UsageError if the unit is none.
  [[nodiscard]] std::optional<std::string> unit_or_none() const;
};

/// Declares MESH, --unit, --node and --material.
void declare_mesh(CommandLine& line, MeshSource& source);
/// The chosen surfaces, with normals, in the file's unit. UVs that leave [0, 1] by up to a quarter are scaled into it. @throws IoError
[[nodiscard]] Mesh load_mesh(const MeshSource& source);
/// "um", "mm", "cm", "m". @throws UsageError
[[nodiscard]] double mm_per_unit(const std::string& unit);

struct AtlasOptions {
  int resolution = 1024;  ///< Texels along each side of the atlas; [16, 16384].
};
void describe(OptionVisitor& v, AtlasOptions& o);

/// Errors name the file.
[[nodiscard]] TexelMap make_texel_map(const std::filesystem::path& path, const Mesh& mesh, const AtlasOptions& atlas, const RunControl& control = {});

}  // namespace patinate
