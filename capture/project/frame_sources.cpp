#include "capture/project/frame_sources.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "capture/project/frame_times.h"
#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "libcommon/history/history_times.h"
#include "libcommon/image/decoder_process.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMaxFrames = 1'000'000;

struct SourceImage {
  fs::path file;
  int image = 0;
  std::optional<double> time;  ///< Given, in the project's unit.
  int number = 0;              ///< Number as `exclude` counts.
  std::optional<Eigen::Matrix3d> transform = {};
};

/// Opens every file once.
class Files {
 public:
  const ImageInfo& info(const fs::path& file) {
    const auto found = infos_.find(file);
    return found != infos_.end() ? found->second : infos_.emplace(file, probe_image(file)).first->second;
  }
  /// Images in the file; 1 for one that cannot be read, which may be among those that are excluded.
  int num_images(const fs::path& file) {
    try {
      return info(file).num_frames;
    } catch (const IoError&) {
      return 1;
    }
  }

 private:
  std::map<fs::path, ImageInfo> infos_;
};

/// start + i * interval as a person would write it: 25 * 19.4 is 485, not 484.99999999999994.
double time_at(double start, double interval, std::size_t i) {
  constexpr int kDigits = 12;     // Digits that remove the rounding of a multiplied interval.
  constexpr double kNear = 1e-6;  // In intervals: far more than rounding, far less than a frame.
  const double time = start + rounded(static_cast<double>(i) * interval, kDigits);
  const double plain = rounded(time, kDigits);
  return std::abs(plain - time) <= kNear * interval ? plain : time;
}

void set_interval_times(JsonReader& json, std::vector<SourceImage>& images) {
  const double interval = json.member("interval").number(above(0));
  const double start = json.has("start") ? json.member("start").number() : 0.0;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const double time = time_at(start, interval, i);
    const bool is_later = i == 0 || *images[i - 1].time < time;
    if (!is_later || !std::isfinite(time)) {
      json.member("interval")
          .fail("an interval by which the times of " + std::to_string(images.size()) + " frames from " +
                number_text(start) + " on can differ");
    }
    images[i].time = time;
  }
}

std::vector<SourceImage> images_of_pattern(JsonReader& json, Files& files) {
  const fs::path pattern = json.member("pattern").path();
  const std::vector<fs::path> found = list_files(pattern.parent_path(), pattern.filename().string());
  if (found.empty()) json.member("pattern").fail("a pattern that matches files; " + pattern.string() + " matches none");
  std::vector<SourceImage> images;
  for (const fs::path& file : found) {
    const int count = files.num_images(file);
    for (int i = 0; i < count; ++i) images.push_back({file, i, std::nullopt});
    if (images.size() > kMaxFrames) json.member("pattern").fail("at most " + std::to_string(kMaxFrames) + " images");
  }
  return images;
}

std::vector<SourceImage> images_of_list(const JsonReader& json, Files& files) {
  std::vector<SourceImage> images;
  for (JsonReader& entry : json.elements(kMaxFrames)) {
    SourceImage image{entry.member("photo").path(), 0, std::nullopt};
    const int count = files.num_images(image.file);
    if (entry.has("image")) {
      image.image = static_cast<int>(entry.member("image").integer(between(0, count - 1)));
    } else if (count != 1) {
      throw IoError(image.file.string(), "holds " + std::to_string(count) + " images; say which one with `image`");
    }
    if (entry.has("time")) {
      const JsonReader time = entry.member("time");
      image.time = time.number();
      if (!images.empty() && images.back().time && !(*images.back().time < *image.time)) {
        time.fail("a time later than that of the frame before (" + number_text(*images.back().time) + ")");
      }
    }
    if (entry.has("transform")) image.transform = read_transform(entry.member("transform"));
    entry.finish();
    images.push_back(image);
    if (images.back().time.has_value() != images.front().time.has_value())
      entry.fail("a `time` for every frame, or for none");
  }
  if (images.empty()) json.fail("at least one frame");
  return images;
}

std::set<int> excluded_numbers(JsonReader& json, std::size_t num_images) {
  std::set<int> excluded;
  if (!json.has("exclude")) return excluded;
  for (const JsonReader& index : json.member("exclude").elements(kMaxFrames))
    excluded.insert(static_cast<int>(index.integer(between(0, static_cast<double>(num_images) - 1))));
  return excluded;
}

