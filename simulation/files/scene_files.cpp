#include "simulation/files/scene_files.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>

#include "libcommon/core/files.h"
#include "libcommon/core/hash.h"
#include "libcommon/mesh_files/mesh_files.h"
#include "patinate/core/error.h"
#include "simulation/rules/rule_io.h"

namespace patinate::simulation {

namespace fs = std::filesystem;

namespace {

void visit_member(Json& object, const char* key, const std::function<void(Json& path)>& visit) {
  if (object.is_object() && object.contains(key) && object[key].is_string()) visit(object[key]);
}

/// Files of a map of a scene, or of what may be one.
void visit_map(Json& map, const std::function<void(Json& path)>& visit) {
  if (!map.is_object()) return;
  for (const char* key : {"image", "sky", "path"}) visit_member(map, key, visit);
  if (map.contains("from") && map["from"].is_string() && fs::path(map["from"].get<std::string>()).has_extension())
    visit(map["from"]);
  if (!map.contains("images")) return;
  for (auto& [object, path] : map["images"].items()) visit(path);
}

/// A file name that every file system takes, and that needs no escape in a glTF.
std::string plain_name(const fs::path& file) {
  std::string name = file.filename().string();
  std::replace_if(
      name.begin(), name.end(),
      [](unsigned char c) { return !(std::isalnum(c) != 0 || c == '.' || c == '_' || c == '-') || c > 127; }, '_');
  if (name.empty() || name.front() == '.') name.insert(0, "_");
  return name;
}

/// A path that stays below the folder that it starts from.
bool stays_below(const fs::path& path) {
  return path.is_relative() && !path.empty() &&
         std::none_of(path.begin(), path.end(), [](const fs::path& part) { return part == ".."; });
}

class CopyPlanner {
 public:
  CopyPlanner(SceneCopy& copy, const fs::path& scene_folder, fs::path folder, std::uint64_t most_bytes)
      : copy_(copy), scene_folder_(scene_folder), folder_(std::move(folder)), num_left_(most_bytes) {
    taken_.insert(copy.name.string());
  }

  /// Gives the path its place in the copy.
  void take(Json& path) {
    const fs::path named = path.get<std::string>();
    const fs::path file = (named.is_absolute() ? named : scene_folder_ / named).lexically_normal();
    const auto [known, is_new] = places_.try_emplace(file.string(), std::nullopt);
    if (is_new) known->second = place_of(file);
    if (known->second) {
      path = known->second->generic_string();
    } else {
      path = fs::relative(fs::weakly_canonical(file), folder_).generic_string();
    }
  }

 private:
  /// Nothing if it is excluded.
  std::optional<fs::path> place_of(const fs::path& file) {
    const std::vector<std::string> buffers = mesh_buffer_files(file);
    std::uint64_t num_bytes = fs::file_size(file);
    for (const std::string& buffer : buffers) {
      std::error_code error;
      const std::uint64_t size = fs::file_size(file.parent_path() / buffer, error);
      if (error || !stays_below(buffer)) return leave(file);
      num_bytes += size;
    }
    if (num_bytes > num_left_) return leave(file);
    num_left_ -= num_bytes;
    const std::string key = hash_file(file);
    if (buffers.empty()) {
      const auto same = places_by_key_.find(key + plain_name(file));
      if (same != places_by_key_.end()) return same->second;
    }
    // A file that names files of its own is in a folder with them, where its names still hold.
    const fs::path inside = buffers.empty() ? fs::path() : fs::path(free_name(plain_name(file.stem()), ""));
    const fs::path to = inside / (buffers.empty() ? free_name(plain_name(file.stem()),
                                                              plain_name(file).substr(plain_name(file.stem()).size()))
                                                  : plain_name(file));
    copy_.files.push_back({file, to, key});
    for (const std::string& buffer : buffers) {
      const fs::path place = inside / fs::path(buffer).lexically_normal();
      const bool is_there =
          std::any_of(copy_.files.begin(), copy_.files.end(), [&](const SceneCopy::File& f) { return f.to == place; });
      if (!is_there)
        copy_.files.push_back({file.parent_path() / buffer, place, hash_file(file.parent_path() / buffer)});
    }
    if (buffers.empty()) places_by_key_[key + plain_name(file)] = to;
    return to;
  }

