#include "tools/studio/place.h"

#include <sys/stat.h>

#include <algorithm>
#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>

#include "capture/project/capture_project.h"
#include "libcommon/core/file_name.h"
#include "libcommon/core/read_limit.h"
#include "libcommon/core/text.h"
#include "libcommon/history/history_times.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/history/history.h"
#include "patinate/transfer/transfer_io.h"
#include "simulation/job/simulation_job.h"

namespace patinate::studio {

namespace fs = std::filesystem;

namespace {

struct Manifest {
  std::string_view file;
  PlaceKind kind;
};
constexpr std::array kManifests{Manifest{"history.json", PlaceKind::History},
                                Manifest{"transfer.json", PlaceKind::Transfer},
                                Manifest{"simulation.json", PlaceKind::Simulation},
                                Manifest{"capture.json", PlaceKind::Ingest},
                                Manifest{"registration.json", PlaceKind::Registration},
                                Manifest{"unlight.json", PlaceKind::Unlit},
                                Manifest{"report.html", PlaceKind::Report},
                                Manifest{"evaluation.html", PlaceKind::Report}};
constexpr std::array<std::string_view, 5> kMeshExtensions{".obj", ".ply", ".stl", ".gltf", ".glb"};
constexpr int kMaxEntries = 20'000, kDepth = 5;

/// Scenes, calibrations and capture projects say what they are in their first lines.
std::optional<PlaceKind> kind_of_json(const fs::path& path) {
  if (!may_read(path)) return std::nullopt;
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return std::nullopt;
  std::string head(4096, '\0');
  std::ifstream in(path, std::ios::binary);
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(in.gcount());
  if (head.find("\"patinate.scene\"") != std::string::npos) return PlaceKind::Scene;
  if (head.find("\"patinate.calibration\"") != std::string::npos) return PlaceKind::Calibration;
  const bool is_of_folder = path.filename() == "capture.json";  // That folder is the place.
  if (!is_of_folder && head.find("\"patinate.capture\"") != std::string::npos) return PlaceKind::Ingest;
  return std::nullopt;
}

std::string count_text(std::size_t n, const std::string& what) {
  return std::to_string(n) + " " + what + (n == 1 ? "" : "s");
}

std::string place_text(const Json& json, const std::string& key) {
  return json.contains(key) && json.at(key).is_string() ? json.at(key).get<std::string>() : std::string();
}
std::size_t size_of(const Json& json, const std::string& key) { return json.contains(key) ? json.at(key).size() : 0; }

std::string span_text(const HistoryManifest& m) {
  return count_text(m.frames.size(), "frame") + ", " + size_text(m.width, m.height) + ", " +
         short_number_text(m.frames.front().time) + "-" + short_number_text(m.frames.back().time) + " " +
         shown_time_unit(m.time_unit);
}

void describe_scene(const fs::path& path, PlaceEntry& entry) {
  const Json json = load_json(path);
  std::string materials;
  if (json.contains("materials")) {
    for (const Json& m : json.at("materials"))
      materials += (materials.empty() ? "" : ", ") + (m.is_string() ? m.get<std::string>() : "?");
  }
  entry.detail = count_text(size_of(json, "objects"), "object") + ", " +
                 count_text(size_of(json, "emitters"), "emitter") + "; " + materials;
}

void describe(const fs::path& path, PlaceEntry& entry) {
  switch (entry.kind) {
    case PlaceKind::History: {
      const HistoryManifest m = read_history_manifest(path);
      if (!m.name.empty()) entry.name = m.name;
      entry.detail = span_text(m);
      break;
    }
    case PlaceKind::Transfer: {
      const transfer::TransferManifest m = transfer::read_transfer_manifest(path);
      entry.detail =
          size_text(m.width, m.height) + (m.tiles.size() > 1 ? ", " + count_text(m.tiles.size(), "tile") : "");
      for (const transfer::RecordedControl& control : m.controls) entry.detail += ", " + control.text();
      break;
    }
    case PlaceKind::Simulation: {
      const simulation::SimulationManifest m = simulation::read_simulation_manifest(path);
      if (!m.name.empty()) entry.name = m.name;
      entry.detail = std::to_string(m.iterations) + " iterations, " + size_text(m.resolution, m.resolution) + ", 0-" +
                     short_number_text(m.time) + " " + time_unit_text(m.time_unit);
      break;
    }
    case PlaceKind::Scene:
      describe_scene(path, entry);
      break;
    case PlaceKind::Ingest: {
      const Json json = load_json(capture::capture_file(path));
      if (const std::string name = place_text(json, "name"); !name.empty()) entry.name = name;
      entry.detail = place_text(json, "kind") == "relit" ? count_text(size_of(json, "steps"), "step") + " under lamps"
                                                         : "fixed camera, constant light";
      break;
    }
    case PlaceKind::Registration:
      entry.detail = count_text(size_of(load_json(path / "registration.json"), "scans"), "scan");
      break;
    case PlaceKind::Unlit: {
      const Json json = load_json(path / "unlight.json");
      entry.detail = count_text(size_of(json, "lights"), "light");
      break;
    }
    case PlaceKind::Calibration:
      entry.detail = place_text(load_json(path), "kind");
      break;
    case PlaceKind::Mesh:
      entry.detail = short_number_text(rounded(static_cast<double>(fs::file_size(path)) / 1e6, 2)) + " MB";
      break;
    case PlaceKind::Report:
      entry.detail = "a page";
      break;
  }
}

}  // namespace

std::string modified_text(const fs::path& path) {
  struct ::stat status {};
  if (::stat(path.c_str(), &status) != 0) return {};
  const std::time_t seconds = status.st_mtime;
  std::tm utc{};
  std::array<char, 24> text{};
  return ::gmtime_r(&seconds, &utc) != nullptr &&
                 std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &utc) > 0
             ? text.data()
             : std::string();
}

