#include "libcommon/geometry/camera_io.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <mutex>
#include <opencv2/core/persistence.hpp>
#include <opencv2/core/utility.hpp>
#include <string>
#include <vector>

#include "libcommon/core/error.h"
#include "libcommon/core/files.h"

namespace patinate {

namespace {

constexpr std::size_t kMaxNumbers = 100;

int stay_silent(int, const char*, const char*, const char*, int, void*) { return 0; }

/// OpenCV prints what it throws; not while this lives. The setting is global: one at a time.
class SilentOpenCv {
 public:
  SilentOpenCv() : lock_(mutex()), before_(cv::redirectError(stay_silent, nullptr, &data_)) {}
  ~SilentOpenCv() { cv::redirectError(before_, data_); }
  SilentOpenCv(const SilentOpenCv&) = delete;
  SilentOpenCv& operator=(const SilentOpenCv&) = delete;

 private:
  static std::mutex& mutex() {
    static std::mutex instance;
    return instance;
  }
  std::lock_guard<std::mutex> lock_;
  void* data_ = nullptr;
  cv::ErrorCallback before_;
};

/// Whether OpenCV's parser, which calls itself for every level, would go deeper than any calibration: brackets, tags, or several `- ` or
/// `key: ` on one line.
bool is_deep(const std::string& bytes) {
  constexpr int kMaxDepth = 64;
  int brackets = 0, tags = 0, in_line = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const char c = bytes[i], next = i + 1 < bytes.size() ? bytes[i + 1] : '\0';
    if (c == '[' || c == '{') ++brackets;
    if (c == ']' || c == '}') --brackets;
    if (c == '<' && next != '?' && next != '!') tags += next == '/' ? -1 : 1;
    if (c == '/' && next == '>') --tags;
    if (c == '\n') in_line = 0;
    if ((c == '-' || c == ':') && (next == ' ' || next == '\t')) ++in_line;
    if (brackets > kMaxDepth || tags > kMaxDepth || in_line > kMaxDepth) return true;
  }
  return false;
}

/// Numbers of a value, of a list (of lists), or of an `opencv-matrix`, row by row; more than kMaxNumbers or anything else: empty.
std::vector<double> numbers_of(const cv::FileNode& node, int depth = 0) {
  std::vector<double> numbers;
  if (node.isInt() || node.isReal()) return {node.real()};
  if (node.isMap()) return depth == 0 ? numbers_of(node["data"], 1) : numbers;
  if (!node.isSeq() || node.size() > kMaxNumbers || depth > 2) return numbers;
  for (const cv::FileNode& element : node) {
    const std::vector<double> more = numbers_of(element, depth + 1);
    if (more.empty() || numbers.size() + more.size() > kMaxNumbers) return {};
    numbers.insert(numbers.end(), more.begin(), more.end());
  }
  return numbers;
}

class CalibrationFile {
 public:
  CalibrationFile(std::string file, const cv::FileStorage& storage) : file_(std::move(file)), storage_(storage) {}

  /// Numbers under the first of the names that is there. @param what  "nine numbers".
  [[nodiscard]] std::vector<double> numbers(std::initializer_list<const char*> names, std::initializer_list<std::size_t> counts,
                                            const std::string& what, const std::string& when_missing = "") const {
    for (const char* name : names) {
      const cv::FileNode node = storage_[name];
      if (node.empty()) continue;
      std::vector<double> found = numbers_of(node);
      const bool fits = std::find(counts.begin(), counts.end(), found.size()) != counts.end();
      if (!fits || !std::all_of(found.begin(), found.end(), [](double v) { return std::isfinite(v); })) {
        throw IoError(file_, std::string("`") + name + "` does not hold what it should; expected " + what);
      }
      return found;
    }
    throw IoError(file_, std::string("has no `") + *names.begin() + "`; expected " + what + when_missing);
  }

  [[nodiscard]] int size(const char* name) const {
    const double value = numbers({name}, {1}, "a number of pixels").front();
    if (!(value >= 1 && value <= 65536 && value == std::floor(value))) {
      throw IoError(file_, std::string("`") + name + "` is out of range; expected 1 to 65536 pixels");
    }
    return static_cast<int>(value);
  }

