#include "simulation/rules/rules.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <optional>
#include <utility>

#include "libcommon/core/expression_program.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "patinate/simulation/weather.h"
#include "simulation/rules/rule_kernel.h"
#include "simulation/rules/tile_facts.h"

namespace patinate::simulation {

namespace {

constexpr std::uint32_t kRulePurpose = 0x72756C65u;
constexpr std::uint64_t kEveryEighth = 0x0101010101010101u;
constexpr std::size_t kPrefetchTiles = 2;
constexpr std::int64_t kChunkPages = 16;  ///< 128 tiles an iteration: about 50 us.

const RuleKernel& kernel_of(InstructionSet set) {
#if defined(__x86_64__)
  if (set == InstructionSet::Avx512) return rules_avx512::kKernel;
  if (set == InstructionSet::Avx2) return rules_avx2::kKernel;
#endif
  return rules_baseline::kKernel;
}

/// The driver, where the rule acts at all. @param maps  Names of maps beyond the built-in ones.
Expression driver_of(const Rule& rule, std::span<const std::string> materials, std::span<const std::string> maps) {
  const std::vector<std::string> names = driver_names(materials, maps);
  const auto parse = [&](const std::string& text, const std::string& part) {
    try {
      return parse_expression(text, {.subject = "rule '" + rule.name + "': " + part,
                                     .name = "material or parameter",
                                     .names = names,
                                     .has_files = false});
    } catch (const ParseError& e) {
      throw InvalidInput(e.what());
    }
  };
  Expression driver = parse(rule.driver, "driver");
  if (rule.where.empty()) return driver;
  (void)parse(rule.where, "where");
  return parse("(" + rule.driver + ") * clamp(" + rule.where + ", 0, 1)", "driver and where");
}

/// A rule as the kernel takes it, and its driver's program.
struct CompiledRule {
  KernelRule form{};
  double rate = 0.0;
  ExpressionProgram driver;
};

struct alignas(64) BlockOf64 {
  std::array<float, TileGrid::kTileTexels> values;
};

/// What one thread works with; which thread it is shows in no result.
struct Worker {
  std::vector<BlockOf64> slots;                      ///< Materials, parameters, then the programs' own.
  std::vector<std::array<std::int32_t, 64>> quanta;  ///< By material.
  std::array<std::array<std::int32_t, 64>, kMaxRuleTerms> changes{};
  std::array<std::int64_t, kMaxMaterials> made{};
  std::array<std::int64_t, kMaxMaterials> used{};
};

}  // namespace

namespace {

/// Names of a driver that are no materials, those of time or the others.
std::vector<std::string> names_beside(const Rule& rule, std::span<const std::string> materials,
                                      std::span<const std::string> maps, bool is_of_time) {
  std::vector<std::string> out;
  for (const ExpressionName& name : driver_of(rule, materials, maps).names) {
    const bool is_material = std::find(materials.begin(), materials.end(), name.text) != materials.end();
    if (!is_material && is_time_signal(name.text) == is_of_time) out.push_back(name.text);
  }
  return out;
}

}  // namespace

std::vector<std::string> parameters_of(const Rule& rule, std::span<const std::string> materials,
                                       std::span<const std::string> maps) {
  return names_beside(rule, materials, maps, false);
}

std::vector<std::string> signals_of(const Rule& rule, std::span<const std::string> materials,
                                    std::span<const std::string> maps) {
  return names_beside(rule, materials, maps, true);
}

namespace {

/// The scene's age, then the weather.
constexpr std::size_t kNumSignals = 1 + kNumWeatherSignals;
using SignalValues = std::array<float, kNumSignals>;

std::size_t signal_index(std::string_view name) {
  const std::optional<WeatherSignal> signal = weather_signal_of(name);
  return signal ? 1 + static_cast<std::size_t>(*signal) : 0;
}

/// All rules, and which slot is whose.
struct CompiledRules {
  std::vector<CompiledRule> rules;
  std::vector<int>
      materials;  ///< Those that occur in a rule: slots 0, 1, ... Slots of the parameters follow, then the signals.
  int num_slots = 0;
  std::array<bool, kNumSignals> uses{};  ///< Signals that a driver asks for.

