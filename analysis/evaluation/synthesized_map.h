/// \file
/// A texture synthesis as any tool leaves it: for every texel the place in the source that it shows.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "patinate/atlas/texel_map.h"
#include "patinate/core/run_control.h"
#include "patinate/image/image.h"

namespace patinate::analysis {

/// What is copied from.
struct SynthesisSource {
  std::vector<ImageF> frames;  ///< H x W x 3, sRGB codes in [0, 255]: the times that are looked at.
  ImageU8 mask;                ///< What may be copied; may be empty.
  ImageF control;              ///< H x W x 1 in [0, 1]; may be empty.
  double pixel_mm = 1.0;       ///< Surface length of a pixel, on the destination.

  [[nodiscard]] int width() const { return frames.front().width(); }
  [[nodiscard]] int height() const { return frames.front().height(); }
};

/// A coordinate map and the surface that it covers.
struct SynthesizedMap {
  std::string name;
  std::shared_ptr<const TexelMap> surface;  ///< In mm; flat_surface() for a picture.
  ImageF coordinates;  ///< H x W x 2: source pixels; -1 outside. Fractions are rounded to the nearest pixel.
  ImageF control;      ///< H x W x 1, the wanted control in the source's values; may be empty.
  std::shared_ptr<const FlowFrames> frames =
      nullptr;  ///< How the source was laid on the surface; none: as the UVs run.
};

/// A plane of `width` x `height` texels of `texel_mm`, all covered.
[[nodiscard]] std::shared_ptr<const TexelMap> flat_surface(int width, int height, double texel_mm);

/// Two texels side by side on the surface.
struct TexelPair {
  TexelId first = -1;
  TexelId second = -1;
  Vec2 offset_mm{0, 0};  ///< From first to second, in the frame of the first.
};

/// Index into the source (y * width + x) of every texel, -1 outside or where the map names no pixel of the source.
class SourceIndices {
 public:
  /// @throws InvalidInput if the map has not two channels or not the surface's size, a covered texel has no
  /// coordinates, or one lies outside the source.
  SourceIndices(const SynthesizedMap& map, const SynthesisSource& source);

  [[nodiscard]] std::int32_t of(TexelId t) const { return index_[static_cast<std::size_t>(t)]; }
  [[nodiscard]] int x(TexelId t) const { return of(t) % width_; }
  [[nodiscard]] int y(TexelId t) const { return of(t) / width_; }
  [[nodiscard]] const std::vector<std::int32_t>& all() const { return index_; }

 private:
  std::vector<std::int32_t> index_;
  int width_;
};

/// The texel one step away in the atlas and in the same chart. @returns nothing if there is none.
[[nodiscard]] std::optional<TexelPair> interior_pair(const TexelMap& surface, const FlowFrames& frames, TexelId t,
                                                     int dx, int dy);
/// Texels on two sides of a seam: a step of one texel (of the first one's size) over a border of its chart. Each side
/// is seen from both.
[[nodiscard]] std::vector<TexelPair> seam_pairs(const TexelMap& surface, const FlowFrames& frames,
                                                const RunControl& control = {});

}  // namespace patinate::analysis