namespace {

class PlaceSearch {
 public:
  explicit PlaceSearch(const ServedFolder& folder) : folder_(folder) {}

  void look(const fs::path& path, int depth) {
    const std::optional<PlaceKind> kind = place_kind(path);
    if (kind) entries.push_back(describe_place(folder_, path, *kind));
    std::error_code error;
    if (!fs::is_directory(path, error) || depth == 0) return;
    if (kind && *kind != PlaceKind::Ingest && *kind != PlaceKind::Report) return;
    std::vector<fs::path> inside;
    for (fs::directory_iterator it(path, error), end; !error && it != end && num_left_ > 0;
         it.increment(error), --num_left_)
      inside.push_back(it->path());
    std::sort(inside.begin(), inside.end());
    for (const fs::path& child : inside) {
      const std::string name = child.filename().string();
      if (name.front() == '.' || child.extension() == ".partial" || fs::is_symlink(child, error)) continue;
      look(child, depth - 1);
    }
  }

  std::vector<PlaceEntry> entries;

 private:
  const ServedFolder& folder_;
  int num_left_ = kMaxEntries;
};

}  // namespace

std::optional<PlaceKind> place_kind(const fs::path& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) {
    for (const Manifest& m : kManifests) {
      if (fs::is_regular_file(path / m.file, error)) return m.kind;
    }
    return std::nullopt;
  }
  if (!fs::is_regular_file(path, error)) return std::nullopt;
  const std::string extension = lower_extension(path);
  if (extension == ".json") return kind_of_json(path);
  const bool is_mesh = std::find(kMeshExtensions.begin(), kMeshExtensions.end(), extension) != kMeshExtensions.end();
  return is_mesh ? std::optional(PlaceKind::Mesh) : std::nullopt;
}

PlaceEntry describe_place(const ServedFolder& folder, const fs::path& path, PlaceKind kind) {
  PlaceEntry entry{.place = folder.name_of(path),
                   .kind = kind,
                   .name = path.stem().string(),
                   .detail = {},
                   .problem = {},
                   .modified = modified_text(path)};
  std::error_code error;
  if (fs::is_directory(path, error)) entry.name = path.filename().string();
  try {
    describe(path, entry);
  } catch (const std::exception& e) {
    entry.problem = e.what();
  }
  return entry;
}

std::vector<PlaceEntry> list_places(const ServedFolder& folder) {
  PlaceSearch search(folder);
  search.look(folder.path(), kDepth);
  return std::move(search.entries);
}

}  // namespace patinate::studio
