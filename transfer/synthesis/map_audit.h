/// \file
/// The audit of a finished coordinate map against the history that it shows, from any tool.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "patinate/atlas/texel_map.h"
#include "patinate/history/history_value.h"
#include "patinate/image/image.h"
#include "patinate/transfer/transfer.h"
#include "transfer/synthesis/audit.h"

namespace patinate::transfer {

/// Target that a map was to follow.
struct FollowedControl {
  std::string source;  ///< Name of the history's control.
  ImageF wanted;       ///< H x W x 1, in the history's values.
  double weight = 1.0;
};

/// A coordinate map and the surface that it covers.
struct MapToAudit {
  std::shared_ptr<const TexelMap> surface;  ///< In mm.
  ImageF coordinates;  ///< H x W x 2: pixels of the history, rounded to whole ones; what is outside it counts as none.
  double pixel_mm = 1.0;                               ///< Surface length of one pixel of the history.
  std::vector<FollowedControl> controls;               ///< At least one.
  std::shared_ptr<const FlowFrames> frames = nullptr;  ///< Frames as TransferInput's.
  std::vector<std::int16_t> turns = {};                ///< Turns as SourcePlace's; empty: all 0.
  ImageU8 source_mask = {};  ///< Pixels that could be copied, instead of the history's mask; empty: that.
};

/// Measures as transfer() does: with its appearance, on the level whose pixels are as large as texels. Of an atlas of
/// several tiles, texels are counted tile by tile.
/// @param options  Coherence share, neighborhood and appearance, open ones as transfer() chooses; nothing
/// else of them counts. @param appearance  As
/// TransferInput's.
/// @throws InvalidInput if sizes do not fit. Audits nothing where no pixel has its whole neighborhood in the mask.
[[nodiscard]] OptimumAudit audit_map(const History& history, const MapToAudit& made, const TransferOptions& options,
                                     std::int64_t num_audits, std::uint64_t seed, const RunControl& control = {},
                                     const AppearanceSource& appearance = {});

}  // namespace patinate::transfer
