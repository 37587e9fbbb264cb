#include "libcommon/geometry/camera_text_io.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "libcommon/core/text_lines.h"
#include "libcommon/geometry/dense_solve.h"
#include "patinate/core/error.h"
#include "patinate/geometry/camera.h"

namespace patinate {

namespace fs = std::filesystem;

namespace {

constexpr const char* kColmapLensHelp =
    "expected SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL or OPENCV: undistort with `colmap image_undistorter`";

constexpr double kPixelCenter = 0.5;  ///< Center of COLMAP's first pixel.

/// A lens model of COLMAP: where its parameters go.
struct LensModel {
  std::string_view name;
  std::size_t num_focals;
  std::vector<int>
      distortion;  ///< Index into k1 k2 p1 p2 k3 of each parameter after the principal point; -1 must be 0.
};

const LensModel* lens_model(std::string_view name) {
  static const std::vector<LensModel> models{
      {"SIMPLE_PINHOLE", 1, {}}, {"PINHOLE", 2, {}},          {"SIMPLE_RADIAL", 1, {0}},
      {"RADIAL", 1, {0, 1}},     {"OPENCV", 2, {0, 1, 2, 3}}, {"FULL_OPENCV", 2, {0, 1, 2, 3, 4, -1, -1, -1}}};
  const auto found = std::find_if(models.begin(), models.end(), [&](const LensModel& m) { return m.name == name; });
  return found == models.end() ? nullptr : &*found;
}

/// By the numbers of binary models, with how many parameters each has.
struct NumberedModel {
  std::string_view name;
  std::size_t num_parameters;
};
constexpr std::array<NumberedModel, 12> kNumbered{{{"SIMPLE_PINHOLE", 3},
                                                   {"PINHOLE", 4},
                                                   {"SIMPLE_RADIAL", 4},
                                                   {"RADIAL", 5},
                                                   {"OPENCV", 8},
                                                   {"OPENCV_FISHEYE", 8},
                                                   {"FULL_OPENCV", 12},
                                                   {"FOV", 5},
                                                   {"SIMPLE_RADIAL_FISHEYE", 4},
                                                   {"RADIAL_FISHEYE", 5},
                                                   {"THIN_PRISM_FISHEYE", 12},
                                                   {"RAD_TAN_THIN_PRISM_FISHEYE", 16}}};

/// Little-endian numbers, one after the other.
class BinaryFile {
 public:
  explicit BinaryFile(const fs::path& path) : name_(path.string()), bytes_(read_file(path, std::uint64_t{1} << 31)) {}

  template <class T>
  T next() {
    static_assert(std::is_arithmetic_v<T>);
    T value{};
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
    return value;
  }
  std::string_view take(std::uint64_t size) {
    if (size > bytes_.size() - at_) fail("is cut off");
    const std::string_view part = std::string_view(bytes_).substr(at_, static_cast<std::size_t>(size));
    at_ += part.size();
    return part;
  }
  /// Up to the zero behind it.
  std::string_view text() {
    const std::size_t end = bytes_.find('\0', at_);
    if (end == std::string::npos) fail("is cut off");
    const std::string_view part = take(end - at_);
    ++at_;
    return part;
  }
  [[noreturn]] void fail(const std::string& problem) const { throw IoError(name_, problem); }

