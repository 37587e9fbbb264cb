#include "simulation/rules/rules.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <iterator>
#include <optional>
#include <utility>

#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "patinate/simulation/layer_atlas.h"
#include "patinate/simulation/weather.h"
#include "simulation/rules/compiled_rules.h"
#include "simulation/rules/device_rules.h"
#include "simulation/rules/layer_cracking.h"
#include "simulation/rules/layer_tile.h"
#include "simulation/rules/rule_worker.h"
#include "simulation/rules/tile_facts.h"

namespace patinate::simulation {

namespace {

constexpr std::uint32_t kRulePurpose = 0x72756C65u;
constexpr std::uint64_t kEveryEighth = 0x0101010101010101u;  ///< A bit for every eighth tile of a page.
constexpr std::size_t kPrefetchTiles = 2;                    ///< Tiles ahead; speed alone.
constexpr std::int64_t kChunkPages = 16;                     ///< 128 tiles an iteration: about 50 us.
constexpr std::size_t kChunkTiles = kChunkPages * TileGrid::kPageTiles / RuleEngine::kEpoch;

const RuleKernel& kernel_of(InstructionSet set) {
#if defined(__x86_64__)
  if (set == InstructionSet::Avx512) return rules_avx512::kKernel;
  if (set == InstructionSet::Avx2) return rules_avx2::kKernel;
#endif
  return rules_baseline::kKernel;
}

}  // namespace

struct RuleEngine::State : CompiledRules {
  InstructionSet set;
  const RuleKernel* kernel;
  double time_per_iteration;
  std::uint64_t seed;
  std::vector<SurfaceParameter> parameters;  ///< Slots after the materials; then the signals.
  Weather weather;
  std::optional<SignalValues> last_signals;  ///< Signals of the last step, the age left out.
  TileFacts facts;
  std::vector<std::uint64_t> awake;  ///< By page: a bit for each tile.
  std::vector<RuleWorker> workers;
  std::vector<TileIndex> dirty;
  std::vector<std::size_t> num_dirty;      ///< By chunk.
  std::unique_ptr<DeviceRules> on_device;  ///< State of these rules on a device; null before a device is asked.
  bool is_all_awake_there = true;          ///< It is to be told so.
  LayerAtlas* layers = nullptr;
  LayerFacts layer_facts;
  std::unique_ptr<LayerCracking> cracking;  ///< Null where no layer cracks.
  std::vector<TileIndex> more_dirty;        ///< With the tiles that cracks and flakes have changed.

