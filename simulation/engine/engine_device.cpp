// Iterations on a device: all of it stays there until somebody asks.
#include <algorithm>
#include <functional>
#include <iterator>
#include <numeric>
#include <utility>

#include "simulation/engine/device_run.h"
#include "simulation/engine/engine_state.h"
#include "simulation/tracing/device_motion.h"

namespace patinate::simulation {

namespace {

// Iterations that a device does before it is waited for: what was queued cannot be stopped.
constexpr std::int64_t kQueued = 8;
// And before the state comes back unasked: what would have to be done again when the device is lost.
constexpr std::int64_t kMaxAhead = 2048;

/// By emitter, then material.
std::vector<std::uint32_t> loads_of(const Scene& scene, double contact_area, int num_materials) {
  std::vector<std::uint32_t> loads;
  for (const Emitter& emitter : scene.emitters) {
    const auto load = MassLedger::cargo_of(emitter.carries, contact_area);
    loads.insert(loads.end(), load.begin(), load.begin() + num_materials);
  }
  return loads;
}

/// Control that cannot stop halfway through a copy.
RunControl unstoppable(const RunControl& control) {
  RunControl threads;
  threads.num_threads = control.num_threads;
  return threads;
}

/// Enters what the device has counted.
void enter(std::span<const std::uint32_t> tally, int num_materials, MassLedger& ledger, TraceCounters& counters) {
  using namespace tally_types;
  for (int m = 0; m < num_materials; ++m) {
    MassAccount& account = ledger.account(m);
    const auto mass = [&](std::uint32_t kind) { return mass_of(tally, kind, m); };
    const std::int64_t ends = mass(kMassLeft) + mass(kMassAbsorbed) + mass(kMassRested);
    const std::int64_t up = mass(kMassPickedUp) - mass(kMassDropped), rules = mass(kMassMade) - mass(kMassUsed);
    account.emitted += mass(kMassEmitted);
    account.carried += mass(kMassEmitted) - ends + up;
    account.left += mass(kMassLeft);
    account.absorbed += mass(kMassAbsorbed);
    account.rested += mass(kMassRested);
    account.on_surfaces += rules - up;
    account.made += mass(kMassMade);
    account.used += mass(kMassUsed);
  }
  counters.segments += counted(tally, kSegments);
  counters.contacts += counted(tally, kContacts);
  counters.emitted += counted(tally, kEmitted);
  counters.absorbed += counted(tally, kAbsorbed);
  counters.left += counted(tally, kLeft);
  counters.rested += counted(tally, kRested);
}

}  // namespace

bool Simulation::State::uses_device() const {
  return options.device && !layers && !options.device->has_failed() &&
         scene.tracing.bounce_normal == BounceNormal::Mesh && rules->can_step_there();
}

void Simulation::State::copy_to_device(const RunControl& control) {
  DeviceArrays& a = there->arrays;
  const device::Device& device = a.device;
  device.write(std::span<const DropRecord>(drop_records(gammatons, control)), a.drops);
  std::vector<std::uint32_t> carried;
  for (const auto& mass : cargo.mass) carried.insert(carried.end(), mass.begin(), mass.begin() + a.num_materials);
  device.write(std::span<const std::uint32_t>(carried), a.cargo);
  device.write(std::span<const Trail>(trails), a.trails);
  device.fill_zero(a.ended.memory());
  std::vector<std::uint32_t> bits(a.met.size(), 0);
  for (TileIndex t = 0; met && t < a.num_tiles; ++t) {
    bits[2 * t] = static_cast<std::uint32_t>(met->tiles()[t]);
    bits[2 * t + 1] = static_cast<std::uint32_t>(met->tiles()[t] >> 32);
  }
  device.write(std::span<const std::uint32_t>(bits), a.met);
  device.write(std::span<const std::int32_t>(changed_in), a.changed_in);
  device.fill_zero(a.dirty.memory());
  device.fill_zero(a.tally.memory());
  std::vector<TileIndex> changed = dirty_since(there->known_at);
  if (!there->has_amounts) {
    changed.resize(a.num_tiles);
    std::iota(changed.begin(), changed.end(), TileIndex{0});
  }
  there->amounts.put(atlas, changed, a);
  list_tiles(dirty_since(composed_at), a);
  if (maps->choice().has_any()) there->exchange.put_maps(*maps);
  const SplatWidths widths = splat_widths(scene.exchange, surface);
  there->exchange.set(scene.exchange, widths, contact_area(scene.exchange, surface), scene.seed);
  rules->wake_everything();
  there->has_amounts = true;
  there->is_stale = false;
  there->is_ahead = false;
  there->known_at = iteration;
}

bool Simulation::State::open_device(const RunControl& control) {
  if (!uses_device()) return false;
  if (!there) {
    there = std::make_unique<DeviceRun>(options.device->device(), surface, atlas.num_materials(), gammatons.size(),
                                        maps->choice());
  }
  if (there->is_stale) copy_to_device(control);
  return true;
}

bool Simulation::State::step_on_device(const RunControl& control) {
  control.throw_if_stopped();
  try {
    if (!open_device(control)) return false;
    apply_weather();
    DeviceArrays& a = there->arrays;
    const std::vector<std::uint32_t> loads =
        loads_of(scene, contact_area(scene.exchange, surface), atlas.num_materials());
    const bool is_deposited = there->exchange.deposits();
    there->is_ahead = true;
    tracer.trace_there(scene, iteration, {.is_deposited = is_deposited, .loads = loads}, a, control);
    there->exchange.deposit(a, iteration, 0);
    there->exchange.exchange(a, iteration);
    const std::optional<WetPaths> wet = wet_paths();
    tracer.respond_there(scene, iteration, wet ? &*wet : nullptr, is_deposited, a);
    there->exchange.deposit(a, iteration, 1);
    renew_rules(control);
    rules->step_on_device(iteration, a);
    if ((iteration + 1) % kQueued == 0) a.device.finish();
    return true;
  } catch (const device::DeviceError& error) {
    lose_device(error, control);
    return false;
  }
}

bool Simulation::State::copy_from_device(const RunControl& control) {
  DeviceArrays& a = there->arrays;
  const device::Device& device = a.device;
  tracer.end_lives_there(a);
  std::vector<std::uint32_t> tally(a.tally.size());
  device.read(a.tally, std::span(tally));
  if (const std::uint32_t overflown = tally[tally_types::kHasOverflown]; overflown != 0) {
    there->exchange.grow(overflown);
    return false;
  }
  std::vector<DropRecord> drops(a.num_gammatons);
  std::vector<std::uint32_t> carried(a.cargo.size()), bits(a.met.size());
  std::vector<Trail> new_trails(a.num_gammatons);
  std::vector<std::int32_t> changed(a.num_tiles);
  device.read(a.drops, std::span(drops));
  device.read(a.cargo, std::span(carried));
  device.read(a.trails, std::span(new_trails));
  device.read(a.met, std::span(bits));
  device.read(a.changed_in, std::span(changed));
  there->amounts.read_dirty(a);
  const std::vector<std::function<void()>> give_maps = there->exchange.read_maps(*maps);
  const std::vector<std::uint32_t> zeros(tally.size() - tally_types::kFirstCount, 0);
  device.fill_zero(a.dirty.memory());
  device.write(std::span<const std::uint32_t>(zeros), a.tally, tally_types::kFirstCount);
  // Nothing fails from here on.
  for (const std::function<void()>& give : give_maps) give();
  take_drop_records(drops, gammatons, control);
  for (std::size_t g = 0; g < cargo.mass.size(); ++g)
    std::copy_n(carried.begin() + static_cast<std::ptrdiff_t>(g * a.num_materials), a.num_materials,
                cargo.mass[g].begin());
  trails = std::move(new_trails);
  for (TileIndex t = 0; met && t < a.num_tiles; ++t)
    met->tiles()[t] = bits[2 * t] | std::uint64_t{bits[2 * t + 1]} << 32;
  changed_in = std::move(changed);
  there->amounts.give(atlas);
  enter(tally, atlas.num_materials(), ledger, counters);
  counters.alive = std::count_if(gammatons.state.begin(), gammatons.state.end(),
                                 [](GammatonState state) { return state != GammatonState::Waiting; });
  rules->wake_everything();
  there->known_at = iteration;
  there->is_ahead = false;
  return true;
}

void Simulation::State::copy_to_host(const RunControl& given) {
  const RunControl control = unstoppable(given);
  while (there && there->is_ahead) {
    try {
      if (copy_from_device(control)) return;
      // There was too little room: all again with more.
      there->is_stale = true;
      there->has_amounts = false;
      composed_at = -1;
      repeat_iterations(control);
    } catch (const device::DeviceError& error) {
      lose_device(error, control);
    }
  }
}

void Simulation::State::compose_again() {
  compose_now({});
  std::vector<TileIndex> all;
  std::set_union(composed_tiles.begin(), composed_tiles.end(), composed_since_asked.begin(), composed_since_asked.end(),
                 std::back_inserter(all));
  composed_tiles = std::move(all);
  composed_since_asked.clear();
}

void Simulation::State::check_room() {
  if (!there || !there->is_ahead) return;
  std::vector<std::uint32_t> tally(there->arrays.tally.size());
  there->arrays.device.read(there->arrays.tally, std::span(tally));
  if (tally[tally_types::kHasOverflown] == 0) return;
  copy_to_host();
  compose_again();
}

void Simulation::State::limit_lag(const RunControl& control) {
  if (there && iteration - there->known_at >= kMaxAhead) copy_to_host(control);
}

void Simulation::State::repeat_iterations(const RunControl& control) {
  const std::int64_t done = std::exchange(iteration, there ? there->known_at : iteration);
  if (there) there->is_ahead = false;
  while (iteration < done) {
    if (!step_on_device(control)) step_on_host(control);
    ++iteration;
  }
}

void Simulation::State::lose_device(const device::DeviceError& error, const RunControl& given) {
  const RunControl control = unstoppable(given);
  is_composed_there = false;
  options.device->report_failure(error);
  const std::int64_t known_at = there && there->is_ahead ? there->known_at : iteration, done = iteration;
  there.reset();
  tracer.forget_there();
  rules->forget_there();
  rules->wake_everything();
  composer.forget_there();
  composed_at = -1;
  iteration = known_at;
  while (iteration < done) {
    step_on_host(control);
    ++iteration;
  }
}

void Simulation::State::change_on_host(const RunControl& control) {
  copy_to_host(control);
  if (there) there->is_stale = true;
}

}  // namespace patinate::simulation
