#include "capture/project/found_images.h"

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <set>
#include <string_view>
#include <tuple>
#include <utility>

#include "libcommon/core/file_name.h"
#include "libcommon/core/files.h"
#include "libcommon/core/read_limit.h"
#include "libcommon/core/text.h"
#include "libcommon/image/decoder_process.h"
#include "libcommon/image/whole_file.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

/// Tells folders that patinate made: they hold no photographs.
bool is_made(const fs::path& folder) {
  std::error_code error;
  return fs::exists(folder / "history.json", error) || fs::exists(folder / "job.json", error);
}

/// "9 photographs of 640 x 480 (day01.png ... day17.png)".
std::string set_text(const std::vector<FoundImage>& set, const fs::path& folder) {
  const FoundImage& first = set.front();
  const auto name = [&](const FoundImage& image) { return image.file.lexically_relative(folder).generic_string(); };
  const std::string size = size_text(first.info.width, first.info.height);
  if (has_many(first)) return name(first) + " with " + std::to_string(first.info.num_frames) + " images of " + size;
  if (set.size() == 1) return "1 photograph of " + size + " (" + name(first) + ")";
  return std::to_string(set.size()) + " photographs of " + size + " (" + name(first) + " ... " + name(set.back()) + ")";
}

}  // namespace

Part part_of(const fs::path& file) {
  const std::string name = lower_case(file.stem().string());
  const auto has = [&](std::string_view word) { return name.find(word) != std::string::npos; };
  const bool is_backlight = has("backlight") || has("back_light") || has("back-light") || has("transmission") ||
                            has("transmitted") || has("lightbox");
  if (has("blank")) return Part::Blank;
  if (is_backlight) return has("empty") ? Part::Blank : Part::Transmission;
  return name == "mask" || name.ends_with("_mask") || name.starts_with("mask_") ? Part::Mask : Part::Photo;
}

bool may_be_photograph(const fs::path& file) {
  static constexpr std::array<std::string_view, 18> kKnown{".png", ".jpg", ".jpeg", ".tif",  ".tiff", ".webp",
                                                           ".gif", ".bmp", ".tga",  ".heic", ".heif", ".avif",
                                                           ".jp2", ".psd", ".ppm",  ".pgm",  ".exr",  ".mpo"};
  const std::string extension = lower_extension(file);
  return is_decoded_apart(file) || std::find(kKnown.begin(), kKnown.end(), extension) != kKnown.end();
}

std::vector<FoundImage> find_images(const fs::path& folder, std::vector<std::string>& to_check) {
  std::vector<fs::path> folders{folder};
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    std::error_code ignored;
    if (!it->is_directory(ignored) || name.starts_with(".") || name.ends_with(".partial")) continue;
    if (!is_made(it->path()) && may_read(it->path())) folders.push_back(it->path());
  }
  if (error) throw IoError(folder.string(), "cannot be listed; " + error.message());
  std::sort(folders.begin() + 1, folders.end());
  std::vector<FoundImage> images;
  for (const fs::path& f : folders) {
    for (const fs::path& file : list_files(f, "*")) {
      if (!may_be_photograph(file)) continue;
      try {
        const ImageInfo info = probe_image(file);
        if (!info.key.empty() && lower_extension(file) == ".exr") continue;  // A map that patinate made.
        if (is_cut_off(file))
          to_check.push_back(file.string() + ": ends before its picture does; copy it again");
        else
          images.push_back({file, info});
      } catch (const IoError& e) {
        to_check.push_back(std::string(e.what()) + "; excluded");
      }
    }
  }
  return images;
}

bool has_many(const FoundImage& image) { return image.info.num_frames > 1; }

std::vector<std::vector<FoundImage>> frame_sets(const std::vector<FoundImage>& images,
                                                const std::function<bool(const fs::path&)>& is_wanted) {
  using Key = std::tuple<fs::path, std::string, int, int, fs::path>;
  std::map<Key, std::vector<FoundImage>> sets;
  for (const FoundImage& image : images) {
    if (part_of(image.file) != Part::Photo || !is_wanted(image.file)) continue;
    sets[{image.file.parent_path(), lower_case(image.file.extension().string()), image.info.width, image.info.height,
          has_many(image) ? image.file : fs::path()}]
        .push_back(image);
  }
  std::vector<std::vector<FoundImage>> list;
  for (auto& [key, set] : sets) list.push_back(std::move(set));
  return list;
}

std::optional<std::vector<FoundImage>> by_hand(const std::vector<std::vector<FoundImage>>& sets,
                                               const std::vector<FoundImage>& images) {
  std::set<fs::path> files;
  std::set<std::string> names;
  for (const std::vector<FoundImage>& set : sets) {
    for (const FoundImage& image : set) {
      if (has_many(image) || !names.insert(lower_case(image.file.stem().string())).second) return std::nullopt;
      files.insert(image.file);
    }
  }
  std::vector<FoundImage> all;
  std::copy_if(images.begin(), images.end(), std::back_inserter(all),
               [&](const FoundImage& image) { return files.contains(image.file); });
  return all;
}

const FoundImage* first_of(const std::vector<FoundImage>& images, Part part) {
  const auto found =
      std::find_if(images.begin(), images.end(), [&](const FoundImage& i) { return part_of(i.file) == part; });
  return found == images.end() ? nullptr : &*found;
}

bool same_size(const FoundImage& a, const FoundImage& b) {
  return a.info.width == b.info.width && a.info.height == b.info.height;
}

void refuse_several(const fs::path& folder, const std::vector<std::vector<FoundImage>>& sets) {
  constexpr std::size_t kMaxNamed = 8;
  std::string list;
  for (std::size_t i = 0; i < std::min(sets.size(), kMaxNamed); ++i)
    list += (i == 0 ? "" : ", ") + set_text(sets[i], folder);
  if (sets.size() > kMaxNamed) list += " and " + std::to_string(sets.size() - kMaxNamed) + " more";
  throw IoError(folder.string(),
                "holds several sets that may be the frames: " + list + "; say with --only which names make them");
}

}  // namespace patinate::capture
