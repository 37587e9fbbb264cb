#include "tools/studio/tile_messages.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>

namespace patinate::studio {

void DirtyTiles::add(std::span<const ScreenTile> tiles) {
  for (const ScreenTile t : tiles) words_[t / 64] |= std::uint64_t{1} << (t % 64);
}

void DirtyTiles::add_all() {
  std::fill(words_.begin(), words_.end(), ~std::uint64_t{0});
  if (num_tiles_ % 64 != 0) words_.back() = (std::uint64_t{1} << (num_tiles_ % 64)) - 1;
}

bool DirtyTiles::empty() const {
  return std::all_of(words_.begin(), words_.end(), [](std::uint64_t w) { return w == 0; });
}

std::vector<ScreenTile> DirtyTiles::take() {
  std::vector<ScreenTile> tiles;
  for (std::size_t i = 0; i < words_.size(); ++i) {
    for (std::uint64_t w = std::exchange(words_[i], 0); w != 0; w &= w - 1) {
      tiles.push_back(static_cast<ScreenTile>(64 * i) + static_cast<ScreenTile>(std::countr_zero(w)));
    }
  }
  return tiles;
}

std::string binary_message(const Json& header, std::string_view payload) {
  std::string text = header.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const auto size = static_cast<std::uint32_t>(text.size());
  std::string message(sizeof(size), '\0');
  std::memcpy(message.data(), &size, sizeof(size));
  message.reserve(message.size() + text.size() + payload.size());
  return message.append(text).append(payload);
}

std::vector<std::string> tile_messages(Json header, std::span<const ScreenTile> tiles, bool is_last,
                                       const std::function<std::span<const std::uint8_t>(ScreenTile)>& tile_bytes) {
  constexpr std::size_t kHeaderRoom = 1024;
  std::vector<std::string> messages;
  if (tiles.empty()) return messages;
  const std::size_t bytes_a_tile = sizeof(ScreenTile) + tile_bytes(tiles.front()).size();
  const std::size_t most = (kMaxMessageBytes - kHeaderRoom) / bytes_a_tile;
  for (std::size_t begin = 0; begin < tiles.size(); begin += most) {
    const std::span<const ScreenTile> part = tiles.subspan(begin, std::min(most, tiles.size() - begin));
    header["count"] = part.size();
    header["last"] = is_last && begin + part.size() == tiles.size();
    std::string payload(part.size() * sizeof(ScreenTile), '\0');
    std::memcpy(payload.data(), part.data(), payload.size());
    payload.reserve(part.size() * bytes_a_tile);
    for (const ScreenTile t : part) {
      const std::span<const std::uint8_t> bytes = tile_bytes(t);
      payload.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    }
    messages.push_back(binary_message(header, payload));
  }
  return messages;
}

}  // namespace patinate::studio
