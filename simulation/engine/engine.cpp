#include "patinate/simulation/engine.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>

#include "libcommon/core/stopwatch.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "simulation/engine/engine_state.h"
#include "simulation/rules/initial_amounts.h"
#include "simulation/rules/initial_layers.h"

namespace patinate::simulation {

namespace {

CargoEnd cargo_end(DeathReason reason) {
  switch (reason) {
    case DeathReason::Absorbed:
      return CargoEnd::Absorbed;
    case DeathReason::Rested:
      return CargoEnd::Rested;
    case DeathReason::Left:
      break;
  }
  return CargoEnd::Left;
}

ParameterMapChoice choice_of(const std::vector<std::string>& names, const std::vector<std::string>& materials) {
  ParameterMapChoice choice;
  for (const std::string& name : names) {
    if (name == "hits") choice.hits = true;
    if (name == "last_hit") choice.last_hit = true;
    if (name == "residence") choice.residence = true;
    for (std::size_t m = 0; m < materials.size(); ++m) {
      if (name == materials[m] + ".deposited") choice.deposited[m] = true;
    }
  }
  return choice;
}

Scene checked(Scene scene) {
  check_scene(scene);
  return scene;
}

SimulationOptions checked(SimulationOptions options, const Scene& scene) {
  for (const std::string& name : options.parameter_maps) check_parameter_map(name, scene.materials);
  return options;
}

}  // namespace

std::vector<std::array<std::uint16_t, kMaxMaterials>> originals_of(const Scene& scene) {
  std::vector<std::array<std::uint16_t, kMaxMaterials>> originals;
  for (const SceneObject& object : scene.objects) {
    std::array<std::uint16_t, kMaxMaterials> quanta{};
    for (std::size_t m = 0; m < scene.materials.size(); ++m)
      quanta[m] = static_cast<std::uint16_t>(std::lround(object.preset.amounts[m] * kAmountOne));
    originals.push_back(quanta);
  }
  return originals;
}

Simulation::State::State(Scene given, SimulationOptions given_options, const RunControl& control)
    : scene(checked(std::move(given))),
      options(checked(std::move(given_options), scene)),
      scene_mesh(make_scene_mesh(scene)),
      surface(scene_mesh, scene.resolution, control.part(0.0, 0.6)),
      atlas(surface, static_cast<int>(scene.materials.size()), originals_of(scene)),
      layers(has_layers(scene) ? std::make_unique<LayerAtlas>(surface, scene) : nullptr),
      tracer(scene_mesh, surface),
      gammatons(make_gammatons(scene)),
      met(surface.grid()),
      exchanger(static_cast<int>(scene.materials.size()), scene.seed),
      composer(scene, scene_mesh, surface, options.color_form, control.part(0.6, 0.9)),
      changed_in(surface.grid().num_tiles(), -1) {
  composer.on_lost([this](const device::DeviceError& error) {
    lose_device(error, {});
    compose_again();
  });
  composer.on_asked([this] { check_room(); });
  for (std::size_t k = 0; k < kNumWeatherSignals; ++k)
    weather_peaks[k] = greatest_weather(scene.weather, static_cast<WeatherSignal>(k));
  for (const SceneObject& object : scene.objects) start_scales.push_back(object.scale);
  scale_factors.assign(scene.objects.size(), 1.0);
  for (const SceneEvent& event : scene.events) {
    const auto* scaling = std::get_if<ScaleEvent>(&event.what);
    for (std::size_t i = 0; scaling && i < scene.objects.size(); ++i) {
      if (scene.objects[i].name == scaling->object) check_scale(i, scaling->scale);
    }
  }
  cargo.mass.resize(gammatons.size());
  trails.resize(gammatons.size());
  check_emitters(scene, scene_mesh, tracer.rays());
  notes = describe_meshes(scene_mesh);
  const LaidAmounts laid = lay_initial_amounts(scene, scene_mesh, atlas);
  ledger.add_rules(laid.more, laid.less);
  if (layers) interface_materials = materials_at_interfaces(scene);
  if (layers) lay_initial_layers(scene, scene_mesh, *layers, control.silent());
  composer.set_layers(layers.get());
  if (layers && options.device)
    notes.emplace_back("the scene has layers: it runs on the CPU, and the device is not used");
  const ParameterMapChoice choice = choice_of(options.parameter_maps, scene.materials);
  maps = std::make_unique<ParameterMaps>(surface.grid(), choice);
  rules = make_rules(control);
  control.report(1.0);
}

void Simulation::State::begin_lives_and_end_them(ExchangeTime now, const RunControl& control) {
  const double area = contact_area(scene.exchange, surface);
  for (const std::uint32_t g : trace.born) {
    const Emitter& emitter = scene.emitters[gammatons.emitter[g]];
    ledger.birth(g, MassLedger::cargo_of(emitter.carries, area), cargo);
  }
  ended.clear();
  for (const Death& death : trace.died) {
    if (death.reason != DeathReason::Left) ended.push_back(death.gammaton);
  }
  deposit(ended, now, control);
  for (const Death& death : trace.died) ledger.end(death.gammaton, cargo_end(death.reason), cargo);
  counters += trace.counters;
  counters.alive = trace.counters.alive;
}

void Simulation::State::deposit(std::span<const std::uint32_t> gone, ExchangeTime now, const RunControl& control) {
  if (!scene.exchange.deposit) return;
  const Stopwatch watch(times.exchange);
  endings.clear();
  for (const std::uint32_t g : gone) {
    if (trails[g].size() > 0) endings.push_back({.gammaton = g, .trail = trails[g]});
  }
  if (endings.empty()) return;
  const ExchangeReport report = exchanger.deposit(endings, scene.exchange, now, cargo, atlas, maps.get(), control);
  ledger.add(report);
  mark(report.dirty_tiles);
  rules->wake(report.dirty_tiles);
}

std::optional<WetPaths> Simulation::State::wet_paths() {
  const TracingOptions& o = scene.tracing;
  const auto found = std::find(scene.materials.begin(), scene.materials.end(), o.wet_material);
  if (!(o.wet_attraction > 0.0) || found == scene.materials.end()) return std::nullopt;
  return WetPaths{.atlas = &atlas,
                  .material = static_cast<int>(found - scene.materials.begin()),
                  .weight = o.wet_attraction,
                  .width_mm = o.rivulet_mm};
}

void Simulation::State::follow_contacts() {
  follow(trace.contacts, trails);
  if (met) met->add(trace.contacts);
}

void Simulation::State::mark(std::span<const TileIndex> tiles) {
  for (const TileIndex t : tiles) changed_in[t] = static_cast<std::int32_t>(iteration);
}

Simulation::Simulation(Scene scene, SimulationOptions options, const RunControl& control)
    : state_(std::make_unique<State>(std::move(scene), std::move(options), control)) {}
Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;

const Scene& Simulation::scene() const { return state_->scene; }
std::int64_t Simulation::iteration() const { return state_->iteration; }
std::int64_t Simulation::num_paint_steps() const { return state_->num_paint_steps; }
double Simulation::time() const { return static_cast<double>(state_->iteration) * state_->scene.time_per_iteration; }
const std::vector<std::string>& Simulation::notes() const { return state_->notes; }
const MaterialAtlas& Simulation::atlas() const {
  state_->copy_to_host();
  return state_->atlas;
}
const TraceCounters& Simulation::counters() const {
  state_->copy_to_host();
  return state_->counters;
}
const LayerAtlas* Simulation::layers() const { return state_->layers.get(); }
const SimulationTimes& Simulation::times() const { return state_->times; }
const MassLedger& Simulation::ledger() const {
  state_->copy_to_host();
  return state_->ledger;
}
const Gammatons& Simulation::gammatons() const {
  state_->copy_to_host();
  return state_->gammatons;
}
const Mesh& Simulation::mesh() const { return state_->scene_mesh.mesh; }
double Simulation::texel_size_mm() const { return state_->surface.median_texel_size_mm(); }

std::size_t Simulation::memory() const {
  state_->copy_to_host();
  const State& s = *state_;
  constexpr std::size_t kGammaton =
      sizeof(GammatonState) + 1 + 2 + 4 + 4 + 2 * sizeof(double) + 2 * sizeof(Vec3) + sizeof(s.cargo.mass[0]);
  return s.atlas.memory() + (s.layers ? s.layers->memory() : 0) + s.composer.memory() +
         std::size_t{s.surface.grid().num_texels()} * (sizeof(std::int32_t) + sizeof(std::uint16_t)) +
         (s.met ? s.met->tiles().size_bytes() : 0) + s.gammatons.size() * kGammaton;
}

std::string Simulation::audit(const RunControl& control) const {
  state_->copy_to_host(control);
  const State& s = *state_;
  std::vector<std::int64_t> at_interfaces;
  for (int m = 0; s.layers && m < s.atlas.num_materials(); ++m)
    at_interfaces.push_back(s.layers->interface_mass(m, control));
  const std::string wrong = simulation::audit(s.ledger, s.atlas, s.cargo, s.scene.materials, control, at_interfaces);
  return wrong.empty() && s.layers ? s.layers->audit(control) : wrong;
}

void Simulation::apply(const SceneEvent& event, const RunControl& control) {
  State& s = *state_;
  if (const auto* stroke = std::get_if<PaintEvent>(&event.what)) {
    for (const BrushStop& stop : stroke->stops) {
      for (std::int64_t i = 0; i < stop.steps; ++i) paint(stroke->emitter, stop.position_mm, control);
    }
    return;
  }
  s.change_on_host(control);
  Scene changed = s.scene;
  const bool moves_objects = apply_event(event, changed);
  check_scene(changed);
  for (std::size_t i = 0; i < changed.objects.size(); ++i) s.check_scale(i, changed.objects[i].scale);
  if (std::holds_alternative<RuleEvent>(event.what)) s.set_rules(changed.rules);
  if (moves_objects) s.move_objects(changed);
  s.scene = std::move(changed);
}

void Simulation::step(const RunControl& control) {
  State& s = *state_;
  apply_due(control);
  if (!s.step_on_device(control)) s.step_on_host(control);
  ++s.iteration;
  s.limit_lag(control);
}

void Simulation::State::step_on_host(const RunControl& control) {
  State& s = *this;
  s.change_on_host(control);
  s.apply_weather();
  {
    const Stopwatch watch(s.times.trace);
    s.tracer.trace(s.gammatons, s.scene, s.iteration, s.trace, control);
  }
  s.begin_lives_and_end_them(s.iteration, control);
  {
    const Stopwatch watch(s.times.exchange);
    s.follow_contacts();
    const ExchangeReport report =
        s.exchanger.exchange(s.trace.contacts, s.scene.exchange, s.iteration, s.cargo, s.atlas, s.maps.get(), control);
    s.ledger.add(report);
    s.mark(report.dirty_tiles);
    s.rules->wake(report.dirty_tiles);
  }
  const std::unique_ptr<SurfaceNormals> normals = s.bounce_normals(control);
  {
    const Stopwatch watch(s.times.respond);
    const std::optional<WetPaths> wet = s.wet_paths();
    s.tracer.respond(s.gammatons, s.scene, s.iteration, s.trace, normals.get(), control, {}, wet ? &*wet : nullptr);
  }
  s.begin_lives_and_end_them(s.iteration, control);
  {
    const Stopwatch watch(s.times.rules);
    s.apply_rules(control);
  }
}

std::vector<TileIndex> Simulation::State::dirty_since(std::int64_t since) const {
  // Most pages have none: sixteen tiles at a time, which compilers make a few comparisons of.
  constexpr std::size_t kFew = 16;
  static_assert(TileGrid::kPageTiles % kFew == 0);
  const auto least = static_cast<std::int32_t>(std::max<std::int64_t>(since, std::numeric_limits<std::int32_t>::min()));
  std::vector<TileIndex> tiles;
  for (std::size_t first = 0; first < changed_in.size(); first += kFew) {
    std::int32_t last = std::numeric_limits<std::int32_t>::min();
    for (std::size_t k = 0; k < kFew; ++k) last = std::max(last, changed_in[first + k]);
    if (last < least) continue;
    for (std::size_t k = 0; k < kFew; ++k) {
      if (changed_in[first + k] >= least) tiles.push_back(static_cast<TileIndex>(first + k));
    }
  }
  return tiles;
}

std::vector<TileIndex> Simulation::dirty_since(std::int64_t since) const {
  state_->copy_to_host();
  return state_->dirty_since(since);
}

void Simulation::State::compose_now(const RunControl& control) {
  const Stopwatch watch(times.compose);
  try {
    if (open_device(control)) {
      composer.compose_there(atlas, there->arrays, control);
      composed_at = iteration;
      is_composed_there = true;
      return;
    }
  } catch (const device::DeviceError& error) {
    lose_device(error, control);
  }
  is_composed_there = false;
  copy_to_host(control);
  std::vector<TileIndex> tiles = composer.compose(atlas, dirty_since(composed_at), control);
  composed_at = iteration;
  if (composed_since_asked.empty()) {
    composed_since_asked = std::move(tiles);
    return;
  }
  std::vector<TileIndex> all;
  std::set_union(tiles.begin(), tiles.end(), composed_since_asked.begin(), composed_since_asked.end(),
                 std::back_inserter(all));
  composed_since_asked = std::move(all);
}

const Composer& Simulation::compose(const RunControl& control) {
  State& s = *state_;
  s.compose_now(control);
  s.composed_tiles = std::exchange(s.composed_since_asked, {});
  return s.composer;
}

std::span<const TileIndex> Simulation::composed_tiles() const {
  State& s = *state_;
  if (!std::exchange(s.is_composed_there, false)) return s.composed_tiles;
  try {
    std::vector<TileIndex> all, changed = s.composer.changed_there();
    std::set_union(changed.begin(), changed.end(), s.composed_tiles.begin(), s.composed_tiles.end(),
                   std::back_inserter(all));
    s.composed_tiles = std::move(all);
  } catch (const device::DeviceError& error) {
    s.lose_device(error, {});
    s.compose_again();
  }
  return s.composed_tiles;
}

void Simulation::set_appearance(std::vector<MaterialAppearance> appearance) {
  state_->composer.set_appearance(appearance);
  state_->is_composed_there = false;
  state_->scene.appearance = std::move(appearance);
}

}  // namespace patinate::simulation
