/// \file
/// What the pieces of a transfer by tile begin with.
#pragma once

#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "patinate/transfer/appearance_space.h"
#include "transfer/synthesis/levels.h"
#include "transfer/synthesis/similar_pixels.h"
#include "transfer/tiles/tile_halo.h"
#include "transfer/tiles/tiled_transfer.h"

namespace patinate::transfer {

/// What follows from the history, the mesh and the texels counted.
struct TiledTransfer::Prepared {
  TransferOptions options;
  std::optional<StructureFacts> structure;
  double refused_line_share = 0.0;
  std::vector<double> weights;
  Neighborhood neighborhood;
  std::shared_ptr<TexelMap> map;  ///< With its figures; nothing was looked at.
  std::size_t first = 0;          ///< Level of the appearance that the atlas is matched with.
  AppearanceSpace appearance;
  std::vector<ControlImage> source_controls;
  SourcePlacement placement;  ///< On level 0.
  std::vector<SourceLevel> sources;
  std::vector<SourceStructure> structures;  ///< Of the finest levels that show it.

  [[nodiscard]] SourcePlacement placement_on(std::size_t level) const {
    SourcePlacement on = placement;
    on.step_mm = std::ldexp(on.step_mm, static_cast<int>(level));
    on.pixel_mm = std::ldexp(on.pixel_mm, static_cast<int>(level));
    return on;
  }
  [[nodiscard]] std::shared_ptr<const TexelMap> map_on(std::size_t level, const RunControl& control) const {
    auto on = std::make_shared<TexelMap>(map->unsearched(control));
    for (std::size_t l = 0; l < level; ++l)
      on = std::make_shared<TexelMap>(on->halved(control, TexelFinding::WhereLooked));
    return on;
  }
  [[nodiscard]] NeighborFinder finder_on(std::size_t level, const TexelMap& on, const RunControl& control) const {
    const SourcePlacement place = placement_on(level);
    std::vector<Vec2> offsets_mm;
    for (const Offset& o : neighborhood.offsets) offsets_mm.emplace_back(o.x * place.step_mm, o.y * place.step_mm);
    return [=, &on](const TexelPart& part) {
      return TexelNeighborhood(on, offsets_mm, place.frames, place.pixel_mm, part, control);
    };
  }
  /// Without neighbors. @param part  Its targets are there.
  [[nodiscard]] SynthesisLevel level_of(std::size_t level, std::shared_ptr<const TexelMap> on,
                                        std::shared_ptr<const LevelPart> part, const RunControl& control) const {
    SynthesisLevel result{.source = sources[level], .destination = {}};
    DestinationLevel& d = result.destination;
    d.texels = TexelSet(
        on->num_texels(), on->width(), part->rect, {}, [&](TexelId t) { return on->is_covered(t); }, control);
    d.map = std::move(on);
    d.placement = placement_on(level);
    d.part = std::move(part);
    return result;
  }
};

/// Of the level, as synthesize_coarse() wrote them.
[[nodiscard]] SimilarPixels read_similar(const std::filesystem::path& folder, std::size_t level);

}  // namespace patinate::transfer
