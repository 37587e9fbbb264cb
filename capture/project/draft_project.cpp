#include "capture/project/draft_project.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string_view>
#include <tuple>
#include <utility>

#include "capture/project/frame_sources.h"
#include "capture/project/frame_times.h"
#include "capture/project/photo_facts.h"
#include "libcommon/core/files.h"
#include "libcommon/core/read_limit.h"
#include "libcommon/core/text.h"
#include "libcommon/image/decoder_process.h"
#include "libcommon/image/whole_file.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

struct FoundImage {
  fs::path file;
  ImageInfo info;
};

enum class Part { Photo, Transmission, Blank, Mask };

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

Part part_of(const fs::path& file) {
  const std::string name = lower(file.stem().string());
  const auto has = [&](std::string_view word) { return name.find(word) != std::string::npos; };
  const bool is_backlight = has("backlight") || has("back_light") || has("back-light") || has("transmission") ||
                            has("transmitted") || has("lightbox");
  if (has("blank")) return Part::Blank;
  if (is_backlight) return has("empty") ? Part::Blank : Part::Transmission;
  return name == "mask" || name.ends_with("_mask") || name.starts_with("mask_") ? Part::Mask : Part::Photo;
}

}  // namespace

bool may_be_photograph(const fs::path& file) {
  static constexpr std::array<std::string_view, 18> kKnown{".png", ".jpg", ".jpeg", ".tif",  ".tiff", ".webp",
                                                           ".gif", ".bmp", ".tga",  ".heic", ".heif", ".avif",
                                                           ".jp2", ".psd", ".ppm",  ".pgm",  ".exr",  ".mpo"};
  const std::string extension = lower(file.extension().string());
  return is_decoded_apart(file) || std::find(kKnown.begin(), kKnown.end(), extension) != kKnown.end();
}

