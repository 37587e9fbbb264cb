#include "patinate/geometry/camera_io.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "libcommon/core/text.h"
#include "libcommon/geometry/camera_text_io.h"
#include "libcommon/geometry/length_unit.h"
#include "libcommon/geometry/opencv_file.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

constexpr std::size_t kMaxElements = 100;

void check_lens_model(const std::string& file, const OpenCvFile& calibration);

class CalibrationFile {
 public:
  explicit CalibrationFile(const std::filesystem::path& path) : name_(path.string()), file_(path) {}

  /// Numbers under the first of the names that is there. @param what  "nine numbers".
  [[nodiscard]] std::vector<double> numbers(std::initializer_list<const char*> names,
                                            std::initializer_list<std::size_t> counts, const std::string& what,
                                            const std::string& when_missing = "") const {
    for (const char* name : names) {
      if (!file_.has(name)) continue;
      const std::optional<std::vector<double>> found = file_.numbers(name);
      if (!found || std::find(counts.begin(), counts.end(), found->size()) == counts.end()) {
        throw IoError(name_, std::string("`") + name + "` does not hold what it should; expected " + what);
      }
      return *found;
    }
    throw IoError(name_, std::string("has no `") + *names.begin() + "`; expected " + what + when_missing);
  }

  void check_lens() const { check_lens_model(name_, file_); }

  [[nodiscard]] int size(const char* name) const {
    const double value = numbers({name}, {1}, "a number of pixels").front();
    if (!(value >= 1 && value <= 65536 && value == std::floor(value))) {
      throw IoError(name_, std::string("`") + name + "` is out of range; expected 1 to 65536 pixels");
    }
    return static_cast<int>(value);
  }

 private:
  std::string name_;
  OpenCvFile file_;
};

/// Row by row. @returns Whether it is [[fx, 0, cx], [0, fy, cy], [0, 0, 1]].
bool set_matrix(const std::vector<double>& m, CameraParameters& p) {
  p.fx = m[0], p.cx = m[2], p.fy = m[4], p.cy = m[5];
  return m[1] == 0 && m[3] == 0 && m[6] == 0 && m[7] == 0 && m[8] == 1;
}

/// @returns Whether only k1 k2 p1 p2 k3 are not 0.
bool set_distortion(const std::vector<double>& d, CameraParameters& p) {
  std::copy_n(d.begin(), std::min(d.size(), p.distortion.size()), p.distortion.begin());
  return d.size() <= p.distortion.size() || std::all_of(d.begin() + 5, d.end(), [](double v) { return v == 0; });
}

/// Nine numbers are a matrix, row by row; three an axis times an angle in radians.
Eigen::Matrix3d rotation_from_numbers(const std::vector<double>& r) {
  if (r.size() == 9) return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(r.data());
  const Vec3 axis(r[0], r[1], r[2]);
  const double angle = axis.norm();
  return angle > 0 ? Eigen::AngleAxisd(angle, axis / angle).toRotationMatrix()
                   : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
}

const char* const kLensModel = "k1 k2 p1 p2 k3 (0 where the lens has none)";

/// Plain form of a name: its letters and digits, small.
std::string plain_word(const std::string& text) {
  std::string plain;
  for (char c : text) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0)
      plain += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return plain;
}

/// Refuses a lens model that is said and is not Brown's. @throws IoError naming it
void check_lens_model(const std::string& file, const OpenCvFile& calibration) {
  constexpr std::array<std::string_view, 11> kBrown{
      "plumbbob",           "radtan",  "radialtangential", "brown",         "brownconrady", "opencv",
      "rationalpolynomial", "pinhole", "perspective",      "pinholeradtan", "none"};
  const auto refuse = [&](const std::string& key, const std::string& model) {
    throw IoError(file, "`" + key + "` says " + model + ", a lens model that is not read; expected " + kLensModel +
                            ": calibrate with that model, or undistort the photographs");
  };
  for (const char* key : {"distortion_model", "lens_model", "model_type", "projection_model", "distortion_type"}) {
    const std::string model = calibration.word(key);
    if (!model.empty() && std::find(kBrown.begin(), kBrown.end(), plain_word(model)) == kBrown.end())
      refuse(key, model);
  }
  // These may name the camera as well.
  constexpr std::array<std::string_view, 12> kOthers{"fish",    "omni",         "equi",       "kannala",
                                                     "mei",     "eucm",         "scaramuzza", "ocam",
                                                     "unified", "doublesphere", "fov",        "spherical"};
  for (const char* key : {"camera_model", "camera_type", "model", "projection"}) {
    const std::string model = calibration.word(key), plain = plain_word(model);
    if (plain == "ds" || std::any_of(kOthers.begin(), kOthers.end(),
                                     [&](std::string_view other) { return plain.find(other) != std::string::npos; }))
      refuse(key, model);
  }
  for (const char* key : {"fisheye_model", "fisheye", "is_fisheye"}) {
    const std::string said = plain_word(calibration.word(key));
    if (!said.empty() && said != "0" && said != "false" && said != "no") refuse(key, "fisheye");
  }
  for (const char* key : {"xi", "mirror_parameters"}) {
    if (calibration.has(key)) refuse(key, "that the camera is omnidirectional");
  }
}

