// Updates that clients see: tiles, hashes, gammatons.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "simulation/tracing/gammatons.h"
#include "tools/studio/live_client.h"
#include "tools/studio/plane_hash.h"

namespace patinate::studio {

namespace {

constexpr std::size_t kMaxUpdateBytes = std::size_t{16}
                                        << 20;  ///< A client that has acknowledged what it has not read yet waits.

constexpr std::chrono::milliseconds kMeasureEvery{500};

/// The range that holds all covered heights of some tiles, widened by doubling.
ReliefRange widened(ReliefRange range, const simulation::Composer& composer, const simulation::SurfaceAtlas& surface,
                    std::span<const simulation::TileIndex> tiles) {
  double most = 0.0;
  for (const simulation::TileIndex tile : tiles) {
    for (simulation::TexelIndex t = tile * 64; t < tile * 64 + 64; ++t) {
      if (surface.is_covered(t)) most = std::max(most, std::abs(composer.height_mm(t)));
    }
  }
  while (range.high_mm < most) range = {2.0 * range.low_mm, 2.0 * range.high_mm};
  return range;
}

}  // namespace

/// Composes what has changed and tells every client's dirty tiles.
void LiveEngine::refresh() {
  const RunControl control{.on_progress = {}, .stop = {}, .num_threads = options_.num_threads};
  const simulation::Composer& composer = simulation_.compose(control);
  const simulation::SurfaceAtlas& surface = simulation_.atlas().surface();
  std::span<const simulation::TileIndex> composed = simulation_.composed_tiles();
  const ReliefRange range = widened(relief_, composer, surface, composed);
  std::vector<simulation::TileIndex> all;
  bool has_new_range = range.high_mm != relief_.high_mm;
  if (has_new_range) {
    relief_ = range;
    for (simulation::TileIndex t = 0; t < surface.grid().num_tiles(); ++t) all.push_back(t);
    composed = all;
  }
  const TilePlanes::Changes changes = planes_.update(composer, layout_.showing(composed), relief_, control);
  for (const auto& [id, client] : clients_) {
    client->surface.add(changes.surface);
    client->relief.add(changes.relief);
  }
  if (material_) {
    const std::vector<ScreenTile> tiles = material_->update(simulation_);
    for (const auto& [id, client] : clients_) client->material.add(tiles);
  }
  for (auto& [name, overlay] : overlays_) {
    const double high = overlay.high();
    const std::vector<ScreenTile> tiles = overlay.update(simulation_);
    has_new_range = has_new_range || overlay.high() != high;
    for (const auto& [id, client] : clients_) {
      if (client->overlay_name == name) client->overlay.add(tiles);
    }
  }
  if (has_new_range && said_) send_scene();
}

/// The ranges of what is watched, a while after it has changed: the last change is measured too.
void LiveEngine::measure_overlays() {
  if (Clock::now() - measured_ < kMeasureEvery ||
      std::none_of(overlays_.begin(), overlays_.end(), [](const auto& o) { return o.second.is_stale(); }))
    return;
  bool is_other = false;
  for (auto& [name, overlay] : overlays_) is_other = (overlay.is_stale() && overlay.measure(simulation_)) || is_other;
  measured_ = Clock::now();
  if (is_other) send_scene();
}

bool LiveEngine::is_due(const Client& c) const {
  if (!c.has_credit() || c.peer->num_waiting_bytes() > kMaxUpdateBytes ||
      Clock::now() - c.last_update < std::chrono::duration<double>(1.0 / options_.most_updates_s))
    return false;
  if (c.wants_hash || c.shown_state != state_number()) return true;
  return (c.wants_surface && !c.surface.empty()) || (c.wants_relief && !c.relief.empty()) ||
         (material_ && c.wants_material && !c.material.empty()) || (!c.overlay_name.empty() && !c.overlay.empty());
}

void LiveEngine::send_update(Client& c) {
  const std::vector<ScreenTile> surface = c.wants_surface ? c.surface.take() : std::vector<ScreenTile>();
  const std::vector<ScreenTile> relief = c.wants_relief ? c.relief.take() : std::vector<ScreenTile>();
  const std::vector<ScreenTile> material =
      material_ && c.wants_material ? c.material.take() : std::vector<ScreenTile>();
  const std::vector<ScreenTile> overlay = c.overlay_name.empty() ? std::vector<ScreenTile>() : c.overlay.take();
  const bool is_empty = surface.empty() && relief.empty() && material.empty() && overlay.empty();
  c.shown_state = state_number();
  if (is_empty && !c.wants_hash && c.num_gammatons == 0) return;
  if (std::exchange(c.wants_hash, false)) {
    Json hash{{"type", "hash"},
              {"iteration", simulation_.iteration()},
              {"surface", xxh64(planes_.rows(TilePlanes::Surface))},
              {"relief", xxh64(planes_.rows(TilePlanes::Relief))}};
    if (material_ && c.wants_material) hash["material"] = xxh64(material_->rows());
    c.peer->send_text(hash.dump());
  }
  if (c.num_gammatons > 0) send_gammatons(c);
  Json header{{"type", "tiles"},
              {"update", ++c.num_sent},
              {"iteration", simulation_.iteration()},
              {"plane", "surface"},
              {"tile", 8},
              {"count", 0},
              {"width", layout_.width()},
              {"height", layout_.height()},
              {"last", true}};
  const auto send = [&](const char* plane, const std::vector<ScreenTile>& tiles, bool is_last, const auto& bytes) {
    header["plane"] = plane;
    for (std::string& message : tile_messages(header, tiles, is_last, bytes)) c.peer->send_binary(std::move(message));
  };
  send("surface", surface, relief.empty() && material.empty() && overlay.empty(),
       [&](ScreenTile t) { return planes_.tile(TilePlanes::Surface, t); });
  send("relief", relief, material.empty() && overlay.empty(),
       [&](ScreenTile t) { return planes_.tile(TilePlanes::Relief, t); });
  if (material_) send("material", material, overlay.empty(), [&](ScreenTile t) { return material_->tile(t); });
  if (!overlay.empty()) {
    const OverlayPlane& plane = overlays_.at(c.overlay_name);
    send("overlay", overlay, true, [&](ScreenTile t) { return plane.tile(t); });
  }
  if (is_empty) c.peer->send_binary(binary_message(header, {}));
  c.last_update = Clock::now();
}

/// Those under way, evenly taken from all when they are more than were asked for.
void LiveEngine::send_gammatons(Client& c) {
  const simulation::Gammatons& g = simulation_.gammatons();
  std::vector<std::size_t> alive;
  for (std::size_t i = 0; i < g.size(); ++i) {
    if (g.state[i] != simulation::GammatonState::Waiting) alive.push_back(i);
  }
  const std::size_t count = std::min(alive.size(), static_cast<std::size_t>(c.num_gammatons));
  std::string payload(count * 12, '\0');
  for (std::size_t k = 0; k < count; ++k) {
    const Eigen::Vector3f p = g.position[alive[k * alive.size() / count]].cast<float>();
    std::memcpy(&payload[12 * k], p.data(), 12);
  }
  c.peer->send_binary(binary_message(Json{{"type", "gammatons"}, {"count", count}}, payload));
}

}  // namespace patinate::studio
