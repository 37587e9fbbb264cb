/// \file
/// Aging: rules turn what lies on a texel into something else while gammatons run [Guenther et al. 2012, sec. 4.3].
///
/// In dt a rule has the extent x = rate * driver * dt; of each material it makes x * products[i]. What it uses falls as
/// if the rule took it in proportion to what is left: A (1 - exp(-x u / A)), so that nothing is overdrawn and
/// evaporation (driver = what it uses) is exact for any split of dt; x is then cut down to what the scarcest material
/// gave, so that as much is made as was used. Amounts stay integers: each change is rounded to whole quanta with a
/// random number of (seed, texel, time, rule), right in the mean.
///
/// Time goes in epochs of kEpoch iterations: tile t is aged at the iterations i with (i + t) mod kEpoch = 0, by all the
/// time since it was aged last. An eighth of the work is done in each iteration, and nothing depends on when one reads
/// it: after iteration i every tile is aged up to some iteration in (i - kEpoch, i], the same ones whenever and however
/// often a run is viewed, saved or resumed.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "libcommon/core/instruction_set.h"
#include "patinate/core/run_control.h"
#include "patinate/simulation/material_atlas.h"
#include "patinate/simulation/scene.h"
#include "patinate/simulation/weather.h"
#include "simulation/rules/surface_parameter.h"

namespace patinate::simulation {

struct DeviceArrays;
class LayerAtlas;

/// Changes by rules.
struct RuleReport {
  std::span<const TileIndex> dirty_tiles;  ///< With texels whose amounts changed; rising. Good until the next step.
  std::array<std::int64_t, kMaxMaterials> made{};  ///< Mass.
  std::array<std::int64_t, kMaxMaterials> used{};
};

/// Names that a rule's driver and mask ask for beyond the materials: the parameters that RuleEngine must be given.
/// @param maps  Names of the scene's maps. @param layers  layer_names(); their values are no parameters.
/// @throws InvalidInput for a driver that cannot be read, with position and did-you-mean.
[[nodiscard]] std::vector<std::string> parameters_of(const Rule& rule, std::span<const std::string> materials,
                                                     std::span<const std::string> maps = {},
                                                     std::span<const std::string> layers = {});
/// Those that change with time (is_time_signal()): "age", and what the weather must tell of. @throws as
/// parameters_of().
[[nodiscard]] std::vector<std::string> signals_of(const Rule& rule, std::span<const std::string> materials,
                                                  std::span<const std::string> maps = {},
                                                  std::span<const std::string> layers = {});

/// Applies a scene's rules, in their order.
class RuleEngine {
 public:
  static constexpr int kEpoch = 8;  ///< Iterations (docs/algorithms/aging_rules.md, Epochs).

  /// @param surface             Outlives the engine.
  /// @param time_per_iteration  In the unit of the rules' alphas.
  /// @param parameters          What drivers ask for; parameters_of().
  /// @param set                 Results do not depend on it.
  /// @param layers              Of the scene, or nullptr where it has none; outlives the engine, which changes them.
  /// @throws InvalidInput for a driver that cannot be read or asks for a parameter that is not given; for an
  /// instruction set that is not there. Signals of the weather are 0 until set_weather().
  RuleEngine(std::span<const Rule> rules, std::span<const std::string> materials, const SurfaceAtlas& surface,
             double time_per_iteration, std::uint64_t seed, std::vector<SurfaceParameter> parameters = {},
             InstructionSet set = instruction_set(), LayerAtlas* layers = nullptr);
  ~RuleEngine();
  RuleEngine(RuleEngine&&) noexcept;
  RuleEngine& operator=(RuleEngine&&) noexcept;

  /// Other rules from the next step on, with all tiles awake. A tile that was not due since is aged by the new ones for
  /// all the time since it was, at most kEpoch - 1 iterations: what a change means depends only on the iteration that
  /// it comes before.
  /// @param more_parameters  What the drivers ask for and has_parameter() denies. @throws InvalidInput as the
  /// constructor; nothing is changed then.
  void set_rules(std::span<const Rule> rules, std::span<const std::string> materials,
                 std::vector<SurfaceParameter> more_parameters = {});
  [[nodiscard]] bool has_parameter(std::string_view name) const;
  /// Weather that drivers see: at a tile's turn its mean over the time since the turn before. @param weather
  /// Checked.
  void set_weather(Weather weather);

  /// Amounts of these tiles were changed by others (ExchangeReport::dirty_tiles), so that rules may have something to
  /// do there. At first all tiles are awake; one falls asleep when no rule has an extent at any of its texels, and
  /// never while a driver asks for the age; all wake when the weather changes that a driver asks for. Sleep saves time
  /// and changes no result: a run may be resumed with all tiles awake.
  void wake(std::span<const TileIndex> tiles);
  [[nodiscard]] std::int64_t num_awake() const;

  /// Iteration `iteration`, counted from 0. Same bits for any number of threads and instruction set.
  /// @param control  Threads; a step that has begun is finished whatever `stop` says.
  RuleReport step(std::int64_t iteration, MaterialAtlas& atlas, const RunControl& control = {});
  /// Steps on a device, with the same bytes: the tiles that are awake there. @throws DeviceError
  void step_on_device(std::int64_t iteration, DeviceArrays& arrays);
  /// Whether a device has room for a texel's values.
  [[nodiscard]] bool can_step_there() const;
  /// Everything is awake, here and there; and after a device has failed.
  void wake_everything();
  void forget_there();

  /// Iterations of aging that a tile has behind it after `iteration`.
  [[nodiscard]] static std::int64_t aged_iterations(TileIndex tile, std::int64_t iteration);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace patinate::simulation
