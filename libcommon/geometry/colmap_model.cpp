#include "libcommon/geometry/colmap_model.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <type_traits>
#include <vector>

#include "libcommon/core/files.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

namespace fs = std::filesystem;

constexpr double kPixelCenter = 0.5;  ///< Of COLMAP's first pixel.

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

}  // namespace

std::size_t num_colmap_parameters(std::string_view model) {
  const LensModel* found = lens_model(model);
  return found == nullptr ? 0 : found->num_focals + 2 + found->distortion.size();
}

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

bool is_colmap_image(std::string_view name, const std::string& wanted) {
  return wanted.empty() || name == wanted || fs::path(name).filename() == wanted;
}

CameraParameters read_colmap_binary(const fs::path& folder, const std::string& image) {
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

}  // namespace patinate
