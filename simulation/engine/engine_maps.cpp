// Images of a simulation: amounts, what maps counted, what was met, and what is covered.
#include <algorithm>
#include <cmath>
#include <optional>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "simulation/engine/engine_state.h"

namespace patinate::simulation {

void check_parameter_map(const std::string& name, const std::vector<std::string>& materials) {
  const std::vector<std::string> known = parameter_map_names(materials);
  if (std::find(known.begin(), known.end(), name) != known.end()) return;
  std::string list;
  for (const std::string& one : known) list += (list.empty() ? "" : ", ") + one;
  throw InvalidInput("there is no parameter map '" + name + "'; use one of " + list + did_you_mean(name, known));
}

namespace {

/// A value of every texel in the user's order of pixels.
template <class Value>
ImageF image_of(const SurfaceAtlas& surface, Value&& value) {
  const TileGrid& grid = surface.grid();
  ImageF image(grid.width, grid.height, 1);
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const TexelIndex t = grid.index(x, y);
      if (surface.is_covered(t)) image.at(x, y) = static_cast<float>(value(t));
    }
  }
  return image;
}

}  // namespace

ImageF Simulation::amounts(int material) const {
  state_->copy_to_host();
  return image_of(state_->surface, [&](TexelIndex t) {
    return double{static_cast<double>(state_->atlas.amount(material, t))} / kAmountOne;
  });
}

ImageF Simulation::original_amounts(int material) const {
  return image_of(state_->surface,
                  [&](TexelIndex t) { return static_cast<double>(state_->atlas.original(material, t)) / kAmountOne; });
}

void Simulation::set_amounts(int material, const ImageF& amounts) {
  State& s = *state_;
  s.change_on_host();
  const TileGrid& grid = s.surface.grid();
  if (amounts.width() != grid.width || amounts.height() != grid.height) {
    throw InvalidInput("the amounts are " + size_text(amounts.width(), amounts.height()) + " texels; the atlas has " +
                       size_text(grid.width, grid.height));
  }
  for (const float a : amounts.values()) {
    if (!(a >= 0.0f && a < 4.0f))
      throw InvalidInput("an amount is " + number_text(static_cast<double>(a)) + "; use [0, 4)");
  }
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const TexelIndex t = grid.index(x, y);
      const auto quanta = static_cast<std::uint16_t>(
          std::min<long>(kMaxAmount, std::lround(static_cast<double>(amounts.at(x, y)) * kAmountOne)));
      if (!s.surface.is_covered(t) || s.atlas.amount(material, t) == quanta) continue;
      s.atlas.writable_tile(material, TileGrid::tile_of(t))[t % TileGrid::kTileTexels] = quanta;
      s.changed_in[TileGrid::tile_of(t)] = static_cast<std::int32_t>(s.iteration);
    }
  }
  s.rules->wake_everything();
}

ParameterMap Simulation::parameter_map(const std::string& name) const {
  state_->copy_to_host();
  const State& s = *state_;
  const ParameterMaps& maps = *s.maps;
  check_parameter_map(name, s.scene.materials);
  const auto counted = [&](const auto* values, const auto& meaning) {
    if (!values) throw InvalidInput("the parameter map '" + name + "' was not asked for when the simulation began");
    return image_of(s.surface, [&](TexelIndex t) { return meaning(t, static_cast<double>(values->value(t))); });
  };
  // A texel that contacts reach from more of the surface, since it is larger or more of their splats have a part of it,
  // is met more often, and its last contact is less long ago: chart by chart, maps would show the UVs.
  const double median_reach = reached_from(s.scene.exchange, s.surface, SurfaceAtlas::kMedianWeight);
  const auto reach = [&](TexelIndex t) {
    return reached_from(s.scene.exchange, s.surface, s.surface.weight(t)) / median_reach;
  };
  const double now = static_cast<double>(s.iteration), time = s.scene.time_per_iteration;
  if (name == "hits") {
    return {name, counted(maps.hits(), [&](TexelIndex t, double n) { return n / s.surface.area_mm2(t); }), "1/mm2"};
  }
  if (name == "last_hit") {
    const auto last = [&](TexelIndex t, double at) {
      // Half an iteration more and less: a contact lies anywhere in its iteration.
      return at == 0.0 ? 0.0 : time * std::clamp(now - ((now - at + 0.5) * reach(t) - 0.5), 0.0, now);
    };
    return {name, counted(maps.choice().last_hit ? maps.last_hit() : nullptr, last), "time"};
  }
  if (name == "residence") {
    const auto residence = [&](TexelIndex t, double n) {
      const double dry = now > 0.0 ? std::max(0.0, 1.0 - n / now) : 1.0;
      return time * now * (1.0 - std::pow(dry, 1.0 / reach(t)));
    };
    return {name, counted(maps.residence(), residence), "time"};
  }
  for (std::size_t m = 0; m < s.scene.materials.size(); ++m) {
    const auto material = static_cast<int>(m);
    if (name == s.scene.materials[m] + ".final") return {name, amounts(material), "amount"};
    if (name != s.scene.materials[m] + ".deposited") continue;
    const auto* values = maps.deposited(material);
    if (!values) break;
    // Mass over area: an amount.
    return {name,
            image_of(s.surface,
                     [&](TexelIndex t) {
                       return static_cast<double>(values->value(t)) / (double{kAmountOne} * s.surface.weight(t));
                     }),
            "amount"};
  }
  throw InvalidInput("the parameter map '" + name + "' was not asked for when the simulation began");
}

std::optional<ImageU8> Simulation::met(const RunControl& control) const {
  state_->copy_to_host(control);
  const State& s = *state_;
  if (!s.met) return std::nullopt;
  return reached_texels(*s.met, s.scene.exchange, s.surface, control);
}

std::vector<ObjectSquare> Simulation::object_squares() const {
  std::vector<ObjectSquare> squares;
  const State& s = *state_;
  const double resolution = s.scene.resolution;
  for (std::size_t i = 0; i < s.scene.objects.size(); ++i) {
    const auto [u, v, side] = s.scene_mesh.uv_squares[i];
    squares.push_back({.name = s.scene.objects[i].name,
                       .x = static_cast<int>(std::lround(u * resolution)),
                       .y = static_cast<int>(std::lround((1.0 - v - side) * resolution)),
                       .side = static_cast<int>(std::lround(side * resolution))});
  }
  return squares;
}

ImageU8 Simulation::coverage() const {
  const TileGrid& grid = state_->surface.grid();
  ImageU8 mask(grid.width, grid.height, 1);
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) mask.at(x, y) = state_->surface.is_covered(grid.index(x, y)) ? 255 : 0;
  }
  return mask;
}

}  // namespace patinate::simulation
