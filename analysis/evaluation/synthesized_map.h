/// \file
/// A texture synthesis as any tool leaves it: for every texel the place in the source that it shows.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "libcommon/atlas/sheet_cells.h"
#include "libcommon/image/between_pixels.h"
#include "patinate/atlas/texel_map.h"
#include "patinate/core/run_control.h"
#include "patinate/core/zeroed_vector.h"
#include "patinate/image/image.h"

namespace patinate::analysis {

/// Source of the copied pixels.
struct SynthesisSource {
  std::vector<ImageF> frames;  ///< H x W x 3, sRGB codes in [0, 255]: the times that are looked at.
  ImageU8 mask;                ///< Pixels that may be copied; may be empty.
  ImageF control;              ///< H x W x 1 in [0, 1]; may be empty.
  double pixel_mm = 1.0;       ///< Surface length of a pixel, on the destination.

  [[nodiscard]] int width() const { return frames.front().width(); }
  [[nodiscard]] int height() const { return frames.front().height(); }
};

/// A coordinate map and the surface that it covers.
struct SynthesizedMap {
  std::string name;
  std::shared_ptr<const TexelMap> surface;  ///< In mm; flat_surface() for a picture.
  ImageF coordinates;  ///< H x W x 2: places in the source in pixels; -1 outside. Lines are looked for in the picture
                       ///< between pixels, all else goes by the nearest one.
  ImageF control;      ///< H x W x 1, the wanted control in the source's values; may be empty.
  std::shared_ptr<const FlowFrames> frames =
      nullptr;  ///< How the source was laid on the surface; none: as the UVs run.
  std::vector<std::int16_t> turns =
      {};  ///< Turns of each texel's piece against them (transfer::SourcePlace); empty: all 0.
};

/// Orientation of the source on a surface. Its parts must outlive it.
struct SourceAxes {
  const FlowFrames& frames;                  ///< One a triangle.
  std::span<const std::int16_t> turns = {};  ///< One a texel; empty: all 0.

  /// A step from a texel along the source's axes there. @param step_mm  In the frame of its triangle.
  [[nodiscard]] Vec2 along_source(TexelId t, const Vec2& step_mm) const;
};

/// A plane of `width` x `height` texels of `texel_mm`, all covered.
[[nodiscard]] std::shared_ptr<const TexelMap> flat_surface(int width, int height, double texel_mm);

/// Visits rows of a coordinate map: `width` pairs x, y each, -1 where nothing is shown.
using CoordinateVisitor = std::function<void(int y, std::span<const float> row)>;
/// Reads a rectangle of a coordinate map that lies inside one tile or in its margins, row by row.
using CoordinateReader = std::function<void(const TexelRect& rect, const CoordinateVisitor& visit)>;
/// Reader of a map in memory, which must outlive it.
[[nodiscard]] CoordinateReader reader_of(const ImageF& coordinates);

/// Two texels side by side on the surface.
struct TexelPair {
  TexelId first = -1;
  TexelId second = -1;
  Vec2 offset_mm{0, 0};  ///< From first to second, along the source's axes at the first.
};

/// Places in the source of texels: index (y * width + x) of the nearest pixel, -1 where none was read, and what lies
/// beside its middle. Takes memory only where texels were read.
class SourceIndices {
 public:
  /// @param name  Of the map, for what is wrong with it.
  SourceIndices(std::string name, std::int64_t num_texels, int source_width, int source_height)
      : name_(std::move(name)),
        index_(static_cast<std::size_t>(num_texels)),
        beside_(2 * static_cast<std::size_t>(num_texels)),
        width_(source_width),
        height_(source_height) {}
  /// The covered texels of a rectangle. @throws InvalidInput if one has no coordinates, or some outside the source.
  void read(const TexelMap& surface, const TexelRect& rect, const CoordinateReader& reader);
  /// A list of covered texels anywhere in the map.
  void read(const TexelMap& surface, std::vector<TexelId> texels, const CoordinateReader& reader);

  [[nodiscard]] std::int32_t of(TexelId t) const { return index_[t] - 1; }
  [[nodiscard]] int x(TexelId t) const { return of(t) % width_; }
  [[nodiscard]] int y(TexelId t) const { return of(t) / width_; }
  [[nodiscard]] BesidePixel beside(TexelId t) const {
    return {beside_[2 * static_cast<std::size_t>(t)], beside_[2 * static_cast<std::size_t>(t) + 1]};
  }

 private:
  void set(const TexelMap& surface, TexelId t, const float* xy);

  std::string name_;
  ZeroedVector<std::int32_t> index_;  ///< From 1 on; 0 = none.
  ZeroedVector<std::int8_t> beside_;  ///< x and y of each.
  int width_, height_;
};

/// Counts of all parts that are needed before one can be measured.
struct PartCounts {
  std::int64_t texels = 0;   ///< Covered ones.
  std::int64_t patches = 0;  ///< Places of whole 7 x 7 patches inside one chart.
  std::int64_t charts = 0;   ///< That have texels.

  void add(const PartCounts& other) { texels += other.texels, patches += other.patches, charts += other.charts; }
};
[[nodiscard]] PartCounts count_part(const TexelMap& surface, const TexelRect& rect);

/// One tile of a map under evaluation; a map without tiles has one part.
struct MapPart {
  const TexelMap& surface;  ///< Surface of the whole map, whose figures it knows.
  const FlowFrames& frames;
  TexelRect rect;
  SourceIndices indices;  ///< Indices of its own texels, and of those that they have beside them over seams.
  ImageF control;         ///< The rectangle's; may be empty.

  [[nodiscard]] std::int64_t num_texels() const { return rect.num_texels(); }
  /// The i-th of the rectangle, row by row.
  [[nodiscard]] TexelId texel(std::int64_t i) const {
    return (rect.y0 + i / rect.width()) * surface.width() + rect.x0 + i % rect.width();
  }
  /// The inverse of texel().
  [[nodiscard]] std::int64_t place(TexelId t) const {
    return (t / surface.width() - rect.y0) * rect.width() + t % surface.width() - rect.x0;
  }
  /// Calls visit(t, i) for the covered ones, row by row.
  template <class Visit>
  void for_each_covered(const Visit& visit) const {
    for (std::int64_t i = 0; i < num_texels(); ++i) {
      if (const TexelId t = texel(i); surface.is_covered(t)) visit(t, i);
    }
  }
  /// 0 / 255, of the rectangle.
  [[nodiscard]] ImageU8 coverage() const;
  /// The value of the source's nearest pixel for each texel of the rectangle, 0 where none is covered.
  [[nodiscard]] ImageF gathered(const ImageF& source) const;
  /// Looks up between pixels, as lookups show it. @param source  Of one channel.
  [[nodiscard]] ImageF looked_up(const ImageF& source) const;
};

/// The texel one step away in the atlas and in the same chart. @returns nothing if there is none.
[[nodiscard]] std::optional<TexelPair> interior_pair(const TexelMap& surface, const SourceAxes& axes, TexelId t, int dx,
                                                     int dy);
/// Texels on two sides of a seam: a step of one texel (of the first one's size) over a border of its chart. Each side
/// is seen from both. @param rect  Of the first ones; the second may lie outside.
[[nodiscard]] std::vector<TexelPair> seam_pairs(const TexelMap& surface, const SourceAxes& axes, const TexelRect& rect,
                                                const RunControl& control = {});

}  // namespace patinate::analysis
