/// \file
/// The stages of calibration from a description in JSON (docs/calibration.md), and their result as a calibration file.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture/calibration/response.h"
#include "patinate/capture/camera_calibration.h"
#include "patinate/capture/lambertian_lights.h"
#include "patinate/capture/sphere_lights.h"
#include "patinate/core/json.h"
#include "patinate/image/image.h"

namespace patinate::capture {

enum class CalibrationKind { Camera, Spheres, Lambertian, Response };
inline constexpr std::array<std::string_view, 4> kCalibrationKindNames{"camera", "spheres", "lambertian", "response"};

struct LambertianRunOptions {
  int sample_step_px = 8;  ///< Side of the squares of pixels that are averaged to a sample; [1, 1000].
  LambertianLightOptions lights = {};
};
void describe(OptionVisitor& v, LambertianRunOptions& o);

struct CalibrateOptions {
  CameraCalibrationOptions camera = {};
  SphereLightOptions spheres = {};
  LambertianRunOptions lambertian = {};
  ResponseOptions response = {};
};

/// Result of a calibration.
struct CalibrationOutput {
  std::shared_ptr<Json>
      json;  ///< A file of format patinate.calibration: `camera`, `lights` or `response`, and a `report`.
  std::optional<Camera> camera;    ///< Camera of kind camera: the one that was found; else the one that was given. mm.
  std::vector<Light> lights;       ///< mm.
  std::vector<std::string> lines;  ///< Lines for the user.
  ImageF picture;                  ///< Residuals over the photograph, linear RGB; may be empty.
};

/// Reads what `json` names and runs the stage.
/// @throws IoError for the description or a file it names, CannotComplete when the data leave the result open (the
/// message says what would help), InvalidInput as the stages.
[[nodiscard]] CalibrationOutput calibrate(CalibrationKind kind, JsonReader json, const CalibrateOptions& options = {},
                                          const RunControl& control = {});

}  // namespace patinate::capture
