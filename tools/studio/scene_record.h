/// \file
/// What an artist has done to a scene, kept so that `patinate simulate` does it again to the byte.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "patinate/core/json.h"
#include "patinate/simulation/scene_io.h"

namespace patinate::studio {

/// The scene file as its user wrote it (without comments), and what has come to it since.
class SceneRecord {
 public:
  /// @param scene  As it was read from `root`. @throws IoError
  SceneRecord(const simulation::SceneFile& scene, Json root);
  SceneRecord(const SceneRecord&) = delete;
  SceneRecord& operator=(const SceneRecord&) = delete;

  /// Makes an emitter part of the file. Call before anything runs.
  void add_emitter(const Json& emitter_of_file);
  /// The atlas is as large as this, whatever the file says.
  void set_resolution(int resolution);
  void set_seed(std::uint64_t seed);
  /// An event that has happened. Where the last one, of the same iteration, did the same to the same, it takes its
  /// place.
  void add_event(const Json& event_of_file);
  /// A step of a brush alone, now. Adds to the last event where that is of the same brush and iteration; as often at
  /// one place is one number.
  /// @param point_of_file  [x, y, z] in the file's unit.
  void add_paint(const std::string& emitter, std::int64_t iteration, const std::array<double, 3>& point_of_file);
  /// Events so far, for set_events(): cheap, and later ones leave it as it is.
  using Events = std::vector<std::shared_ptr<Json>>;
  [[nodiscard]] Events events();
  void set_events(Events events);
  /// One that has happened and stays as it is.
  void append(const std::shared_ptr<Json>& event);
  [[nodiscard]] std::size_t num_events() const;
  [[nodiscard]] Json events_json() const;
  /// Members of "appearance" that set_appearance() was given.
  [[nodiscard]] const Json& appearance() const { return *appearance_; }
  /// Another number after every change.
  [[nodiscard]] std::uint64_t version() const { return version_; }
  /// Members of "appearance" for a material, over what the file says.
  void set_appearance(const std::string& material, const Json& members);
  /// All that set_appearance() changes, to go back to.
  struct Appearance {
    std::shared_ptr<const Json> of_file, set;
  };
  [[nodiscard]] Appearance appearance_state() const;
  void set_appearance_state(const Appearance& state);

  /// The scene file that ends where the studio is now. Paths lead from `folder` to what they led to before; recorded
  /// events come before those of the file that happen in the same iteration, as they did here.
  /// @param iterations  Done so far; 0 leaves the file's own, unless something was painted.
  [[nodiscard]] Json file_for(const std::filesystem::path& folder, std::int64_t iterations) const;
  /// The scene file without what was done since, but with the looks that were set.
  [[nodiscard]] std::shared_ptr<const Json> written() const { return std::make_shared<const Json>(*root_); }
  /// A scene file that begins with all settings as they are now; strokes are not in it.
  /// @param scene  It now.
  [[nodiscard]] Json settled(const simulation::Scene& scene) const;

 private:
  std::filesystem::path folder_;  ///< Folder of the original file.
  std::shared_ptr<Json> root_, appearance_;
  std::uint64_t version_ = 0;
  Events events_;
  std::size_t num_fixed_ = 0;  ///< Events that nothing replaces or adds to.
};

/// A scene without a brush gets one, off, and so does its record. It comes last, so that the streams of the others
/// stay.
/// @returns file.scene
[[nodiscard]] const simulation::Scene& with_brush(simulation::SceneFile& file, SceneRecord& record);

}  // namespace patinate::studio
