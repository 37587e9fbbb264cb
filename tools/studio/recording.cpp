#include "tools/studio/recording.h"

#include <sys/stat.h>

#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "libcommon/core/files.h"
#include "libcommon/core/hash.h"
#include "libcommon/job/result_folder.h"
#include "patinate/core/error.h"
#include "tools/studio/place.h"

namespace patinate::studio {

namespace fs = std::filesystem;

namespace {

constexpr const char* kFormat = "patinate.recording";

/// A name that says which scene it is, and is no other's.
std::string file_name(const std::string& place) {
  std::string stem = fs::path(place).stem().string();
  if (stem.size() > 100) stem.resize(100);
  return stem + "-" + ContentHash().add(place).hex().substr(0, 8) + ".json";
}

fs::path beside(const fs::path& path, const std::string& word) {
  fs::path other = path;
  return other.replace_extension("." + word + ".json");
}

/// Tells a file from another one that has taken its place: "" = there is none.
std::string identity_of(const fs::path& path) {
  struct ::stat status {};
  if (::stat(path.c_str(), &status) != 0) return {};
  return std::to_string(status.st_dev) + " " + std::to_string(status.st_ino) + " " +
         std::to_string(status.st_mtim.tv_sec) + " " + std::to_string(status.st_mtim.tv_nsec);
}

/// @throws IoError unless it is all that resuming needs.
Recording read_recording(JsonReader& json, const Json& root, const fs::path& path) {
  double last = 0.0;
  for (JsonReader event : json.member("events").elements())
    last = static_cast<double>(event.member("iteration").integer(at_least(last)));
  (void)json.member("appearance").keys();
  return {.iterations = json.member("iterations").integer(at_least(last)),
          .events = std::make_shared<const Json>(root.at("events")),
          .appearance = std::make_shared<const Json>(root.at("appearance")),
          .document = root.contains("document") ? std::make_shared<const Json>(root.at("document")) : nullptr,
          .modified = modified_text(path)};
}

}  // namespace

fs::path recording_folder(const ServedFolder& folder) {
  return result_around(folder.path()).empty() ? folder.path() / ".studio" : fs::path();
}

std::string scene_content_key(const simulation::SceneFile& scene) {
  ContentHash hash;
  hash.add("recording 1").add(load_json(scene.file).dump(-1, ' ', false, Json::error_handler_t::replace));
  for (const auto& [role, path] : scene.inputs) hash.add(role).add_file(path);
  hash.add(std::int64_t{scene.scene.resolution}).add(static_cast<std::int64_t>(scene.scene.seed));
  return hash.hex();
}

RecordingFile::RecordingFile(const ServedFolder& folder, const fs::path& place, std::string key)
    : path_(recording_folder(folder) / file_name(folder.name_of(place))),
      place_(folder.name_of(place)),
      key_(std::move(key)) {
  std::error_code error;
  if (fs::is_regular_file(path_, error)) {
    try {
      found_file_ = identity_of(path_);
      Json root = load_json(path_);
      update_spelling(root, 1,
                      {{"looks", "appearance"},
                       {"behaviour", "behavior"},
                       {"alpha", "rate"},
                       {"makes", "products"},
                       {"uses", "reactants"}});
      JsonReader json(path_.string(), root);
      json.expect_format(kFormat, 2);
      if (json.member("scene_key").string() == key_) {
        found_ = read_recording(json, root, path_);
      } else {
        const fs::path scene = beside(path_, "before_change");
        (void)json.member("scene").keys();
        save_json(scene, root.at("scene"));
        note_ = "The scene has changed since it was painted last; what was painted then is the scene file " +
                folder.name_of(scene) + ".";
        move_aside();
      }
    } catch (const std::exception& e) {
      note_ = std::string("The recording of an earlier run cannot be read: ") + e.what();
    }
  }
  writer_ = std::jthread([this](const std::stop_token& stop) { write(stop); });
}

RecordingFile::~RecordingFile() = default;

void RecordingFile::keep(std::int64_t iterations, const Json& events, const Json& appearance, const Json& scene,
                         const std::shared_ptr<const Json>& document) {
  Json root{{"format", kFormat},        {"version", 2},     {"place", place_},          {"scene_key", key_},
            {"iterations", iterations}, {"events", events}, {"appearance", appearance}, {"scene", scene}};
  if (document) root["document"] = *document;
  std::string text = root.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
  {
    const std::scoped_lock lock(mutex_);
    waiting_ = std::move(text);
  }
  has_text_.notify_one();
}

void RecordingFile::put_aside() {
  {
    const std::scoped_lock lock(mutex_);
    waiting_ = "";
  }
  has_text_.notify_one();
}

void RecordingFile::go_on() {
  const std::scoped_lock lock(mutex_);
  own_file_ = found_file_;
}

std::string RecordingFile::take_problem() {
  const std::scoped_lock lock(mutex_);
  return problem_.empty() || std::exchange(said_problem_, true) ? std::string() : problem_;
}

bool RecordingFile::is_own() {
  const std::string there = identity_of(path_);
  const std::scoped_lock lock(mutex_);
  return there == own_file_;
}

void RecordingFile::move_aside() {
  std::error_code error;
  fs::rename(path_, beside(path_, "previous"), error);  // there may be none
}

/// Two programs that serve one folder so keep both: the one that writes puts what the other has written aside.
void RecordingFile::replace(const std::string& text) {
  const fs::path folder = path_.parent_path();
  if (fs::is_symlink(folder)) throw CannotComplete(folder.string() + ": is a link; make it a folder, or remove it");
  fs::create_directories(folder);
  if (!identity_of(path_).empty() && !is_own()) {
    move_aside();
    has_put_aside_ = true;
  }
  write_atomically(path_, text);
  const std::string written = identity_of(path_);
  const std::scoped_lock lock(mutex_);
  own_file_ = written;
}

/// A recording that was put aside for this one is worth more than what somebody has just gone back from.
void RecordingFile::clear() {
  if (!is_own()) return;
  std::error_code error;
  if (has_put_aside_) {
    fs::remove(path_, error);
  } else {
    move_aside();
  }
}

void RecordingFile::write(const std::stop_token& stop) {
  while (true) {
    std::string text;
    {
      std::unique_lock lock(mutex_);
      has_text_.wait(lock, stop, [&] { return waiting_.has_value(); });
      if (!waiting_) return;  // the end
      text = std::move(*waiting_);
      waiting_.reset();
    }
    std::string why;
    try {
      if (text.empty()) {
        clear();
      } else {
        replace(text);
      }
    } catch (const fs::filesystem_error& e) {
      why = e.path1().string() + ": " + e.code().message();
    } catch (const std::exception& e) {
      why = e.what();
    }
    if (why.empty()) continue;
    const std::scoped_lock lock(mutex_);
    problem_ = "What is done here cannot be kept on the disk: " + why;
  }
}

}  // namespace patinate::studio