 private:
  std::string name_;
  std::string bytes_;
  std::size_t at_ = 0;
};

/// Number of parameters of a lens model that is read; 0 for another name.
std::size_t num_colmap_parameters(std::string_view model) {
  const LensModel* found = lens_model(model);
  return found == nullptr ? 0 : found->num_focals + 2 + found->distortion.size();
}

/// Sets focal lengths, principal point and distortion. COLMAP's pixel centers are at halves, ours at integers.
/// @param values  num_colmap_parameters(model) of them. @returns what is wrong; "" = nothing
std::string set_colmap_lens(std::string_view model, std::span<const double> values, CameraParameters& p) {
  const LensModel& lens = *lens_model(model);
  const std::size_t f = lens.num_focals;
  p.fx = values[0], p.fy = values[f - 1], p.cx = values[f] - kPixelCenter, p.cy = values[f + 1] - kPixelCenter;
  for (std::size_t i = 0; i < lens.distortion.size(); ++i) {
    const double k = values[f + 2 + i];
    const int index = lens.distortion[i];
    if (index >= 0) p.distortion[index] = k;
    if (index < 0 && k != 0) return "k4 k5 k6 of FULL_OPENCV are not read; expected 0: calibrate with OPENCV";
  }
  return "";
}

void read_camera_bin(const fs::path& path, std::uint32_t wanted, CameraParameters& p) {
  BinaryFile file(path);
  for (auto count = file.next<std::uint64_t>(); count > 0; --count) {
    const auto id = file.next<std::uint32_t>();
    const auto number = file.next<std::int32_t>();
    const auto width = file.next<std::uint64_t>(), height = file.next<std::uint64_t>();
    if (number < 0 || static_cast<std::size_t>(number) >= kNumbered.size())
      file.fail("has the lens model number " + std::to_string(number) + ", which is not known; " + kColmapLensHelp);
    const NumberedModel& model = kNumbered[number];
    std::vector<double> values;
    for (std::size_t i = 0; i < model.num_parameters; ++i) values.push_back(file.next<double>());
    if (id != wanted) continue;
    if (width < 1 || height < 1 || width > 65536 || height > 65536)
      file.fail("the size is out of range; expected 1 to 65536 pixels");
    if (num_colmap_parameters(model.name) == 0)
      file.fail("the lens model `" + std::string(model.name) + "` is not read; " + kColmapLensHelp);
    p.width = static_cast<int>(width), p.height = static_cast<int>(height);
    if (const std::string problem = set_colmap_lens(model.name, values, p); !problem.empty()) file.fail(problem);
    return;
  }
  file.fail("has no camera " + std::to_string(wanted) + ", which images.bin names");
}

/// Whether an image is meant: its name, or its last part; "" = any.
bool is_colmap_image(std::string_view name, const std::string& wanted) {
  return wanted.empty() || name == wanted || fs::path(name).filename() == wanted;
}

/// One image of a binary model: `images.bin` and the `cameras.bin` beside it.
/// @throws IoError naming the images there are, or the lens model that is not read.
CameraParameters read_colmap_binary(const std::filesystem::path& folder, const std::string& image) {
  BinaryFile file(folder / "images.bin");
  CameraParameters p;
  std::optional<std::uint32_t> camera;
  std::size_t num_found = 0;
  std::string some;
  for (auto count = file.next<std::uint64_t>(); count > 0; --count) {
    (void)file.next<std::uint32_t>();
    std::array<double, 7> v{};
    for (double& value : v) value = file.next<double>();
    const auto camera_id = file.next<std::uint32_t>();
    const std::string_view name = file.text();
    constexpr std::uint64_t kPointBytes = 24;
    const auto num_points = file.next<std::uint64_t>();
    if (num_points > (std::uint64_t{1} << 32)) file.fail("is damaged");
    (void)file.take(num_points * kPointBytes);
    if (some.size() < 120) some += (some.empty() ? "" : ", ") + std::string(name);
    if (!is_colmap_image(name, image)) continue;
    ++num_found;
    const Eigen::Quaterniond q(v[0], v[1], v[2], v[3]);
    if (!(std::abs(q.norm() - 1.0) <= 1e-3))
      file.fail("the quaternion of " + std::string(name) + " is not of length 1");
    p.rotation = q.normalized().toRotationMatrix();
    p.translation = {v[4], v[5], v[6]};
    camera = camera_id;
  }
  if (some.empty()) file.fail("holds no image");
  if (num_found == 0) file.fail("has no image `" + image + "`; expected one of " + some);
  if (num_found > 1) file.fail("has several images; expected \"image\": one of " + some);
  read_camera_bin(folder / "cameras.bin", *camera, p);
  return p;
}

namespace fs = std::filesystem;
using Line = TextLines::Line;

/// Numbers in words [first, first + count). @throws IoError naming the line.
std::vector<double> numbers_in(const TextLines& text, const Line& line, const std::vector<std::string_view>& words,
                               std::size_t first, std::size_t count, const std::string& what) {
  std::vector<double> numbers;
  for (std::size_t i = first; i < first + count && i < words.size(); ++i) {
    const std::optional<double> number = parse_number(words[i]);
    if (!number) text.fail(line, "`" + std::string(words[i].substr(0, 40)) + "` is no number; expected " + what);
    numbers.push_back(*number);
  }
  if (numbers.size() != count) text.fail(line, "ends too early; expected " + what);
  return numbers;
}

/// Up to five names for an error.
std::string some_of(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < std::min<std::size_t>(5, names.size()); ++i) text += (i == 0 ? "" : ", ") + names[i];
  return names.size() > 5 ? text + ", ... (" + std::to_string(names.size()) + ")" : text;
}

/// Lines that an image is looked up among.
class NamedLines {
 public:
  explicit NamedLines(std::string wanted) : wanted_(std::move(wanted)) {}
  void add(std::string_view name, const Line& line) {
    names_.emplace_back(name);
    if (is_colmap_image(name, wanted_)) found_.push_back(line);
  }
  [[nodiscard]] const Line& only(const TextLines& text) const {
    if (names_.empty()) throw IoError(text.file(), "holds no image");
    if (found_.empty())
      throw IoError(text.file(), "has no image `" + wanted_ + "`; expected one of " + some_of(names_));
    if (found_.size() > 1)
      throw IoError(text.file(), "has several images; expected \"image\": one of " + some_of(names_));
    return found_.front();
  }

