/// \file
/// What is done to a running scene, on the disk within a second: when the program has ended, however it did, it can be
/// gone through again.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "patinate/core/json.h"
#include "patinate/simulation/scene_io.h"
#include "tools/studio/served_folder.h"

namespace patinate::studio {

/// Where recordings are kept: `.studio` in the served folder; "" where that is a finished result, or a part of one,
/// which stays as it was made.
[[nodiscard]] std::filesystem::path recording_folder(const ServedFolder& folder);

/// Tells scenes apart by all that they are made of. @throws IoError
[[nodiscard]] std::string scene_content_key(const simulation::SceneFile& scene);

/// Content of one file of recording_folder().
struct Recording {
  std::int64_t iterations = 0;             ///< Done when it was written.
  std::shared_ptr<const Json> events;      ///< An array, as SceneRecord has them.
  std::shared_ptr<const Json> appearance;  ///< Members of "appearance" that were set.
  std::shared_ptr<const Json> document;    ///< The scene that they are of; null: that of the place.
  std::string modified;                    ///< "2026-11-21T15:04:05Z"
};

/// The file of one place. Thread-safe: its writing has a thread of its own, so that no simulation waits for a disk.
class RecordingFile {
 public:
  /// Looks for what an earlier run has left. @param folder  With a recording_folder(). @param place  Canonical, below
  /// the folder.
  /// @param key  scene_content_key() of the scene there.
  RecordingFile(const ServedFolder& folder, const std::filesystem::path& place, std::string key);
  /// Writes what waits.
  ~RecordingFile();
  RecordingFile(const RecordingFile&) = delete;
  RecordingFile& operator=(const RecordingFile&) = delete;

  /// Recording that was there when this was made, and is of the same scene.
  [[nodiscard]] const std::optional<Recording>& found() const { return found_; }
  /// Text about one that is of another scene: of the scene before it was changed. "" = none.
  [[nodiscard]] const std::string& note() const { return note_; }
  /// Where the file's folder is.
  [[nodiscard]] std::filesystem::path folder() const { return path_.parent_path(); }

  /// Takes the place of what was kept before; returns at once. What is of an earlier run, or of another program, is put
  /// aside first, unless it continues.
  /// @param scene  The scene file that ends where the studio is, with paths from folder().
  /// @param document  As Recording::document.
  void keep(std::int64_t iterations, const Json& events, const Json& appearance, const Json& scene,
            const std::shared_ptr<const Json>& document);
  /// There is nothing to keep any more: what was kept is put aside, or removed where another has been put aside for it.
  void put_aside();
  /// Continues the found recording.
  void go_on();
  /// Why nothing is kept, once; "" = it is.
  [[nodiscard]] std::string take_problem();

 private:
  void write(const std::stop_token& stop);
  void replace(const std::string& text);
  void clear();
  [[nodiscard]] bool is_own();
  void move_aside();

  std::filesystem::path path_;
  std::string place_, key_, note_;
  std::optional<Recording> found_;
  std::string found_file_;      ///< Name of that file.
  bool has_put_aside_ = false;  ///< One of an earlier run, or of another program; of the writing thread.
  std::mutex mutex_;
  std::condition_variable_any has_text_;
  std::optional<std::string> waiting_;  ///< "" = there is nothing to keep.
  std::string own_file_;                ///< File that this has written last.
  std::string problem_;
  bool said_problem_ = false;
  std::jthread writer_;
};

}  // namespace patinate::studio