namespace {

/// Tells folders that patinate made: they hold no photographs.
bool is_made(const fs::path& folder) {
  std::error_code error;
  return fs::exists(folder / "history.json", error) || fs::exists(folder / "job.json", error);
}

/// Every image in the folder and the folders directly in it, in natural order; hidden folders, and what patinate made,
/// are skipped.
std::vector<FoundImage> look(const fs::path& folder, std::vector<std::string>& to_check) {
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
        if (!info.key.empty() && lower(file.extension().string()) == ".exr") continue;  // A map that patinate made.
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

/// Candidates for the frames of a project: the photographs that share folder, format and size, or one movie.
std::vector<std::vector<FoundImage>> frame_sets(const std::vector<FoundImage>& images,
                                                const std::function<bool(const fs::path&)>& is_wanted) {
  using Key = std::tuple<fs::path, std::string, int, int, fs::path>;
  std::map<Key, std::vector<FoundImage>> sets;
  for (const FoundImage& image : images) {
    if (part_of(image.file) != Part::Photo || !is_wanted(image.file)) continue;
    sets[{image.file.parent_path(), lower(image.file.extension().string()), image.info.width, image.info.height,
          has_many(image) ? image.file : fs::path()}]
        .push_back(image);
  }
  std::vector<std::vector<FoundImage>> list;
  for (auto& [key, set] : sets) list.push_back(std::move(set));
  return list;
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

/// All photographs as one series taken by hand. Nothing where a movie is among them, or where pictures of one name
/// stand in several sets: smaller copies, or RAW beside JPEG.
/// @param images  All that were found, in order.
std::optional<std::vector<FoundImage>> by_hand(const std::vector<std::vector<FoundImage>>& sets,
                                               const std::vector<FoundImage>& images) {
  std::set<fs::path> files;
  std::set<std::string> names;
  for (const std::vector<FoundImage>& set : sets) {
    for (const FoundImage& image : set) {
      if (has_many(image) || !names.insert(lower(image.file.stem().string())).second) return std::nullopt;
      files.insert(image.file);
    }
  }
  std::vector<FoundImage> all;
  std::copy_if(images.begin(), images.end(), std::back_inserter(all),
               [&](const FoundImage& image) { return files.contains(image.file); });
  return all;
}

/// List of photographs that no pattern holds: all of them, one by one.
Json frame_list(const std::vector<FoundImage>& group, const std::vector<double>& times,
                const std::function<std::string(const fs::path&)>& relative) {
  std::vector<std::pair<double, std::string>> rows;
  for (std::size_t i = 0; i < group.size(); ++i) rows.emplace_back(times[i], relative(group[i].file));
  std::stable_sort(rows.begin(), rows.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  Json list = Json::array();
  for (const auto& [time, photo] : rows) list.push_back({{"time", time}, {"photo", photo}});
  return list;
}

/// A project that left some of the photographs out in silence would look whole.
[[noreturn]] void refuse_several(const fs::path& folder, const std::vector<std::vector<FoundImage>>& sets) {
  constexpr std::size_t kMaxNamed = 8;
  std::string list;
  for (std::size_t i = 0; i < std::min(sets.size(), kMaxNamed); ++i)
    list += (i == 0 ? "" : ", ") + set_text(sets[i], folder);
  if (sets.size() > kMaxNamed) list += " and " + std::to_string(sets.size() - kMaxNamed) + " more";
  throw IoError(folder.string(),
                "holds several sets that may be the frames: " + list + "; say with --only which names make them");
}

/// `IMG_*.jpg` for names that begin alike, so that a mask beside them is not meant.
std::string pattern_of(const std::vector<FoundImage>& group) {
  std::string first = group.front().file.filename().string();
  if (group.size() == 1) return first;
  std::size_t length = group.front().file.stem().string().size();
  for (const FoundImage& image : group) {
    const std::string name = image.file.filename().string();
    length = std::min(
        length, static_cast<std::size_t>(std::mismatch(first.begin(), first.end(), name.begin(), name.end()).first -
                                         first.begin()));
  }
  // Digits belong to the number or date: the next photograph may have others.
  std::string prefix = first.substr(0, length);
  while (!prefix.empty() && (std::isdigit(static_cast<unsigned char>(prefix.back())) != 0 || prefix.back() == '-'))
    prefix.pop_back();
  const std::string extension = group.front().file.extension().string();
  const bool is_alike =
      std::all_of(group.begin(), group.end(), [&](const FoundImage& i) { return i.file.extension() == extension; });
  return prefix + "*" + (is_alike ? extension : "." + std::string(extension.size() - 1, '?'));  // .JPG beside .jpg
}

bool has_one_pattern(const std::vector<FoundImage>& group) {
  const FoundImage& first = group.front();
  return std::all_of(group.begin(), group.end(), [&](const FoundImage& i) {
    return i.file.parent_path() == first.file.parent_path() &&
           lower(i.file.extension().string()) == lower(first.file.extension().string());
  });
}

TimeUnit unit_for(double seconds) {
  if (seconds > 3 * 86400.0) return TimeUnit::Days;
  if (seconds > 6 * 3600.0) return TimeUnit::Hours;
  return seconds > 600.0 ? TimeUnit::Minutes : TimeUnit::Seconds;
}

/// Bytes that are no UTF-8 have no place in JSON.
std::string text_of(const Json& value) { return value.dump(-1, ' ', false, Json::error_handler_t::replace); }

/// A path as a project can name it. @throws IoError where its name is no UTF-8
std::string project_path(const fs::path& relative, const fs::path& file) {
  std::string text = relative.string();
  if (Json::parse(text_of(Json(text))).get<std::string>() != text)
    throw IoError(file.string(), "has a name that is no UTF-8, which no project can hold; rename it");
  return text;
}

/// The project in the order of its members, as plain JSON, and what a person may want to know of each.
class DraftText {
 public:
  void member(const std::string& name, const Json& value, const std::string& hint = "") {
    text_ += std::string(text_.empty() ? "" : ",") + "\n  " + Json(name).dump() + ": " + text_of(value);
    if (!hint.empty()) hints_.push_back("`" + name + "`: " + hint);
  }
  void hint(const std::string& text) { hints_.push_back(text); }
  [[nodiscard]] std::string text() const { return "{" + text_ + "\n}\n"; }
  [[nodiscard]] const std::vector<std::string>& hints() const { return hints_; }

 private:
  std::string text_;
  std::vector<std::string> hints_;
};

/// Facts about the frames that are found before anything is written.
struct Frames {
  std::string pattern;  ///< Empty: of several folders or formats, so that they are listed.
  std::vector<std::size_t> excluded;
  std::vector<double> times;               ///< Times of the group, in `unit`; empty: not known.
  std::optional<std::string> time_source;  ///< Nothing: an interval stands in.
  TimeUnit unit = TimeUnit::Seconds;
};

Frames find_frames(const std::vector<FoundImage>& group, std::vector<std::string>& to_check) {
  Frames frames;
  if (has_one_pattern(group)) frames.pattern = pattern_of(group);
  std::set<fs::path> members;
  std::vector<DatedPhoto> photos;
  for (const FoundImage& image : group) {
    members.insert(image.file);
    photos.push_back({image.file, image.info.date_time, image.info.digitized});
  }
  std::vector<fs::path> matched;
  if (!frames.pattern.empty()) matched = list_files(group.front().file.parent_path(), frames.pattern);
  for (std::size_t i = 0; i < matched.size(); ++i) {
    if (members.contains(matched[i])) continue;
    frames.excluded.push_back(i);
    to_check.push_back(matched[i].filename().string() +
                       " matches the names but is another kind of image or cannot be read; excluded (number " +
                       std::to_string(i) + ")");
  }
  if (has_many(group.front())) {
    const ImageInfo& info = group.front().info;
    if (info.frame_times_s.size() != static_cast<std::size_t>(info.num_frames)) return frames;
    frames.time_source = kPresentationTimes;
    frames.unit = unit_for(info.frame_times_s.back());
    to_check.push_back("times are those at which the movie shows its images: for a time-lapse give `interval`");
    return frames;
  }
  try {
    const FrameTimes times = find_frame_times(photos, TimeUnit::Seconds);
    frames.unit = unit_for(*std::max_element(times.times.begin(), times.times.end()));
    frames.time_source = times.source + ", " + times.span;
    frames.times = find_frame_times(photos, frames.unit).times;
    for (const HistoryWarning& warning : times.warnings) to_check.push_back(warning_text(warning));
  } catch (const InvalidInput& e) {
    // The interval's own line follows, and says that there is none.
    const bool has_some = std::any_of(photos.begin(), photos.end(), [](const DatedPhoto& p) {
      return !p.date_time.empty() || !p.digitized.empty() || times_in_names({p.file.stem().string()}).front();
    });
    if (has_some) to_check.emplace_back(e.what());
  }
  return frames;
}

const FoundImage* first_of(const std::vector<FoundImage>& images, Part part) {
  const auto found =
      std::find_if(images.begin(), images.end(), [&](const FoundImage& i) { return part_of(i.file) == part; });
  return found == images.end() ? nullptr : &*found;
}

bool same_size(const FoundImage& a, const FoundImage& b) {
  return a.info.width == b.info.width && a.info.height == b.info.height;
}

}  // namespace

ProjectDraft draft_capture_project(const fs::path& folder, const fs::path& project_folder, const std::string& only) {
  std::error_code error;
  if (!fs::is_directory(folder, error))
    throw IoError(folder.string(), "is no folder; give the folder of the photographs");
  ProjectDraft draft;
  const std::vector<FoundImage> images = look(folder, draft.to_check);
  const auto is_wanted = [&](const fs::path& file) {
    return only.empty() || matches_pattern(file.filename().string(), only) ||
           matches_pattern(file.lexically_relative(folder).generic_string(), only);
  };
  const std::vector<std::vector<FoundImage>> sets = frame_sets(images, is_wanted);
  if (sets.empty() && !only.empty())
    throw IoError(folder.string(),
                  "holds no photograph and no movie whose name matches `" + only + "`, nor do the folders in it");
  if (sets.empty()) {
    const std::string why = draft.to_check.empty() ? "" : " (" + draft.to_check.front() + ")";
    throw IoError(folder.string(), "holds no photographs and no movie, nor do the folders in it" + why);
  }
  const std::optional<std::vector<FoundImage>> series = sets.size() > 1 ? by_hand(sets, images) : sets.front();
  if (!series) refuse_several(folder, sets);
  const std::vector<FoundImage>& group = *series;
  const fs::path base = fs::absolute(project_folder.empty() ? fs::path(".") : project_folder).lexically_normal();
  const auto relative = [&](const fs::path& file) {
    return project_path(fs::absolute(file).lexically_normal().lexically_relative(base), file);
  };
  const FoundImage& first = group.front();
  const Frames frames = find_frames(group, draft.to_check);
  const bool is_listed = frames.pattern.empty();
  const std::string pattern = relative(first.file.parent_path() / frames.pattern);
  const bool has_one_size =
      std::all_of(group.begin(), group.end(), [&](const FoundImage& i) { return same_size(i, first); });
  const std::string size = has_one_size ? size_text(first.info.width, first.info.height) : "of several sizes";
  if (is_listed)
    draft.found.push_back(std::to_string(group.size()) + " photographs of several folders or formats, " + size);
  else
    draft.found.push_back((has_many(first) ? std::to_string(first.info.num_frames) + " images in "
                                           : std::to_string(group.size()) + " photographs, ") +
                          pattern + ", " + size);
  DraftText text;
  text.member("format", "patinate.capture");
  text.member("version", 1);
  const std::string name = fs::absolute(folder).lexically_normal().filename().string();
  text.member("name", name.empty() ? fs::absolute(folder).lexically_normal().parent_path().filename().string() : name);
  text.member("kind", "fixed");
  text.member("time_unit", time_unit_text(frames.unit), "s, min, h or d");
  if (is_listed) {
    std::vector<double> times = frames.times;
    for (std::size_t i = times.size(); i < group.size(); ++i) times.push_back(static_cast<double>(i));
    const std::string source = frames.time_source ? "times from " + *frames.time_source : "`time` is in `time_unit`";
    text.member("frames", frame_list(group, times, relative), source);
    if (frames.time_source)
      draft.found.push_back(source);
    else
      draft.to_check.push_back("`time`: nothing says when the images were taken, so they are numbered");
  } else if (frames.time_source) {
    text.member("frames", Json{{"pattern", pattern}}, "times from " + *frames.time_source);
    draft.found.push_back("times from " + *frames.time_source);
  } else {
    text.member("frames", Json{{"pattern", pattern}, {"interval", 1}},
                "`interval` is the time from one image to the next, in `time_unit`");
    draft.to_check.push_back("`interval`: the images have no times, so the draft has 1");
  }
  if (!frames.excluded.empty()) text.member("exclude", frames.excluded);
  if (sets.size() > 1) {
    text.member("align", "auto", "\"off\" when a camera that stood still took all of them");
    draft.to_check.push_back(
        "`align`: photographs differ in size, folder or format, so they are aligned with each other, as "
        "those taken by hand; --only says which names make the frames if some belong elsewhere");
  }
  if (first.info.is_raw) draft.found.push_back("camera RAW: taken as linear light");
  std::vector<std::pair<std::string, ImageFacts>> facts;
  for (const FoundImage& image : group) facts.emplace_back(image.file.filename().string(), image.info.facts);
  const bool is_color_said = std::any_of(group.begin(), group.end(), [](const FoundImage& i) {
    return i.info.encoding != nullptr || !i.info.facts.color.empty();
  });
  // A response would hold in the place of what the files say.
  if (!first.info.is_raw && !is_color_said) text.member("response", "srgb", "\"linear\" when no curve was applied");
  for (const std::string& line : series_facts(facts)) draft.found.push_back(line);
  const FoundImage* transmission = first_of(images, Part::Transmission);
  const FoundImage* blank = first_of(images, Part::Blank);
  if (transmission != nullptr) {
    const bool is_pose_same = same_size(*transmission, first);
    Json member{{"photo", relative(transmission->file)}};
    if (blank != nullptr && same_size(*blank, *transmission)) member["blank"] = relative(blank->file);
    member["align"] = is_pose_same ? "none" : "auto";
    text.member("transmission", member, is_pose_same ? "align: \"auto\" when it was taken from another pose" : "");
    draft.found.push_back("back-light photograph " + relative(transmission->file) +
                          (member.contains("blank") ? ", with its blank" : ""));
    draft.to_check.push_back(
        "`align` of the back-light photograph: \"none\" when it was taken from the frames' pose, else \"auto\"");
  }
  if (const FoundImage* mask = first_of(images, Part::Mask)) {
    const bool fits = same_size(*mask, first);
    if (fits) text.member("mask", relative(mask->file));
    (fits ? draft.found : draft.to_check)
        .push_back("mask " + relative(mask->file) + (fits ? "" : " is not as large as the photographs; excluded"));
  }
  text.hint("`texel_size_mm`, for example 0.1: surface length of a pixel; measure a ruler in the picture");
  draft.to_check.push_back("`texel_size_mm`: not known; textures then have no physical size");
  const auto num_unwanted = std::count_if(images.begin(), images.end(), [&](const FoundImage& i) {
    return part_of(i.file) == Part::Photo && !is_wanted(i.file);
  });
  if (num_unwanted > 0)
    draft.found.push_back(std::to_string(num_unwanted) +
                          (num_unwanted == 1 ? " other image, which" : " other images, which") + " --only leaves out");
  draft.text = text.text();
  draft.hints = text.hints();
  return draft;
}

}  // namespace patinate::capture
