#include "patinate/transfer/transfer.h"

#include <cstddef>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "patinate/core/run_control.h"
#include "transfer/exemplar/structure.h"
#include "transfer/synthesis/multi_level.h"
#include "transfer/synthesis/open_options.h"
#include "transfer/synthesis/places.h"
#include "transfer/synthesis/prepared.h"
#include "transfer/synthesis/pyramid.h"
#include "transfer/synthesis/reference.h"

namespace patinate::transfer {

namespace {

/// The fast synthesis; borders are refined on every level that shows the source's structure: large cells are made whole
/// on coarse ones, lines on fine ones.
PlaceMap synthesize_fast(PreparedTransfer& prepared, const std::vector<SourceStructure>& structures,
                         const SearchDevice* device, std::unique_ptr<SearchDevice::Level>& kept,
                         const RunControl& control) {
  const TransferOptions& options = prepared.used;
  return synthesize_multi_level(prepared.levels, prepared.neighborhood, *options.coherence_share, prepared.weights,
                                static_cast<std::uint64_t>(options.seed), options.multi_level, control,
                                refinement_of(structures, options, prepared.weights), device, &kept);
}

/// Nothing where the device has no tables of the level, or fails.
std::optional<CostSums> sums_on_device(const SearchDevice* device, SearchDevice::Level* level, const EnergyScale& scale,
                                       const CoordinateMap& coordinates, const RunControl& control) {
  if (level == nullptr) return std::nullopt;
  try {
    return level->sum_costs(scale, coordinates, control);
  } catch (const device::DeviceError& error) {
    device->report_failure(error);
    return std::nullopt;
  }
}

}  // namespace

void describe(OptionVisitor& v, TransferOptions& o) {
  v.visit_choice({"method", "fast, or the source's own exhaustive search (slow)"}, o.method, kTransferMethodNames);
  v.visit({"coherence",
           "Weight of texture relative to control: 1 = texture only, 0 = control only; default 0.65; 0.85 if the "
           "source has structure (lines or regions); 0.995 with reference",
           "", between(0, 1)},
          o.coherence_share);
  v.visit({"neighborhood", "Radius of the compared neighborhood; 0 = 3, or 4 if the source has structure", "px",
           between(0, 5)},
          o.neighborhood_radius_px);
  v.visit_choice({"quality",
                  "Effort for the borders of copied pieces: draft: none; good: cut them where the source has lines or "
                  "regions; best: cut all of them"},
                 o.quality, kTransferQualityNames);
  v.visit_choice({"turning",
                  "Copied pieces may be rotated relative to --flow, so that lines join; auto: only if lines run in all "
                  "directions, like cracks"},
                 o.turning, kPieceTurningNames);
  v.visit_choice({"footprint", "Value of a texel that covers several pixels: their mean, or the pixel in the middle"},
                 o.footprint, kFootprintNames);
  describe(v, o.appearance);
  describe(v, o.multi_level);
  describe(v, o.reference);
}

TransferResult transfer(const TransferInput& input, const TransferOptions& asked, const RunControl& control) {
  const RunControl silent = control.silent();
  PreparedTransfer prepared = prepare_transfer(input, asked, control);
  const TransferOptions& options = prepared.used;
  const Neighborhood& neighborhood = prepared.neighborhood;
  std::vector<SynthesisLevel>& levels = prepared.levels;
  TransferResult result;
  result.used = options;
  result.structure = facts_of(prepared.structure);
  result.refused_line_share = prepared.structure.refused_line_share;
  result.explained_variance = prepared.explained_variance;
  const auto seed = static_cast<std::uint64_t>(options.seed);
  const RunControl synthesis_control = control.part(prepared.progress_share, 0.97);
  if (options.method == TransferMethod::Reference) find_neighbors(levels[0].destination, neighborhood, silent);
  std::unique_ptr<SearchDevice::Level> on_device;
  PlaceMap places(0, levels[0].source.width());
  if (options.method == TransferMethod::Reference) {
    places.pixels =
        synthesize_reference(levels[0].source, levels[0].destination, neighborhood, *options.coherence_share,
                             prepared.weights, seed, options.reference, synthesis_control);
  } else {
    places = synthesize_fast(prepared, refined_structures(prepared, silent), input.device.get(), on_device,
                             synthesis_control);
  }
  const std::optional<CostSums> sums =
      sums_on_device(input.device.get(), places.turns().empty() ? on_device.get() : nullptr,
                     full_scale(levels[0].source, prepared.weights), places.pixels, silent);
  on_device.reset();
  result.energy =
      measure_energy(levels[0].source, levels[0].destination, neighborhood, places.pixels, *options.coherence_share,
                     prepared.weights, silent, sums ? &*sums : nullptr, places.turns());
  result.matched_controls = std::move(levels[0].destination.controls);
  const bool is_subpixel = keeps_fractions(options, input.history->facts());
  if (is_subpixel) result.fractions.resize(2 * places.pixels.size());
  result.turns = {places.turns().begin(), places.turns().end()};
  for (std::size_t t = 0; t < places.pixels.size(); ++t) {
    const SourcePlace kept =
        is_subpixel ? places.source_place(static_cast<TexelId>(t)) : SourcePlace{places.pixels[t], 0, 0};
    const SourcePlace place =
        to_full_size(kept, levels[0].source.width(), static_cast<int>(prepared.first), prepared.source_width);
    places.pixels[t] = place.pixel;
    if (!is_subpixel) continue;
    result.fractions[2 * t] = place.beside_x;
    result.fractions[2 * t + 1] = place.beside_y;
  }
  result.coordinates = std::move(places.pixels);
  control.report(1.0);
  return result;
}

}  // namespace patinate::transfer
