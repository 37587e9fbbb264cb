/// \file
/// The whole of transfer in one call, without files: a mesh that has the ages of a history.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "patinate/atlas/atlas_mesh.h"
#include "patinate/controls/control_kinds.h"
#include "patinate/transfer/transfer.h"

namespace patinate::transfer {

struct AgeOptions {
  int resolution = 1024;                  ///< [16, 16384]. Texels along each side of a tile.
  AtlasMethod atlas = AtlasMethod::Auto;  ///< The mesh's UVs, or new ones where they will not do.
  std::optional<double> mm_per_unit =
      {};  ///< Of the mesh; > 0. Not given: scaled so that one texel equals one pixel of the history.
  ControlKindOptions controls = {};  ///< Of the kinds that the control names.
  TransferOptions transfer = {};
};

/// A mesh and where each of its texels takes its color from, at all times.
struct AgedMesh {
  Mesh mesh;           ///< In mm, with UVs over the whole texture.
  ImageF coordinates;  ///< H x W x 2: pixel of the history; -1 outside the charts.
  ImageU8 coverage;    ///< H x W: 0 / 255.
  EnergyReport energy;
  std::shared_ptr<const History> history;  ///< That coordinates are of.

  /// The texture at a time of the history's unit (clamped to its ends): H x W x 3, linear, gutters filled.
  [[nodiscard]] ImageF texture(double time, const RunControl& control = {}) const;
};

/// @param mesh  Any that read_mesh() gives.
/// @param control  `[SOURCE=]DESTINATION[:weight[:mapping]]`, as --control: "accessibility", "thickness=0.7*facing +
/// 0.3*spray".
/// @throws ParseError if the control cannot be read; InvalidInput if the mesh cannot be textured or an option is out of
/// range; IoError.
[[nodiscard]] AgedMesh age_mesh(const std::shared_ptr<const History>& history, Mesh mesh, std::string_view control,
                                const AgeOptions& options = {}, const RunControl& run = {});

}  // namespace patinate::transfer
