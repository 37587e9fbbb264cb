/// \file
/// The simulator as an engine without files: apply what an artist does, step, look. Looking never changes what happens
/// next.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/image/image.h"
#include "patinate/simulation/compose.h"
#include "patinate/simulation/ledger.h"
#include "patinate/simulation/material_atlas.h"
#include "patinate/simulation/scene.h"

namespace patinate::simulation {

class LayerAtlas;
class SimulationDevice;
struct Gammatons;
struct TraceCounters;

struct SimulationOptions {
  std::vector<std::string> parameter_maps;  ///< Names, of parameter_map_names(), of the maps to count during the run.
                                            ///< Costs memory and little time.
  ColorForm color_form = ColorForm::Normalized;
  std::shared_ptr<const SimulationDevice> device =
      nullptr;  ///< Iterations and composition stay on it until somebody looks; no result depends on it.
};

/// Seconds since the beginning, of one process, by the CPU: of what a device does, only its times() tell.
struct SimulationTimes {
  double trace = 0.0;
  double exchange = 0.0;  ///< Surface update and gammaton update of the paper's Table 2.
  double respond = 0.0;
  double rules = 0.0;
  double compose = 0.0;
};

/// A map that is counted during the run, or the state at the end.
struct ParameterMap {
  std::string name;
  ImageF values;     ///< H x W x 1, in `unit`; 0 outside the charts.
  std::string unit;  ///< "1" (counts), "amount", or the scene's unit of time.
};

/// Texels of the atlas, from its upper left, that show an object's unit square of UVs.
struct ObjectSquare {
  std::string name;  ///< Of the object.
  int x = 0, y = 0, side = 0;
};

/// Gammatons age a scene [Guenther, Rohmer, Grosch 2012, "GPU-accelerated Interactive Material Aging"]. An iteration
/// is: the scene's own events, tracing (each gammaton to its next contact), exchange of material, response (bounce,
/// float, absorb), rules.
///
/// Same bits for any number of threads and any instruction set, for any way to divide a run by snapshots, and whoever
/// looks meanwhile. Not thread-safe; each call uses all threads that its RunControl grants.
class Simulation {
 public:
  /// @throws InvalidInput what check_scene(), make_scene_mesh(), SurfaceAtlas and check_emitters() throw, and for a
  /// parameter map of no known name.
  explicit Simulation(Scene scene, SimulationOptions options = {}, const RunControl& control = {});
  ~Simulation();
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;

  /// The scene as it is now: emitters and objects where events have moved them.
  [[nodiscard]] const Scene& scene() const;
  /// Iterations done.
  [[nodiscard]] std::int64_t iteration() const;
  /// Steps of paint() ever: with iteration() it tells states of one run apart.
  [[nodiscard]] std::int64_t num_paint_steps() const;
  /// Current time in the scene's unit.
  [[nodiscard]] double time() const;
  /// Unusual but allowed things that a user should know of (open or inside-out meshes).
  [[nodiscard]] const std::vector<std::string>& notes() const;

  /// Now, whatever event.iteration says. @throws InvalidInput for an unknown target or a value out of range; nothing is
  /// changed then.
  /// @param control  For the steps of an event `paint`. @throws Canceled as step().
  void apply(const SceneEvent& event, const RunControl& control = {});
  /// The scene's own events that come before the next iteration happen now, and not in the next step(): for a picture
  /// that is to show them.
  void apply_due(const RunControl& control = {});
  /// A brush alone: the emitter moves to a place, its gammatons are born (though it may be off), go to their next
  /// contact, exchange and respond. All other gammatons, the rules and time stand still: an artist's stroke costs none.
  /// What it leaves under way continues with the next step().
  /// @param emitter  Of any shape but Sky. @throws InvalidInput for another, nothing is changed then; Canceled as
  /// step().
  void paint(const std::string& emitter, const Vec3& position_mm, const RunControl& control = {});
  /// One iteration. @throws Canceled: the state is then lost (go back to a snapshot).
  void step(const RunControl& control = {});

