#include "transfer/synthesis/map_audit.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "libcommon/atlas/sheet_cells.h"
#include "libcommon/core/text.h"
#include "transfer/exemplar/structure.h"
#include "transfer/guidance/compared_control.h"
#include "transfer/synthesis/open_options.h"
#include "transfer/synthesis/source_levels.h"

namespace patinate::transfer {

namespace {

void check_sizes(const MapToAudit& made) {
  const TexelMap& surface = *made.surface;
  const auto fits = [&](const ImageF& image, int channels) {
    return image.width() == surface.width() && image.height() == surface.height() && image.channels() == channels;
  };
  if (!fits(made.coordinates, 2))
    throw InvalidInput("the coordinate map has not " + size_text(surface.width(), surface.height()) +
                       " texels with two channels");
  for (const FollowedControl& c : made.controls) {
    if (!fits(c.wanted, 1))
      throw InvalidInput("control `" + c.source + "` has not " + size_text(surface.width(), surface.height()) +
                         " values");
  }
}

/// Source that is measured against, without a destination.
struct Auditor {
  TransferOptions options;
  Neighborhood neighborhood;
  std::vector<double> weights;
  std::vector<ImageF> wanted;
  int halvings = 0;
  SynthesisLevel level;
  SourcePlacement placement;

  Auditor(const History& history, const MapToAudit& made, const TransferOptions& asked,
          const AppearanceSource& appearance_source, const RunControl& control) {
    check_ranges(asked);
    if (made.controls.empty()) throw InvalidInput("an audit needs a control that the map followed");
    const ImageU8 mask = made.source_mask.empty() ? history.read_mask() : made.source_mask;
    options = with_defaults(asked, !find_structure(history, mask, asked.appearance, control).empty(),
                            !history.facts().parts.empty());
    const int wished = source_halvings(made.surface->median_texel_size_mm(), made.pixel_mm, smallest_side(history));
    const AppearanceSpace appearance =
        appearance_of(history, appearance_source, wished + 1, options.appearance, control, made.source_mask);
    const auto first = std::min(static_cast<std::size_t>(wished), appearance.levels.size() - 1);
    halvings = static_cast<int>(first);
    std::vector<ImageF> known;
    for (const FollowedControl& c : made.controls) {
      known.push_back(compared_control(history, c.source, mask, control));
      wanted.push_back(c.wanted);
      weights.push_back(c.weight);
    }
    neighborhood = Neighborhood::square(options.neighborhood_radius_px);
    level.source = make_source_level(appearance.levels[first], source_control_levels(appearance, known)[first],
                                     appearance.masks[first], appearance.variances[first], neighborhood);
    placement = place_source(*made.surface, made.frames, made.pixel_mm, halvings);
  }

  /// Pixel of the level for one of the history.
  [[nodiscard]] std::int32_t pixel(int x, int y) const {
    return std::min(y >> halvings, level.source.height() - 1) * level.source.width() +
           std::min(x >> halvings, level.source.width() - 1);
  }
};

TexelSet texels_of(const TexelMap& surface, int tile, const RunControl& control) {
  const TexelRect cell = cell_of(surface.sheet(), tile);
  const auto is_member = [&](TexelId t) {
    return cell.contains(static_cast<int>(t % surface.width()), static_cast<int>(t / surface.width())) &&
           surface.is_covered(t);
  };
  return {surface.num_texels(), is_member, control};
}

CoordinateMap level_pixels(const MapToAudit& made, const HistoryFacts& history, const Auditor& auditor) {
  CoordinateMap pixels(static_cast<std::size_t>(made.surface->num_texels()), -1);
  for (TexelId t = 0; t < made.surface->num_texels(); ++t) {
    if (!made.surface->is_covered(t)) continue;
    const float* s = made.coordinates.data() + 2 * t;
    const double x = std::floor(static_cast<double>(s[0]) + 0.5), y = std::floor(static_cast<double>(s[1]) + 0.5);
    if (!(x >= 0.0 && y >= 0.0 && x < history.width && y < history.height)) continue;
    pixels[t] = auditor.pixel(static_cast<int>(x), static_cast<int>(y));
  }
  return pixels;
}

}  // namespace

OptimumAudit audit_map(const History& history, const MapToAudit& made, const TransferOptions& asked,
                       std::int64_t num_audits, std::uint64_t seed, const RunControl& control,
                       const AppearanceSource& appearance) {
  check_sizes(made);
  if (!(num_audits > 0)) throw InvalidInput("audits: " + std::to_string(num_audits) + " is out of range; use > 0");
  Auditor auditor(history, made, asked, appearance, control.part(0.0, 0.5));
  if (auditor.level.source.usable.empty()) return {};
  const TexelMap& surface = *made.surface;
  auditor.level.destination = make_destination_level(made.surface, interleave(auditor.wanted), auditor.neighborhood,
                                                     auditor.placement, control.silent());
  std::vector<TexelId> drawn;
  std::int64_t before = 0;
  for (int tile = 0; tile < surface.sheet().num_tiles(); ++tile) {
    const TexelSet texels = texels_of(surface, tile, control.silent());
    const std::vector<TexelId> here = drawn_texels(texels, before, surface.num_covered(), num_audits, seed);
    drawn.insert(drawn.end(), here.begin(), here.end());
    before += static_cast<std::int64_t>(texels.size());
  }
  return summary_of(audit_texels(auditor.level, auditor.neighborhood, level_pixels(made, history.facts(), auditor),
                                 drawn, *auditor.options.coherence_share, auditor.weights, control.part(0.6, 1.0),
                                 made.turns));
}

}  // namespace patinate::transfer
