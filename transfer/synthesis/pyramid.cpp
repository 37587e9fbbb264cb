#include "transfer/synthesis/pyramid.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "transfer/synthesis/places.h"
#include "transfer/synthesis/source_levels.h"
#include "transfer/synthesis/whole_windows.h"

namespace patinate::transfer {

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

int usable_levels(const History& history, int halvings, int width, int height, const TransferOptions& options) {
  if (options.method == TransferMethod::Reference) return 1;
  const int source_side = smallest_side(history) >> halvings;
  const int smallest = std::min({source_side, width, height});
  int levels = 1;
  while (levels < options.multi_level.num_levels && (smallest >> levels) >= kSmallestSide) ++levels;
  return levels;
}

std::int32_t to_full_size(std::int32_t pixel, int coarse_width, int halvings, int full_width) {
  if (halvings == 0 || pixel < 0) return pixel;
  const int middle = 1 << (halvings - 1);
  return ((pixel / coarse_width << halvings) + middle) * full_width + ((pixel % coarse_width << halvings) + middle);
}

SourcePlace to_full_size(const SourcePlace& place, int coarse_width, int halvings, int full_width) {
  if (halvings == 0 || place.pixel < 0) return place;
  const std::int32_t middle = to_full_size(place.pixel, coarse_width, halvings, full_width);
  const FixedPoint point{middle % full_width * PixelNeighbor::kOne + (place.beside_x << halvings),
                         middle / full_width * PixelNeighbor::kOne + (place.beside_y << halvings)};
  const PlaceMap::Beside beside = PlaceMap::beside_of({0, point});
  return {whole_pixels(point.y) * full_width + whole_pixels(point.x), beside.x, beside.y, place.turn};
}

SourcePlace from_full_size(const SourcePlace& place, int coarse_width, int halvings, int full_width) {
  if (halvings == 0 || place.pixel < 0) return place;
  const std::int32_t middle = PixelNeighbor::kOne << (halvings - 1);
  const FixedPoint point{(place.pixel % full_width * PixelNeighbor::kOne + place.beside_x - middle) >> halvings,
                         (place.pixel / full_width * PixelNeighbor::kOne + place.beside_y - middle) >> halvings};
  const PlaceMap::Beside beside = PlaceMap::beside_of({0, point});
  return {whole_pixels(point.y) * coarse_width + whole_pixels(point.x), beside.x, beside.y, place.turn};
}

void for_each_uncovered(const TexelMap& coarse, const TexelMap& fine, const TexelRect& part,
                        const std::function<void(int x, int y, TexelId fine)>& fill, const RunControl& control) {
  for (int y = part.y0; y < part.y1; ++y) {
    control.throw_if_stopped();
    for (int x = part.x0; x < part.x1; ++x) {
      const TexelId t = TexelId{y} * coarse.width() + x;
      if (!coarse.is_covered(t)) continue;
      bool has_child = false;
      for (int dy = 0; dy < 2; ++dy) {
        for (int dx = 0; dx < 2; ++dx) {
          has_child |= fine.rect().contains(2 * x + dx, 2 * y + dy) &&
                       fine.is_covered(TexelId{2 * y + dy} * fine.width() + 2 * x + dx);
        }
      }
      const TexelId near = has_child ? -1 : fine.texel_of(coarse.point(t));
      if (near >= 0) fill(x, y, near);
    }
  }
}

SourceLevel make_pyramid_source(const AppearanceSpace& appearance, const std::vector<ControlImage>& controls,
                                std::size_t l, std::size_t first, const Neighborhood& neighborhood) {
  return l == first ? make_source_level(appearance.levels[l], controls[l], appearance.masks[l], appearance.variances[l],
                                        neighborhood)
                    : make_coarse_source_level(appearance.levels[l], controls[l], appearance.masks[l],
                                               appearance.variances[l], neighborhood);
}

void append_levels(std::vector<SynthesisLevel>& levels, const AppearanceSpace& appearance, std::size_t first,
                   const std::vector<ControlImage>& source_controls, ControlImage controls,
                   std::shared_ptr<const TexelMap> map, SourcePlacement placement, const Neighborhood& neighborhood,
                   const RunControl& control) {
  const std::size_t begin = levels.size();
  placement.step_mm = std::ldexp(placement.step_mm, static_cast<int>(begin));
  placement.pixel_mm = std::ldexp(placement.pixel_mm, static_cast<int>(begin));
  for (std::size_t l = first + begin; l < appearance.levels.size();
       ++l, placement.step_mm *= 2.0, placement.pixel_mm *= 2.0) {
    if (levels.size() > begin) {
      auto coarse_map = std::make_shared<TexelMap>(map->halved(control));
      if (coarse_map->num_covered() == 0) break;
      const ControlImage& fine = levels.back().destination.controls;
      controls = halve(
          fine, coarse_map->width(), coarse_map->height(),
          [&](int x, int y) { return map->is_covered(TexelId{y} * map->width() + x); }, control);
      for_each_uncovered(
          *coarse_map, *map, coarse_map->rect(),
          [&](int x, int y, TexelId near) {
            for (int c = 0; c < controls.channels(); ++c)
              controls.at(x, y, c) = fine.data()[near * fine.channels() + c];
          },
          control);
      map = std::move(coarse_map);
    }
    SourceLevel source = make_pyramid_source(appearance, source_controls, l, first, neighborhood);
    if (source.usable.empty()) break;  // A coarse level is not needed.
    levels.push_back({std::move(source), cover_level(map, std::move(controls), placement, control)});
  }
}

}  // namespace patinate::transfer
