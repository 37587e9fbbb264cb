/// \file
/// Places in the source to fractions of a pixel, and how they go from a coarse level to a fine one.
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "transfer/synthesis/energy.h"
#include "transfer/synthesis/search_kernel.h"
#include "transfer/synthesis/turns.h"

namespace patinate::transfer {

/// A place in the source. Where texels are turned or scaled against it, a copied piece keeps its shape only if
/// fractions are carried on from texel to texel.
struct Place {
  std::int32_t pixel = -1;  ///< y * width + x of the nearest pixel; -1 = none.
  FixedPoint point;
  Turn turn = 0;  ///< Turn of the piece against the texel's frame.
  friend bool operator==(const Place&, const Place&) = default;
};

/// The places of all texels, in 6 bytes each: pixels, and how far beside their middles; 2 more where pieces turn.
class PlaceMap {
 public:
  /// In 1/256 pixel, [-128, 127].
  struct Beside {
    std::int8_t x = 0, y = 0;
  };
  CoordinateMap pixels;  ///< -1 = none.

  /// @param source_width  > 0.
  PlaceMap(std::int64_t num_texels, std::int32_t source_width)
      : pixels(static_cast<std::size_t>(num_texels), -1),
        beside_(2 * static_cast<std::size_t>(num_texels)),
        width_(source_width),
        shift_(31 + static_cast<int>(std::bit_width(static_cast<std::uint32_t>(source_width) - 1))),
        reciprocal_((std::uint64_t{1} << shift_) / static_cast<std::uint32_t>(source_width) + 1) {}
  /// Place of a texel that has one.
  [[nodiscard]] FixedPoint point(TexelId t) const {
    const search_kernel::PlaceTables all = tables();
    const search_kernel::FixedPlace place = search_kernel::place_of_texel(&all, t);
    return {place.x, place.y};
  }
  [[nodiscard]] Place at(TexelId t) const {
    const std::int32_t pixel = pixels[t];
    return pixel < 0 ? Place{} : Place{pixel, point(t), turn(t)};
  }
  /// Places as results have them.
  [[nodiscard]] SourcePlace source_place(TexelId t) const {
    const auto i = static_cast<std::size_t>(t);
    return {pixels[i], beside_[2 * i], beside_[2 * i + 1], turn(t)};
  }
  void set(TexelId t, std::int32_t pixel, Beside beside) {
    pixels[t] = pixel;
    beside_[2 * static_cast<std::size_t>(t)] = beside.x;
    beside_[2 * static_cast<std::size_t>(t) + 1] = beside.y;
  }
  void set(TexelId t, const Place& place) {
    set(t, place.pixel, beside_of(place));
    if (!turns_.empty()) turns_[t] = place.turn;
  }
  /// From now on turns are kept; 0 so far.
  void keep_turns() { turns_ = ZeroedVector<Turn>(pixels.size()); }
  [[nodiscard]] Turn turn(TexelId t) const { return turns_.empty() ? Turn{0} : turns_[t]; }
  /// Empty: none are kept.
  [[nodiscard]] std::span<const Turn> turns() const { return turns_; }
  [[nodiscard]] static Beside beside_of(const Place& place) {
    const auto rest = [](std::int32_t fixed) { return static_cast<std::int8_t>(search_kernel::beside_middle(fixed)); };
    return {rest(place.point.x), rest(place.point.y)};
  }
  /// For kernels; valid until a place is set.
  [[nodiscard]] search_kernel::PlaceTables tables() const {
    return {
        .pixels = pixels.data(), .beside = beside_.data(), .width = width_, .shift = shift_, .reciprocal = reciprocal_};
  }
  /// x and y of each texel, as a device has them.
  [[nodiscard]] std::span<const std::int8_t> beside() const { return beside_; }
  [[nodiscard]] std::span<std::int8_t> beside() { return beside_; }

 private:
  ZeroedVector<std::int8_t> beside_;
  ZeroedVector<Turn> turns_;
  std::int32_t width_;
  int shift_;
  std::uint64_t reciprocal_;
};

/// The middle of a pixel.
[[nodiscard]] inline Place place_of(const SourceLevel& source, std::int32_t pixel) {
  return {pixel, {pixel % source.width() * PixelNeighbor::kOne, pixel / source.width() * PixelNeighbor::kOne}};
}
/// Pixel -1 where no usable pixel is.
[[nodiscard]] inline Place place_at(const SourceLevel& source, const FixedPoint& p, Turn turn = 0) {
  const std::int32_t x = whole_pixels(p.x), y = whole_pixels(p.y);
  if (x < 0 || y < 0 || x >= source.width() || y >= source.height()) return {};
  const std::int32_t pixel = y * source.width() + x;
  if (source.is_usable[pixel] == 0) return {};
  return {pixel, p, turn};
}

inline constexpr int kSimilarTolerance = kControlSteps / 50;  ///< How near "similar control value" is.

/// Every covered texel gets a source pixel of similar control value.
[[nodiscard]] PlaceMap initial_places(const SynthesisLevel& level, std::uint64_t seed, const RunControl& control = {});
/// The same for some texels of a map that is there. @param seed  A texel's pixel depends on it and the texel alone.
void set_initial_places(const SynthesisLevel& level, const TexelSet& texels, std::uint64_t seed, PlaceMap& places,
                        const RunControl& control = {});

/// Doubles places: a fine texel's place lies in its parent's as the texel lies in its parent on the surface, turned as
/// the parent's is. Texels
/// whose parent is not covered or leads outside take a pixel of similar control value.
[[nodiscard]] PlaceMap upsample(const PlaceMap& coarse, const SynthesisLevel& coarse_level,
                                const SynthesisLevel& fine_level, std::uint64_t seed, const RunControl& control = {});
/// The same for some texels of a map that is there, which have initial places: those without a parent keep them.
void upsample_texels(const PlaceMap& coarse, const SynthesisLevel& coarse_level, const SynthesisLevel& fine_level,
                     const TexelSet& texels, PlaceMap& fine, const RunControl& control = {});

/// Halves places, as upsample() doubles them: a coarse texel lies where it has to for its first covered child to get
/// its place. Texels without a child, or whose place cannot be copied on the coarse level, keep theirs.
void downsample_texels(const PlaceMap& fine, const SynthesisLevel& fine_level, const SynthesisLevel& coarse_level,
                       const TexelSet& texels, PlaceMap& coarse, const RunControl& control = {});

}  // namespace patinate::transfer
