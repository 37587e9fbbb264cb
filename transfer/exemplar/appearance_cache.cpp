#include "transfer/exemplar/appearance_cache.h"

#include <algorithm>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "libcommon/core/files.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/read_limit.h"
#include "patinate/core/error.h"
#include "transfer/exemplar/appearance_io.h"
#include "transfer/exemplar/compared_layers.h"

namespace patinate::transfer {

namespace fs = std::filesystem;

void describe(OptionVisitor& v, CacheOptions& o) {
  v.visit({"cache",
           "Keep analyses of histories in their folders (.cache), and control maps that took long in "
           "~/.cache/patinate, for later commands"},
          o.cache);
}

namespace {

constexpr const char* kPrefix = "appearance-";
constexpr const char* kTagFile =
    "CACHEDIR.TAG";  // Tells backups that what is here can be made again (bford.info/cachedir).
constexpr const char* kTag =
    "Signature: 8a477f597d28d172789f06886806bc55\n# Made by patinate transfer; may be removed.\n";

/// Every file that decides what a pixel looks like.
std::vector<fs::path> compared_files(const HistoryReader& history, const AppearanceOptions& options) {
  const HistoryManifest& manifest = history.manifest();
  std::vector<fs::path> files;
  const auto add_materials = [&](const std::vector<HistoryImage>& images, bool are_of_frame) {
    for (const HistoryImage& image : images) {
      if (options.material_maps > 0.0 && is_compared(image.name, are_of_frame)) files.push_back(image.file);
    }
  };
  for (const int i : compared_frames(history.num_frames(), options.max_frames)) {
    const HistoryFrame& frame = manifest.frames[i];
    files.push_back(frame.file);
    add_materials(frame.extras, true);
  }
  add_materials(manifest.maps, false);
  return files;
}

std::optional<std::string> find_key(const HistoryReader& history, const AppearanceOptions& options, const ImageU8& mask,
                                    const RunControl& control) {
  try {
    return appearance_key(history, options, mask, control);
  } catch (const IoError&) {
    return std::nullopt;  // Building says what is wrong.
  }
}

std::optional<AppearanceSpace> find_kept(const fs::path& file, const std::string& key, int num_levels,
                                         const ImageU8& mask, const RunControl& control) {
  std::error_code error;
  if (!fs::exists(file, error)) return std::nullopt;
  try {
    AppearanceSpace space = read_appearance(file, key, num_levels, mask, control);
    fs::last_write_time(file, fs::file_time_type::clock::now(), error);  // Used last; not to be written to is no harm.
    return space;
  } catch (const IoError&) {
    return std::nullopt;
  }
}

/// Leaves of the others so many that one of `size` bytes may join them.
void remove_oldest(const fs::path& file, std::uint64_t size) {
  struct Entry {
    fs::file_time_type time;
    fs::path path;
    std::uint64_t size = 0;
  };
  std::vector<Entry> others;
  std::error_code error;
  for (fs::directory_iterator it(file.parent_path(), error), end; !error && it != end; it.increment(error)) {
    const fs::path& path = it->path();
    std::error_code ignored;
    if (path == file || !path.filename().string().starts_with(kPrefix) || path.extension() != file.extension() ||
        !it->is_regular_file(ignored))
      continue;
    others.push_back({it->last_write_time(ignored), path, it->file_size(ignored)});
  }
  std::sort(others.begin(), others.end(),
            [](const Entry& a, const Entry& b) { return std::pair(b.time, b.path) < std::pair(a.time, a.path); });
  std::uint64_t total = size;
  for (std::size_t i = 0; i < others.size(); ++i) {
    total += others[i].size;
    if (i + 1 >= kMaxKeptAppearances || total > kMaxKeptBytes) fs::remove(others[i].path, error);
  }
}

/// There must be room for what the caller wants to write, too.
bool has_room(const fs::path& folder, std::uint64_t size) {
  std::error_code error;
  const fs::space_info space = fs::space(folder, error);
  return !error && size <= space.available / 4;
}

void keep(const fs::path& file, const KeptAppearance& kept, const RunControl& control) {
  const AppearanceImage& finest = kept.space.levels[0];
  const std::uint64_t size =
      appearance_file_size(finest.width(), finest.height(), static_cast<int>(kept.space.levels.size()));
  if (size > kMaxKeptBytes) return;
  const fs::path folder = file.parent_path();
  try {
    check_may_write(folder);
    std::error_code error;
    fs::create_directory(folder, error);
    if (error) return;
    if (!fs::exists(folder / kTagFile, error)) write_atomically(folder / kTagFile, kTag);
    remove_abandoned(folder, kPrefix);
    remove_oldest(file, size);
    if (has_room(folder, size)) write_appearance(file, kept, control);
  } catch (const CannotComplete&) {
    // Nothing is kept, and nothing lost.
  }
}

}  // namespace

std::string appearance_key(const HistoryReader& history, const AppearanceOptions& options, const ImageU8& mask,
                           const RunControl& control) {
  ContentHash hash;
  hash.add("appearance").add(std::int64_t{kAppearanceVersion});
  for (const auto& [name, value] : option_values(options)) hash.add(name).add(value);
  hash.add(std::int64_t{mask.width()}).add(std::int64_t{mask.height()}).add(std::as_bytes(mask.values()));
  for (const ControlParameter& c : history.manifest().controls) {
    if (c.name == options.structure_map) hash.add_file(history.folder() / c.file);
  }
  const std::vector<fs::path> files = compared_files(history, options);
  std::vector<std::string> parts(files.size());
  RunControl silent = control;
  silent.on_progress = nullptr;
  parallel_for(static_cast<std::int64_t>(files.size()), 1, silent, [&](std::int64_t begin, std::int64_t) {
    const auto i = static_cast<std::size_t>(begin);
    // The extension tells how the bytes are read.
    parts[i] = files[i].extension().string() + hash_file(history.folder() / files[i]);
  });
  for (const std::string& part : parts) hash.add(part);
  return hash.hex();
}

fs::path appearance_file(const HistoryReader& history, const std::string& key) {
  return history.folder() / kCacheFolder / (kPrefix + key + ".bin");
}

AppearanceSpace cached_appearance_space(const HistoryReader& history, int num_levels, const AppearanceOptions& options,
                                        const RunControl& control, const ImageU8& given_mask) {
  check_ranges(options);
  const ImageU8 mask = given_mask.empty() ? history.read_mask() : given_mask;
  const std::optional<std::string> key = find_key(history, options, mask, control);
  if (!key) return build_appearance_space(history, num_levels, options, control, mask);
  const fs::path file = appearance_file(history, *key);
  if (std::optional<AppearanceSpace> kept = find_kept(file, *key, num_levels, mask, control)) {
    control.report(1.0);
    return std::move(*kept);
  }
  KeptAppearance made{*key, num_levels,
                      build_appearance_space(history, num_levels, options, control.part(0.0, 0.95), mask)};
  // Frames that were replaced meanwhile may be what was analyzed.
  if (find_key(history, options, mask, control) == key) keep(file, made, control);
  control.report(1.0);
  return std::move(made.space);
}

AppearanceSource appearance_source(const HistoryReader& history, const CacheOptions& options) {
  if (!options.cache) return {};
  return
      [&history](int num_levels, const AppearanceOptions& appearance, const RunControl& control, const ImageU8& mask) {
        return cached_appearance_space(history, num_levels, appearance, control, mask);
      };
}

}  // namespace patinate::transfer
