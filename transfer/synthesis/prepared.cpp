#include "transfer/synthesis/prepared.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "libcommon/core/parallel.h"
#include "libcommon/image/filters.h"
#include "transfer/exemplar/directedness.h"
#include "transfer/synthesis/open_options.h"
#include "transfer/synthesis/pyramid.h"
#include "transfer/synthesis/refinement.h"
#include "transfer/synthesis/source_levels.h"
#include "transfer/synthesis/transfer_controls.h"

namespace patinate::transfer {

namespace {

constexpr double kPlainScale_px = 16.0;  // Half of a window that a source without cells is cut in.

/// The next coarser level's.
SourceStructure halved(const SourceStructure& fine, const RunControl& control) {
  SourceStructure structure = fine;
  if (!fine.empty())
    structure.channels = downscale_area(fine.channels, std::max(1, fine.channels.width() / 2),
                                        std::max(1, fine.channels.height() / 2), control);
  structure.scale_px /= 2.0;
  return structure;
}

/// On every level that is refined; no rounds for drafts. The best quality refines sources without structure as well.
RefinementOptions refinement_options(const SourceStructure& structure, TransferQuality quality) {
  constexpr std::array kRounds{0, 10, 32};  // Rounds of draft, good and best (docs/algorithms/refinement.md).
  // Without lines nothing is lost where a control is followed more closely: three times as closely keeps the control
  // error of the search on rust and copper, in pieces four times as large.
  constexpr RefinementOptions kPlain{.num_rounds = 10, .control_share = 1.5};
  if (!structure.empty()) return {.num_rounds = kRounds[static_cast<std::size_t>(quality)]};
  return quality == TransferQuality::Best ? kPlain : RefinementOptions{.num_rounds = 0};
}

/// How many levels are refined, the finest among them: those that show cells of the structure's size.
std::size_t num_refined_levels(const SourceStructure& structure, TransferQuality quality) {
  constexpr double kMinScale_px = 4.0;  // Cells of less than eight pixels are not told from texture.
  if (refinement_options(structure, quality).num_rounds == 0) return 0;
  std::size_t levels = 1;
  for (double scale_px = structure.empty() ? kPlainScale_px : structure.scale_px; scale_px >= 2.0 * kMinScale_px;
       scale_px /= 2.0)
    ++levels;
  return levels;
}

/// On `first`, which is the finest that is synthesized, and on the coarser ones that are refined; without channels
/// where the source has no structure.
/// @param num_levels  At most so many.
std::vector<SourceStructure> structure_levels(SourceStructure structure, TransferQuality quality, std::size_t first,
                                              std::size_t num_levels, const RunControl& control) {
  if (structure.empty()) {
    structure = {.channels = {}, .scale_px = std::ldexp(kPlainScale_px, static_cast<int>(first))};
  }
  for (std::size_t l = 0; l < first; ++l) structure = halved(structure, control);
  const std::size_t count = std::min(num_refined_levels(structure, quality), std::max<std::size_t>(1, num_levels));
  std::vector<SourceStructure> levels;
  while (levels.size() < count) levels.push_back(levels.empty() ? structure : halved(levels.back(), control));
  return levels;
}

void check_controls(const std::vector<TransferControl>& controls, const TexelMap& map, const RunControl& silent) {
  if (controls.empty()) throw InvalidInput("transfer needs at least one control");
  for (const TransferControl& c : controls) {
    if (c.values.width() != map.width() || c.values.height() != map.height()) {
      throw InvalidInput("control `" + c.destination + "`: a map of " + std::to_string(c.values.width()) + " x " +
                         std::to_string(c.values.height()) + " was given; expected " + std::to_string(map.width()) +
                         " x " + std::to_string(map.height()));
    }
    if (!(c.weight >= 0.0) || !std::isfinite(c.weight))
      throw InvalidInput("control `" + c.destination + "`: its weight must be a number >= 0");
    constexpr std::int64_t kTexels = 1 << 20;
    parallel_for(map.num_texels(), kTexels, silent, [&](TexelId begin, TexelId end) {
      for (TexelId t = begin; t < end; ++t) {
        if (std::isfinite(c.values.data()[t]) || !map.is_covered(t)) continue;
        throw InvalidInput("control `" + c.destination + "`: texel (" + std::to_string(t % map.width()) + ", " +
                           std::to_string(t / map.width()) + ") holds NaN or infinity");
      }
    });
  }
}

void check_input(const TransferInput& input, const RunControl& silent) {
  if (!input.history || !input.map) throw InvalidInput("transfer needs a history and a map of the surface");
  const HistoryFacts& facts = input.history->facts();
  check_controls(input.controls, *input.map, silent);
  if (input.frames && input.frames->size() != input.map->mesh().triangles.size())
    throw InvalidInput("transfer: expected one frame a triangle");
  if (input.frames &&
      !std::all_of(input.frames->begin(), input.frames->end(), [](const FlowFrame& f) { return f.allFinite(); }))
    throw InvalidInput("transfer: a frame of the flow holds NaN or infinity");
  const std::int64_t num_pixels = std::int64_t{facts.width} * facts.height;
  if (num_pixels > std::numeric_limits<std::int32_t>::max())
    throw InvalidInput(input.history->label() + ": has more than 2^31 pixels; scale it down");
  if (std::max(facts.width, facts.height) > kLargestSource_px)
    throw InvalidInput(input.history->label() + ": is longer than " + std::to_string(kLargestSource_px) +
                       " pixels; scale it down");
  if (!(input.texel_size_mm > 0.0) || !std::isfinite(input.texel_size_mm))
    throw InvalidInput("texel_size_mm must be > 0");
  if (input.map->num_covered() == 0)
    throw InvalidInput("the mesh's UVs cover no texel of the atlas; use a larger --resolution");
}

/// Histories of a library that are asked for can be copied from. @param first  The level is halved as often.
void check_usable(const History& history, const std::vector<std::size_t>& asked, const SourceLevel& level,
                  std::size_t first, int window_px) {
  const std::vector<LibraryPart>& parts = history.facts().parts;
  for (std::size_t p : asked) {
    const LibraryPart& part = parts[p];
    const auto is_of_part = [&](std::int32_t pixel) {
      return pixel % level.width() >= part.x >> first && pixel % level.width() < (part.x + part.width) >> first;
    };
    if (std::any_of(level.usable.begin(), level.usable.end(), is_of_part)) continue;
    throw InvalidInput(history.label() + ": no pixel of its history " + std::to_string(p) + " (" + part.name +
                       ") has its whole neighborhood of " + std::to_string(window_px) +
                       " pixels inside the mask; give a larger mask, or a smaller --neighborhood");
  }
}

/// Whether pieces are turned. Mirrored frames of UVs do not know turns.
PieceTurning turning_of(const TransferInput& input, const SourceStructure& structure, const ImageU8& mask,
                        const TransferOptions& options, const RunControl& control) {
  const bool has_lines = !structure.empty() && structure.kind != StructureKind::Regions;
  if (!has_lines || !input.frames || options.method != TransferMethod::Fast || options.turning == PieceTurning::Never)
    return PieceTurning::Never;
  const bool is_free = options.turning == PieceTurning::Free || directedness(*input.history, mask, control) < kDirected;
  return is_free ? PieceTurning::Free : PieceTurning::Never;
}

/// For progress: what the appearance takes of the time, which grows with the history, where synthesis grows with the
/// texels. Measured on 24 frames of 512 x 512 and 12 of 256 x 256 pixels, 128 x 128 and 512 x 512 texels.
double appearance_share(const History& history, std::int64_t num_texels) {
  // Measured times of reading and synthesis; they divide the progress bar alone.
  constexpr double kPixelSeconds = 4e-7, kTexelSeconds = 3e-4, kMost = 0.3;
  const double pixels = static_cast<double>(history.facts().width) * history.facts().height * history.num_frames();
  const double appearance = kPixelSeconds * pixels, synthesis = kTexelSeconds * static_cast<double>(num_texels);
  return std::min(kMost, appearance / (appearance + synthesis));
}

}  // namespace

std::vector<SourceStructure> refined_structures(const PreparedTransfer& prepared, const RunControl& control) {
  return structure_levels(prepared.structure, prepared.used.quality, prepared.first, prepared.levels.size(), control);
}

LevelRefinement refinement_of(const std::vector<SourceStructure>& structures, const TransferOptions& options,
                              const std::vector<double>& weights, const std::vector<TexelSet>* region) {
  if (structures.empty()) return {};
  const RefinementOptions refined = refinement_options(structures.front(), options.quality);
  const auto seed = static_cast<std::uint64_t>(options.seed);
  const auto refine = [=, &structures, &weights](std::size_t l, const SynthesisLevel& level,
                                                 const SimilarPixels& similar, PlaceMap& places,
                                                 const RunControl& control) {
    if (l >= structures.size()) return;
    refine_places(level, structures[l], similar, weights, seed + l, refined, places, control,
                  region == nullptr ? nullptr : &(*region)[l]);
  };
  return {.refine = refine, .num_passes = static_cast<double>(refined.num_rounds), .num_levels = structures.size()};
}

PreparedTransfer prepare_transfer(const TransferInput& input, const TransferOptions& asked, const RunControl& control) {
  check_ranges(asked);
  const RunControl silent = control.silent();
  check_input(input, silent);
  const History& history = *input.history;
  const std::shared_ptr<const TexelMap>& map = input.map;
  PreparedTransfer made;
  made.source_width = history.facts().width;
  const ImageU8 mask = usable_mask(history, input.source_mask);
  MatchedControls matched = match_controls(history, mask, input.controls, map->coverage(), control.part(0.0, 0.0));
  TransferOptions open = asked;
  if (open.method == TransferMethod::Reference) open.appearance.structure = 0.0;  // The paper's knows none.
  made.structure = find_structure(history, mask, open.appearance, silent);
  made.used = with_defaults(open, !made.structure.empty(), !history.facts().parts.empty());
  made.used.turning = turning_of(input, made.structure, mask, open, silent);
  check_large_enough(history, mask, made.used.neighborhood_radius_px);
  for (const TransferControl& c : input.controls) made.weights.push_back(c.weight);
  made.progress_share = appearance_share(history, map->num_covered());
  const int halvings = source_halvings(map->median_texel_size_mm(), input.texel_size_mm, smallest_side(history));
  const AppearanceSpace appearance = appearance_of(
      history, input.appearance, halvings + usable_levels(history, halvings, map->width(), map->height(), made.used),
      made.used.appearance, control.part(0.0, made.progress_share), mask);
  made.first = std::min(static_cast<std::size_t>(halvings), appearance.levels.size() - 1);
  made.explained_variance = appearance.explained_variance;
  made.neighborhood = Neighborhood::square(made.used.neighborhood_radius_px);
  SourcePlacement placement = place_source(*map, input.frames, input.texel_size_mm, static_cast<int>(made.first));
  if (made.used.turning == PieceTurning::Free)
    placement.turns = std::make_shared<const FrameTurns>(map->mesh(), *placement.frames);
  ControlImage targets = interleave(matched.destination, silent);
  matched.destination.clear();
  append_levels(made.levels, appearance, made.first, source_control_levels(appearance, matched.source, silent),
                std::move(targets), map, placement, made.neighborhood, silent);
  const int window_px = 2 * made.neighborhood.radius_px + 1;
  if (made.levels.empty()) {
    throw InvalidInput(
        history.label() + ": no pixel has its whole neighborhood of " + std::to_string(window_px) +
        " pixels inside the mask" +
        (made.first > 0 ? ", halved " + std::to_string(made.first) + " times to the size of texels" : "") +
        "; give a larger mask, a larger --resolution, or a smaller --neighborhood");
  }
  check_usable(history, matched.asked_histories, made.levels[0].source, made.first, window_px);
  return made;
}

}  // namespace patinate::transfer