 private:
  std::string file_;
  const cv::FileStorage& storage_;
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
Eigen::Matrix3d rotation_of(const std::vector<double>& r) {
  if (r.size() == 9) return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(r.data());
  const Vec3 axis(r[0], r[1], r[2]);
  const double angle = axis.norm();
  return angle > 0 ? Eigen::AngleAxisd(angle, axis / angle).toRotationMatrix() : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
}

const char* const kMatrixShape = "[[fx, 0, cx], [0, fy, cy], [0, 0, 1]] in pixels";

CameraParameters parameters_of(const std::string& file, const cv::FileStorage& storage) {
  const CalibrationFile calibration(file, storage);
  CameraParameters p;
  p.width = calibration.size("image_width");
  p.height = calibration.size("image_height");
  if (!set_matrix(calibration.numbers({"camera_matrix"}, {9}, kMatrixShape), p)) {
    throw IoError(file, std::string("`camera_matrix` does not hold what it should; expected ") + kMatrixShape);
  }
  const std::string model = "k1 k2 p1 p2 k3 (0 where the lens has none)";
  if (!set_distortion(calibration.numbers({"distortion_coefficients", "dist_coeffs"}, {4, 5, 8, 12, 14}, model), p)) {
    throw IoError(file, "`distortion_coefficients` go beyond " + model + "; calibrate with that model");
  }
  const std::string pose = "; x_in_camera = rotation * x_in_world + translation, for instance from cv::solvePnP";
  p.rotation = rotation_of(calibration.numbers({"rotation", "R", "rvec"}, {9, 3}, "a 3 x 3 matrix, or an axis times an angle", pose));
  const std::vector<double> t = calibration.numbers({"translation", "T", "t", "tvec"}, {3}, "three numbers in the project's `unit`", pose);
  p.translation = {t[0], t[1], t[2]};
  return p;
}

/// Rows of numbers, or three numbers where `may_be_vector`.
std::vector<double> read_3x3(const JsonReader& json, bool may_be_vector) {
  const std::vector<JsonReader> rows = json.elements(kMaxNumbers);
  if (rows.size() != 3) json.fail(may_be_vector ? "three rows of three numbers, or an axis times an angle" : "three rows of three numbers");
  if (may_be_vector && rows[0].is_number()) return json.numbers(3);
  std::vector<double> numbers;
  for (const JsonReader& row : rows) {
    for (double v : row.numbers(3)) numbers.push_back(v);
  }
  return numbers;
}

/// What is wrong with the values, under the name of where they stand.
Camera make_camera(const std::string& where, const CameraParameters& p) {
  try {
    return Camera(p);
  } catch (const InvalidInput& e) {
    throw IoError(where, e.what());
  }
}

}  // namespace

Camera read_camera(const std::filesystem::path& path) {
  constexpr std::uint64_t kMaxBytes = std::uint64_t{1} << 20;
  const std::string bytes = read_file(path, kMaxBytes);
  CameraParameters parameters;
  try {
    if (is_deep(bytes)) throw cv::Exception();
    const SilentOpenCv silent;
    const cv::FileStorage storage(bytes, cv::FileStorage::READ | cv::FileStorage::MEMORY);
    if (!storage.isOpened()) throw cv::Exception();
    parameters = parameters_of(path.string(), storage);
  } catch (const cv::Exception&) {
    throw IoError(path.string(), "is no OpenCV calibration that can be read; expected YAML that begins with %YAML:1.0, or XML");
  }
  return make_camera(path.string(), parameters);
}

Camera read_camera(JsonReader json) {
  if (json.is_string()) return read_camera(json.path());
  if (!json.is_object()) json.fail("the path of an OpenCV calibration, or an object with width, height, matrix, distortion, rotation, translation");
  CameraParameters p;
  p.width = static_cast<int>(json.member("width").integer(between(1, 65536)));
  p.height = static_cast<int>(json.member("height").integer(between(1, 65536)));
  const JsonReader matrix = json.member("matrix");
  if (!set_matrix(read_3x3(matrix, false), p)) matrix.fail(kMatrixShape);
  if (json.has("distortion")) {
    const JsonReader distortion = json.member("distortion");
    (void)set_distortion(distortion.numbers(distortion.elements(kMaxNumbers).size() == 4 ? 4 : 5), p);
  }
  p.rotation = rotation_of(read_3x3(json.member("rotation"), true));
  const std::vector<double> t = json.member("translation").numbers(3);
  p.translation = {t[0], t[1], t[2]};
  json.finish();
  return make_camera(json.file() + ": " + json.pointer(), p);
}

}  // namespace patinate
