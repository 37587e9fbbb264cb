/// \file
/// A splat's texels out of planes in tile order into lanes, and back.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>

#include "simulation/transport/splat.h"

namespace patinate::simulation {

/// Where a stencil lies, away from seams and the atlas's edges. It reaches less than a page to each side: at most two
/// by two pages have a part of it.
class SplatPlace {
 public:
  /// Values of the pages by row and column: kPageTexels each.
  template <class Value>
  using Pages = std::array<Value*, 4>;
  /// Lanes have room for so many more values behind the last.
  static constexpr std::size_t kSlack = 16;

  SplatPlace(const TileGrid& grid, const SplatStencil& stencil, int x, int y)
      : page_x_((x - stencil.reach) >> 6),
        page_y_((y - stencil.reach) >> 6),
        columns_(1 + ((x + stencil.reach) >> 6) - page_x_),
        rows_(1 + ((y + stencil.reach) >> 6) - page_y_),
        pages_x_(static_cast<std::uint32_t>(grid.pages_x())) {
    int lane = 0;
    for (const SplatStencil::Run& run : stencil.runs) {
      const int row = y + run.y, end = x + run.x + run.length;
      const int page_row = (row >> 6) == page_y_ ? 0 : 2, in_column = (row >> 3 & 7) << 9 | (row & 7) << 3;
      for (int column = x + run.x; column < end;) {
        const int next = std::min(end, (column | 7) + 1);
        pieces_[num_pieces_++] = {
            .texel = static_cast<std::uint16_t>(in_column | (column >> 3 & 7) << 6 | (column & 7)),
            .lane = static_cast<std::uint16_t>(lane),
            .page = static_cast<std::uint8_t>(page_row + ((column >> 6) == page_x_ ? 0 : 1)),
            .num = static_cast<std::uint8_t>(next - column)};
        lane += next - column;
        column = next;
      }
    }
  }

  /// Numbers of the pages in the order of Pages; where there are fewer than two rows or columns, some of them again.
  [[nodiscard]] std::array<std::uint32_t, 4> pages() const {
    std::array<std::uint32_t, 4> out;
    for (int i = 0; i < 4; ++i) {
      const int row = page_y_ + (i < 2 || rows_ == 1 ? 0 : 1), column = page_x_ + (i % 2 == 0 || columns_ == 1 ? 0 : 1);
      out[i] = static_cast<std::uint32_t>(row) * pages_x_ + static_cast<std::uint32_t>(column);
    }
    return out;
  }

  /// A piece of a row in one tile: work(which page, first texel in it, first lane, how many).
  template <class Work>
  void each_piece(Work&& work) const {
    for (std::size_t k = 0; k < num_pieces_; ++k) {
      const Piece& piece = pieces_[k];
      work(std::uint32_t{piece.page}, std::uint32_t{piece.texel}, std::uint32_t{piece.lane}, std::uint32_t{piece.num});
    }
  }

  /// @param lanes  With kSlack.
  void gather(const Pages<const std::uint16_t>& pages, std::uint16_t* lanes) const {
    each_piece([&](std::uint32_t page, std::uint32_t texel, std::uint32_t lane, std::uint32_t num) {
      const std::uint16_t* from = pages[page] + texel;
      // Eight at once, of which the next piece writes over those that are not of this one.
      if (texel + TileGrid::kTileSide <= TileGrid::kPageTexels) {
        std::memcpy(lanes + lane, from, TileGrid::kTileSide * sizeof(std::uint16_t));
      } else {
        std::memcpy(lanes + lane, from, num * sizeof(std::uint16_t));
      }
    });
  }
  /// @param pages  What lies on one that is null is left out.
  void scatter(const std::uint16_t* lanes, const Pages<std::uint16_t>& pages) const {
    each_piece([&](std::uint32_t page, std::uint32_t texel, std::uint32_t lane, std::uint32_t num) {
      if (pages[page] == nullptr) return;
      std::uint16_t* to = pages[page] + texel;
      if (num == TileGrid::kTileSide) {
        std::memcpy(to, lanes + lane, TileGrid::kTileSide * sizeof(std::uint16_t));
      } else {
        for (std::uint32_t i = 0; i < num; ++i) to[i] = lanes[lane + i];
      }
    });
  }
  /// Whether some of `num` lanes, at most 8, is not 0. @param lanes  With kSlack.
  [[nodiscard]] static bool some(const std::uint16_t* lanes, std::uint32_t num) {
    std::array<std::uint64_t, 2> four;
    std::memcpy(four.data(), lanes, sizeof(four));
    if (num < 4) return (four[0] & ((std::uint64_t{1} << 16 * num) - 1)) != 0;
    return (four[0] | (num == 8 ? four[1] : four[1] & ((std::uint64_t{1} << 16 * (num - 4)) - 1))) != 0;
  }

 private:
  struct Piece {
    std::uint16_t texel, lane;
    std::uint8_t page, num;
  };
  /// Rows of up to 31 texels, each in up to 5 tiles.
  static constexpr std::size_t kMaxPieces = 160;

  int page_x_, page_y_;
  int columns_, rows_;
  std::size_t num_pieces_ = 0;
  std::array<Piece, kMaxPieces> pieces_;
  std::uint32_t pages_x_;
};

}  // namespace patinate::simulation