  [[nodiscard]] std::size_t first_signal() const { return num_changing() + parameters.size(); }
  [[nodiscard]] SignalValues signals_over(std::int64_t iteration, std::int64_t span) const;
  void wake_on_change(const SignalValues& signals);
  struct StepFacts {
    SignalValues signals{};
    int phase = 0;  ///< Tiles are due whose number modulo kEpoch it is.
  };
  /// @returns false where there is nothing to do.
  [[nodiscard]] bool begin_step(std::int64_t iteration, StepFacts& step);
  [[nodiscard]] bool age_tile(TileIndex tile, MaterialAtlas& atlas, RuleWorker& worker, bool& is_dirty) const;
  /// Enters what a step has done to layers, and wakes what is beside those that are gone.
  void enter_layers(MaterialAtlas& atlas, const RunControl& control);
  /// Rising, of the last step.
  [[nodiscard]] std::span<const TileIndex> dirty_tiles();
  void wake_beside(TileIndex tile);
  /// @returns a bit for each material slot of which there is some.
  std::uint32_t load(TileIndex tile, const MaterialAtlas& atlas, RuleWorker& worker) const;
  /// The amounts of a slot: where they are stored, else in `originals`.
  [[nodiscard]] const std::uint16_t* amounts_of(std::size_t slot, TileIndex tile, const MaterialAtlas& atlas,
                                                std::array<std::uint16_t, TileGrid::kTileTexels>& originals) const;
  /// Forms of all rules for a step.
  void set_forms(std::int64_t iteration, double time);
  [[nodiscard]] std::int64_t num_chunks() const {
    return (static_cast<std::int64_t>(awake.size()) + kChunkPages - 1) / kChunkPages;
  }
  /// Those of a chunk that are awake and due: tile % kEpoch == phase. @returns how many.
  std::size_t due_tiles(std::int64_t chunk, int phase, TileIndex* tiles) const;
  void begin(RuleWorker& worker, const SignalValues& signals) const;
  void age_chunk(std::int64_t chunk, int phase, MaterialAtlas& atlas, RuleWorker& worker);
  /// Settles a tile that was aged.
  void settle(std::int64_t chunk, TileIndex tile, bool has_extent, bool is_dirty);
  /// Asks memory for what load() will read: tiles that are due at once lie a kilobyte apart, which no processor
  /// guesses.
  void prefetch(TileIndex tile, const MaterialAtlas& atlas) const {
    for (const int material : materials) {
      const std::uint16_t* stored = atlas.tile(material, tile).data();
      if (!stored) continue;
      __builtin_prefetch(stored, 1);
      __builtin_prefetch(stored + 32, 1);
    }
    for (const SurfaceParameter& parameter : parameters) prefetch_parameter(parameter, tile);
  }
};

RuleEngine::RuleEngine(std::span<const Rule> rules, std::span<const std::string> materials, const SurfaceAtlas& surface,
                       double time_per_iteration, std::uint64_t seed, std::vector<SurfaceParameter> parameters,
                       InstructionSet set, LayerAtlas* layers)
    : state_(std::make_unique<State>()) {
  State& s = *state_;
  if (!has_instruction_set(set))
    throw InvalidInput("rules: this machine lacks " + std::string(kInstructionSetNames[static_cast<std::size_t>(set)]));
  if (!(time_per_iteration >= 0.0))
    throw InvalidInput("rules: the time of an iteration is " + number_text(time_per_iteration) + "; use 0 or more");
  s.set = set;
  s.kernel = &kernel_of(set);
  s.time_per_iteration = time_per_iteration;
  s.seed = seed;
  s.facts = TileFacts(surface);
  s.layers = layers;
  if (layers && layers->has_cracks()) s.cracking = std::make_unique<LayerCracking>(*layers, seed);
  set_rules(rules, materials, std::move(parameters));
}

RuleEngine::~RuleEngine() = default;
RuleEngine::RuleEngine(RuleEngine&&) noexcept = default;
RuleEngine& RuleEngine::operator=(RuleEngine&&) noexcept = default;

void RuleEngine::set_rules(std::span<const Rule> rules, std::span<const std::string> materials,
                           std::vector<SurfaceParameter> more_parameters) {
  State& s = *state_;
  std::vector<SurfaceParameter> parameters = s.parameters;
  for (SurfaceParameter& parameter : more_parameters) parameters.push_back(std::move(parameter));
  static_cast<CompiledRules&>(s) =
      compile_rules(rules, materials, parameters, s.layers ? layer_names_of(*s.layers) : LayerNames{});
  if (s.layers) s.layer_facts = LayerFacts(*s.layers, s, s.facts);
  s.parameters = std::move(parameters);
  s.awake = s.rules.empty() ? std::vector<std::uint64_t>() : s.facts.covered_tiles();
  s.is_all_awake_there = true;
  s.workers.clear();  // their slots are others'
  s.on_device.reset();
}

bool RuleEngine::has_parameter(std::string_view name) const {
  return std::any_of(state_->parameters.begin(), state_->parameters.end(),
                     [&](const SurfaceParameter& p) { return p.name == name; });
}

void RuleEngine::set_weather(Weather weather) { state_->weather = std::move(weather); }

/// Means over the last `span` iterations, this one included; the age in their middle.
SignalValues RuleEngine::State::signals_over(std::int64_t iteration, std::int64_t span) const {
  SignalValues signals{};
  const double end = static_cast<double>(iteration + 1);
  signals[0] = static_cast<float>((end - 0.5 * static_cast<double>(span)) * time_per_iteration);
  if (weather.empty()) return signals;
  const WeatherMean mean =
      mean_weather(weather, (end - static_cast<double>(span)) * time_per_iteration, end * time_per_iteration);
  for (std::size_t k = 0; k < kNumWeatherSignals; ++k) signals[1 + k] = static_cast<float>(mean.values[k]);
  return signals;
}

/// Wakes what may have something to do under other weather. Before the first step everything is awake.
void RuleEngine::State::wake_on_change(const SignalValues& signals) {
  bool has_changed = false;
  for (std::size_t k = 1; k < kNumSignals; ++k)
    has_changed = has_changed || (uses[k] && last_signals && (*last_signals)[k] != signals[k]);
  if (has_changed) {
    awake = facts.covered_tiles();
    is_all_awake_there = true;
  }
  last_signals = signals;
}

void RuleEngine::wake(std::span<const TileIndex> tiles) {
  if (state_->awake.empty()) return;
  for (const TileIndex tile : tiles)
    state_->awake[tile / TileGrid::kPageTiles] |= std::uint64_t{1} << tile % TileGrid::kPageTiles;
}

std::int64_t RuleEngine::num_awake() const {
  std::int64_t sum = 0;
  for (const std::uint64_t page : state_->awake) sum += std::popcount(page);
  return sum;
}

std::int64_t RuleEngine::aged_iterations(TileIndex tile, std::int64_t iteration) {
  const std::int64_t since = (iteration + tile) % kEpoch;
  return std::max<std::int64_t>(0, iteration + 1 - since);
}

const std::uint16_t* RuleEngine::State::amounts_of(std::size_t slot, TileIndex tile, const MaterialAtlas& atlas,
                                                   std::array<std::uint16_t, TileGrid::kTileTexels>& originals) const {
  const std::uint16_t* stored = atlas.tile(materials[slot], tile).data();
  if (stored) return stored;
  if (facts.is_uniform(tile)) {
    originals.fill(atlas.original(materials[slot], tile * TileGrid::kTileTexels));
  } else {
    atlas.read_tile(materials[slot], tile, originals);
  }
  return originals.data();
}

std::uint32_t RuleEngine::State::load(TileIndex tile, const MaterialAtlas& atlas, RuleWorker& worker) const {
  alignas(64) std::array<std::uint16_t, TileGrid::kTileTexels> originals;
  std::uint32_t there = 0;
  for (std::size_t k = 0; k < materials.size(); ++k) {
    const std::uint16_t* amounts = amounts_of(k, tile, atlas, originals);
    kernel->load(amounts, worker.quanta[k].data(), worker.slots[k].values.data());
    unsigned any = 0;
    for (std::size_t i = 0; i < TileGrid::kTileTexels; ++i) any |= amounts[i];
    there |= (any != 0 ? std::uint32_t{1} : 0) << k;
  }
  for (std::size_t p = 0; p < parameters.size(); ++p)
    load_parameter(parameters[p], tile, worker.slots[num_changing() + p].values.data());
  return there;
}

/// @returns whether some rule has an extent there.
bool RuleEngine::State::age_tile(TileIndex tile, MaterialAtlas& atlas, RuleWorker& worker, bool& is_dirty) const {
  std::uint32_t there = load(tile, atlas, worker);
  alignas(64) std::array<float, TileGrid::kTileTexels> covered;
  facts.covered(tile, covered);
  std::array<bool, 3 * kMaxMaterials> has_changed{};  // Materials, then states of layers.
  std::array<std::uint32_t, TileGrid::kTileTexels> weights;
  bool has_weights = false, has_extent = false;
  float* slots = worker.slots[0].values.data();
  if (worker.layers) worker.layers->load(tile);
  for (const CompiledRule& rule : rules) {
    if ((rule.needs & ~there) != 0) continue;
    const bool is_layered = worker.layers && rule.has_layers();
    const float* where =
        is_layered ? worker.layers->begin(rule, covered.data(), slots, worker.quanta[0].data()) : covered.data();
    run_expression(rule.driver, slots, set);
    const KernelRule& form = rule.form;
    const float* driver = worker.slots[rule.driver.result].values.data();
    const int outcome = kernel->apply(form, driver, where, tile * TileGrid::kTileTexels, worker.quanta[0].data(), slots,
                                      worker.changes[0].data());
    has_extent |= (outcome & 1) != 0;
    if ((outcome & 2) == 0) continue;
    if (!std::exchange(has_weights, true)) facts.weights(tile, weights);
    for (int k = 0; k < form.num_terms; ++k) {
      const auto slot = static_cast<std::size_t>(form.terms[k].material);
      has_changed[slot] = true;
      there |= std::uint32_t{1} << slot;  // made; what was used up may be gone, and is tried in vain
      const int material = slot < materials.size() ? materials[slot] : layer_states[slot - materials.size()].material;
      if (material < 0) continue;
      const auto m = static_cast<std::size_t>(material);
      (k < form.num_makes ? worker.made : worker.used)[m] += kernel->weigh(worker.changes[k].data(), weights.data());
    }
    if (is_layered && !rule.states.empty()) worker.layers->end(rule, worker.quanta[0].data(), weights, worker.sums);
  }
  for (std::size_t k = 0; k < materials.size(); ++k) {
    if (has_changed[k]) kernel->store(worker.quanta[k].data(), atlas.writable_tile(materials[k], tile).data());
  }
  is_dirty = std::find(has_changed.begin(), has_changed.end(), true) != has_changed.end();
  if (!worker.layers) return has_extent;
  bool is_opened = false;
  is_dirty = worker.layers->store(*layers, atlas, worker.sums, is_opened) || is_dirty;
  if (is_opened) worker.opened.push_back(tile);
  if (cracking) cracking->find(tile, *worker.layers, worker.cracking);
  return has_extent;
}

void RuleEngine::State::set_forms(std::int64_t iteration, double time) {
  for (std::size_t r = 0; r < rules.size(); ++r) {
    KernelRule& form = rules[r].form;
    form.scale = static_cast<float>(rules[r].rate * time);
    const auto now = static_cast<std::uint64_t>(iteration);
    const auto random = philox4x32({static_cast<std::uint32_t>(now), static_cast<std::uint32_t>(now >> 32),
                                    static_cast<std::uint32_t>(r), kRulePurpose},
                                   {static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)});
    form.keys[0] = random[0];
    form.keys[1] = random[1];
  }
}

