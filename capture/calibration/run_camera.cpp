#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <vector>

#include "capture/calibration/calibrate_kinds.h"
#include "capture/calibration/residual_picture.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "patinate/geometry/camera_io.h"
#include "patinate/geometry/mesh.h"
#include "patinate/image/image.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

namespace {

/// A flat target, or points of any shape.
struct CalibrationTarget {
  enum class Kind {
    Chessboard,  ///< Inner corners, row by row.
    Circles,     ///< Asymmetric grid of dark circles: every other row is shifted by half a step.
    Points,      ///< Given; not found in photographs.
  };
  Kind kind = Kind::Points;
  int columns = 0;  ///< Inner corners, or circles of a row; [2, 200].
  int rows = 0;
  double spacing_mm =
      0.0;  ///< Side of a square; for circles, distance of neighboring rows (half that of neighbors in a row); > 0.
  std::vector<Vec3> points_mm;  ///< Points of kind Points.

  /// Its points in its own frame, z = 0 for the two flat kinds. @throws InvalidInput if a number is out of range.
  [[nodiscard]] std::vector<Vec3> points() const;
  /// "chessboard of 9 x 6 inner corners".
  [[nodiscard]] std::string text() const;
};

/// Corners to a few hundredths of a pixel: where all gradients around point away from [Foerstner 1987], in a window of
/// a third of a square, in a picture so smooth that its gradients are those of the edges and not of the pixels. On
/// rendered boards 10 times as near as what the detectors give.
void refine_corners(const ImageF& gray, std::vector<cv::Point2f>& corners, int columns) {
  double spacing = 1e9;
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    if ((i + 1) % static_cast<std::size_t>(columns) != 0)
      spacing = std::min(spacing, cv::norm(corners[i + 1] - corners[i]));
  }
  for (std::size_t i = 0; i + static_cast<std::size_t>(columns) < corners.size(); ++i) {
    spacing = std::min(spacing, cv::norm(corners[i + static_cast<std::size_t>(columns)] - corners[i]));
  }
  const int window = std::clamp(static_cast<int>(std::lround(0.35 * spacing)), 2, 15);
  cv::Mat smooth(gray.height(), gray.width(), CV_32F);
  for (int y = 0; y < gray.height(); ++y) std::copy_n(gray.row(y).data(), gray.width(), smooth.ptr<float>(y));
  cv::GaussianBlur(smooth, smooth, {0, 0}, std::clamp(0.2 * window, 0.7, 2.0));
  const std::vector<cv::Point2f> start = corners;
  cv::cornerSubPix(smooth, corners, {window, window}, {-1, -1},
                   {cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 100, 1e-5});
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (!(cv::norm(corners[i] - start[i]) < 2.0)) corners[i] = start[i];
  }
}

std::vector<Vec3> CalibrationTarget::points() const {
  if (kind == Kind::Points) return points_mm;
  if (columns < 2 || rows < 2 || columns > 200 || rows > 200)
    throw InvalidInput("a target has 2 to 200 columns and rows");
  if (!(spacing_mm > 0) || !std::isfinite(spacing_mm)) throw InvalidInput("a target's spacing must be > 0");
  std::vector<Vec3> points;
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x)
      points.emplace_back(spacing_mm * (kind == Kind::Circles ? 2 * x + y % 2 : x), spacing_mm * y, 0.0);
  }
  return points;
}

std::string CalibrationTarget::text() const {
  if (kind == Kind::Points) return "list of " + std::to_string(points_mm.size()) + " points";
  const std::string size = std::to_string(columns) + " x " + std::to_string(rows);
  return kind == Kind::Chessboard ? "chessboard of " + size + " inner corners"
                                  : "asymmetric grid of " + size + " circles";
}

