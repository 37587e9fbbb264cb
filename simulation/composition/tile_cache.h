/// \file
/// Bytes of an atlas that are worked out tile by tile when first asked for.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>
#include <span>
#include <vector>

#include "patinate/simulation/surface_atlas.h"

namespace patinate::simulation::composition {

/// Memory is the operating system's zeros until a tile is made. Different tiles may be asked for by several threads at
/// once.
class TileCache {
 public:
  TileCache() = default;
  TileCache(TileIndex num_tiles, std::size_t bytes_a_tile) : bytes_a_tile_(bytes_a_tile), is_made_(num_tiles, 0) {
    bytes_.reset(static_cast<std::uint8_t*>(std::calloc(num_tiles, bytes_a_tile)));
    if (!bytes_) throw std::bad_alloc();
  }
  [[nodiscard]] bool empty() const { return bytes_ == nullptr; }

  /// @param make  make(std::span<std::uint8_t>) writes the tile's bytes.
  template <class Make>
  [[nodiscard]] const std::uint8_t* tile(TileIndex tile, Make&& make) {
    std::uint8_t* const bytes = bytes_.get() + tile * bytes_a_tile_;
    if (is_made_[tile] == 0) {
      make(std::span(bytes, bytes_a_tile_));
      is_made_[tile] = 1;
    }
    return bytes;
  }
  [[nodiscard]] std::size_t memory() const {
    std::size_t bytes = is_made_.size();
    for (const std::uint8_t is_made : is_made_) bytes += is_made * bytes_a_tile_;
    return bytes;
  }

 private:
  struct Free {
    void operator()(std::uint8_t* bytes) const { std::free(bytes); }
  };
  std::size_t bytes_a_tile_ = 0;
  std::unique_ptr<std::uint8_t[], Free> bytes_;
  std::vector<std::uint8_t> is_made_;
};

}  // namespace patinate::simulation::composition
