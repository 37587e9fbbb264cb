#include "capture/calibration/calibrate.h"

#include <nlohmann/json.hpp>

#include "capture/calibration/calibrate_kinds.h"
#include "libcommon/geometry/length_unit.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

constexpr std::size_t kMaxPoints = 100'000;

}  // namespace

void describe(OptionVisitor& v, LambertianRunOptions& o) {
  v.visit({"sample_step", "side of the squares of pixels that are averaged to a sample", "px", between(1, 1000)},
          o.sample_step_px);
  describe(v, o.lights);
}

double read_mm_per_unit(JsonReader& json) { return kMmPerLengthUnit[json.member("unit").choice(kLengthUnitNames)]; }

std::vector<Vec2> read_pixels(const JsonReader& json) {
  std::vector<Vec2> pixels;
  for (const JsonReader& entry : json.elements(kMaxPoints)) {
    const std::vector<double> v = entry.numbers(2);
    pixels.emplace_back(v[0], v[1]);
  }
  return pixels;
}

std::vector<Vec3> read_points(const JsonReader& json, double mm_per_unit) {
  std::vector<Vec3> points;
  for (const JsonReader& entry : json.elements(kMaxPoints)) {
    const std::vector<double> v = entry.numbers(3);
    points.push_back(mm_per_unit * Vec3(v[0], v[1], v[2]));
  }
  return points;
}

Json matrix_json(const Eigen::MatrixXd& matrix) {
  Json rows = Json::array();
  for (Eigen::Index r = 0; r < matrix.rows(); ++r) {
    Json row = Json::array();
    for (Eigen::Index c = 0; c < matrix.cols(); ++c) row.push_back(matrix(r, c));
    rows.push_back(std::move(row));
  }
  return rows;
}

Json result_json(CalibrationKind kind) {
  return Json{{"format", "patinate.calibration"},
              {"version", 1},
              {"kind", std::string(kCalibrationKindNames[static_cast<std::size_t>(kind)])},
              {"unit", "mm"}};
}

CalibrationOutput calibrate(CalibrationKind kind, JsonReader json, const CalibrateOptions& options,
                            const RunControl& control) {
  json.expect_format("patinate.calibrate", 1);
  const JsonReader named = json.member("kind");
  if (named.choice(kCalibrationKindNames) != static_cast<int>(kind)) {
    named.fail("\"" + std::string(kCalibrationKindNames[static_cast<std::size_t>(kind)]) + "\", as the command says");
  }
  if (json.has("name")) (void)json.member("name").string();
  switch (kind) {
    case CalibrationKind::Camera:
      return run_camera(json, options.camera, control);
    case CalibrationKind::Spheres:
      return run_spheres(json, options.spheres, control);
    case CalibrationKind::Lambertian:
      return run_lambertian(json, options.lambertian, control);
    case CalibrationKind::Response:
      return run_response(json, options.response);
  }
  return {};
}

}  // namespace patinate::capture
