/// \file
/// A simulation as the module's functions take it.
#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "patinate/core/error.h"
#include "patinate/simulation/engine.h"
#include "patinate/simulation/scene_io.h"
#include "python/simulation/scene_argument.h"
#include "python/support/device_keyword.h"
#include "python/support/keywords.h"

namespace patinate::python {

/// A running scene. One call at a time: the interpreter's lock is not held while it works.
class PySimulation {
 public:
  PySimulation(const pybind11::object& scene, const pybind11::kwargs& kwargs);

  /// `work` runs without the interpreter's lock; it owns what it uses. @throws InvalidInput when another thread is at
  /// it.
  template <class F>
  auto alone(const RunArguments& run, F work) {
    const Turn turn = take_turn();
    throw_if_lost();
    auto owned = [turn, work = std::move(work)](const RunControl& control) mutable {
      return work(*turn->running, control);
    };
    if constexpr (std::is_void_v<decltype(owned(RunControl{}))>) {
      run_interruptibly(run, std::move(owned));
      device_->warn();
    } else {
      auto result = result_of(run, std::move(owned));
      device_->warn();
      return result;
    }
  }
  /// Works in the same way for what takes no time, whatever the atlas.
  template <class F>
  auto look(F&& read) {
    const Turn turn = take_turn();
    throw_if_lost();
    return read(*turn->running);
  }

  /// alone() for what changes the state. What ends it half-way loses the state; what is wrong with the input is found
  /// before any change, but for a stroke that has painted already.
  template <class F>
  void change(const RunArguments& run, F work) {
    alone(run,
          [state = state_.get(), work = std::move(work)](simulation::Simulation& s, const RunControl& control) mutable {
            control.throw_if_stopped();
            const std::int64_t painted = s.num_paint_steps();
            state->is_lost = true;  // Until it is whole again.
            state->is_changed_by_hand = true;
            try {
              work(s, control);
            } catch (const InputError&) {
              state->is_lost = s.num_paint_steps() != painted;
              throw;
            }
            state->is_lost = false;
          });
  }

  void step(std::int64_t count, const RunArguments& run) {
    if (count < 0) throw InvalidInput("count: " + std::to_string(count) + " is out of range; use >= 0");
    alone(run, [state = state_.get(), count](simulation::Simulation& s, const RunControl& control) {
      for (std::int64_t i = 0; i < count; ++i) {
        control.throw_if_stopped();
        state->is_lost = true;  // By what an iteration throws. It is not interrupted, so that the state stays whole.
        s.step({.on_progress = {}, .stop = {}, .num_threads = control.num_threads});
        state->is_lost = false;
        control.report(static_cast<double>(i + 1) / static_cast<double>(count));
      }
    });
  }

  void set_amounts(int material, const ImageF& amounts) {
    change({}, [state = state_.get(), material, amounts](simulation::Simulation& s, const RunControl&) {
      s.set_amounts(material, amounts);
      state->has_set_amounts = true;
    });
  }

  void restore(std::string bytes) {
    const Turn turn = take_turn();
    run_interruptibly({}, [turn, bytes = std::move(bytes)](const RunControl&) {
      turn->running->restore(std::as_bytes(std::span(bytes)));
      turn->is_lost = false;
      turn->is_changed_by_hand = turn->has_set_amounts = true;  // The snapshot may be of a state that was.
    });
  }

  /// Writes the folder of a simulation as it is now.
  void save(const std::string& folder, bool force, const RunArguments& run);

  [[nodiscard]] const simulation::SceneFile& file() const { return state_->file; }
  [[nodiscard]] int material(const std::string& name) const {
    const std::vector<std::string>& all = file().scene.materials;
    const auto found = std::find(all.begin(), all.end(), name);
    if (found != all.end()) return static_cast<int>(found - all.begin());
    std::string list;
    for (const std::string& m : all) list += (list.empty() ? "" : ", ") + m;
    throw InvalidInput("material: found `" + name + "`; the scene has " + list);
  }

 private:
  struct State {
    simulation::SceneFile file;
    SceneArgument scene;  ///< As it was given.
    simulation::SimulationOptions options;
    std::optional<simulation::Simulation> running;
    bool is_changed_by_hand = false;
    bool has_set_amounts = false;
    std::atomic<bool> is_busy = false;
    std::atomic<bool> is_lost = false;  ///< By what ended in the middle of a change.
  };
  /// The state, for whoever is at it; the last copy that goes ends the turn, also on a thread that was left behind.
  using Turn = std::shared_ptr<State>;

  Turn take_turn() const {
    finish_left_work();
    if (state_->is_busy.exchange(true))
      throw InvalidInput("the simulation is at work in another thread; one call at a time");
    return {state_.get(), [held = state_](State* state) { state->is_busy = false; }};
  }
  void throw_if_lost() const {
    if (state_->is_lost)
      throw InvalidInput("a change was interrupted, so that the state is lost; restore() a snapshot");
  }
  static std::shared_ptr<State> opened(const std::filesystem::path& folder, const DeviceKeyword& device,
                                       const RunControl& control);
  static int checked_resolution(std::int64_t resolution) {
    constexpr Range kAllowed{.low = 16, .high = 16384};
    if (!kAllowed.contains(static_cast<double>(resolution)))
      throw InvalidInput("resolution: " + std::to_string(resolution) + " is out of range; use " + kAllowed.text());
    return static_cast<int>(resolution);
  }

  std::shared_ptr<State> state_;
  std::optional<DeviceKeyword> device_;
};

}  // namespace patinate::python
