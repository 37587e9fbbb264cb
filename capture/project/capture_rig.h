/// \file
/// Where lamp and camera stood over a fixed capture's surface, as its project says it.
#pragma once

#include <optional>
#include <vector>

#include "patinate/core/json.h"
#include "patinate/geometry/light.h"

namespace patinate::capture {

struct CaptureProject;

/// Lights and cameras of a capture, in mm. Over a `plate`, x points right, y up and z to the camera, and the origin is
/// in the middle of the whole photograph. With a `scan`, places are in the scan's coordinate frame.
struct CaptureRig {
  std::vector<Light> lights;  ///< One, or one for each frame.
  std::vector<Vec3> cameras;  ///< Cameras of the photographs, or one; none with a scan, whose camera it is.

  [[nodiscard]] const Light& light(std::size_t frame) const { return lights[lights.size() == 1 ? 0 : frame]; }
  [[nodiscard]] const Vec3& camera(std::size_t frame) const { return cameras[cameras.size() == 1 ? 0 : frame]; }
  /// Lamp or camera stand elsewhere from photograph to photograph.
  [[nodiscard]] bool is_moving() const { return lights.size() > 1 || cameras.size() > 1; }
};

/// `lights` and `plate` of a project whose frames, scan and texel size are read; nothing without them.
/// @param unit  Where `unit` of the project stands; nothing when it is not given.
/// @throws IoError
[[nodiscard]] std::optional<CaptureRig> read_capture_rig(JsonReader& json, const std::optional<JsonReader>& unit,
                                                         const CaptureProject& project);

}  // namespace patinate::capture
