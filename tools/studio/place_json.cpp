// GET /api/place: what a place is.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "capture/project/capture_project.h"
#include "capture/project/relit_project.h"
#include "libcommon/core/read_limit.h"
#include "libcommon/core/text.h"
#include "libcommon/history/history_times.h"
#include "patinate/mesh_files/mesh_io.h"
#include "simulation/job/simulation_job.h"
#include "tools/studio/registered_scans.h"
#include "tools/studio/routes.h"

namespace patinate::studio {

namespace fs = std::filesystem;

namespace {

/// [[label, text], ...]
class FactList {
 public:
  void add(const std::string& label, const std::string& text) {
    if (!text.empty()) json_.push_back(Json::array({label, text}));
  }
  [[nodiscard]] Json take() { return std::move(json_); }

 private:
  Json json_ = Json::array();
};

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

/// The file in which `init` says what it has found; "" if there is none.
std::string hints_of(const fs::path& place) {
  const fs::path file = capture::capture_file(place).replace_extension(".hints.txt");
  std::error_code error;
  return fs::is_regular_file(file, error) ? file.filename().string() : std::string();
}

void add_history(const SurfaceInTime& surface, Json& json, FactList& facts) {
  const HistoryManifest& m = surface.history().manifest();
  json["width"] = surface.width();
  json["height"] = surface.height();
  json["unit"] = shown_time_unit(m.time_unit);
  Json times = Json::array(), controls = Json::array(), maps = Json::array();
  bool has_masks = false;
  for (const HistoryFrame& frame : m.frames) {
    times.push_back(frame.time);
    has_masks = has_masks || frame.mask.has_value();
  }
  std::vector<std::string> names;
  for (const ControlParameter& c : m.controls) {
    controls.push_back({{"name", c.name}, {"low", c.low}, {"high", c.high}, {"unit", c.unit}});
    names.push_back(c.name + " (" + short_number_text(c.low) + " to " + short_number_text(c.high) +
                    (c.unit.empty() ? "" : " " + c.unit) + ")");
  }
  for (const HistoryMap& map : m.maps) maps.push_back(map.name);
  facts.add("Frames", std::to_string(m.frames.size()) + ", " + short_number_text(m.frames.front().time) + " to " +
                          short_number_text(m.frames.back().time) + " " + shown_time_unit(m.time_unit));
  facts.add("Size", size_text(surface.width(), surface.height()));
  facts.add("Origin", m.origin);
  if (m.texel_size_mm) facts.add("Pixel", short_number_text(rounded(*m.texel_size_mm, 3)) + " mm");
  facts.add("Controls", joined(names));
  json["times"] = std::move(times);
  json["texel_size_mm"] = m.texel_size_mm ? Json(*m.texel_size_mm) : Json(nullptr);
  json["origin"] = m.origin;
  json["controls"] = std::move(controls);
  json["maps"] = std::move(maps);
  json["frame_masks"] = has_masks;
  json["frame_maps"] = surface.frame_maps();
  json["amounts"] = surface.amounts();
  json["material"] = Json::array();
  for (const SurfaceMap map : surface.material())
    json["material"].push_back(kSurfaceMapNames[static_cast<std::size_t>(map)]);
}

void add_transfer(const ServedFolder& folder, const SurfaceInTime& surface, Json& json, FactList& facts) {
  const transfer::TransferManifest& m = surface.transfer()->manifest();
  json["mesh"] = true;
  json["tiles"] = surface.transfer()->sheet().names;
  std::error_code error;
  const fs::path history = fs::canonical(surface.history().folder(), error);
  const std::string name = error ? "" : folder.name_of(history);
  const bool is_served = !name.empty() && folder.find(name).has_value();
  json["source"] = is_served ? Json(name) : Json(nullptr);
  json["source_width"] = surface.history().manifest().width;
  json["source_height"] = surface.history().manifest().height;
  facts.add("History", m.history.filename().string());
  std::vector<std::string> guides;
  for (const transfer::RecordedControl& c : m.controls) guides.push_back(c.text());
  facts.add("Guided by", joined(guides));
  facts.add("Coherent", percent_text(m.energy.coherent_share));
}

void add_simulation(const fs::path& path, Json& json, FactList& facts) {
  const simulation::SimulationManifest m = simulation::read_simulation_manifest(path);
  json["mesh"] = true;
  json["can_recompose"] = true;
  json["materials"] = m.materials;
  json["iterations"] = m.iterations;
  facts.add("Iterations", std::to_string(m.iterations));
  facts.add("Materials", joined(m.materials));
  std::error_code error;
  if (!may_read(m.scene))
    json["live_problem"] = "its scene file " + m.scene.string() +
                           " lies outside of the folder that is served, so it cannot be run again here";
  else if (!fs::is_regular_file(m.scene, error))
    json["live_problem"] = "its scene file " + m.scene.string() + " is not there any more, so it cannot be run again";
}

void add_registration(const ServedFolder& folder, const fs::path& path, Json& json, FactList& facts) {
  const RegisteredScans registration = read_registration(path, folder);
  const auto is_shown = [](const PlacedScan& scan) { return scan.file.has_value(); };
  json["mesh"] = std::any_of(registration.scans.begin(), registration.scans.end(), is_shown);
  json["scans"] = scans_json(registration);
  json["steps"] = steps_json(folder, path, PlaceKind::Registration);
  facts.add("Scans", std::to_string(registration.scans.size()) + ", " +
                         std::to_string(std::count_if(registration.scans.begin(), registration.scans.end(), is_shown)) +
                         " shown");
  facts.add("Reference", registration.reference);
  facts.add("Unit", registration.unit.empty() ? "not said" : registration.unit);
}

std::string share_text(const Json& json, const char* key) {
  return json.contains(key) && json.at(key).is_number() ? percent_text(json.at(key).get<double>()) : "";
}

void add_unlit(const fs::path& path, FactList& facts) {
  const Json json = load_json(path / "unlight.json");
  facts.add("Size", size_text(json.value("width", 0), json.value("height", 0)));
  if (const double surface = json.value("surface_pixels", 0.0); surface > 0.0) {
    facts.add("Known", short_number_text(rounded(100.0 * json.value("determined_pixels", 0.0) / surface, 3)) +
                           " % of the surface");
  }
  facts.add("Residual", share_text(json, "residual"));
  facts.add("Lamps", json.contains("lights") ? std::to_string(json.at("lights").size()) : "");
}

}  // namespace

Json place_json(const ServedFolder& folder, OpenedPlaces& opened, const fs::path& path, PlaceKind kind) {
  const PlaceEntry entry = describe_place(folder, path, kind);
  Json json{{"place", entry.place},
            {"kind", kPlaceKindNames[static_cast<std::size_t>(kind)]},
            {"name", entry.name},
            {"detail", entry.detail}};
  FactList facts;
  switch (kind) {
    case PlaceKind::History:
    case PlaceKind::Transfer:
    case PlaceKind::Simulation: {
      const std::shared_ptr<const SurfaceInTime> surface = opened.open(path, kind);
      add_history(*surface, json, facts);
      if (kind == PlaceKind::Transfer) add_transfer(folder, *surface, json, facts);
      if (kind == PlaceKind::Simulation) add_simulation(path, json, facts);
      if (fs::is_regular_file(path / "report.html")) json["page"] = "report.html";
      if (kind == PlaceKind::History) json["steps"] = steps_json(folder, path, kind);
      if (std::error_code error; fs::is_regular_file(path / "relief.json", error))
        json["shows"] = "frame:height";  // Its color is mid gray.
      break;
    }
    case PlaceKind::Registration:
      add_registration(folder, path, json, facts);
      break;
    case PlaceKind::Unlit:
      add_unlit(path, facts);
      [[fallthrough]];
    case PlaceKind::Ingest:
      json["steps"] = steps_json(folder, path, kind);
      if (const std::string hints = hints_of(path); !hints.empty()) json["hints"] = hints;
      json["has_marks"] = kind == PlaceKind::Ingest && !capture::is_relit_capture(capture::capture_file(path));
      break;
    case PlaceKind::Mesh: {
      const Mesh mesh = read_mesh(path);
      json["mesh"] = true;
      json["has_uvs"] = mesh.has_uvs();
      facts.add("Triangles", std::to_string(mesh.num_triangles()));
      facts.add("UVs", mesh.has_uvs() ? "yes" : "no");
      break;
    }
    case PlaceKind::Report:
      json["page"] = fs::exists(path / "report.html") ? "report.html" : "evaluation.html";
      break;
    case PlaceKind::Scene:
    case PlaceKind::Calibration:
      break;
  }
  facts.add("", entry.problem);
  json["facts"] = facts.take();
  return json;
}

HttpResponse answer_place(const Asked& asked) {
  const auto [path, kind] = asked.place();
  return json_response(place_json(asked.folder, asked.opened, path, kind));
}

HttpResponse answer_live(const Asked& asked) {
  const auto [path, kind] = asked.place();
  if (!can_run(kind)) throw InvalidInput(kOnlyScenesRun);
  const std::shared_ptr<LiveScene> scene = asked.live.find(path);
  if (!scene) return json_response(Json{{"state", "none"}});
  if (const std::string why = scene->problem(); !why.empty()) throw InvalidInput(why);
  return json_response(Json{{"state", scene->is_running() ? "running" : "reading"}});
}

}  // namespace patinate::studio
