#include "transfer/synthesis/levels.h"

#include <algorithm>
#include <cstdlib>
#include <string>

#include "transfer/synthesis/search_kernel.h"

namespace patinate::transfer {

Neighborhood Neighborhood::square(int radius_px) {
  if (radius_px < 1 || radius_px > 5)
    throw InvalidInput("neighborhood: " + std::to_string(radius_px) + " is out of range; use [1, 5]");
  Neighborhood n;
  n.radius_px = radius_px;
  // A tent, 16 beside the texel: the nearest neighbors say most. Sums stay below 1024 up to radius 5.
  const auto weight = [&](const Offset& o) {
    return std::max(
        1, 16 * (radius_px + 1 - std::abs(o.x)) * (radius_px + 1 - std::abs(o.y)) / (radius_px * (radius_px + 1)));
  };
  for (int y = -radius_px; y <= radius_px; ++y) {
    for (int x = -radius_px; x <= radius_px; ++x) {
      if (x == 0 && y == 0) continue;
      n.offsets.push_back({x, y});
    }
  }
  std::stable_sort(n.offsets.begin(), n.offsets.end(),
                   [&](const Offset& a, const Offset& b) { return weight(a) > weight(b); });
  for (const Offset& o : n.offsets) n.weights.push_back(static_cast<std::int16_t>(weight(o)));
  return n;
}

namespace {

int grid_index(std::span<const std::uint16_t> controls) { return search_kernel::control_cell(controls.data()); }

std::span<const std::uint16_t> controls_of(const ControlImage& controls, std::int64_t pixel) {
  const auto n = static_cast<std::size_t>(controls.channels());
  return controls.values().subspan(static_cast<std::size_t>(pixel) * n, n);
}

/// Sorts the usable pixels into cells and leads every empty cell to the nearest filled one.
void fill_grid(SourceLevel& level) {
  constexpr int kSide = SourceLevel::kGridSide;
  level.grid_begin.assign(kSide * kSide + 1, 0);
  level.grid_pixels.resize(level.usable.size());
  const auto cell = [&](std::int32_t p) {
    return static_cast<std::size_t>(grid_index(controls_of(level.controls, p)));
  };
  for (std::int32_t p : level.usable) ++level.grid_begin[cell(p) + 1];
  for (std::size_t c = 1; c < level.grid_begin.size(); ++c) level.grid_begin[c] += level.grid_begin[c - 1];
  std::vector<std::int32_t> next(level.grid_begin.begin(), level.grid_begin.end() - 1);
  for (std::int32_t p : level.usable) level.grid_pixels[next[cell(p)]++] = p;

  std::vector<std::int32_t> filled;
  for (int c = 0; c < kSide * kSide; ++c) {
    if (level.grid_begin[c] < level.grid_begin[static_cast<std::size_t>(c) + 1]) filled.push_back(c);
  }
  for (int c = 0; c < kSide * kSide; ++c) {
    const auto squared = [&](std::int32_t f) {
      const int dx = f % kSide - c % kSide, dy = f / kSide - c / kSide;
      return dx * dx + dy * dy;
    };
    level.grid_cell.push_back(
        *std::min_element(filled.begin(), filled.end(), [&](auto a, auto b) { return squared(a) < squared(b); }));
  }
}

}  // namespace

search_kernel::AlikeTables alike_tables(const SourceLevel& source) {
  static_assert(search_kernel::kLargestControl == kControlSteps &&
                search_kernel::kControlGridSide == SourceLevel::kGridSide);
  return {.usable = source.usable.data(),
          .first_with = source.first_with.data(),
          .grid_cell = source.grid_cell.data(),
          .grid_begin = source.grid_begin.data(),
          .grid_pixels = source.grid_pixels.data(),
          .num_usable = static_cast<std::int32_t>(source.usable.size()),
          .num_controls = source.controls.channels()};
}

search_kernel::SourceTables source_tables(const SourceLevel& source) {
  static_assert(search_kernel::kComponents == kAppearanceSize);
  return {.appearance = source.appearance.data(),
          .controls = source.controls.data(),
          .is_usable = source.is_usable.data(),
          .similar = nullptr,
          .width = source.width(),
          .height = source.height()};
}

std::span<const std::int32_t> SourceLevel::similar(std::span<const std::uint16_t> target, int tolerance) const {
  const search_kernel::AlikeTables tables = alike_tables(*this);
  const search_kernel::AlikePixels alike = search_kernel::alike_pixels(&tables, target.data(), tolerance);
  return {alike.pixels, static_cast<std::size_t>(alike.num)};
}

namespace {

/// Spreads below 1/64 of the range count as that: a control that hardly varies decides little, and costs stay below
/// 2^51.
constexpr double kSmallestSpread = (kControlSteps + 1) / 64.0;

/// Per channel, over the usable pixels.
std::vector<double> control_variances(const ControlImage& controls, std::span<const std::int32_t> pixels) {
  std::vector<double> result;
  for (int c = 0; c < controls.channels(); ++c) {
    double sum = 0.0, squares = 0.0;
    for (std::int32_t p : pixels) {
      const double v = controls.data()[static_cast<std::int64_t>(p) * controls.channels() + c];
      sum += v;
      squares += v * v;
    }
    const double n = static_cast<double>(pixels.size());
    result.push_back(std::max(kSmallestSpread * kSmallestSpread, squares / n - (sum / n) * (sum / n)));
  }
  return result;
}

/// Lists the usable pixels, and what is looked up of them.
void index_usable(SourceLevel& level) {
  for (std::size_t pixel = 0; pixel < level.is_usable.size(); ++pixel) {
    if (level.is_usable[pixel] != 0) level.usable.push_back(static_cast<std::int32_t>(pixel));
  }
  if (level.usable.empty()) return;
  std::stable_sort(level.usable.begin(), level.usable.end(), [&](std::int32_t a, std::int32_t b) {
    const int n = level.controls.channels();
    return level.controls.data()[std::int64_t{a} * n] < level.controls.data()[std::int64_t{b} * n];
  });
  for (int value = 0; value <= kControlSteps + 1; ++value) {
    auto at = level.first_with.empty() ? level.usable.begin() : level.usable.begin() + level.first_with.back();
    while (at != level.usable.end() && controls_of(level.controls, *at)[0] < value) ++at;
    level.first_with.push_back(static_cast<std::int32_t>(at - level.usable.begin()));
  }
  level.control_variances = control_variances(level.controls, level.usable);
  if (level.controls.channels() > 1) fill_grid(level);
}

/// The image with a margin of zeros.
template <class T>
Image<T> with_margin(const Image<T>& image, int margin) {
  Image<T> result(image.width() + 2 * margin, image.height() + 2 * margin, image.channels());
  for (int y = 0; y < image.height(); ++y) {
    std::copy_n(&image.at(0, y), std::ptrdiff_t{image.width()} * image.channels(), &result.at(margin, y + margin));
  }
  return result;
}

/// Gives every pixel outside the mask, but near it, what lies as far behind the nearest pixel inside; or that one,
/// where the mask is narrow.
void mirror_outwards(AppearanceImage& appearance, const ImageU8& mask, int radius) {
  const auto is_inside = [&](int x, int y) { return mask.contains(x, y) && mask.at(x, y) != 0; };
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      if (is_inside(x, y)) continue;
      Offset nearest;  // Offset of length 0 where there is none.
      int least = 2 * radius * radius + 1;
      for (int dy = -radius; dy <= radius; ++dy) {
        for (int dx = -radius; dx <= radius; ++dx) {
          if (dx * dx + dy * dy >= least || !is_inside(x + dx, y + dy)) continue;
          least = dx * dx + dy * dy;
          nearest = {dx, dy};
        }
      }
      const int steps = is_inside(x + 2 * nearest.x, y + 2 * nearest.y) ? 2 : 1;
      const auto from = appearance.pixel(x + steps * nearest.x, y + steps * nearest.y);
      std::copy(from.begin(), from.end(), appearance.pixel(x, y).begin());
    }
  }
}

}  // namespace