  [[nodiscard]] int slot_of_material(int material) const {
    return static_cast<int>(std::find(materials.begin(), materials.end(), material) - materials.begin());
  }
};

CompiledRules compile_rules(std::span<const Rule> all, std::span<const std::string> names,
                            std::span<const SurfaceParameter> parameters) {
  CompiledRules out;
  std::vector<Expression> drivers;
  std::array<bool, kMaxMaterials> occurs{};
  std::vector<std::string> maps;
  for (const SurfaceParameter& parameter : parameters) maps.push_back(parameter.name);
  for (const Rule& rule : all) {
    drivers.push_back(driver_of(rule, names, maps));
    for (const ExpressionName& name : drivers.back().names) {
      const auto m = static_cast<std::size_t>(std::find(names.begin(), names.end(), name.text) - names.begin());
      if (m < names.size()) {
        occurs[m] = true;
      } else if (is_time_signal(name.text)) {
        out.uses[signal_index(name.text)] = true;
      } else if (std::none_of(parameters.begin(), parameters.end(),
                              [&](const SurfaceParameter& p) { return p.name == name.text; })) {
        throw InvalidInput("rule '" + rule.name + "' asks for `" + name.text + "`, of which there is no map here");
      }
    }
    for (std::size_t m = 0; m < names.size(); ++m)
      occurs[m] = occurs[m] || rule.products[m] > 0.0 || rule.reactants[m] > 0.0;
  }
  for (std::size_t m = 0; m < names.size(); ++m) {
    if (occurs[m]) out.materials.push_back(static_cast<int>(m));
  }
  const auto first_signal = static_cast<int>(out.materials.size() + parameters.size());
  const auto slot_of = [&](const ExpressionName& name) {
    const auto m = std::find(names.begin(), names.end(), name.text) - names.begin();
    if (m < static_cast<std::ptrdiff_t>(names.size())) return out.slot_of_material(static_cast<int>(m));
    if (is_time_signal(name.text)) return first_signal + static_cast<int>(signal_index(name.text));
    const auto p = std::find_if(parameters.begin(), parameters.end(),
                                [&](const SurfaceParameter& q) { return q.name == name.text; });
    return static_cast<int>(out.materials.size()) + static_cast<int>(p - parameters.begin());
  };
  out.num_slots = first_signal + static_cast<int>(kNumSignals);
  for (std::size_t r = 0; r < all.size(); ++r) {
    CompiledRule rule;
    rule.rate = all[r].rate;
    rule.driver = compile_expression(drivers[r], slot_of, out.num_slots);
    out.num_slots = std::max(out.num_slots, rule.driver.num_slots);
    const auto add_terms = [&](const MaterialValues& shares) {
      for (std::size_t m = 0; m < names.size(); ++m) {
        if (shares[m] > 0.0)
          rule.form.terms[rule.form.num_terms++] = {out.slot_of_material(static_cast<int>(m)),
                                                    static_cast<float>(shares[m])};
      }
    };
    add_terms(all[r].products);
    rule.form.num_makes = rule.form.num_terms;
    add_terms(all[r].reactants);
    out.rules.push_back(std::move(rule));
  }
  return out;
}

}  // namespace

struct RuleEngine::State : CompiledRules {
  InstructionSet set;
  const RuleKernel* kernel;
  double time_per_iteration;
  std::uint64_t seed;
  std::vector<SurfaceParameter> parameters;  ///< Slots after the materials; then the signals.
  Weather weather;
  std::optional<SignalValues> last_signals;  ///< Of the last step, the age left out.
  TileFacts facts;
  std::vector<std::uint64_t> awake;  ///< By page: a bit for each tile.
  std::vector<Worker> workers;
  std::vector<TileIndex> dirty;
  std::vector<std::size_t> num_dirty;  ///< By chunk.

