/// \file
/// The neighbors of all texels at one fixed list of offsets on the surface, and where they really lie.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "libcommon/atlas/texel_set.h"
#include "libcommon/core/kernel_language.h"
#include "patinate/atlas/texel_map.h"
#include "patinate/core/run_control.h"

namespace patinate {

/// A neighbor in pixels of what is laid on the surface.
struct PixelNeighbor {
  TexelId texel = -1;
  std::int16_t x = 0, y = 0;  ///< TexelNeighbor::offset_mm in units of 1/256 pixel; neighbors that lie farther than 127
                              ///< pixels are excluded (-1).

  static constexpr int kOne = 256;
  friend bool operator==(const PixelNeighbor&, const PixelNeighbor&) = default;
};

/// The nearest whole pixel of a length in units of 1/256.
[[nodiscard]] constexpr int whole_pixels(std::int32_t fixed) { return (fixed + PixelNeighbor::kOne / 2) >> 8; }

/// texel_neighbors.inl for C++; devices read the same text.
namespace neighbor_kernel {
using namespace kernel_types;
#include "libcommon/atlas/texel_neighbors.inl"
}  // namespace neighbor_kernel
/// The text of texel_neighbors.inl.
extern const std::string_view kNeighborKernel;

/// Arrays that NeighborTables point to.
struct FlatNeighbors {
  std::vector<std::int32_t> row;
  std::vector<std::uint64_t> is_stored;
  std::vector<std::uint32_t> begin;
  std::vector<neighbor_kernel::PackedNeighbor> stored;
  std::vector<std::int32_t> steps_of;
  std::vector<neighbor_kernel::PackedNeighbor> steps;
};

/// Neighbors of every texel at one fixed list of offsets, and the eight texels beside it, whatever their size: those
/// that lie where their triangle's own grid says are computed, triangle by triangle, and only the others are stored: in
/// bands along seams. In triangles of few texels that costs more than it saves, and all neighbors in the bands are
/// stored.
class TexelNeighborhood {
 public:
  /// @param map       Must outlive this.
  /// @param frames    What offsets are measured along.
  /// @param pixel_mm  > 0. Of PixelNeighbor.
  TexelNeighborhood(const TexelMap& map, std::vector<Vec2> offsets_mm, std::shared_ptr<const FlowFrames> frames,
                    double pixel_mm, const RunControl& control = {});

  /// All: those at the offsets first, then from first_adjacent() on the eight beside (row by row; a step of one texel).
  [[nodiscard]] std::size_t size() const { return offsets_mm_.size() + kNumAdjacent; }
  [[nodiscard]] std::size_t first_adjacent() const { return offsets_mm_.size(); }
  static constexpr std::size_t kNumAdjacent = 8;
  /// Texels in the bands.
  [[nodiscard]] std::int64_t num_stored() const { return static_cast<std::int64_t>(band_.size()); }
  [[nodiscard]] std::int64_t stored_bytes() const;
  /// Those in the bands.
  [[nodiscard]] const TexelSet& band() const { return band_; }
  [[nodiscard]] double pixel_mm() const { return pixel_mm_; }
  /// Neighbors that Cursor finds, for a device: 4 bytes a texel, and size() * 8 for each triangle with texels.
  /// @throws InvalidInput if the atlas has 2^31 texels or more.
  [[nodiscard]] FlatNeighbors flat(const RunControl& control = {}) const;
  /// Pixels of a texel step to the right and one down (columns) in a triangle.
  [[nodiscard]] Eigen::Matrix2d pixels_per_texel(int triangle) const;

  /// Looks neighbors up, quickly for texels of a few triangles. One for each thread.
  class Cursor {
   public:
    explicit Cursor(const TexelNeighborhood& neighborhood)
        : neighborhood_(neighborhood), steps_(neighborhood.size() * kNumKept), found_(neighborhood.size()) {
      triangles_.fill(-1);
    }
    /// Neighbors of a covered texel as TexelMap::gather() finds them. Valid until the next call.
    [[nodiscard]] std::span<const PixelNeighbor> at(TexelId t);

   private:
    friend class TexelNeighborhood;
    /// Follows the grid of a texel's own triangle.
    void follow_grid(TexelId t);

    const TexelNeighborhood& neighborhood_;
    static constexpr std::size_t kNumKept = 8;
    std::array<int, kNumKept> triangles_{};  ///< At their index modulo kNumKept; -1 = none.
    std::vector<PixelNeighbor> steps_;       ///< Steps of those triangles: texel = how far on.
    std::vector<PixelNeighbor> found_;
  };

 private:
  struct Stored {
    std::uint32_t texel = kNone;
    std::int16_t x = 0, y = 0;
    static constexpr std::uint32_t kNone = 0xFFFFFFFF;
  };
  static constexpr std::size_t kMaxNeighbors = 128;
  /// Row that says which neighbors of a texel are stored, and where its first one is.
  struct Row {
    std::array<std::uint64_t, kMaxNeighbors / 64> is_stored{};
    std::uint32_t begin = 0;
  };
  /// Rows whose neighbors were found together.
  struct Chunk {
    std::vector<Row> rows;
    std::vector<Stored> stored;
  };
  static constexpr std::size_t kChunk = 4096;
  [[nodiscard]] PixelNeighbor in_pixels(const TexelNeighbor& n) const;
  void find_steps(int triangle, std::span<PixelNeighbor> steps) const;
  void find_all_steps(const RunControl& control);
  [[nodiscard]] std::vector<bool> follow_their_grid(const std::vector<int>& reach) const;
  void store(std::size_t chunk, const std::vector<bool>& follows_grid);

  const TexelMap& map_;
  std::vector<Vec2> offsets_mm_;
  std::shared_ptr<const FlowFrames> frames_;
  double pixel_mm_;
  std::vector<PixelNeighbor> steps_;  ///< By triangle, as find_steps() says; empty: too many triangles, or too few.
  TexelSet band_;                     ///< Texels with a row.
  std::vector<Chunk> chunks_;         ///< kChunk rows each.
};

}  // namespace patinate
