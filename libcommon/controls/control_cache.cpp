#include "libcommon/controls/control_cache.h"

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "libcommon/controls/image_control.h"
#include "libcommon/core/files.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/input_watch.h"
#include "libcommon/core/read_limit.h"
#include "libcommon/geometry/mesh_key.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/image/image_io.h"

namespace patinate {

namespace fs = std::filesystem;

namespace {

constexpr const char* kPrefix = "control-";
constexpr const char* kTagFile =
    "CACHEDIR.TAG";  // Tells backups that what is here can be made again (bford.info/cachedir).
constexpr const char* kTag =
    "Signature: 8a477f597d28d172789f06886806bc55\n# Control maps of patinate; may be removed.\n";

fs::path values_file(const fs::path& folder, const std::string& key) { return folder / (kPrefix + key + ".exr"); }
fs::path facts_file(const fs::path& folder, const std::string& key) { return folder / (kPrefix + key + ".json"); }

/// Key of all that is kept, so that what was damaged or edited is made again.
std::string content_key(const ControlMap& kept) {
  ContentHash hash;
  hash.add(std::as_bytes(kept.values.values())).add(kept.low).add(kept.high).add(kept.unit);
  hash.add(std::int64_t{kept.has_file});
  for (const std::string& note : kept.notes) hash.add(note);
  return hash.hex();
}

std::optional<ControlMap> find_kept(const fs::path& folder, const std::string& key, const TexelMap& map) {
  const fs::path file = values_file(folder, key), facts = facts_file(folder, key);
  std::error_code error;
  if (!fs::exists(facts, error) || !fs::exists(file, error)) return std::nullopt;
  const UnwatchedReads of_cache;
  try {
    const Json json = load_json(facts);
    ControlMap kept{.values = read_gray(file, "Y"),
                    .low = json.at("low"),
                    .high = json.at("high"),
                    .unit = json.at("unit"),
                    .has_file = json.at("has_file"),
                    .notes = json.at("notes")};
    if (kept.values.width() != map.width() || kept.values.height() != map.height() ||
        content_key(kept) != json.at("content"))
      return std::nullopt;
    fs::last_write_time(facts, fs::file_time_type::clock::now(), error);  // Used last.
    return kept;
  } catch (const InputError&) {
    return std::nullopt;
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
}

/// Leaves of the others so many that one of `size` bytes may join them.
void remove_oldest(const fs::path& folder, std::uint64_t size) {
  std::vector<std::pair<fs::file_time_type, fs::path>> kept;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    std::error_code ignored;
    const fs::path& path = it->path();
    if (path.filename().string().starts_with(kPrefix) && path.extension() == ".json")
      kept.emplace_back(it->last_write_time(ignored), path);
  }
  std::sort(kept.begin(), kept.end(), std::greater<>());
  std::uint64_t total = size;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    const fs::path values = fs::path(kept[i].second).replace_extension(".exr");
    const std::uintmax_t bytes = fs::file_size(values, error);
    total += error ? 0 : bytes;
    if (i + 1 < kMaxKeptControls && total <= kMaxKeptControlBytes) continue;
    fs::remove(kept[i].second, error);
    fs::remove(values, error);
  }
}

void keep(const fs::path& folder, const std::string& key, const ControlMap& made) {
  const std::uint64_t size = std::uint64_t{4} * static_cast<std::uint64_t>(made.values.num_pixels());
  if (size > kMaxKeptControlBytes) return;
  try {
    check_may_write(folder);
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) return;
    if (!fs::exists(folder / kTagFile, error)) write_atomically(folder / kTagFile, kTag);
    remove_abandoned(folder, kPrefix);
    remove_oldest(folder, size);
    const fs::space_info space = fs::space(folder, error);
    if (error || size > space.available / 4) return;  // Room is left for what the caller wants to write.
    write_exr(values_file(folder, key), made.values, {"Y"}, ExrDepth::Float, key);
    save_json(facts_file(folder, key), Json{{"low", made.low},
                                            {"high", made.high},
                                            {"unit", made.unit},
                                            {"has_file", made.has_file},
                                            {"notes", made.notes},
                                            {"content", content_key(made)}});
  } catch (const CannotComplete&) {
    // Nothing is kept, and nothing lost.
  }
}

}  // namespace

std::string control_content_key(const std::string& kind, const TexelMap& map, const ControlKindOptions& options) {
  ContentHash hash;
  hash.add("control map").add(std::int64_t{kControlVersion}).add(kind).add(mesh_content_key(map.mesh()));
  hash.add(std::int64_t{map.width()}).add(std::int64_t{map.height()});
  for (const std::string& name : map.sheet().names) hash.add(name);
  for (const auto& [name, value] : option_values(used_options(kind, options))) hash.add(name).add(value);
  for (const fs::path& path : control_input_files(kind, options)) {
    for (const fs::path& file : tile_map_files(path, map.sheet().names)) hash.add_file(file);
  }
  return hash.hex();
}

ControlMap cached_control(const std::string& kind, const TexelMap& map, const ControlKindOptions& options,
                          const ControlCache& cache, const RunControl& control) {
  if (cache.folder.empty()) return make_control(kind, map, options, control);
  check_ranges(options);
  std::string key;
  try {
    key = control_content_key(kind, map, options);
  } catch (const InputError&) {
    return make_control(kind, map, options, control);  // It says what is wrong.
  }
  if (std::optional<ControlMap> kept = find_kept(cache.folder, key, map)) {
    control.report(1.0);
    return std::move(*kept);
  }
  const auto begin = std::chrono::steady_clock::now();
  ControlMap made = make_control(kind, map, options, control);
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
  if (taken.count() >= cache.least_seconds) keep(cache.folder, key, made);
  return made;
}

ControlSource control_source(ControlCache cache) {
  return [cache = std::move(cache)](const std::string& kind, const TexelMap& map, const ControlKindOptions& options,
                                    const RunControl& control) {
    return cached_control(kind, map, options, cache, control);
  };
}

}  // namespace patinate
