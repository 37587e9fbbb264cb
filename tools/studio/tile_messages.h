/// \file
/// What travels: sets of dirty tiles, and the binary messages made of them.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "patinate/core/json.h"
#include "tools/studio/tile_planes.h"

namespace patinate::studio {

/// Tiles that one client does not have in their newest state. A tile is in it once, however often it has changed.
class DirtyTiles {
 public:
  explicit DirtyTiles(ScreenTile num_tiles) : words_((num_tiles + 63) / 64), num_tiles_(num_tiles) {}

  void add(std::span<const ScreenTile> tiles);
  void add_all();
  [[nodiscard]] bool empty() const;
  /// All of them, in order; none are left.
  [[nodiscard]] std::vector<ScreenTile> take();

 private:
  std::vector<std::uint64_t> words_;
  ScreenTile num_tiles_;
};

inline constexpr std::size_t kMaxMessageBytes = std::size_t{4} << 20;

/// u32 header_bytes, header (padded with spaces so that the payload begins at a multiple of 4), payload.
[[nodiscard]] std::string binary_message(const Json& header, std::string_view payload);
/// One plane of an update, in as many messages as it takes to stay within kMaxMessageBytes; none without tiles.
/// @param header      Its "count" and "last" are set here; "last" of the last message is `is_last`.
/// @param tile_bytes  Of one tile.
[[nodiscard]] std::vector<std::string> tile_messages(
    Json header, std::span<const ScreenTile> tiles, bool is_last,
    const std::function<std::span<const std::uint8_t>(ScreenTile)>& tile_bytes);

}  // namespace patinate::studio
