/// \file
/// Inside calibrate(): one function a kind, and what they share.
#pragma once

#include "capture/calibration/calibrate.h"

namespace patinate::capture {

/// The description's members beside `format`, `version` and `kind`.
[[nodiscard]] CalibrationOutput run_camera(JsonReader& json, const CameraCalibrationOptions& options,
                                           const RunControl& control);
[[nodiscard]] CalibrationOutput run_spheres(JsonReader& json, const SphereLightOptions& options,
                                            const RunControl& control);
[[nodiscard]] CalibrationOutput run_lambertian(JsonReader& json, const LambertianRunOptions& options,
                                               const RunControl& control);
[[nodiscard]] CalibrationOutput run_response(JsonReader& json, const ResponseOptions& options);

/// `unit` of the description, mm per unit. @throws IoError when it is missing.
[[nodiscard]] double read_mm_per_unit(JsonReader& json);
/// [[x, y], ...] or [[x, y, z], ...]. @throws IoError
[[nodiscard]] std::vector<Vec2> read_pixels(const JsonReader& json);
[[nodiscard]] std::vector<Vec3> read_points(const JsonReader& json, double mm_per_unit);
/// Rows of a matrix.
[[nodiscard]] Json matrix_json(const Eigen::MatrixXd& matrix);
/// A start of the result: format, version, kind, unit.
[[nodiscard]] Json result_json(CalibrationKind kind);

}  // namespace patinate::capture