const char* const kMatrixShape = "[[fx, 0, cx], [0, fy, cy], [0, 0, 1]] in pixels";

CameraParameters read_opencv(const std::filesystem::path& path) {
  const std::string file = path.string();
  const CalibrationFile calibration(path);
  calibration.check_lens();
  CameraParameters p;
  p.width = calibration.size("image_width");
  p.height = calibration.size("image_height");
  if (!set_matrix(calibration.numbers({"camera_matrix"}, {9}, kMatrixShape), p)) {
    throw IoError(file, std::string("`camera_matrix` does not hold what it should; expected ") + kMatrixShape);
  }
  const std::string model = kLensModel;
  if (!set_distortion(calibration.numbers({"distortion_coefficients", "dist_coeffs"}, {4, 5, 8, 12, 14}, model), p)) {
    throw IoError(file, "`distortion_coefficients` go beyond " + model + "; calibrate with that model");
  }
  const std::string pose = "; x_in_camera = rotation * x_in_world + translation, for instance from cv::solvePnP";
  p.rotation = rotation_from_numbers(
      calibration.numbers({"rotation", "R", "rvec"}, {9, 3}, "a 3 x 3 matrix, or an axis times an angle", pose));
  const std::vector<double> t =
      calibration.numbers({"translation", "T", "t", "tvec"}, {3}, "three numbers in the project's `unit`", pose);
  p.translation = {t[0], t[1], t[2]};
  return p;
}

/// Rows of numbers, or three numbers where `may_be_vector`.
std::vector<double> read_3x3(const JsonReader& json, bool may_be_vector) {
  const std::vector<JsonReader> rows = json.elements(kMaxElements);
  if (rows.size() != 3)
    json.fail(may_be_vector ? "three rows of three numbers, or an axis times an angle" : "three rows of three numbers");
  if (may_be_vector && rows[0].is_number()) return json.numbers(3);
  std::vector<double> numbers;
  for (const JsonReader& row : rows) {
    for (double v : row.numbers(3)) numbers.push_back(v);
  }
  return numbers;
}

/// Reports problems of the values under the name of where they stand.
Camera make_camera(const std::string& where, const CameraParameters& p) {
  try {
    return Camera(p);
  } catch (const InvalidInput& e) {
    throw IoError(where, e.what());
  }
}

/// A camera as our JSON files write it.
Camera read_object(JsonReader& json) {
  CameraParameters p;
  p.width = static_cast<int>(json.member("width").integer(between(1, 65536)));
  p.height = static_cast<int>(json.member("height").integer(between(1, 65536)));
  const JsonReader matrix = json.member("matrix");
  if (!set_matrix(read_3x3(matrix, false), p)) matrix.fail(kMatrixShape);
  if (json.has("distortion")) {
    const JsonReader distortion = json.member("distortion");
    (void)set_distortion(distortion.numbers(distortion.elements(kMaxElements).size() == 4 ? 4 : 5), p);
  }
  p.rotation = rotation_from_numbers(read_3x3(json.member("rotation"), true));
  const std::vector<double> t = json.member("translation").numbers(3);
  p.translation = {t[0], t[1], t[2]};
  json.finish();
  return make_camera(json.file() + ": " + json.pointer(), p);
}

/// A calibration of ours; nothing when the file is another one.
std::optional<Camera> read_own(const std::filesystem::path& path) {
  if (path.extension() != ".json") return std::nullopt;
  const Json content = load_json(path);
  JsonReader json(path.string(), content);
  if (!json.has("format")) return std::nullopt;
  json.expect_format("patinate.calibration", 1);
  const double mm = kMmPerLengthUnit[json.member("unit").choice(kLengthUnitNames)];
  if (!json.has("camera")) throw IoError(path.string(), "is a calibration without a camera");
  JsonReader camera = json.member("camera");
  return read_object(camera).scaled(mm);
}