/// Images that `from`, `to`, `every` (of a pattern) and `exclude` leave.
std::vector<bool> chosen(JsonReader& json, JsonReader* pattern, const std::set<int>& excluded, std::size_t num_images) {
  const double last = static_cast<double>(num_images) - 1;
  std::int64_t from = 0, to = static_cast<std::int64_t>(num_images) - 1, every = 1;
  if (pattern != nullptr && pattern->has("from")) from = pattern->member("from").integer(between(0, last));
  if (pattern != nullptr && pattern->has("to"))
    to = pattern->member("to").integer(between(static_cast<double>(from), last));
  if (pattern != nullptr && pattern->has("every")) every = pattern->member("every").integer(at_least(1));
  std::vector<bool> is_chosen(num_images, false);
  for (std::int64_t i = from; i <= to; i += every) is_chosen[i] = !excluded.contains(static_cast<int>(i));
  if (std::find(is_chosen.begin(), is_chosen.end(), true) == is_chosen.end()) {
    json.member("exclude").fail("at least one frame left");
  }
  return is_chosen;
}

/// The times of a movie's images, as it shows them. @throws IoError where it is no movie, or does not say
void set_movie_times(std::vector<SourceImage>& images, const std::vector<bool>& is_kept, const fs::path& file,
                     Files& files, const JsonReader& json, TimeUnit unit, FrameSources& sources) {
  const ImageInfo& info = files.info(file);
  const bool is_timed = info.frame_times_s.size() == static_cast<std::size_t>(info.num_frames);
  bool is_one_file = true;
  for (std::size_t i = 0; i < images.size(); ++i) is_one_file = is_one_file && (!is_kept[i] || images[i].file == file);
  if (!is_one_file || !(is_timed || (is_movie(file) && info.frame_rate > 0.0))) {
    throw IoError(json.file(), "frames: no times; " + file.filename().string() +
                                   " does not say when its images were taken; give `interval`, or a list with times");
  }
  for (SourceImage& image : images) {
    if (image.file != file) continue;
    const double seconds = is_timed ? info.frame_times_s[image.image] : image.image / info.frame_rate;
    image.time = rounded(seconds / seconds_per(unit), 12);
  }
  sources.time_source = is_timed ? kPresentationTimes : "the movie's frame rate";
}

/// Times that photographs state; empty where a file holds many images.
std::vector<DatedPhoto> dated_photos(const std::vector<SourceImage>& images, const std::vector<bool>& is_kept,
                                     Files& files) {
  std::vector<DatedPhoto> photos;
  for (std::size_t i = 0; i < images.size(); ++i) {
    DatedPhoto photo{.file = images[i].file, .is_kept = is_kept[i]};
    try {
      const ImageInfo& info = files.info(images[i].file);
      if (info.num_frames > 1 && is_kept[i]) return {};
      photo.date_time = info.date_time;
      photo.digitized = info.digitized;
    } catch (const IoError&) {
      if (is_kept[i]) throw;
    }
    photos.push_back(std::move(photo));
  }
  return photos;
}

/// For images without times. Excluded photographs count for when the series begins. @throws IoError
void find_times(std::vector<SourceImage>& images, const std::vector<bool>& is_kept, Files& files,
                const JsonReader& json, TimeUnit unit, FrameSources& sources) {
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (is_kept[i] && files.info(images[i].file).num_frames > 1)
      return set_movie_times(images, is_kept, images[i].file, files, json, unit, sources);
  }
  try {
    FrameTimes found = find_frame_times(dated_photos(images, is_kept, files), unit);
    std::size_t next = 0;
    for (std::size_t i = 0; i < images.size(); ++i) {
      if (is_kept[i]) images[i].time = found.times[next++];
    }
    sources.time_source = std::move(found.source);
    sources.time_span = std::move(found.span);
    sources.time_warnings = std::move(found.warnings);
  } catch (const InvalidInput& e) {
    throw IoError(json.file(), e.what());
  }
}

/// Checks the times of the photographs that are kept against what is stated.
void check_times(const std::vector<SourceImage>& images, const std::vector<bool>& is_kept, Files& files, TimeUnit unit,
                 FrameSources& sources) {
  std::vector<DatedPhoto> photos = dated_photos(images, is_kept, files);
  std::vector<double> times;
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (is_kept[i]) times.push_back(*images[i].time);
  }
  std::erase_if(photos, [](const DatedPhoto& photo) { return !photo.is_kept; });
  if (!photos.empty()) sources.time_warnings = check_stated_times(photos, times, unit);
}

/// One stream for each file with many images.
class Streams {
 public:
  Streams(const std::vector<SourceImage>& images, Files& files) {
    std::map<fs::path, std::vector<int>> wanted;
    for (const SourceImage& image : images) {
      if (files.info(image.file).num_frames > 1) wanted[image.file].push_back(image.image);
    }
    for (auto& [file, numbers] : wanted) {
      std::sort(numbers.begin(), numbers.end());
      streams_[file] = std::make_shared<FrameStream>(file, numbers);
    }
  }
  [[nodiscard]] std::shared_ptr<FrameStream> of(const fs::path& file) const {
    const auto found = streams_.find(file);
    return found == streams_.end() ? nullptr : found->second;
  }

