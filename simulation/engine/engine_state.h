/// \file
/// What Simulation holds. For engine*.cpp only.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "patinate/simulation/engine.h"
#include "patinate/simulation/layer_atlas.h"
#include "simulation/device/simulation_device.h"
#include "simulation/engine/device_run.h"
#include "simulation/rules/rules.h"
#include "simulation/tracing/motion.h"
#include "simulation/tracing/scene_checks.h"
#include "simulation/tracing/wet_paths.h"
#include "simulation/transport/exchange.h"
#include "simulation/transport/met_texels.h"
#include "simulation/transport/parameter_maps.h"

namespace patinate::simulation {

struct Simulation::State {
  State(Scene given, SimulationOptions given_options, const RunControl& control);

  /// Enters births and deaths into the ledger of the last trace() or respond(). Those that end on the surface leave
  /// their cargo there.
  void begin_lives_and_end_them(ExchangeTime now, const RunControl& control);
  void end_share(const GammatonRange& moving, ExchangeTime now, const RunControl& control);
  /// @param gone  Gammatons that end on the surface, rising; what fits of their cargo goes to where they have run.
  void deposit(std::span<const std::uint32_t> gone, ExchangeTime now, const RunControl& control);
  /// Notes the contacts of the last trace(): where gammatons run, and where they have ever been.
  void follow_contacts();
  void mark(std::span<const TileIndex> tiles);
  /// After a loss or an error: composes everything, as part of what the last compose() has changed.
  void compose_again();
  /// Repeats iterations whose device buffers overflowed, before their results are used.
  void check_room();
  /// Composes what has changed, for whoever asks; composed_since_asked has what was composed.
  void compose_now(const RunControl& control);
  /// Normals that the next response reflects about; nullptr: the mesh's.
  [[nodiscard]] std::unique_ptr<SurfaceNormals> bounce_normals(const RunControl& control);
  [[nodiscard]] std::vector<TileIndex> dirty_since(std::int64_t since) const;
  /// Sets emitters that follow the weather to the weather of the next iteration. A snapshot need not hold this.
  void apply_weather();
  [[nodiscard]] std::unique_ptr<RuleEngine> make_rules(const RunControl& control) const;
  /// Takes over where objects stand in `changed`, and how large they are there. Amounts stay what they are: the mass
  /// that an object has more of when it has grown is entered as made, what it has less of as used. Maps of drivers are
  /// made anew before the rules' next step. @throws InvalidInput as place_objects(); nothing is changed then.
  void move_objects(const Scene& changed);
  /// @throws InvalidInput if an object is scaled by more than its texels' weights can tell.
  void check_scale(std::size_t object, double scale) const;
  void renew_rules(const RunControl& control);
  /// Enters the layers' masses under other weights. @param before  LayerAtlas::remaining() under those of before.
  void enter_scaled_layers(std::span<const std::int64_t> before);
  /// Other rules from now on; maps that they need are made of the objects where they stand now.
  /// @throws InvalidInput; nothing is changed then.
  void set_rules(std::span<const Rule> changed);
  void apply_rules(const RunControl& control);
  /// The emitter of this name that may paint. @throws InvalidInput
  [[nodiscard]] std::size_t brush_index(const std::string& emitter) const;
  /// Paths that attract floating gammatons; empty when nothing does.
  [[nodiscard]] std::optional<WetPaths> wet_paths();
  /// Marks every tile as changed, after amounts were set from outside.
  void wake_everything();
  /// One iteration on the host, without its events.
  void step_on_host(const RunControl& control);
  /// Steps on a device. @returns false, and does nothing, where no device can.
  [[nodiscard]] bool step_on_device(const RunControl& control);
  [[nodiscard]] bool uses_device() const;
  /// Copies the state to the device if it has changed on the host. @returns false where none is used. @throws
  /// DeviceError
  [[nodiscard]] bool open_device(const RunControl& control);
  void copy_to_device(const RunControl& control);
  /// @returns false if the device's buffers overflowed; they are larger now.
  [[nodiscard]] bool copy_from_device(const RunControl& control);
  /// Copies the state from the device to the host. Call it before the state is read.
  void copy_to_host(const RunControl& control = {});
  /// Call it before the state is changed on the host.
  void change_on_host(const RunControl& control = {});
  /// Copies the state to the host when the device has run many iterations since the last copy.
  void limit_lag(const RunControl& control);
  /// Repeats the iterations since the last copy to the host.
  void repeat_iterations(const RunControl& control);
  /// Continues on the host, from the last state that was copied to it.
  void lose_device(const device::DeviceError& error, const RunControl& control);

  Scene scene;
  SimulationOptions options;
  SceneMesh scene_mesh;
  SurfaceAtlas surface;
  MaterialAtlas atlas;
  std::unique_ptr<LayerAtlas> layers;      ///< Null in a scene without.
  std::vector<int> interface_materials{};  ///< materials_at_interfaces() of the scene as it began.
  GammatonTracer tracer;
  Gammatons gammatons;
  Cargo cargo;
  std::vector<Trail> trails;     ///< By gammaton.
  std::optional<MetTexels> met;  ///< Not known where a snapshot of an older version did not say.
  Exchanger exchanger;
  std::unique_ptr<ParameterMaps> maps;
  MassLedger ledger;
  std::vector<double> start_scales;   ///< By object.
  std::vector<double> scale_factors;  ///< By object: to that, as the weights have it.
  bool has_old_maps = false;          ///< Drivers' maps are of where objects stood before.
  std::unique_ptr<RuleEngine> rules;
  Composer composer;
  TraceResult trace;
  std::vector<std::uint32_t> ended;  ///< Working memory of begin_lives_and_end_them().
  std::vector<Ending> endings;       ///< Buffer of deposit().
  TraceCounters counters;
  SimulationTimes times;
  std::vector<std::int32_t> changed_in;  ///< By tile: the last iteration that changed it; -1 = none.
  std::int64_t iteration = 0;
  std::int64_t num_paint_steps = 0;
  std::int64_t composed_at = -1;                ///< Tiles changed in this iteration or later are not composed yet.
  std::vector<TileIndex> composed_tiles;        ///< By the last compose(),
  std::vector<TileIndex> composed_since_asked;  ///< and by the engine itself since then; in order.
  std::size_t next_event = 0;
  std::int64_t series_done = -1;  ///< Series that were due before this iteration have happened.
  WeatherValues weather_peaks{};  ///< Greatest values of the whole weather.
  std::vector<std::string> notes;
  std::unique_ptr<DeviceRun> there;  ///< Null where no device is used.
  bool is_composed_there = false;    ///< The device knows which tiles the last compose() has changed.
};

/// Amount quanta at the start, by object and material.
[[nodiscard]] std::vector<std::array<std::uint16_t, kMaxMaterials>> originals_of(const Scene& scene);
/// @throws InvalidInput unless it is a name of parameter_map_names().
void check_parameter_map(const std::string& name, const std::vector<std::string>& materials);
/// Changes a scene as the event says. @returns whether objects have moved. @throws InvalidInput for an unknown target.
bool apply_event(const SceneEvent& event, Scene& scene);

}  // namespace patinate::simulation