/// Pixels of target.points(), in their order, to a fraction of a pixel; nothing when the whole target is not seen.
/// A symmetric board may be found turned by half.
/// @param gray  H x W x 1, [0, 1], as encoded by the camera rather than linear: corners lie then in the middle of their
/// edges' codes.
std::optional<std::vector<Vec2>> find_target(const ImageF& gray, const CalibrationTarget& target) {
  if (target.kind == CalibrationTarget::Kind::Points || gray.empty() || gray.channels() != 1) return std::nullopt;
  cv::Mat codes(gray.height(), gray.width(), CV_8U);
  for (int y = 0; y < gray.height(); ++y) {
    for (int x = 0; x < gray.width(); ++x)
      codes.at<std::uint8_t>(y, x) = cv::saturate_cast<std::uint8_t>(255.0f * gray.at(x, y));
  }
  std::vector<cv::Point2f> found;
  const cv::Size size(target.columns, target.rows);
  bool is_found = false;
  try {
    if (target.kind == CalibrationTarget::Kind::Chessboard) {
      is_found = cv::findChessboardCornersSB(
          codes, size, found, cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_EXHAUSTIVE | cv::CALIB_CB_ACCURACY);
      if (!is_found) is_found = cv::findChessboardCorners(codes, size, found);
      if (is_found) refine_corners(gray, found, target.columns);
    } else {
      is_found = cv::findCirclesGrid(codes, size, found, cv::CALIB_CB_ASYMMETRIC_GRID);
    }
  } catch (const cv::Exception&) {
    return std::nullopt;
  }
  if (!is_found || found.size() != static_cast<std::size_t>(target.columns) * static_cast<std::size_t>(target.rows))
    return std::nullopt;
  std::vector<Vec2> pixels;
  for (const cv::Point2f& p : found) pixels.emplace_back(static_cast<double>(p.x), static_cast<double>(p.y));
  return pixels;
}

constexpr std::size_t kMaxViews = 1000;

CalibrationTarget read_target(JsonReader json, double mm_per_unit) {
  CalibrationTarget target;
  if (json.has("points")) {
    target.points_mm = read_points(json.member("points"), mm_per_unit);
    json.finish();
    return target;
  }
  const bool is_board = json.has("chessboard");
  if (!is_board && !json.has("circles"))
    json.fail("a target with `chessboard`: [columns, rows] of inner corners, `circles`: [columns, rows], or `points`");
  target.kind = is_board ? CalibrationTarget::Kind::Chessboard : CalibrationTarget::Kind::Circles;
  const JsonReader size = json.member(is_board ? "chessboard" : "circles");
  const std::vector<double> numbers = size.numbers(2, between(2, 200));
  if (numbers[0] != std::floor(numbers[0]) || numbers[1] != std::floor(numbers[1])) size.fail("two whole numbers");
  target.columns = static_cast<int>(numbers[0]), target.rows = static_cast<int>(numbers[1]);
  target.spacing_mm = mm_per_unit * json.member("spacing").number(above(0));
  json.finish();
  return target;
}

/// Size of the photographs, from the first or as given.
struct Size {
  int width = 0;
  int height = 0;
  void expect(int w, int h, const std::string& file) {
    if (width == 0) width = w, height = h;
    if (w != width || h != height)
      throw IoError(file,
                    "is " + size_text(w, h) + " pixels; expected " + size_text(width, height) + ", as the others");
  }
};

PointView read_view(JsonReader json, const std::optional<CalibrationTarget>& target, double mm_per_unit, Size& size) {
  PointView view;
  const bool is_path = json.is_string();
  if (is_path || json.has("photo")) {
    const std::filesystem::path photo = is_path ? json.path() : json.member("photo").path();
    view.name = photo.filename().string();
    const ImageF gray = read_gray(photo);
    size.expect(gray.width(), gray.height(), photo.string());
    if (!is_path && json.has("pixels")) view.pixels = read_pixels(json.member("pixels"));
    if (view.pixels.empty()) {
      if (!target || target->kind == CalibrationTarget::Kind::Points)
        json.fail("`pixels`, since the target is no chessboard or grid of circles");
      const auto found = find_target(gray, *target);
      if (!found)
        throw IoError(photo.string(),
                      "shows no " + target->text() + "; the whole target must be seen, sharp, with a light margin");
      view.pixels = *found;
    }
  } else {
    view.pixels = read_pixels(json.member("pixels"));
  }
  if (!is_path && json.has("points")) view.points_mm = read_points(json.member("points"), mm_per_unit);
  if (view.points_mm.empty()) {
    if (!target) json.fail("`points`, since there is no `target`");
    view.points_mm = target->points();
  }
  if (!is_path && json.has("name")) view.name = json.member("name").string();
  if (!is_path) json.finish();
  return view;
}

