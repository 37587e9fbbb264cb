/// \file
/// A mesh given on the command line: the file, which of its surfaces, its unit.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "libcommon/geometry/mesh.h"
#include "tools/patinate/command_line.h"

namespace patinate {

struct MeshArgument {
  std::filesystem::path path;
  std::string node;
  std::string material;
  std::string unit;  ///< mm, cm, m, or "" when not said.

  /// MESH, --node, --material, --unit.
  void declare(CommandLine& line);
  /// mm per unit of the file when --unit is given. @throws UsageError for another word.
  [[nodiscard]] std::optional<double> mm_per_unit() const;
};

/// The chosen surfaces, in the file's unit. @throws IoError; InvalidInput if it has no UVs.
[[nodiscard]] Mesh read_mesh_argument(const MeshArgument& argument);
/// Content key of a mesh: everything that is read, from however many files.
[[nodiscard]] std::string mesh_content_key(const Mesh& mesh);

}  // namespace patinate
