/// \file
/// A piece of the surface around a texel, laid flat in source pixels, with the pairs of neighbors in it and at its rim.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "libcommon/atlas/texel_neighborhood.h"
#include "patinate/atlas/texel_map.h"
#include "transfer/synthesis/places.h"
#include "transfer/synthesis/turns.h"

namespace patinate::transfer {

struct PatchTexel {
  TexelId texel = -1;
  FixedPoint offset;  ///< From the center, along the surface, in the center's frame.
  Turn turn = 0;      ///< Turn of a piece here that is not turned at the center; 0 where pieces follow the frames.
};

/// Two neighbors, the second at `step` from the first.
struct PatchEdge {
  std::int32_t first = 0;
  std::int32_t second = -1;  ///< -1: outside of the patch.
  TexelId outside = -1;      ///< Then that texel.
  FixedPoint step;           ///< In the first one's frame.
  Turn turn = 0;             ///< How far the second one's frame is turned in it; 0 where pieces follow the frames.
  std::int32_t weight =
      0;  ///< 4 beside each other, 2 diagonally; half of that over seams, where both may see the other.
};

struct SurfacePatch {
  int half_px = 0;
  std::vector<PatchTexel> texels;  ///< The center first.
  std::vector<PatchEdge> edges;
};

/// Finds patches; one for each thread.
class PatchFinder {
 public:
  static constexpr std::size_t kMostTexels = 16384;
  /// @param map,neighbors,turns  Must outlive this. Only the eight beside a texel are looked at: neighbors at no
  /// offsets are the quickest. @param turns  Null: pieces follow the frames, and are sheared where those turn.
  PatchFinder(const TexelMap& map, const TexelNeighborhood& neighbors, const FrameTurns* turns = nullptr);

  /// Texels that lie within half_px to every side of the center, going from neighbor to neighbor. [1, 100] pixels. A
  /// texel lies where those beside it that are laid already would have it, on the mean: on a bent surface ways to a
  /// place differ, and what they differ by is spread, not torn open along a line.
  void find_texels(TexelId center, int half_px, SurfacePatch& patch);
  /// The pairs, after find_texels() of the same patch.
  void find_edges(SurfacePatch& patch);

 private:
  /// A texel of the patch or beside it.
  struct Known {
    TexelId texel = -1;
    std::int32_t index = -1;  ///< In the patch; -1: outside.
    std::int32_t row = -1;    ///< Row of rows_; -1: not asked for yet.
  };
  /// The eight beside a texel. They are looked up once a patch, though most are asked for five times.
  struct Row {
    std::array<PixelNeighbor, TexelNeighborhood::kNumAdjacent> neighbors;
    std::array<std::int32_t, TexelNeighborhood::kNumAdjacent> known;  ///< -1: there is none, or the texel itself.
    std::array<std::int32_t, TexelNeighborhood::kNumAdjacent> turns;  ///< Turns of its frame in the texel's; kNotAsked.
  };
  static constexpr std::int32_t kNotAsked = 1 << 20;
  void forget();
  [[nodiscard]] std::int32_t known_of(TexelId texel);
  /// Valid until the next call.
  [[nodiscard]] Row& row_of(std::int32_t known);
  /// Row of the k-th beside a texel.
  [[nodiscard]] Turn turn_in(Row& row, std::int32_t known, std::size_t k) const {
    if (row.turns[k] == kNotAsked) row.turns[k] = frame_turn(known_[known].texel, row.neighbors[k].texel);
    return static_cast<Turn>(row.turns[k]);
  }
  /// Where those beside a texel would have it. @param otherwise  As the one that it was found from has it.
  [[nodiscard]] PatchTexel mean_place(std::int32_t known, const PatchTexel& otherwise, const SurfacePatch& patch);
  [[nodiscard]] Turn frame_turn(TexelId from, TexelId to) const {
    return turns_ == nullptr ? Turn{0} : turns_->between(map_.triangle(from), map_.triangle(to));
  }

  const TexelMap& map_;
  std::size_t first_adjacent_;
  TexelNeighborhood::Cursor cursor_;
  const FrameTurns* turns_;
  TexelId center_ = -1;
  std::vector<Known> known_;  ///< Around the center, of whatever size of patch.
  std::vector<Row> rows_;
  std::vector<std::int32_t> slots_;  ///< A hash table of known_; -1 = free.
  std::vector<std::size_t> used_;    ///< Used of slots_.
};

/// Calls visit(neighbor, is_earlier, weight) for the neighbors of a texel. Earlier are those of the grid that come
/// first in row order: such a pair is counted from their side. Pairs across seams are counted from both, each by half.
/// @param adjacent  The eight beside it.
template <class Visit>
void for_each_pair(TexelId texel, std::span<const PixelNeighbor> adjacent, int width, const Visit& visit) {
  for (std::size_t k = 0; k < adjacent.size(); ++k) {
    const PixelNeighbor& n = adjacent[k];
    if (n.texel < 0 || n.texel == texel) continue;
    const std::size_t square = k < 4 ? k : k + 1;  // Square of 3 x 3, the middle left out.
    const int dx = static_cast<int>(square % 3) - 1, dy = static_cast<int>(square / 3) - 1;
    const bool is_grid = n.texel == texel + dx + TexelId{dy} * width;
    const int weight = dx == 0 || dy == 0 ? 4 : 2;
    visit(n, is_grid && k < 4, is_grid ? weight : weight / 2);
  }
}

}  // namespace patinate::transfer