  std::optional<fs::path> leave(const fs::path& file) {
    copy_.excluded.push_back(file.filename().string());
    return std::nullopt;
  }

  std::string free_name(const std::string& stem, const std::string& extension) {
    std::string name = stem + extension;
    for (int i = 2; !taken_.insert(name).second; ++i) name = stem + "-" + std::to_string(i) + extension;
    return name;
  }

  SceneCopy& copy_;
  fs::path scene_folder_, folder_;
  std::uint64_t num_left_;
  std::set<std::string> taken_;
  std::map<std::string, std::optional<fs::path>> places_;  ///< By the path of the original.
  std::map<std::string, fs::path> places_by_key_;          ///< Equal files of one name are one file.
};

}  // namespace

void for_each_scene_path(Json& root, const std::function<void(Json& path)>& visit) {
  for (const char* list : {"presets", "appearance"}) {
    if (!root.contains(list)) continue;
    for (auto& [name, member] : root[list].items()) {
      visit_member(member, "color", visit);
      if (member.is_object() && member.contains("color")) visit_member(member["color"], "image", visit);
    }
  }
  if (root.contains("maps")) {
    for (auto& [name, map] : root["maps"].items()) visit_map(map, visit);
  }
  visit_member(root, "weather", visit);
  if (root.contains("weather")) visit_member(root["weather"], "file", visit);
  for (Json& object : root["objects"]) {
    visit_member(object, "mesh", visit);
    if (object.contains("initial")) {
      for (auto& [material, amount] : object["initial"].items()) visit_map(amount, visit);
    }
    if (!object.contains("maps")) continue;
    for (auto& [name, path] : object["maps"].items()) {
      if (path.is_string()) visit(path);
    }
  }
  if (!root.contains("rules")) return;
  for (Json& rule : root["rules"]) {
    visit_member(rule, "file", visit);
    if (rule.is_object() && rule.contains("where")) visit_map(rule["where"], visit);
    if (rule.is_string() && is_rule_path(rule.get<std::string>())) visit(rule);
  }
}

void move_scene_path(Json& path, const fs::path& from, const fs::path& to) {
  const fs::path named = path.get<std::string>();
  if (named.is_relative()) path = (from / named).lexically_normal().lexically_relative(to).generic_string();
}

SceneCopy plan_scene_copy(const fs::path& scene, const Json& root, const fs::path& folder, std::uint64_t most_bytes) {
  SceneCopy copy{.name = plain_name(scene), .text = {}, .files = {}, .excluded = {}};
  CopyPlanner planner(copy, fs::absolute(scene).parent_path(), fs::weakly_canonical(fs::absolute(folder)), most_bytes);
  Json moved = root;
  for_each_scene_path(moved, [&](Json& path) { planner.take(path); });
  copy.text = moved.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
  return copy;
}

void write_scene_copy(const SceneCopy& copy, const fs::path& folder) {
  fs::create_directories(folder);
  for (const SceneCopy::File& file : copy.files) {
    const fs::path to = folder / file.to;
    fs::create_directories(to.parent_path());
    write_atomically(to, [&](const fs::path& temporary) {
      std::error_code error;
      if (!fs::copy_file(file.from, temporary, fs::copy_options::overwrite_existing, error) || error) {
        throw CannotComplete(to.string() + ": cannot be copied from " + file.from.string() + "; " + error.message());
      }
    });
    if (hash_file(to) != file.key)
      throw CannotComplete(file.from.string() + ": has changed since the simulation began; run it again");
  }
  write_atomically(folder / copy.name, copy.text);
}

}  // namespace patinate::simulation