/// A COLMAP model's folder, or one of its files.
bool is_colmap_file(const std::filesystem::path& path) {
  constexpr std::array<std::string_view, 4> kNames{"images.txt", "cameras.txt", "images.bin", "cameras.bin"};
  std::error_code error;
  return std::find(kNames.begin(), kNames.end(), path.filename().string()) != kNames.end() ||
         std::filesystem::is_directory(path, error);
}

/// {"file", "image", "width", "height"}.
Camera read_of_image(JsonReader& json, double mm_per_unit) {
  const std::filesystem::path path = json.member("file").path();
  const std::string image = json.has("image") ? json.member("image").string() : "";
  if (is_colmap_file(path)) {
    json.finish();
    return make_camera(path.string(), read_colmap_camera(path, image)).scaled(mm_per_unit);
  }
  if (path.extension() != ".txt") {
    json.finish();
    return read_camera(path, mm_per_unit);
  }
  const auto width = static_cast<int>(json.member("width").integer(between(1, 65536)));
  const auto height = static_cast<int>(json.member("height").integer(between(1, 65536)));
  json.finish();
  return make_camera(path.string(), read_middlebury_camera(path, image, width, height)).scaled(mm_per_unit);
}

}  // namespace

Camera read_camera(const std::filesystem::path& path, double mm_per_unit) {
  if (const std::optional<Camera> own = read_own(path)) return *own;
  if (is_colmap_file(path)) {
    return make_camera(path.string(), read_colmap_camera(path)).scaled(mm_per_unit);
  }
  return make_camera(path.string(), read_opencv(path)).scaled(mm_per_unit);
}

Camera read_camera(JsonReader json, double mm_per_unit) {
  if (json.is_string()) return read_camera(json.path(), mm_per_unit);
  if (!json.is_object())
    json.fail(
        "the path of an OpenCV calibration, or an object with width, height, matrix, distortion, rotation, "
        "translation");
  if (json.has("file")) return read_of_image(json, mm_per_unit);
  return read_object(json).scaled(mm_per_unit);
}

Json json_of(const Camera& camera) {
  const CameraParameters& p = camera.parameters();
  Json json{{"width", p.width}, {"height", p.height}};
  json["matrix"] = Json{{p.fx, 0.0, p.cx}, {0.0, p.fy, p.cy}, {0.0, 0.0, 1.0}};
  json["distortion"] = p.distortion;
  json["rotation"] = Json::array();
  for (int r = 0; r < 3; ++r) json["rotation"].push_back({p.rotation(r, 0), p.rotation(r, 1), p.rotation(r, 2)});
  json["translation"] = {p.translation[0], p.translation[1], p.translation[2]};
  return json;
}

std::string opencv_text(const Camera& camera) {
  const CameraParameters& p = camera.parameters();
  const auto matrix = [](const char* name, int rows, int columns, const std::vector<double>& values) {
    std::string text = std::string(name) + ": !!opencv-matrix\n   rows: " + std::to_string(rows) +
                       "\n   cols: " + std::to_string(columns) + "\n   dt: d\n   data: [ ";
    for (std::size_t i = 0; i < values.size(); ++i) {
      // OpenCV tells real numbers from integers by the point.
      std::string number = number_text(values[i]);
      if (number.find_first_of(".en") == std::string::npos) number += ".";
      text += (i == 0 ? "" : ", ") + number;
    }
    return text + " ]\n";
  };
  std::vector<double> rotation;
  rotation.reserve(9);
  for (int i = 0; i < 9; ++i) rotation.push_back(p.rotation(i / 3, i % 3));
  return "%YAML:1.0\n---\nimage_width: " + std::to_string(p.width) + "\nimage_height: " + std::to_string(p.height) +
         "\n" + matrix("camera_matrix", 3, 3, {p.fx, 0, p.cx, 0, p.fy, p.cy, 0, 0, 1}) +
         matrix("distortion_coefficients", 1, 5, {p.distortion.begin(), p.distortion.end()}) +
         matrix("rotation", 3, 3, rotation) +
         matrix("translation", 3, 1, {p.translation[0], p.translation[1], p.translation[2]});
}

}  // namespace patinate
