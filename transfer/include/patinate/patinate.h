/// \file
/// The front door: what a program needs to age a mesh, save it and look at it, under short names. Every part of it is
/// described in its own header; a simulation, a capture and a comparison are in `patinate/simulation`,
/// `patinate/capture` and `patinate/analysis`.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "patinate/controls/control_kinds.h"
#include "patinate/core/error.h"
#include "patinate/history/history.h"
#include "patinate/history/memory_history.h"
#include "patinate/history/write_history.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/mesh_io.h"
#include "patinate/transfer/age.h"

namespace patinate {

using transfer::AgedMesh;
using transfer::AgeOptions;
using transfer::AgingSurface;
using transfer::make_aging_surface;
using transfer::read_aged_mesh;

/// @param path  A history folder, or its history.json. @throws IoError naming the file.
[[nodiscard]] std::shared_ptr<const History> read_history(const std::filesystem::path& path);

/// Computes a control at every texel. (rest unchanged)
[[nodiscard]] ControlMap control(const AgingSurface& surface, std::string_view expression, const RunControl& run = {});

/// A control of the history, and what it is on the surface.
using ControlPair = std::pair<std::string, ControlMap>;

/// Ages a surface as the history aged where the controls are alike: the short form of transfer::age_surface().
/// @param controls  At least one; the maps have the size of the surface's texture.
/// @throws InvalidInput if the history has no such control, a map has another size or an option is out of range.
[[nodiscard]] AgedMesh age(const std::shared_ptr<const History>& history, const AgingSurface& surface,
                           const std::vector<ControlPair>& controls, const transfer::TransferOptions& options = {},
                           const RunControl& run = {});

}  // namespace patinate
