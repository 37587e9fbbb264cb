/// \file
/// What an artist has done to a scene, kept so that `patinate simulate` does it again to the byte.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "libcommon/core/json.h"
#include "simulation/scene/scene_io.h"

namespace patinate {

/// The scene file as its user wrote it (without comments), and what has come to it since.
class SceneRecord {
 public:
  /// @param scene  As it was read from its file. @throws IoError
  explicit SceneRecord(const SceneFile& scene);
  SceneRecord(const SceneRecord&) = delete;
  SceneRecord& operator=(const SceneRecord&) = delete;

  /// Makes an emitter part of the file. Call before anything runs.
  void add_emitter(const Json& emitter_of_file);
  /// The atlas is as large as this, whatever the file says.
  void set_resolution(int resolution);
  void set_seed(std::uint64_t seed);
  /// An event that has happened. Where the last one, of the same iteration, did the same to the same, it takes its place.
  void add_event(const Json& event_of_file);
  /// After this, the events so far stay as they are. @returns what forget_after() takes.
  [[nodiscard]] std::size_t mark();
  void forget_after(std::size_t mark);
  [[nodiscard]] std::size_t num_events() const;
  /// Members of "appearance" for a material, over what the file says.
  void set_look(const std::string& material, const Json& members);

  /// The scene file that ends where the studio is now. Paths lead from `folder` to what they led to before; recorded events come before
  /// those of the file that happen in the same iteration, as they did here.
  /// @param iterations  Done so far; 0 leaves the file's own.
  [[nodiscard]] Json file_for(const std::filesystem::path& folder, std::int64_t iterations) const;

 private:
  std::filesystem::path folder_;  ///< Of the original file.
  std::shared_ptr<Json> root_, events_;
  std::size_t num_fixed_ = 0;  ///< Events that no other replaces.
};

}  // namespace patinate