std::size_t RuleEngine::State::due_tiles(std::int64_t chunk, int phase, TileIndex* tiles) const {
  const auto first = static_cast<std::size_t>(chunk * kChunkPages);
  std::size_t num = 0;
  for (std::size_t page = first; page < std::min(awake.size(), first + kChunkPages); ++page) {
    for (std::uint64_t due = awake[page] & kEveryEighth << phase; due != 0; due &= due - 1) {
      tiles[num++] =
          static_cast<TileIndex>(page) * TileGrid::kPageTiles + static_cast<std::uint32_t>(std::countr_zero(due));
    }
  }
  return num;
}

void RuleEngine::State::settle(std::int64_t chunk, TileIndex tile, bool has_extent, bool is_dirty) {
  if (!has_extent && !uses[0]) awake[tile / TileGrid::kPageTiles] &= ~(std::uint64_t{1} << tile % TileGrid::kPageTiles);
  const auto c = static_cast<std::size_t>(chunk);
  if (is_dirty) dirty[c * kChunkTiles + num_dirty[c]++] = tile;
}

void RuleEngine::State::begin(RuleWorker& worker, const SignalValues& signals) const {
  if (worker.slots.empty()) {
    worker.slots.resize(num_slots);
    worker.quanta.resize(std::max<std::size_t>(1, num_changing()));
    if (layers) worker.layers.emplace(layer_facts);
    if (layers) worker.sums.worn.resize(layers->accounts().size());
    if (layers) worker.sums.flaked.resize(layers->accounts().size());
    for (const CompiledRule& rule : rules) {
      for (const auto& constant : rule.driver.constants) worker.slots[constant.slot].values.fill(constant.value);
    }
  }
  for (std::size_t k = 0; k < kNumSignals; ++k) worker.slots[first_signal() + k].values.fill(signals[k]);
}

