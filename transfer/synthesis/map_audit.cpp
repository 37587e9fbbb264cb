#include "transfer/synthesis/map_audit.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "libcommon/core/text.h"
#include "transfer/exemplar/structure.h"
#include "transfer/synthesis/open_options.h"
#include "transfer/synthesis/source_levels.h"

namespace patinate::transfer {

namespace {

void check_sizes(const MapToAudit& made) {
  const TexelMap& surface = *made.surface;
  const auto fits = [&](const ImageF& image, int channels) {
    return image.width() == surface.width() && image.height() == surface.height() && image.channels() == channels;
  };
  if (made.controls.empty()) throw InvalidInput("an audit needs a control that the map followed");
  if (!fits(made.coordinates, 2))
    throw InvalidInput("the coordinate map has not " + size_text(surface.width(), surface.height()) +
                       " texels with two channels");
  for (const FollowedControl& c : made.controls) {
    if (!fits(c.wanted, 1))
      throw InvalidInput("control `" + c.source + "` has not " + size_text(surface.width(), surface.height()) +
                         " values");
  }
}

/// Pixels of a source that is halved `halvings` times.
CoordinateMap level_pixels(const MapToAudit& made, const HistoryFacts& history, const SourceLevel& source,
                           int halvings) {
  CoordinateMap pixels(static_cast<std::size_t>(made.surface->num_texels()), -1);
  for (TexelId t = 0; t < made.surface->num_texels(); ++t) {
    if (!made.surface->is_covered(t)) continue;
    const float* s = made.coordinates.data() + 2 * t;
    const double x = std::floor(static_cast<double>(s[0]) + 0.5), y = std::floor(static_cast<double>(s[1]) + 0.5);
    if (!(x >= 0.0 && y >= 0.0 && x < history.width && y < history.height)) continue;
    const int column = std::min(static_cast<int>(x) >> halvings, source.width() - 1),
              row = std::min(static_cast<int>(y) >> halvings, source.height() - 1);
    pixels[static_cast<std::size_t>(t)] = row * source.width() + column;
  }
  return pixels;
}

}  // namespace

OptimumAudit audit_map(const History& history, const MapToAudit& made, const TransferOptions& asked,
                       std::int64_t num_audits, std::uint64_t seed, const RunControl& control,
                       const AppearanceSource& appearance_source) {
  check_ranges(asked);
  check_sizes(made);
  const bool has_structure = !find_structure(history, made.source_mask.empty() ? history.read_mask() : made.source_mask,
                                             asked.appearance, control)
                                  .empty();
  const TransferOptions options = with_defaults(asked, has_structure);
  const HistoryFacts& facts = history.facts();
  const int halvings = source_halvings(made.surface->median_texel_size_mm(), made.pixel_mm, smallest_side(history));
  const AppearanceSpace appearance = appearance_of(history, appearance_source, halvings + 1, options.appearance,
                                                   control.part(0.0, 0.5), made.source_mask);
  const auto first = std::min(static_cast<std::size_t>(halvings), appearance.levels.size() - 1);
  std::vector<ImageF> known, wanted;
  std::vector<double> weights;
  for (const FollowedControl& c : made.controls) {
    known.push_back(history.read_control(c.source));
    wanted.push_back(c.wanted);
    weights.push_back(c.weight);
  }
  const Neighborhood neighborhood = Neighborhood::square(options.neighborhood_radius_px);
  SynthesisLevel level{
      .source = make_source_level(appearance.levels[first], source_control_levels(appearance, known)[first],
                                  appearance.masks[first], appearance.variances[first], neighborhood),
      .destination = {}};
  if (level.source.usable.empty()) return {};
  RunControl silent = control;
  silent.on_progress = nullptr;
  level.destination =
      make_destination_level(made.surface, interleave(wanted), neighborhood,
                             place_source(*made.surface, made.frames, made.pixel_mm, static_cast<int>(first)), silent);
  return audit_optimum(level, neighborhood, level_pixels(made, facts, level.source, static_cast<int>(first)),
                       *options.coherence_share, weights, num_audits, seed, control.part(0.6, 1.0));
}

}  // namespace patinate::transfer
