// Outcome of a running scene, and its files on the disk: a scene file, textures, GLB, parameter maps, a
// history.
#include <algorithm>
#include <array>
#include <atomic>
#include <nlohmann/json.hpp>

#include "patinate/core/error.h"
#include "patinate/image/color.h"
#include "patinate/image/image_io.h"
#include "simulation/job/outcome_json.h"
#include "simulation/job/simulation_job.h"
#include "simulation/job/simulation_output.h"
#include "tools/studio/live_client.h"

namespace patinate::studio {

namespace fs = std::filesystem;

namespace {

constexpr std::array<std::string_view, 4> kExports{"textures", "glb", "controls", "history"};

/// Runs the saved scene again, from the start, with its history: the same bytes as what is on screen.
void make_history(const fs::path& scene, const fs::path& output, simulation::ColorForm form,
                  const RunControl& control) {
  simulation::SimulationOptions options;
  options.color_form = form;
  (void)run_job(simulation::plan_simulation(simulation::read_scene(scene, control.part(0.0, 0.1)), options, output), {},
                control.part(0.1, 1.0));
}

}  // namespace

void LiveEngine::save(const std::string& name) {
  const fs::path path = folder_.new_path(name);
  if (path.extension() != ".json") throw InvalidInput("\"" + name + "\": a scene file ends in .json");
  catch_up();  // Drawn strokes are in the file, painted already or not.
  save_json(path, record_.file_for(path.parent_path(), iteration()));
}

void LiveEngine::export_to(const std::string& name, const std::vector<std::string>& what,
                           const std::shared_ptr<WebSocketPeer>& peer) {
  const auto wants = [&](std::string_view word) { return std::find(what.begin(), what.end(), word) != what.end(); };
  for (const std::string& word : what) {
    if (std::find(kExports.begin(), kExports.end(), word) == kExports.end())
      throw InvalidInput("/what: found \"" + word + "\"; expected textures, glb, controls or history");
  }
  if (wants("history") && iteration() == 0)
    throw InvalidInput("nothing has happened yet, so there is no history; let the scene run first");
  if (wants("history") && is_exporting_->load())
    throw InvalidInput("another history is being made; wait for it, or cancel it");
  const fs::path folder = folder_.new_path(name);
  catch_up();
  fs::create_directory(folder);
  save_json(folder / "scene.json", record_.file_for(folder, iteration()));
  if (wants("textures") || wants("glb")) {
    simulation::write_composed_files(folder, file_.name, simulation_, "");
    std::error_code ignored;
    if (!wants("glb")) fs::remove(folder / "model.glb", ignored);
    for (const char* file : {"color.png", "specular.png", "normal.png", "height.exr"}) {
      if (!wants("textures")) fs::remove(folder / file, ignored);
    }
  }
  if (wants("controls")) {
    fs::create_directory(folder / "controls");
    std::vector<std::string> names = file_.controls;
    if (options_.finished.empty() && std::find(names.begin(), names.end(), "hits") == names.end())
      names.push_back("hits");
    for (const std::string& control : names) {
      const simulation::ParameterControl c = simulation::parameter_control(simulation_, control, file_.time_unit);
      write_scaled_exr(folder / "controls" / (control + ".exr"), c.values, {c.low, c.high, c.unit});
    }
  }
  if (!wants("history")) return;
  is_exporting_->store(true);
  exporting_ = std::jthread([folder, peer, flag = is_exporting_, form = options_.color_form,
                             threads = options_.num_threads](const std::stop_token& stop) {
    double said = -1.0;
    const auto say = [&](const std::string& text) {
      peer->send_text(Json{{"type", "notice"}, {"text", text}}.dump(-1, ' ', false, Json::error_handler_t::replace));
    };
    RunControl control{.on_progress = {}, .stop = stop, .num_threads = threads};
    control.on_progress = [&](double f) {
      if (f - said < 0.01 && f < 1.0) return;
      said = f;
      peer->send_text(Json{
          {"type", "progress"},
          {"text", "Running the scene again for its history"},
          {"done", f},
          {"total", 1}}.dump());
    };
    try {
      make_history(folder / "scene.json", folder / "simulation", form, control);
      say("The history is in " + (folder / "simulation").string());
    } catch (const std::exception& e) {
      say(stop.stop_requested() ? "The history was canceled"
                                : std::string("The history could not be made: ") + e.what());
    }
    flag->store(false);
  });
}

/// Colors, amounts and places never met since the start of the scene.
Json LiveEngine::outcome() {
  refresh();  // Clients get to see what is composed below.
  ImageF before(start_color_.width(), start_color_.height(), 3);
  for (std::size_t i = 0; i < before.values().size(); ++i)
    before.values()[i] = linear_from_srgb(static_cast<float>(start_color_.values()[i]) / 255.0f);
  const RunControl control{.on_progress = {}, .stop = {}, .num_threads = options_.num_threads};
  Json json = simulation::outcome_json(simulation::outcome_of(simulation_, before, control));
  json["type"] = "outcome";
  json["iteration"] = iteration();
  return json;
}

}  // namespace patinate::studio