void RuleEngine::State::age_chunk(std::int64_t chunk, int phase, MaterialAtlas& atlas, RuleWorker& worker) {
  std::array<TileIndex, kChunkTiles> tiles;
  const std::size_t num_tiles = due_tiles(chunk, phase, tiles.data());
  for (std::size_t i = 0; i < num_tiles; ++i) {
    if (i + kPrefetchTiles < num_tiles) prefetch(tiles[i + kPrefetchTiles], atlas);
    bool is_dirty = false;
    const bool has_extent = age_tile(tiles[i], atlas, worker, is_dirty);
    settle(chunk, tiles[i], has_extent, is_dirty);
  }
}

bool RuleEngine::State::begin_step(std::int64_t iteration, StepFacts& step) {
  if (rules.empty() || awake.empty() || !(time_per_iteration > 0.0)) return false;
  step.phase = static_cast<int>((kEpoch - iteration % kEpoch) % kEpoch);
  const std::int64_t span = std::min<std::int64_t>(kEpoch, iteration + 1);
  step.signals = signals_over(iteration, span);
  wake_on_change(step.signals);
  set_forms(iteration, static_cast<double>(span) * time_per_iteration);
  return true;
}

RuleReport RuleEngine::step(std::int64_t iteration, MaterialAtlas& atlas, const RunControl& control) {
  State& s = *state_;
  RuleReport report;
  State::StepFacts step;
  if (!s.begin_step(iteration, step)) return report;
  const std::int64_t num_chunks = s.num_chunks();
  s.dirty.resize(static_cast<std::size_t>(num_chunks) * kChunkTiles);
  s.num_dirty.assign(static_cast<std::size_t>(num_chunks), 0);
  RunControl threads;  // a part of a step is no state to stop in
  threads.num_threads = control.num_threads;
  std::atomic<std::int64_t> next{0};
  const std::int64_t num_workers = std::min<std::int64_t>(thread_count(threads), num_chunks);
  if (s.workers.size() < static_cast<std::size_t>(num_workers)) s.workers.resize(num_workers);
  parallel_for(num_workers, 1, threads, [&](std::int64_t w, std::int64_t) {
    RuleWorker& worker = s.workers[w];
    s.begin(worker, step.signals);
    for (std::int64_t chunk = next++; chunk < num_chunks; chunk = next++) s.age_chunk(chunk, step.phase, atlas, worker);
  });
  if (s.layers) s.enter_layers(atlas, threads);
  report.dirty_tiles = s.dirty_tiles();
  for (RuleWorker& worker : s.workers) {
    for (std::size_t m = 0; m < kMaxMaterials; ++m) {
      report.made[m] += std::exchange(worker.made[m], 0);
      report.used[m] += std::exchange(worker.used[m], 0) + std::exchange(worker.sums.overflow[m], 0);
    }
  }
  return report;
}

