/// \file
/// What Simulation holds. For engine*.cpp only.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "patinate/simulation/engine.h"
#include "simulation/rules/rules.h"
#include "simulation/tracing/motion.h"
#include "simulation/tracing/scene_checks.h"
#include "simulation/transport/exchange.h"
#include "simulation/transport/parameter_maps.h"

namespace patinate::simulation {

struct Simulation::State {
  State(Scene given, SimulationOptions given_options, const RunControl& control);

  /// Enters births and deaths into the ledger of the last trace() or respond().
  void begin_lives_and_end_them();
  void end_share(const GammatonRange& moving);
  void mark(std::span<const TileIndex> tiles);
  [[nodiscard]] std::unique_ptr<RuleEngine> make_rules(const RunControl& control) const;
  /// Takes over where objects stand in `changed`, and how large they are there. Amounts stay what they are: the mass
  /// that an object has more of when it has grown is entered as made, what it has less of as used. Maps of drivers are
  /// made anew before the rules' next step. @throws InvalidInput as place_objects(); nothing is changed then.
  void move_objects(const Scene& changed);
  /// @throws InvalidInput if an object is scaled by more than its texels' weights can tell.
  void check_scale(std::size_t object, double scale) const;
  void renew_rules(const RunControl& control);
  /// Other rules from now on; maps that they need are made of the objects where they stand now.
  /// @throws InvalidInput; nothing is changed then.
  void set_rules(std::span<const Rule> changed);
  /// @param touched  Tiles whose amounts the exchange has changed.
  void apply_rules(std::span<const TileIndex> touched, const RunControl& control);
  /// The emitter of this name that may paint. @throws InvalidInput
  [[nodiscard]] std::size_t brush_index(const std::string& emitter) const;
  /// After amounts have come from elsewhere: every tile is looked at again.
  void wake_everything();

  Scene scene;
  SimulationOptions options;
  SceneMesh scene_mesh;
  SurfaceAtlas surface;
  MaterialAtlas atlas;
  GammatonTracer tracer;
  Gammatons gammatons;
  Cargo cargo;
  Exchanger exchanger;
  std::unique_ptr<ParameterMaps> maps;
  MassLedger ledger;
  std::vector<double> start_scales;   ///< By object.
  std::vector<double> scale_factors;  ///< By object: to that, as the weights have it.
  bool has_old_maps = false;          ///< Drivers' maps are of where objects stood before.
  std::unique_ptr<RuleEngine> rules;
  Composer composer;
  TraceResult trace;
  TraceCounters counters;
  SimulationTimes times;
  std::vector<std::int32_t> changed_in;  ///< By tile: the last iteration that changed it; -1 = none.
  std::int64_t iteration = 0;
  std::int64_t num_paint_steps = 0;
  std::int64_t composed_at = -1;          ///< Tiles changed in this iteration or later are not composed yet.
  std::vector<TileIndex> composed_tiles;  ///< By the last compose().
  std::size_t next_event = 0;
  std::vector<std::string> notes;
};

/// Amount quanta at the start, by object and material.
[[nodiscard]] std::vector<std::array<std::uint16_t, kMaxMaterials>> originals_of(const Scene& scene);
/// Changes a scene as the event says. @returns whether objects have moved. @throws InvalidInput for an unknown target.
bool apply_event(const SceneEvent& event, Scene& scene);

}  // namespace patinate::simulation
