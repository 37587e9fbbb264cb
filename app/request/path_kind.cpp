#include "app/request/path_kind.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "app/request/history_library.h"
#include "libcommon/core/file_name.h"
#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"

namespace patinate::app {

namespace fs = std::filesystem;

namespace {

struct Manifest {
  std::string_view file;  ///< In a folder; "" = it is a file of its own.
  std::string_view format;
  PathKind kind;
};
constexpr std::array kManifests{Manifest{"history.json", "patinate.history", PathKind::History},
                                Manifest{"transfer.json", "patinate.transfer", PathKind::Transfer},
                                Manifest{"capture.json", "patinate.capture", PathKind::Capture},
                                Manifest{"simulation.json", "patinate.simulation", PathKind::Simulation},
                                Manifest{"registration.json", "patinate.registration", PathKind::Registration},
                                Manifest{"unlight.json", "patinate.unlit", PathKind::Unlit},
                                Manifest{"factorization.json", "patinate.factorization", PathKind::Factorization},
                                Manifest{"explanation.json", "patinate.explanation", PathKind::Explanation},
                                Manifest{"report.json", "patinate.fit", PathKind::Fit},
                                Manifest{"report.json", "patinate.compare", PathKind::Report},
                                Manifest{"report.json", "patinate.replicates", PathKind::Report},
                                Manifest{"report.json", "patinate.grade", PathKind::Report},
                                Manifest{"report.json", "patinate.grade_groups", PathKind::Report},
                                Manifest{"evaluation.json", "patinate.evaluation", PathKind::Report},
                                Manifest{"", "patinate.calibration", PathKind::Calibration}};
/// Those that are read, and others, which the reader refuses as what they are.
constexpr std::array<std::string_view, 20> kMeshExtensions{".obj", ".ply", ".stl",   ".gltf", ".glb",  ".fbx",  ".dae",
                                                           ".off", ".3ds", ".usd",   ".usda", ".usdc", ".usdz", ".x3d",
                                                           ".wrl", ".abc", ".blend", ".step", ".stp",  ".3mf"};

PathKind kind_of_json(const fs::path& path) {
  const Json json = load_json(path);
  const std::string format = json.is_object() && json.contains("format") && json["format"].is_string()
                                 ? json["format"].get<std::string>()
                                 : std::string();
  for (const Manifest& m : kManifests) {
    if (m.format == format) return m.kind;
  }
  std::string known;
  for (const Manifest& m : kManifests) {
    if (&m != kManifests.begin()) known += &m + 1 == kManifests.end() ? " or " : ", ";
    known += "\"" + std::string(m.format) + "\"";
  }
  throw IoError(path.string(), "/format: found \"" + format + "\"; expected " + known);
}

/// "; did you mean `library:copper`?" for nearly the name of a history in the library.
std::string similar_in_library(const std::string& name) {
  std::vector<std::string> names;
  for (const LibraryEntry& entry : library_entries()) names.push_back(entry.name);
  std::string text = did_you_mean(name, names);
  if (!text.empty()) text.insert(text.find('`') + 1, "library:");
  return text;
}

/// "; did you mean `photos`?" for a path whose folder holds something with nearly its name.
std::string similar_path(const fs::path& path) {
  fs::path plain = path.has_filename() ? path : path.parent_path();
  const fs::path parent = folder_of(plain);
  constexpr std::size_t kMost = 10000;
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator it(parent, error), end; !error && it != end && names.size() < kMost;
       it.increment(error)) {
    names.push_back(it->path().filename().string());
  }
  std::sort(names.begin(), names.end());
  const std::string beside = did_you_mean(plain.filename().string(), names);
  return beside.empty() && !plain.has_parent_path() ? similar_in_library(plain.string()) : beside;
}

}  // namespace

void require_exists(const fs::path& path) {
  std::error_code error;
  if (fs::exists(path, error) || error) return;  // Other troubles are named by who reads it.
  throw IoError(path.string(), "does not exist" + similar_path(path));
}

PathKind kind_of(const fs::path& path) {
  std::error_code error;
  require_exists(path);
  if (fs::is_directory(path, error)) {
    for (const Manifest& m : kManifests) {
      if (m.file.empty() || !fs::exists(path / m.file, error)) continue;
      return m.kind == PathKind::Fit ? kind_of_json(path / m.file) : m.kind;  // Others write a report.json too.
    }
    throw IoError(path.string(),
                  "holds no history.json, transfer.json, capture.json, simulation.json, registration.json, "
                  "unlight.json, factorization.json, explanation.json, evaluation.json or report.json");
  }
  const std::string extension = lower_extension(path);
  if (extension == ".json") return kind_of_json(path);
  const bool is_mesh = std::find(kMeshExtensions.begin(), kMeshExtensions.end(), extension) != kMeshExtensions.end();
  return is_mesh ? PathKind::Mesh : PathKind::Image;
}

void require_transfer(const fs::path& path) {
  const PathKind kind = kind_of(path);
  if (kind == PathKind::Transfer) return;
  if (kind == PathKind::History) {
    throw InvalidInput(path.string() + ": is a history; make a transfer of it first: patinate transfer " +
                       path.string() + " MESH --control C -o TRANSFER");
  }
  throw InvalidInput(path.string() + ": is no transfer; `patinate transfer` makes one");
}

fs::path history_place(const fs::path& path) {
  if (const fs::path place = library_place(path); place != path) return place;
  std::error_code error;
  for (const char* manifest : {"simulation.json", "factorization.json"}) {
    const fs::path folder = path.filename() == manifest ? path.parent_path() : path;
    if (fs::is_regular_file(folder / manifest, error)) return folder / "history";
  }
  return path;
}

}  // namespace patinate::app