  [[nodiscard]] std::size_t first_signal() const { return materials.size() + parameters.size(); }
  [[nodiscard]] SignalValues signals_over(std::int64_t iteration, std::int64_t span) const;
  void wake_on_change(const SignalValues& signals);
  [[nodiscard]] bool age_tile(TileIndex tile, MaterialAtlas& atlas, Worker& worker, bool& is_dirty) const;
  void load(TileIndex tile, const MaterialAtlas& atlas, Worker& worker) const;
  /// Asks memory for what load() will read: tiles that are due at once lie a kilobyte apart, which no processor
  /// guesses.
  void prefetch(TileIndex tile, const MaterialAtlas& atlas) const {
    for (const int material : materials) {
      const std::uint16_t* stored = atlas.tile(material, tile).data();
      if (!stored) continue;
      __builtin_prefetch(stored, 1);
      __builtin_prefetch(stored + 32, 1);
    }
  }
};

RuleEngine::RuleEngine(std::span<const Rule> rules, std::span<const std::string> materials, const SurfaceAtlas& surface,
                       double time_per_iteration, std::uint64_t seed, std::vector<SurfaceParameter> parameters,
                       InstructionSet set)
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
  static_cast<CompiledRules&>(s) = compile_rules(rules, materials, parameters);
  s.parameters = std::move(parameters);
  s.awake = s.rules.empty() ? std::vector<std::uint64_t>() : s.facts.covered_tiles();
  s.workers.clear();  // their slots are others'
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

/// What sleeps may have something to do under other weather. Before the first step everything is awake.
void RuleEngine::State::wake_on_change(const SignalValues& signals) {
  bool has_changed = false;
  for (std::size_t k = 1; k < kNumSignals; ++k)
    has_changed = has_changed || (uses[k] && last_signals && (*last_signals)[k] != signals[k]);
  if (has_changed) awake = facts.covered_tiles();
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

void RuleEngine::State::load(TileIndex tile, const MaterialAtlas& atlas, Worker& worker) const {
  alignas(64) std::array<std::uint16_t, TileGrid::kTileTexels> originals;
  for (std::size_t k = 0; k < materials.size(); ++k) {
    const std::uint16_t* stored = atlas.tile(materials[k], tile).data();
    if (!stored) {
      if (facts.is_uniform(tile)) {
        originals.fill(atlas.original(materials[k], tile * TileGrid::kTileTexels));
      } else {
        atlas.read_tile(materials[k], tile, originals);
      }
      stored = originals.data();
    }
    kernel->load(stored, worker.quanta[k].data(), worker.slots[k].values.data());
  }
  for (std::size_t p = 0; p < parameters.size(); ++p)
    load_parameter(parameters[p], tile, worker.slots[materials.size() + p].values.data());
}

/// @returns whether some rule has an extent there.
bool RuleEngine::State::age_tile(TileIndex tile, MaterialAtlas& atlas, Worker& worker, bool& is_dirty) const {
  load(tile, atlas, worker);
  alignas(64) std::array<float, TileGrid::kTileTexels> covered;
  facts.covered(tile, covered);
  std::array<bool, kMaxMaterials> has_changed{};
  std::array<std::uint32_t, TileGrid::kTileTexels> weights;
  bool has_weights = false, has_extent = false;
  float* slots = worker.slots[0].values.data();
  for (const CompiledRule& rule : rules) {
    run_expression(rule.driver, slots, set);
    const KernelRule& form = rule.form;
    const float* driver = worker.slots[static_cast<std::size_t>(rule.driver.result)].values.data();
    const int outcome = kernel->apply(form, driver, covered.data(), tile * TileGrid::kTileTexels,
                                      worker.quanta[0].data(), slots, worker.changes[0].data());
    has_extent |= (outcome & 1) != 0;
    if ((outcome & 2) == 0) continue;
    if (!std::exchange(has_weights, true)) facts.weights(tile, weights);
    for (int k = 0; k < form.num_terms; ++k) {
      const auto slot = static_cast<std::size_t>(form.terms[k].material);
      has_changed[slot] = true;
      const auto m = static_cast<std::size_t>(materials[slot]);
      (k < form.num_makes ? worker.made : worker.used)[m] +=
          kernel->weigh(worker.changes[static_cast<std::size_t>(k)].data(), weights.data());
    }
  }
  for (std::size_t k = 0; k < materials.size(); ++k) {
    if (has_changed[k]) kernel->store(worker.quanta[k].data(), atlas.writable_tile(materials[k], tile).data());
  }
  is_dirty = std::find(has_changed.begin(), has_changed.end(), true) != has_changed.end();
  return has_extent;
}

RuleReport RuleEngine::step(std::int64_t iteration, MaterialAtlas& atlas, const RunControl& control) {
  State& s = *state_;
  RuleReport report;
  if (s.rules.empty() || s.awake.empty() || !(s.time_per_iteration > 0.0)) return report;
  const auto phase = static_cast<int>((kEpoch - iteration % kEpoch) % kEpoch);  // tiles that are due: tile % kEpoch
  const std::int64_t span = std::min<std::int64_t>(kEpoch, iteration + 1);
  const double time = static_cast<double>(span) * s.time_per_iteration;
  const SignalValues signals = s.signals_over(iteration, span);
  s.wake_on_change(signals);
  for (std::size_t r = 0; r < s.rules.size(); ++r) {
    KernelRule& form = s.rules[r].form;
    form.scale = static_cast<float>(s.rules[r].rate * time);
    const auto now = static_cast<std::uint64_t>(iteration);
    const auto random = philox4x32({static_cast<std::uint32_t>(now), static_cast<std::uint32_t>(now >> 32),
                                    static_cast<std::uint32_t>(r), kRulePurpose},
                                   {static_cast<std::uint32_t>(s.seed), static_cast<std::uint32_t>(s.seed >> 32)});
    form.keys[0] = random[0];
    form.keys[1] = random[1];
  }
  const auto num_pages = static_cast<std::int64_t>(s.awake.size());
  const std::int64_t num_chunks = (num_pages + kChunkPages - 1) / kChunkPages;
  constexpr std::size_t kChunkTiles = kChunkPages * TileGrid::kPageTiles / kEpoch;
  s.dirty.resize(static_cast<std::size_t>(num_chunks) * kChunkTiles);
  s.num_dirty.assign(static_cast<std::size_t>(num_chunks), 0);
  RunControl threads;  // a part of a step is no state to stop in
  threads.num_threads = control.num_threads;
  const std::int64_t num_workers = std::min<std::int64_t>(thread_count(threads), num_chunks);
  if (s.workers.size() < static_cast<std::size_t>(num_workers)) s.workers.resize(static_cast<std::size_t>(num_workers));
  std::atomic<std::int64_t> next{0};
  parallel_for(num_workers, 1, threads, [&](std::int64_t w, std::int64_t) {
    Worker& worker = s.workers[static_cast<std::size_t>(w)];
    if (worker.slots.empty()) {
      worker.slots.resize(static_cast<std::size_t>(s.num_slots));
      worker.quanta.resize(std::max<std::size_t>(1, s.materials.size()));
      for (const CompiledRule& rule : s.rules) {
        for (const auto& constant : rule.driver.constants)
          worker.slots[static_cast<std::size_t>(constant.slot)].values.fill(constant.value);
      }
    }
    for (std::size_t k = 0; k < kNumSignals; ++k) worker.slots[s.first_signal() + k].values.fill(signals[k]);
    for (std::int64_t chunk = next++; chunk < num_chunks; chunk = next++) {
      const auto c = static_cast<std::size_t>(chunk);
      std::array<TileIndex, kChunkTiles> tiles;
      std::size_t num_tiles = 0;
      for (auto page = static_cast<std::size_t>(chunk * kChunkPages);
           page < static_cast<std::size_t>(std::min(num_pages, (chunk + 1) * kChunkPages)); ++page) {
        for (std::uint64_t due = s.awake[page] & kEveryEighth << phase; due != 0; due &= due - 1) {
          tiles[num_tiles++] =
              static_cast<TileIndex>(page) * TileGrid::kPageTiles + static_cast<std::uint32_t>(std::countr_zero(due));
        }
      }
      for (std::size_t i = 0; i < num_tiles; ++i) {
        if (i + kPrefetchTiles < num_tiles) s.prefetch(tiles[i + kPrefetchTiles], atlas);
        const TileIndex tile = tiles[i];
        bool is_dirty = false;
        if (!s.age_tile(tile, atlas, worker, is_dirty) && !s.uses[0]) {
          s.awake[tile / TileGrid::kPageTiles] &= ~(std::uint64_t{1} << tile % TileGrid::kPageTiles);
        }
        if (is_dirty) s.dirty[c * kChunkTiles + s.num_dirty[c]++] = tile;
      }
    }
  });
  std::size_t num_dirty = 0;
  for (std::size_t c = 0; c < static_cast<std::size_t>(num_chunks); ++c) {
    std::copy_n(s.dirty.begin() + static_cast<std::ptrdiff_t>(c * kChunkTiles), s.num_dirty[c],
                s.dirty.begin() + static_cast<std::ptrdiff_t>(num_dirty));
    num_dirty += s.num_dirty[c];
  }
  report.dirty_tiles = std::span<const TileIndex>(s.dirty).first(num_dirty);
  for (Worker& worker : s.workers) {
    for (std::size_t m = 0; m < kMaxMaterials; ++m) {
      report.made[m] += std::exchange(worker.made[m], 0);
      report.used[m] += std::exchange(worker.used[m], 0);
    }
  }
  return report;
}

}  // namespace patinate::simulation