 private:
  std::string wanted_;
  std::vector<std::string> names_;
  std::vector<Line> found_;
};

void read_lens(const fs::path& path, std::string_view camera_id, CameraParameters& p) {
  const TextLines text(path);
  for (const Line& line : text.lines()) {
    if (line.is_empty()) continue;
    const std::vector<std::string_view> words = words_of(line.text, 64);
    if (words[0] != camera_id) continue;
    if (words.size() < 4) text.fail(line, "expected CAMERA_ID MODEL WIDTH HEIGHT PARAMS");
    const std::size_t num_parameters = num_colmap_parameters(words[1]);
    if (num_parameters == 0) {
      text.fail(line, "the lens model `" + std::string(words[1].substr(0, 40)) + "` is not read; " + kColmapLensHelp);
    }
    const std::vector<double> size = numbers_in(text, line, words, 2, 2, "width and height");
    const auto is_size = [](double v) { return v >= 1 && v <= 65536 && v == std::floor(v); };
    if (!is_size(size[0]) || !is_size(size[1])) text.fail(line, "the size is out of range; expected 1 to 65536 pixels");
    p.width = static_cast<int>(size[0]), p.height = static_cast<int>(size[1]);
    const std::string model(words[1]);
    const std::vector<double> v = numbers_in(text, line, words, 4, num_parameters, "the parameters of " + model);
    if (const std::string problem = set_colmap_lens(model, v, p); !problem.empty()) text.fail(line, problem);
    return;
  }
  throw IoError(path.string(), "has no camera " + std::string(camera_id.substr(0, 40)) + ", which images.txt names");
}

/// The rotation nearest to one that is printed with few digits. @throws IoError
Eigen::Matrix3d nearest_rotation(const TextLines& text, const Line& line, const Eigen::Matrix3d& printed) {
  constexpr double kPrinted = 1e-3;
  if (!((printed * printed.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() <= kPrinted) ||
      printed.determinant() < 0) {
    text.fail(line, "R is no rotation; expected nine numbers, row by row");
  }
  return nearest_orthonormal(printed);
}

}  // namespace

CameraParameters read_colmap_camera(const fs::path& path, const std::string& image) {
  std::error_code error;
  const fs::path folder = fs::is_directory(path, error) ? path : path.parent_path();
  if (!fs::exists(folder / "images.txt", error) && fs::exists(folder / "images.bin", error))
    return read_colmap_binary(folder, image);
  const TextLines text(folder / "images.txt", std::uint64_t{1} << 30);
  NamedLines images(image);
  bool is_points_line = false;
  for (const Line& line : text.lines()) {
    // The second line of an image is skipped, empty or not.
    if (is_points_line) {
      is_points_line = false;
    } else if (!line.is_empty()) {
      const std::vector<std::string_view> words = words_of(line.text, 10);
      if (words.size() != 10) text.fail(line, "expected IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME");
      images.add(words[9], line);
      is_points_line = true;
    }
  }
  const Line& line = images.only(text);
  const std::vector<std::string_view> words = words_of(line.text, 10);
  const std::vector<double> v = numbers_in(text, line, words, 1, 7, "a quaternion and a translation");
  const Eigen::Quaterniond q(v[0], v[1], v[2], v[3]);
  if (!(std::abs(q.norm() - 1.0) <= 1e-3)) text.fail(line, "QW QX QY QZ is not of length 1");
  CameraParameters p;
  p.rotation = q.normalized().toRotationMatrix();
  p.translation = {v[4], v[5], v[6]};
  read_lens(folder / "cameras.txt", words[8], p);
  return p;
}

CameraParameters read_middlebury_camera(const fs::path& path, const std::string& image, int width, int height) {
  const TextLines text(path);
  NamedLines images(image);
  std::optional<double> count;
  double num_images = 0;
  for (const Line& line : text.lines()) {
    if (line.is_empty()) continue;
    if (!count) {
      count = parse_number(line.text);
      if (!count) text.fail(line, "expected the number of images first, as in Middlebury's _par.txt");
      continue;
    }
    images.add(words_of(line.text, 2)[0], line);
    ++num_images;
  }
  if (count && *count != num_images)
    throw IoError(text.file(), "says " + number_text(*count) + " images, but " + number_text(num_images) + " follow");
  const Line& line = images.only(text);
  const std::vector<double> v =
      numbers_in(text, line, words_of(line.text, 64), 1, 21, "k11 ... k33 r11 ... r33 t1 t2 t3");
  using Rows = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  const Rows k = Eigen::Map<const Rows>(v.data()) / (v[8] != 0 ? v[8] : 1.0);
  const double skew = std::max({std::abs(k(0, 1)), std::abs(k(1, 0)), std::abs(k(2, 0)), std::abs(k(2, 1))});
  if (!(skew == 0) || k(2, 2) != 1) text.fail(line, "K is not [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]");
  CameraParameters p;
  p.width = width, p.height = height;
  p.fx = k(0, 0), p.fy = k(1, 1), p.cx = k(0, 2), p.cy = k(1, 2);
  p.rotation = nearest_rotation(text, line, Eigen::Map<const Rows>(v.data() + 9));
  p.translation = {v[18], v[19], v[20]};
  return p;
}

}  // namespace patinate