  [[nodiscard]] const MaterialAtlas& atlas() const;
  /// Thicknesses and adhesion of the objects' layers; nullptr in a scene without. Such a scene runs on the CPU.
  [[nodiscard]] const LayerAtlas* layers() const;
  /// Of all amounts, and of the layers: equal for equal states.
  [[nodiscard]] std::string state_hash() const;
  [[nodiscard]] const TraceCounters& counters() const;
  [[nodiscard]] const SimulationTimes& times() const;
  /// Bytes of the atlas, its pages and gammatons, without optional maps.
  [[nodiscard]] std::size_t memory() const;
  /// The location of all mass. Balances exactly after every step.
  [[nodiscard]] const MassLedger& ledger() const;
  /// Compares the mass balance with a sum over all texels and gammatons (slow): what is wrong, "" if nothing.
  [[nodiscard]] std::string audit(const RunControl& control = {}) const;
  /// Tiles whose amounts changed in iteration `since` or later, in order.
  [[nodiscard]] std::vector<TileIndex> dirty_since(std::int64_t since) const;

  /// Composes the current appearance; only changes since the last call are composed again.
  [[nodiscard]] const Composer& compose(const RunControl& control = {});
  /// Tiles that the last compose() has changed, in order: for those who hold a copy.
  [[nodiscard]] std::span<const TileIndex> composed_tiles() const;
  /// Other appearance parameters for the same amounts. @throws InvalidInput unless there is one for each material.
  void set_appearance(std::vector<MaterialAppearance> appearance);

  /// Positions of all gammatons, for display.
  [[nodiscard]] const Gammatons& gammatons() const;
  /// Amounts of a material in the user's order of pixels, 1 = kAmountOne; 0 outside the charts.
  [[nodiscard]] ImageF amounts(int material) const;
  [[nodiscard]] ImageF original_amounts(int material) const;
  /// Takes amounts over from elsewhere (a finished folder), rounded to quanta; the ledger then no longer describes
  /// them.
  /// @throws InvalidInput on another size or a value outside [0, 4).
  void set_amounts(int material, const ImageF& amounts);
  /// What files keep of the layers: a name for each map, such as "layer1.thickness_um". Empty in a scene without.
  [[nodiscard]] std::vector<std::string> layer_map_names() const;
  /// In um, as adhesion, or as an amount; 0 outside the charts.
  [[nodiscard]] ImageF layer_map(std::size_t index) const;
  /// As set_amounts(). @throws InvalidInput on another size or a value out of range.
  void set_layer_map(std::size_t index, const ImageF& values);
  /// MATERIAL.final needs not have been asked for. @throws InvalidInput for another that was not, or an unknown name.
  [[nodiscard]] ParameterMap parameter_map(const std::string& name) const;
  /// 255 where a gammaton has ever been, with the width that its splat has; else 0. nullopt: a snapshot was restored
  /// that does not tell (before "PPATSN05").
  [[nodiscard]] std::optional<ImageU8> met(const RunControl& control = {}) const;
  /// Where each object's own unit square of UVs lies in the atlas, in the scene's order.
  [[nodiscard]] std::vector<ObjectSquare> object_squares() const;
  /// 0 / 255.
  [[nodiscard]] ImageU8 coverage() const;
  /// All objects, with UVs over the atlas, mm, where they are now.
  [[nodiscard]] const Mesh& mesh() const;
  [[nodiscard]] double texel_size_mm() const;

  /// Everything that changes while it runs. Equal states give equal bytes.
  [[nodiscard]] std::vector<std::byte> snapshot() const;
  /// @param bytes  A snapshot of a simulation of the same scene and options; this scene may have more emitters behind
  /// those of that one, which
  ///   have waited then. @throws InvalidInput otherwise; nothing is changed then.
  void restore(std::span<const std::byte> bytes);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace patinate::simulation
