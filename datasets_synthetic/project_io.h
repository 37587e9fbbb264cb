/// \file
/// What the data sets that are capture projects share: names of files, photographs, and JSON of what stands in them.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "patinate/core/json.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/camera.h"
#include "patinate/image/image.h"

namespace patinate::datasets {

/// What all items of a plan need: made when the first asks for it, without progress, and shared.
template <class T>
class MadeOnce {
 public:
  explicit MadeOnce(std::function<T(const RunControl&)> make) : make_(std::move(make)) {}
  const T& get(const RunControl& control) {
    const std::lock_guard lock(mutex_);
    if (!made_) {
      RunControl quiet = control;
      quiet.on_progress = nullptr;
      made_ = std::make_unique<T>(make_(quiet));
    }
    return *made_;
  }

 private:
  std::function<T(const RunControl&)> make_;
  std::mutex mutex_;
  std::unique_ptr<T> made_;
};

/// "0007" for 7 and four digits.
[[nodiscard]] std::string digits(int index, int count = 4);
/// frames/0007.png
[[nodiscard]] std::filesystem::path photo_file(int index);
/// truth/NAME/0007.exr
[[nodiscard]] std::filesystem::path truth_file(const std::string& name, int index);

/// 8-bit sRGB PNG of a linear image, as photograph() makes it; the folder is made.
void save_photograph(const std::filesystem::path& file, const ImageF& linear, double noise, std::int64_t seed,
                     int picture);
/// Float EXR of 1 (Y), 2 (strength, roughness) or 3 (R, G, B) channels; the folder is made.
void save_truth_map(const std::filesystem::path& file, const ImageF& values, const std::string& key = "");

[[nodiscard]] Json vector_json(const Vec3& v);
/// Rows of a matrix.
[[nodiscard]] Json matrix_json(const Eigen::MatrixXd& m);
/// As `camera` of a capture project has it.
[[nodiscard]] Json camera_json(const Camera& camera);

/// capture.json of a fixed camera, without `frames`.
[[nodiscard]] Json fixed_capture(const std::string& name, const std::string& time_unit);
/// truth.json: format, version, kind and options. @param options  option_values().
[[nodiscard]] Json truth_header(const std::string& kind,
                                const std::vector<std::pair<std::string, std::string>>& options);
/// `frames` of truth.json: the time of each, and its maps relative to that file. @param interval  In the capture's
/// unit.
[[nodiscard]] Json truth_frames(int num_frames, double interval, std::initializer_list<const char*> maps);

}  // namespace patinate::datasets