Json camera_report(const CameraCalibration& c) {
  Json report{{"status", calibration_status_text(c.status)},
              {"sigma_px", c.sigma_px},
              {"rms_px", c.rms_px},
              {"weakest", c.weakest}};
  Json names = Json::array();
  for (int i = 0; i < kNumCameraNumbers; ++i) {
    names.push_back(camera_number_name(i));
    report["sd"][camera_number_name(i)] = std::sqrt(c.covariance(i, i));
  }
  report["numbers"] = names;
  report["covariance"] = matrix_json(c.covariance);
  for (const auto& view : c.views) {
    report["views"].push_back({{"name", view.name},
                               {"points", view.num_points},
                               {"outliers", view.num_outliers},
                               {"rms_px", view.rms_px},
                               {"max_px", view.max_px}});
  }
  return report;
}

}  // namespace

CalibrationOutput run_camera(JsonReader& json, const CameraCalibrationOptions& options, const RunControl& control) {
  const double mm = read_mm_per_unit(json);
  std::optional<CalibrationTarget> target;
  if (json.has("target")) target = read_target(json.member("target"), mm);
  Size size;
  if (json.has("width") || json.has("height")) {
    size.width = static_cast<int>(json.member("width").integer(between(1, 65536)));
    size.height = static_cast<int>(json.member("height").integer(between(1, 65536)));
  }
  std::vector<PointView> views;
  if (json.has("views")) {
    for (const JsonReader& entry : json.member("views").elements(kMaxViews)) {
      control.throw_if_stopped();
      views.push_back(read_view(entry, target, mm, size));
    }
  }
  PointView scanner;
  if (json.has("scanner")) scanner = read_view(json.member("scanner"), std::nullopt, mm, size);
  json.finish();
  if (size.width == 0)
    throw IoError(json.file(),
                  "says nowhere how large the photographs are; expected `width` and `height`, or a `photo`");

  const CameraCalibration c = calibrate_camera(size.width, size.height, views, scanner, options, control);
  if (c.status != CalibrationStatus::Converged) {
    throw CannotComplete("the views leave the camera open (" + calibration_status_text(c.status) +
                         "; least known: " + c.weakest +
                         "); tilt the target by 20 to 40 degrees to all sides, or fit fewer lens terms (--lens)");
  }
  CalibrationOutput output;
  output.camera = Camera(c.camera);
  output.json = std::make_shared<Json>(result_json(CalibrationKind::Camera));
  (*output.json)["camera"] = json_of(*output.camera);
  (*output.json)["report"] = camera_report(c);
  const auto sd = [&](int i) { return short_number_text(rounded(std::sqrt(c.covariance(i, i)), 2)); };
  output.lines.push_back("fx " + short_number_text(c.camera.fx) + " +- " + sd(0) + ", fy " +
                         short_number_text(c.camera.fy) + " +- " + sd(1) + ", cx " + short_number_text(c.camera.cx) +
                         " +- " + sd(2) + ", cy " + short_number_text(c.camera.cy) + " +- " + sd(3) + " px; " +
                         short_number_text(rounded(c.rms_px, 3)) + " px rms over " + std::to_string(c.views.size()) +
                         " views");
  for (const auto& view : c.views) {
    if (view.num_outliers * 5 > view.num_points)
      output.lines.push_back(view.name + ": " + std::to_string(view.num_outliers) + " of " +
                             std::to_string(view.num_points) +
                             " points do not fit; are points and pixels in the same order?");
  }
  if (c.has_scanner_pose) {
    output.lines.push_back("stands within " + sd(12) + ", " + sd(13) + ", " + sd(14) + " mm (x, y, z of the camera)");
  } else {
    output.lines.push_back(
        "no `scanner` points: rotation and translation are those of the first view's target, not of the scanner");
  }
  if (c.has_scanner_pose) views.push_back(scanner);
  output.picture = view_residuals_picture(c, views);
  return output;
}

}  // namespace patinate::capture
