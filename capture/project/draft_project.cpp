#include "capture/project/draft_project.h"

#include <algorithm>
#include <cctype>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>

#include "capture/project/found_images.h"
#include "capture/project/frame_sources.h"
#include "capture/project/frame_times.h"
#include "capture/project/photo_facts.h"
#include "capture/project/plain_object.h"
#include "libcommon/core/file_name.h"
#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

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
           lower_case(i.file.extension().string()) == lower_case(first.file.extension().string());
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

/// Masks a plain background, and aligns an object that does not lie still before it.
void add_background(const std::vector<FoundImage>& group, bool is_aligned, DraftText& text, ProjectDraft& draft) {
  std::vector<fs::path> files;
  for (const FoundImage& image : group) files.push_back(image.file);
  const std::optional<PlainObject> object = find_plain_object(files);
  if (!object) return;
  text.member("background", "plain", "masks what is around the object; \"off\" keeps it");
  draft.found.push_back("an object before a plain background, on " + fixed_percent_text(object->share) +
                        " of the picture; `background` masks the rest");
  if (!object->has_moved || is_aligned) return;
  text.member("align", "auto", "\"off\" when camera and object stood still");
  draft.to_check.push_back(
      "`align`: the object does not lie in the same place in all photographs, so they are aligned with each other");
}

}  // namespace

ProjectDraft draft_capture_project(const fs::path& folder, const fs::path& project_folder, const std::string& only) {
  std::error_code error;
  if (!fs::is_directory(folder, error))
    throw IoError(folder.string(), "is no folder; give the folder of the photographs");
  ProjectDraft draft;
  const std::vector<FoundImage> images = find_images(folder, draft.to_check);
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
  const bool has_mask = first_of(images, Part::Mask) != nullptr || first_of(images, Part::Transmission) != nullptr;
  if (!has_mask && !has_many(first)) add_background(group, sets.size() > 1, text, draft);
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
