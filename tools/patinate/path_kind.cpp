#include "tools/patinate/path_kind.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "libcommon/core/error.h"
#include "libcommon/core/json.h"

namespace patinate {

namespace fs = std::filesystem;

namespace {

struct Manifest {
  std::string_view file;
  std::string_view format;
  PathKind kind;
};
constexpr std::array kManifests{Manifest{"history.json", "patinate.history", PathKind::History},
                                Manifest{"transfer.json", "patinate.transfer", PathKind::Transfer},
                                Manifest{"capture.json", "patinate.capture", PathKind::Capture}};
constexpr std::array<std::string_view, 4> kMeshExtensions{".obj", ".ply", ".gltf", ".glb"};

PathKind kind_of_json(const fs::path& path) {
  const Json json = load_json(path);
  const std::string format = json.is_object() && json.contains("format") && json["format"].is_string()
                                 ? json["format"].get<std::string>()
                                 : std::string();
  for (const Manifest& m : kManifests) {
    if (m.format == format) return m.kind;
  }
  throw IoError(path.string(), "/format: found \"" + format +
                                   "\"; expected \"patinate.history\", \"patinate.transfer\" or \"patinate.capture\"");
}

}  // namespace

std::string lower_extension(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

PathKind kind_of(const fs::path& path) {
  std::error_code error;
  if (!fs::exists(path, error)) throw IoError(path.string(), "does not exist");
  if (fs::is_directory(path, error)) {
    for (const Manifest& m : kManifests) {
      if (fs::exists(path / m.file, error)) return m.kind;
    }
    throw IoError(path.string(), "holds no history.json, transfer.json or capture.json");
  }
  const std::string extension = lower_extension(path);
  if (extension == ".json") return kind_of_json(path);
  const bool is_mesh = std::find(kMeshExtensions.begin(), kMeshExtensions.end(), extension) != kMeshExtensions.end();
  return is_mesh ? PathKind::Mesh : PathKind::Image;
}

fs::path capture_file(const fs::path& path) {
  std::error_code error;
  return fs::is_directory(path, error) ? path / "capture.json" : path;
}

}  // namespace patinate
