// Outcome of a running scene, and its files on the disk: a scene file, textures, GLB, parameter maps, a
// history.
#include <algorithm>
#include <array>
#include <atomic>
#include <nlohmann/json.hpp>

#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"
#include "patinate/image/image_io.h"
#include "simulation/job/outcome_json.h"
#include "simulation/job/simulation_job.h"
#include "simulation/job/simulation_output.h"
#include "tools/studio/live_client.h"
#include "tools/studio/scene_text.h"

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

/// Work while the simulation is composed as files have it: water is a color, no film.
void LiveEngine::as_exported(const std::function<void()>& work) {
  refresh();  // Clients get to see what is composed from now on.
  if (!material_) return work();
  const auto back = [this] {
    set_looks(std::move(looks_));
    refresh();  // The composer has what clients have again; it tells only what differs from what it has.
  };
  simulation_.set_appearance(looks_);
  try {
    work();
  } catch (...) {
    back();
    throw;
  }
  back();
}

void LiveEngine::save(const std::string& name) {
  const fs::path path = folder_.new_path(name);
  if (path.extension() != ".json") throw InvalidInput("\"" + name + "\": a scene file ends in .json");
  catch_up();  // Drawn strokes are in the file, painted already or not.
  write_atomically(path, readable_text(record_.file_for(path.parent_path(), iteration())));
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
  write_atomically(folder / "scene.json", readable_text(record_.file_for(folder, iteration())));
  if (wants("textures") || wants("glb")) {
    as_exported([&] { simulation::write_composed_files(folder, file_.name, simulation_, ""); });
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
  const auto tell = [](const std::shared_ptr<WebSocketPeer>& to, const Json& json) {
    to->send_text(json.dump(-1, ' ', false, Json::error_handler_t::replace));
  };
  tell(peer, exported_json(name, folder));
  if (!wants("history")) return;
  is_exporting_->store(true);
  exporting_ = std::jthread([folder, name, tell, peer, flag = is_exporting_, form = options_.color_form,
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
      tell(peer, exported_json(name, folder));
      say("The history is in " + name + "/simulation");
    } catch (const std::exception& e) {
      say(stop.stop_requested() ? "The history was canceled"
                                : std::string("The history could not be made: ") + e.what());
    }
    flag->store(false);
  });
}

/// What lies in a folder that was exported, for those who download it.
Json LiveEngine::exported_json(const std::string& name, const fs::path& folder) {
  Json files = Json::array();
  std::vector<std::pair<std::string, std::uintmax_t>> found;
  std::error_code error;
  for (fs::recursive_directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (it->is_regular_file(error))
      found.emplace_back(it->path().lexically_relative(folder).generic_string(), it->file_size(error));
  }
  std::sort(found.begin(), found.end());
  for (const auto& [path, bytes] : found) files.push_back({{"path", path}, {"bytes", bytes}});
  return {{"type", "exported"}, {"place", name + "/scene.json"}, {"files", std::move(files)}};
}

/// All that is known of one texel. @param x,y  Of the picture.
Json LiveEngine::probe(int x, int y) {
  refresh();
  const auto tile = static_cast<ScreenTile>((y / 8) * layout_.columns() + x / 8);
  const auto place = static_cast<std::size_t>((y % 8) * 8 + x % 8);
  const simulation::TexelIndex texel = layout_.sources(tile)[place];
  Json json{{"type", "probe"}, {"x", x}, {"y", y}, {"iteration", iteration()}, {"is_surface", false}};
  json["time"] = rounded(static_cast<double>(iteration()) * simulation_.scene().time_per_iteration, 12);
  if (texel == simulation::kNoTexel) return json;
  const simulation::SurfaceAtlas& surface = simulation_.atlas().surface();
  const simulation::Scene& scene = simulation_.scene();
  json["is_surface"] = surface.grid().x(texel) == x && surface.grid().y(texel) == y;
  json["amounts"] = Json::object();
  for (std::size_t m = 0; m < scene.materials.size(); ++m) {
    json["amounts"][scene.materials[m]] =
        static_cast<double>(simulation_.atlas().amount(static_cast<int>(m), texel)) / simulation::kAmountOne;
  }
  const std::span<const std::uint8_t> codes = planes_.tile(TilePlanes::Surface, tile);
  json["srgb"] = {codes[4 * place], codes[4 * place + 1], codes[4 * place + 2]};
  json["specular"] = static_cast<double>(codes[4 * place + 3]) / 255.0;
  json["height_mm"] = simulation_.compose({}).height_mm(texel);
  return json;
}

/// Colors, amounts and places never met since the start of the scene.
Json LiveEngine::outcome() {
  ImageF before(start_color_.width(), start_color_.height(), 3);
  for (std::size_t i = 0; i < before.values().size(); ++i)
    before.values()[i] = linear_from_srgb(static_cast<float>(start_color_.values()[i]) / 255.0f);
  const RunControl control{.on_progress = {}, .stop = {}, .num_threads = options_.num_threads};
  Json json;
  as_exported([&] { json = simulation::outcome_json(simulation::outcome_of(simulation_, before, control)); });
  json["type"] = "outcome";
  json["iteration"] = iteration();
  return json;
}

}  // namespace patinate::studio
