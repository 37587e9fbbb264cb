/// \file
/// What a LiveEngine knows of a client. For live_*.cpp.
#pragma once

#include "tools/studio/live_engine.h"

namespace patinate::studio {

inline constexpr std::int64_t kMaxUnacknowledged = 2;

struct LiveEngine::Client {
  Client(std::shared_ptr<WebSocketPeer> given, ScreenTile num_tiles)
      : peer(std::move(given)), surface(num_tiles), relief(num_tiles), material(num_tiles), overlay(num_tiles) {
    surface.add_all();
    relief.add_all();
  }
  [[nodiscard]] bool has_credit() const { return num_sent - num_acknowledged < kMaxUnacknowledged; }

  std::shared_ptr<WebSocketPeer> peer;
  DirtyTiles surface, relief, material, overlay;
  bool wants_surface = true;
  bool wants_relief = true;
  bool wants_material = false;  ///< Water is a film then.
  std::string overlay_name;     ///< "" = none.
  std::int64_t num_gammatons = 0;
  std::int64_t num_sent = 0;  ///< Updates; the number of the last one.
  std::int64_t num_acknowledged = 0;
  std::int64_t shown_state = -1;  ///< state_number() of the last update.
  bool wants_hash = false;
  bool wants_status = false;  ///< There is a newer one than it has.
  Clock::time_point last_update{};
};

/// {"type": "done"} with the id of the request and further members.
[[nodiscard]] std::string done_text(const Json& id, const Json& answer = Json::object());
[[nodiscard]] std::string error_text(const Json& id, const std::string& message);
/// Says why nothing runs here and closes, so that a client knows not to come back by itself.
void refuse(WebSocketPeer& peer, const std::string& why);

}  // namespace patinate::studio
