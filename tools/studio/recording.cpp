#include "tools/studio/recording.h"

#include <array>
#include <ctime>
#include <nlohmann/json.hpp>
#include <utility>

#include "libcommon/core/error.h"
#include "libcommon/core/files.h"
#include "libcommon/core/hash.h"
#include "tools/studio/place.h"

namespace patinate {

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

}  // namespace

std::string scene_content_key(const SceneFile& scene) {
  ContentHash hash;
  hash.add("recording 1").add(load_json(scene.file).dump(-1, ' ', false, Json::error_handler_t::replace));
  for (const auto& [role, path] : scene.inputs) hash.add(role).add_file(path);
  hash.add(std::int64_t{scene.scene.resolution}).add(static_cast<std::int64_t>(scene.scene.seed));
  return hash.hex();
}

RecordingFile::RecordingFile(const ServedFolder& folder, const fs::path& place, std::string key)
    : path_(folder.path() / kRecordingFolder / file_name(folder.name_of(place))), place_(folder.name_of(place)), key_(std::move(key)) {
  std::error_code error;
  if (fs::is_regular_file(path_, error)) {
    has_other_ = true;
    try {
      Json root = load_json(path_);
      JsonReader json(path_.string(), root);
      json.expect_format(kFormat, 1);
      const std::string of = json.member("scene_key").string();
      Recording recording;
      recording.iterations = json.member("iterations").integer(at_least(0));
      recording.events = std::make_shared<const Json>(root.at("events"));
      recording.looks = std::make_shared<const Json>(root.at("looks"));
      recording.modified = modified_text(path_);
      if (of == key_) {
        found_ = std::move(recording);
      } else {
        const fs::path scene = beside(path_, "before_change");
        save_json(scene, root.at("scene"));
        note_ = "The scene has changed since it was painted last; what was painted then is the scene file " + folder.name_of(scene) + ".";
        move_aside();
      }
    } catch (const std::exception& e) {
      note_ = std::string("The recording of an earlier run cannot be read: ") + e.what();
    }
  }
  writer_ = std::jthread([this](const std::stop_token& stop) { write(stop); });
}

RecordingFile::~RecordingFile() = default;

void RecordingFile::keep(std::int64_t iterations, const Json& events, const Json& looks, const Json& scene) {
  const Json root{{"format", kFormat}, {"version", 1},    {"place", place_}, {"scene_key", key_},
                  {"iterations", iterations}, {"events", events}, {"looks", looks}, {"scene", scene}};
  std::string text = root.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
  {
    const std::scoped_lock lock(mutex_);
    moves_first_ = moves_first_ || std::exchange(has_other_, false);
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

std::string RecordingFile::take_problem() {
  const std::scoped_lock lock(mutex_);
  return problem_.empty() || std::exchange(said_problem_, true) ? std::string() : problem_;
}

void RecordingFile::move_aside() {
  std::error_code error;
  fs::rename(path_, beside(path_, "previous"), error);  // there may be none
}

void RecordingFile::write(const std::stop_token& stop) {
  while (true) {
    std::string text;
    bool moves_first = false;
    {
      std::unique_lock lock(mutex_);
      has_text_.wait(lock, stop, [&] { return waiting_.has_value(); });
      if (!waiting_) return;  // the end
      text = std::move(*waiting_);
      waiting_.reset();
      moves_first = std::exchange(moves_first_, false);
    }
    if (moves_first || text.empty()) move_aside();
    if (text.empty()) continue;
    try {
      fs::create_directories(path_.parent_path());
      write_atomically(path_, text);
    } catch (const std::exception& e) {
      const std::scoped_lock lock(mutex_);
      problem_ = std::string("What is done here cannot be kept on the disk: ") + e.what();
    }
  }
}

}  // namespace patinate
