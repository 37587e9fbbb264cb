/// \file
/// A capture project of kind `relit` (`patinate.capture`, docs/capture.md): a scan and one photograph per light at
/// every step.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "patinate/geometry/camera.h"
#include "patinate/geometry/light.h"
#include "patinate/geometry/rigid_transform.h"
#include "patinate/history/history.h"
#include "patinate/image/color.h"

namespace patinate::capture {

/// One step: photographs with a scan, photographs alone (all lights directional), or ready-made maps.
struct RelitStep {
  /// Albedo that another program made, in the photographs' view, with what its pixels show in scanner coordinates.
  struct Ready {
    std::filesystem::path albedo;    ///< Linear color.
    std::filesystem::path position;  ///< Channels X, Y, Z, in the project's unit; (0, 0, 0) = no surface.
    std::filesystem::path normal;    ///< Channels X, Y, Z.
  };
  int number = 0;     ///< Its place in the file's `steps`, from 0.
  double time = 0.0;  ///< In the project's time unit.
  std::optional<std::filesystem::path> scan = {};
  std::vector<std::filesystem::path> photos = {};  ///< One a light, in their order; none with ready-made maps.
  std::optional<std::filesystem::path> ambient = {};
  std::optional<Ready> ready = {};
  std::optional<RigidTransform> reference_from_scan = {};  ///< mm; given, so that nothing is registered.
  bool is_from_registration = false;                       ///< The project's `registration` gives it.
  std::optional<RigidTransform> initial = {};              ///< mm; where registration starts.

  [[nodiscard]] bool has_shape() const { return scan || ready; }
};

/// A patch of known albedo that does not move, seen by every photograph.
struct ReferencePatch {
  std::vector<Vec2> polygon;  ///< Pixels of the photographs; three or more.
  Vec3 albedo;                ///< Red, green, blue; > 0.
};

/// Every path is usable as it stands.
struct RelitProject {
  std::filesystem::path file;  ///< The project file itself.
  std::string name;
  TimeUnit time_unit = TimeUnit::Seconds;
  double mm_per_unit = 1.0;
  Response response = {};
  /// Camera of the photographs, in a world of mm. A project without any shape may leave it out: then it looks along -z
  /// of a frame in which the directional lights stand, x right, y up.
  Camera camera_mm;
  bool is_camera_given = true;
  std::vector<Light> lights = {};
  std::optional<ReferencePatch> patch = {};
  std::vector<RelitStep> steps = {};  ///< Strictly increasing time; excluded ones are excluded.
  std::size_t reference = 0;          ///< Into steps.
  std::vector<SampleFact> sample = {};

  [[nodiscard]] int width() const { return camera_mm.parameters().width; }
  [[nodiscard]] int height() const { return camera_mm.parameters().height; }
  /// Whether the reference step has a shape, so that the others are brought into its view.
  [[nodiscard]] bool has_shape() const { return steps[reference].has_shape(); }
};

/// Whether a project is of kind `relit`. @throws IoError if the file cannot be read or is no capture project.
[[nodiscard]] bool is_relit_capture(const std::filesystem::path& file);
/// Reads and checks a project: every file is there, every photograph has the camera's size; pixels are not decoded.
/// @throws IoError naming the file and what is wrong.
[[nodiscard]] RelitProject read_relit_project(const std::filesystem::path& file);

}  // namespace patinate::capture