SourceLevel make_source_level(AppearanceImage appearance, ControlImage controls, const ImageU8& mask,
                              double appearance_variance, const Neighborhood& neighborhood) {
  SourceLevel level;
  level.appearance = std::move(appearance);
  level.controls = std::move(controls);
  level.appearance_variance = std::max(1.0, appearance_variance);
  const int w = level.width(), h = level.height(), r = neighborhood.radius_px;
  // Usable = no masked pixel within the neighborhood's square: a running count over rows, then over columns.
  Image<int> outside_in_row(w, h);
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      for (int dx = -r; dx <= r; ++dx) outside_in_row.at(x, y) += !mask.contains(x + dx, y) || mask.at(x + dx, y) == 0;
    }
  }
  level.is_usable.assign(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), 0);
  for (int y = r; y < h - r; ++y) {
    for (int x = r; x < w - r; ++x) {
      int outside = 0;
      for (int dy = -r; dy <= r; ++dy) outside += outside_in_row.at(x, y + dy);
      level.is_usable[static_cast<std::size_t>(y) * static_cast<std::size_t>(w) + static_cast<std::size_t>(x)] =
          outside == 0;
    }
  }
  index_usable(level);
  return level;
}

SourceLevel make_coarse_source_level(const AppearanceImage& appearance, const ControlImage& controls,
                                     const ImageU8& mask, double appearance_variance,
                                     const Neighborhood& neighborhood) {
  SourceLevel level;
  level.margin_px = neighborhood.radius_px;
  level.appearance = with_margin(appearance, level.margin_px);
  level.controls = with_margin(controls, level.margin_px);
  level.appearance_variance = std::max(1.0, appearance_variance);
  const ImageU8 inside = with_margin(mask, level.margin_px);
  mirror_outwards(level.appearance, inside, level.margin_px);
  for (std::uint8_t m : inside.values()) level.is_usable.push_back(m != 0);
  index_usable(level);
  return level;
}

DestinationLevel cover_level(std::shared_ptr<const TexelMap> map, ControlImage controls, SourcePlacement placement,
                             const RunControl& control) {
  TexelSet texels(
      map->num_texels(), [&](TexelId t) { return map->is_covered(t); }, control);
  return {.map = std::move(map),
          .controls = std::move(controls),
          .placement = std::move(placement),
          .texels = std::move(texels)};
}

void find_neighbors(DestinationLevel& level, const Neighborhood& neighborhood, const RunControl& control) {
  std::vector<Vec2> offsets_mm;
  for (const Offset& o : neighborhood.offsets)
    offsets_mm.emplace_back(o.x * level.placement.step_mm, o.y * level.placement.step_mm);
  level.neighbors = std::make_shared<TexelNeighborhood>(*level.map, std::move(offsets_mm), level.placement.frames,
                                                        level.placement.pixel_mm, control);
}

DestinationLevel make_destination_level(std::shared_ptr<const TexelMap> map, ControlImage controls,
                                        const Neighborhood& neighborhood, const SourcePlacement& placement,
                                        const RunControl& control) {
  DestinationLevel level = cover_level(std::move(map), std::move(controls), placement, control);
  find_neighbors(level, neighborhood, control);
  return level;
}

}  // namespace patinate::transfer
