#include "patinate/transfer/transfer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "libcommon/image/filters.h"
#include "transfer/exemplar/structure.h"
#include "transfer/synthesis/multi_level.h"
#include "transfer/synthesis/open_options.h"
#include "transfer/synthesis/places.h"
#include "transfer/synthesis/reference.h"
#include "transfer/synthesis/refinement.h"
#include "transfer/synthesis/source_levels.h"
#include "transfer/synthesis/transfer_controls.h"
#include "transfer/synthesis/whole_windows.h"

namespace patinate::transfer {

void describe(OptionVisitor& v, TransferOptions& o) {
  v.visit_choice({"method", "fast, or the source's own exhaustive search (slow)"}, o.method, kTransferMethodNames);
  v.visit({"coherence",
           "Weight of texture against control: 1 = texture only, 0 = control only; default 0.65, 0.85 where the source "
           "has structure (lines or regions)",
           "", between(0, 1)},
          o.coherence_share);
  v.visit({"neighborhood", "Radius of the neighborhood that is compared; 0 = 3, or 4 where the source has structure",
           "px", between(0, 5)},
          o.neighborhood_radius_px);
  v.visit_choice(
      {"quality", "Time for the borders of copied pieces, where the source has structure that they may break"},
      o.quality, kTransferQualityNames);
  v.visit_choice({"footprint", "What a texel shows that covers several pixels: their mean, or the pixel in the middle"},
                 o.footprint, kFootprintNames);
  describe(v, o.appearance);
  describe(v, o.multi_level);
  describe(v, o.reference);
}

namespace {

/// Levels from the atlas's own to the coarsest.
int usable_levels(const History& history, int halvings, const TexelMap& map, const TransferOptions& options) {
  if (options.method == TransferMethod::Reference) return 1;
  const int source_side = smallest_side(history) >> halvings;
  const int smallest = std::min({source_side, map.width(), map.height()});
  int levels = 1;
  while (levels < options.multi_level.num_levels && (smallest >> levels) >= kSmallestSide) ++levels;
  return levels;
}

/// Coordinates on a coarse level as those of the history's own pixels: the middle of what a coarse pixel covers.
CoordinateMap to_full_size(CoordinateMap coordinates, int coarse_width, int halvings, int full_width) {
  if (halvings == 0) return coordinates;
  const int middle = 1 << (halvings - 1);
  for (std::int32_t& s : coordinates) {
    if (s >= 0) s = ((s / coarse_width << halvings) + middle) * full_width + ((s % coarse_width << halvings) + middle);
  }
  return coordinates;
}

/// Texels that are covered on a coarse level but by no fine texel keep a control of their own: filled from the finer
/// level by position.
void fill_uncovered(ControlImage& coarse, const TexelMap& coarse_map, const ControlImage& fine,
                    const TexelMap& fine_map, const RunControl& control) {
  for (TexelId t = 0; t < coarse_map.num_texels(); ++t) {
    if (t % 4096 == 0) control.throw_if_stopped();
    if (!coarse_map.is_covered(t)) continue;
    const int x = static_cast<int>(t % coarse_map.width()), y = static_cast<int>(t / coarse_map.width());
    bool has_child = false;
    for (int dy = 0; dy < 2; ++dy) {
      for (int dx = 0; dx < 2; ++dx) {
        has_child |= fine.contains(2 * x + dx, 2 * y + dy) &&
                     fine_map.is_covered(TexelId{2 * y + dy} * fine_map.width() + 2 * x + dx);
      }
    }
    const TexelId near = has_child ? -1 : fine_map.texel_of(coarse_map.point(t));
    if (near < 0) continue;
    for (int c = 0; c < coarse.channels(); ++c) coarse.at(x, y, c) = fine.data()[near * fine.channels() + c];
  }
}

/// @param first  Level of the appearance that the atlas itself is matched with.
std::vector<SynthesisLevel> make_levels(const AppearanceSpace& appearance, std::size_t first,
                                        const std::vector<ImageF>& source_controls, std::vector<ImageF> matched,
                                        std::shared_ptr<const TexelMap> map, SourcePlacement placement,
                                        const Neighborhood& neighborhood, const RunControl& control) {
  std::vector<SynthesisLevel> levels;
  const std::vector<ControlImage> sources = source_control_levels(appearance, source_controls, control);
  for (std::size_t l = first; l < appearance.levels.size(); ++l, placement.step_mm *= 2.0, placement.pixel_mm *= 2.0) {
    ControlImage destination;
    if (l == first) {
      destination = interleave(matched, control);
      matched.clear();
    } else {
      auto coarse_map = std::make_shared<TexelMap>(map->halved(control));
      if (coarse_map->num_covered() == 0) break;
      const ControlImage& fine = levels.back().destination.controls;
      destination = halve(
          fine, coarse_map->width(), coarse_map->height(),
          [&](int x, int y) { return map->is_covered(TexelId{y} * map->width() + x); }, control);
      fill_uncovered(destination, *coarse_map, fine, *map, control);
      map = std::move(coarse_map);
    }
    SourceLevel source = l == first ? make_source_level(appearance.levels[l], sources[l], appearance.masks[l],
                                                        appearance.variances[l], neighborhood)
                                    : make_coarse_source_level(appearance.levels[l], sources[l], appearance.masks[l],
                                                               appearance.variances[l], neighborhood);
    if (source.usable.empty()) break;  // A coarse level is not needed.
    levels.push_back({std::move(source), cover_level(map, std::move(destination), placement)});
  }
  return levels;
}

void check_controls(const std::vector<TransferControl>& controls, const TexelMap& map) {
  if (controls.empty()) throw InvalidInput("transfer needs at least one control");
  for (const TransferControl& c : controls) {
    if (c.values.width() != map.width() || c.values.height() != map.height()) {
      throw InvalidInput("control `" + c.destination + "`: a map of " + std::to_string(c.values.width()) + " x " +
                         std::to_string(c.values.height()) + " was given; expected " + std::to_string(map.width()) +
                         " x " + std::to_string(map.height()));
    }
  }
}

void check_input(const TransferInput& input) {
  if (!input.history || !input.map) throw InvalidInput("transfer needs a history and a map of the surface");
  const HistoryFacts& facts = input.history->facts();
  check_controls(input.controls, *input.map);
  if (input.frames && input.frames->size() != input.map->mesh().triangles.size())
    throw InvalidInput("transfer: expected one frame a triangle");
  const std::int64_t num_pixels = std::int64_t{facts.width} * facts.height;
  if (num_pixels > std::numeric_limits<std::int32_t>::max())
    throw InvalidInput(input.history->label() + ": has more than 2^31 pixels; scale it down");
  if (std::max(facts.width, facts.height) > kLargestSource_px)
    throw InvalidInput(input.history->label() + ": is longer than " + std::to_string(kLargestSource_px) +
                       " pixels; scale it down");
  if (!(input.texel_size_mm > 0.0)) throw InvalidInput("texel_size_mm must be > 0");
  if (input.map->num_covered() == 0)
    throw InvalidInput("the mesh's UVs cover no texel of the atlas; use a larger --resolution");
}

/// @throws InvalidInput that says how many pixels there are, and how many are needed.
void check_large_enough(const History& history, const ImageU8& mask, int radius_px) {
  const std::int64_t num_whole = num_whole_windows(mask, radius_px), least = least_whole_windows(radius_px);
  if (num_whole >= least) return;
  const auto num_inside =
      std::count_if(mask.values().begin(), mask.values().end(), [](std::uint8_t m) { return m != 0; });
  const std::string side = std::to_string(2 * radius_px + 1);
  throw InvalidInput(history.label() + ": is too small to transfer: " + std::to_string(num_inside) + " of " +
                     std::to_string(mask.num_pixels()) + " pixels are inside the mask, " + std::to_string(num_whole) +
                     " of them with their whole neighborhood of " + side + " x " + side + ", and at least " +
                     std::to_string(least) + " are needed; give a larger mask, or a smaller --neighborhood");
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

constexpr std::array kRounds{0, 10, 32};  // By quality.

std::optional<StructureFacts> facts_of(const SourceStructure& structure) {
  if (structure.empty()) return std::nullopt;
  return StructureFacts{.kind = structure.kind,
                        .share = structure.share,
                        .scale_px = structure.scale_px,
                        .contrast_lab = structure.contrast};
}

/// The next coarser level's.
SourceStructure halved(const SourceStructure& fine, const RunControl& control) {
  SourceStructure structure = fine;
  structure.channels = downscale_area(fine.channels, std::max(1, fine.channels.width() / 2),
                                      std::max(1, fine.channels.height() / 2), control);
  structure.scale_px /= 2.0;
  return structure;
}

/// On `first`, which is the finest that is synthesized, and on the coarser ones that still show it.
std::vector<SourceStructure> structure_levels(SourceStructure structure, std::size_t first, std::size_t num_levels,
                                              const RunControl& control) {
  constexpr double kLeastScale_px = 4.0;  // Cells of less than eight pixels are not told from texture.
  if (structure.empty()) return {};
  for (std::size_t l = 0; l < first; ++l) structure = halved(structure, control);
  std::vector<SourceStructure> levels{std::move(structure)};
  while (levels.size() < num_levels && levels.back().scale_px >= 2.0 * kLeastScale_px)
    levels.push_back(halved(levels.back(), control));
  return levels;
}

/// The fast synthesis; borders are refined on every level that shows the source's structure: large cells are made whole
/// on coarse ones, lines on fine ones.
CoordinateMap synthesize_fast(std::vector<SynthesisLevel>& levels, const Neighborhood& neighborhood,
                              const std::vector<double>& weights, const std::vector<SourceStructure>& structure,
                              const TransferOptions& options, const SearchDevice* device, const RunControl& control) {
  const auto seed = static_cast<std::uint64_t>(options.seed);
  const int num_rounds = structure.empty() ? 0 : kRounds[static_cast<std::size_t>(options.quality)];
  LevelRefinement refinement;
  if (num_rounds > 0) {
    refinement.num_passes = num_rounds;
    refinement.refine = [&](std::size_t l, const SynthesisLevel& level, const SimilarPixels& similar, PlaceMap& places,
                            const RunControl& part) {
      if (l < structure.size())
        refine_places(level, structure[l], similar, weights, seed + l, {.num_rounds = num_rounds}, places, part);
    };
  }
  return std::move(synthesize_multi_level(levels, neighborhood, *options.coherence_share, weights, seed,
                                          options.multi_level, control, refinement, device)
                       .pixels);
}

}  // namespace

TransferResult transfer(const TransferInput& input, const TransferOptions& asked, const RunControl& control) {
  check_ranges(asked);
  check_input(input);
  const History& history = *input.history;
  const std::shared_ptr<const TexelMap>& map = input.map;
  TransferResult result;
  const ImageU8 mask = usable_mask(history, input.source_mask);
  MatchedControls matched = match_controls(history, mask, input.controls, map->coverage(), control.part(0.0, 0.0));
  RunControl silent = control;
  silent.on_progress = nullptr;
  TransferOptions open = asked;
  if (open.method == TransferMethod::Reference) open.appearance.structure = 0.0;  // The paper's knows none.
  const SourceStructure structure = find_structure(history, mask, open.appearance, silent);
  const TransferOptions options = with_defaults(open, !structure.empty());
  check_large_enough(history, mask, options.neighborhood_radius_px);
  result.used = options;
  result.structure = facts_of(structure);
  std::vector<double> weights;
  for (const TransferControl& c : input.controls) weights.push_back(c.weight);
  const int halvings = source_halvings(map->median_texel_size_mm(), input.texel_size_mm, smallest_side(history));
  const AppearanceSpace appearance =
      appearance_of(history, input.appearance, halvings + usable_levels(history, halvings, *map, options),
                    options.appearance, control.part(0.0, 0.3), mask);
  const auto first = std::min(static_cast<std::size_t>(halvings), appearance.levels.size() - 1);
  result.explained_variance = appearance.explained_variance;
  const Neighborhood neighborhood = Neighborhood::square(options.neighborhood_radius_px);
  const SourcePlacement placement = place_source(*map, input.frames, input.texel_size_mm, static_cast<int>(first));
  std::vector<SynthesisLevel> levels = make_levels(appearance, first, matched.source, std::move(matched.destination),
                                                   map, placement, neighborhood, silent);
  if (levels.empty()) {
    throw InvalidInput(history.label() + ": no pixel has its whole neighborhood of " +
                       std::to_string(2 * neighborhood.radius_px + 1) + " pixels inside the mask" +
                       (first > 0 ? ", halved " + std::to_string(first) + " times to the size of texels" : "") +
                       "; give a larger mask, a larger --resolution, or a smaller --neighborhood");
  }
  check_usable(history, matched.asked_histories, levels[0].source, first, 2 * neighborhood.radius_px + 1);
  const auto seed = static_cast<std::uint64_t>(options.seed);
  const RunControl synthesis_control = control.part(0.35, 0.97);
  if (options.method == TransferMethod::Reference) find_neighbors(levels[0].destination, neighborhood, silent);
  result.coordinates =
      options.method == TransferMethod::Reference
          ? synthesize_reference(levels[0].source, levels[0].destination, neighborhood, *options.coherence_share,
                                 weights, seed, options.reference, synthesis_control)
          : synthesize_fast(levels, neighborhood, weights, structure_levels(structure, first, levels.size(), silent),
                            options, input.device.get(), synthesis_control);
  result.energy = measure_energy(levels[0].source, levels[0].destination, neighborhood, result.coordinates,
                                 *options.coherence_share, weights, silent);
  result.matched_controls = std::move(levels[0].destination.controls);
  result.coordinates = to_full_size(std::move(result.coordinates), levels[0].source.width(), static_cast<int>(first),
                                    history.facts().width);
  control.report(1.0);
  return result;
}

}  // namespace patinate::transfer
