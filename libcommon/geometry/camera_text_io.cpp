#include "libcommon/geometry/camera_text_io.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "libcommon/core/text.h"
#include "libcommon/core/text_lines.h"
#include "libcommon/geometry/colmap_model.h"
#include "libcommon/geometry/dense_solve.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

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

/// What an image is looked up among.
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