std::span<const TileIndex> RuleEngine::State::dirty_tiles() {
  std::size_t num = 0;
  for (std::size_t c = 0; c < num_dirty.size(); ++c) {
    std::copy_n(dirty.begin() + static_cast<std::ptrdiff_t>(c * kChunkTiles), num_dirty[c],
                dirty.begin() + static_cast<std::ptrdiff_t>(num));
    num += num_dirty[c];
  }
  const std::span<const TileIndex> aged = std::span<const TileIndex>(dirty).first(num);
  if (more_dirty.empty()) return aged;
  std::vector<TileIndex> all;
  std::set_union(aged.begin(), aged.end(), more_dirty.begin(), more_dirty.end(), std::back_inserter(all));
  more_dirty = std::move(all);
  return more_dirty;
}

void RuleEngine::State::wake_beside(TileIndex tile) {
  for (const TileIndex each : tiles_at(tile, layers->surface()))
    awake[each / TileGrid::kPageTiles] |= std::uint64_t{1} << each % TileGrid::kPageTiles;
}

void RuleEngine::State::enter_layers(MaterialAtlas& atlas, const RunControl& control) {
  LayerCracking::Finds finds;
  for (RuleWorker& worker : workers) {
    for (const TileIndex tile : worker.opened) {
      layers->renew_tops(tile);
      wake_beside(tile);
    }
    finds.opened.insert(finds.opened.end(), worker.opened.begin(), worker.opened.end());
    worker.opened.clear();
    finds.take(worker.cracking);
  }
  RuleWorker& first = workers.front();
  if (cracking) more_dirty = cracking->step(std::move(finds), *first.layers, atlas, first.sums, control);
  for (const TileIndex tile : more_dirty) wake_beside(tile);
  for (RuleWorker& worker : workers) worker.sums.enter(layers->accounts());
}

bool RuleEngine::can_step_there() const {
  return !state_->layers && DeviceRules::can_run(*state_, state_->parameters.size());
}

void RuleEngine::step_on_device(std::int64_t iteration, DeviceArrays& arrays) {
  State& s = *state_;
  State::StepFacts step;
  if (!s.begin_step(iteration, step)) return;
  if (!s.on_device) s.on_device = std::make_unique<DeviceRules>(arrays.device, s, s.parameters, s.facts);
  if (std::exchange(s.is_all_awake_there, false)) arrays.device.fill_words(arrays.awake.memory(), 1);
  s.on_device->age({.rules = s.rules, .signals = step.signals, .phase = step.phase, .iteration = iteration}, arrays);
}

void RuleEngine::wake_everything() {
  if (!state_->awake.empty()) state_->awake = state_->facts.covered_tiles();
  state_->is_all_awake_there = true;
  if (state_->cracking) state_->cracking->forget();
}

void RuleEngine::forget_there() { state_->on_device.reset(); }

}  // namespace patinate::simulation