 private:
  std::map<fs::path, std::shared_ptr<FrameStream>> streams_;
};

}  // namespace

std::string CapturePhoto::name() const {
  return file.filename().string() + (stream ? ", image " + std::to_string(image) : "");
}

std::vector<std::string> photo_names(const std::vector<CapturePhoto>& photos) {
  std::map<std::string, int> counts;
  for (const CapturePhoto& photo : photos) ++counts[photo.name()];
  std::vector<std::string> names;
  for (const CapturePhoto& photo : photos) {
    const std::string name = photo.name();
    names.push_back(counts[name] == 1 ? name : name + " (number " + std::to_string(photo.number) + ")");
  }
  return names;
}

CapturePhoto photo_of(const fs::path& file, const ImageInfo& info) {
  return {.file = file,
          .has_alpha = info.has_alpha(),
          .has_codes = info.is_integer && !info.is_raw,
          .is_raw = info.is_raw,
          .is_encoded = info.encoding != nullptr,
          .facts = info.facts,
          .exposure = info.exposure,
          .said_time = info.num_frames > 1 ? "" : photo_time_text(file, info),
          .width = info.width,
          .height = info.height};
}

Eigen::Matrix3d read_transform(const JsonReader& json) {
  const std::vector<double> n = json.numbers(9);
  Eigen::Matrix3d h;
  h << n[0], n[1], n[2], n[3], n[4], n[5], n[6], n[7], n[8];
  constexpr double kLeast = 1e-9;  // Least determinant of a given homography.
  if (!(std::abs(h.determinant()) > kLeast) || !(std::abs(h(2, 2)) > kLeast))
    json.fail("an invertible 3 x 3 matrix, row by row, from the photograph's pixels to the reference's");
  return h / h(2, 2);
}

FrameSources read_frame_sources(JsonReader& json, TimeUnit unit) {
  JsonReader frames = json.member("frames");
  if (!frames.is_array() && !frames.is_object()) frames.fail("a list of frames, or {\"pattern\": ...}");
  const bool is_list = frames.is_array();
  Files files;
  std::vector<SourceImage> images = is_list ? images_of_list(frames, files) : images_of_pattern(frames, files);
  FrameSources sources;
  if (is_list && images.front().time) sources.time_source = "list";
  if (!is_list && frames.has("interval")) {
    set_interval_times(frames, images);
    sources.time_source = "interval";
  } else if (!is_list && frames.has("start")) {
    frames.member("start").fail("no `start` without `interval`");
  }
  const std::set<int> excluded = excluded_numbers(json, images.size());
  sources.num_images = static_cast<int>(images.size());
  sources.excluded.assign(excluded.begin(), excluded.end());
  const std::vector<bool> is_chosen = chosen(json, is_list ? nullptr : &frames, excluded, images.size());
  if (!is_list) frames.finish();
  if (sources.time_source.empty())
    find_times(images, is_chosen, files, json, unit, sources);
  else
    check_times(images, is_chosen, files, unit, sources);
  std::vector<SourceImage> kept;
  for (std::size_t i = 0; i < images.size(); ++i) {
    images[i].number = static_cast<int>(i);
    if (is_chosen[i]) kept.push_back(std::move(images[i]));
  }
  const Streams streams(kept, files);
  for (const SourceImage& image : kept) {
    const ImageInfo& info = files.info(image.file);
    if (!info.color_problem.empty()) throw IoError(image.file.string(), info.color_problem);
    CapturePhoto photo = photo_of(image.file, info);
    photo.time = *image.time;
    photo.image = image.image;
    photo.number = image.number;
    photo.stream = streams.of(image.file);
    photo.transform = image.transform;
    sources.photos.push_back(std::move(photo));
    sources.is_raw = sources.is_raw || info.is_raw;
  }
  std::stable_sort(sources.photos.begin(), sources.photos.end(),
                   [](const CapturePhoto& a, const CapturePhoto& b) { return a.time < b.time; });
  std::vector<double> times;
  for (const CapturePhoto& photo : sources.photos) times.push_back(photo.time);
  if (const auto problem = find_time_problem(times))
    throw IoError(json.file(),
                  "frames: " + sources.photos[problem->index].file.filename().string() + " " + problem->text);
  return sources;
}

}  // namespace patinate::capture
