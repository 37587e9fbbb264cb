/// \file
/// Transfers a material history onto a mesh: for every texel of its atlas the source coordinates of its value, once for
/// all times.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "patinate/atlas/texel_map.h"
#include "patinate/core/options.h"
#include "patinate/core/run_control.h"
#include "patinate/history/history_value.h"
#include "patinate/transfer/appearance_space.h"
#include "patinate/transfer/control_matching.h"
#include "patinate/transfer/control_spec.h"
#include "patinate/transfer/coordinate_map.h"
#include "patinate/transfer/method_options.h"

namespace patinate::transfer {

enum class TransferMethod { Fast, Reference };
inline constexpr std::array<std::string_view, 2> kTransferMethodNames{"fast", "reference"};

struct TransferOptions {
  TransferMethod method = TransferMethod::Fast;
  double coherence_share = 0.65;   ///< [0, 1]. a of the energy: 1 = texture only, 0 = control only.
  int neighborhood_radius_px = 3;  ///< [1, 5]. 3 = the 48 nearest neighbors.
  std::int64_t seed = 1;
  AppearanceOptions appearance = {};
  MultiLevelOptions multi_level = {};
  ReferenceOptions reference = {};
};
void describe(OptionVisitor& v, TransferOptions& o);

/// One control pair: where in the history, where on the mesh.
struct TransferControl {
  std::string source;       ///< Name of the history's control.
  std::string destination;  ///< What the user asked for, as text.
  ImageF values;            ///< H x W over the atlas, [0, 1].
  ControlRange range;       ///< What 0 and 1 of `values` stand for.
  double weight = 1.0;
  ControlMapping mapping = ControlMapping::Rank;
};

struct TransferResult {
  CoordinateMap coordinates;      ///< Per texel of the atlas, index into the history's pixels; -1 outside.
  ControlImage matched_controls;  ///< H x W x a channel for each control, in the history's values.
  EnergyReport energy;
  double explained_variance = 0.0;  ///< Of the history's colors, by the appearance that was compared.
};

/// What is transferred onto what.
struct TransferInput {
  std::shared_ptr<const History> history;
  std::shared_ptr<const TexelMap> map;                 ///< The destination in mm.
  double texel_size_mm = 1.0;                          ///< Surface length of one history pixel; > 0.
  std::vector<TransferControl> controls;               ///< At least one.
  std::shared_ptr<const FlowFrames> frames = nullptr;  ///< Which way the history's rows and columns run on the surface
                                                       ///< (direction_field.h); none: as the UVs do.
  ImageU8 source_mask =
      {};  ///< Of the history's size; 0 = must not be copied, as where the history's own mask is 0. Empty: only that.
  AppearanceSource appearance = {};  ///< Of the history; no result depends on it. Empty: built.
};

/// @throws InvalidInput
[[nodiscard]] TransferResult transfer(const TransferInput& input, const TransferOptions& options = {},
                                      const RunControl& control = {});

}  // namespace patinate::transfer
