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

#include "libcommon/job/job_inputs.h"
#include "patinate/core/json.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/camera.h"
#include "patinate/image/image.h"

namespace patinate::datasets {

/// Object that all items of a plan need: made when the first asks for it, without progress, and shared.
template <class T>
class MadeOnce {
 public:
  explicit MadeOnce(std::function<T(const RunControl&)> make) : make_(std::move(make)) {}
  const T& get(const RunControl& control) {
    const std::lock_guard lock(mutex_);
    if (!made_) {
      made_ = std::make_unique<T>(make_(control.silent()));
    }
    return *made_;
  }

 private:
  std::function<T(const RunControl&)> make_;
  std::mutex mutex_;
  std::unique_ptr<T> made_;
};

/// A JSON file of a data set that is written when its items are done.
struct ProjectDocument {
  std::filesystem::path file;
  std::function<Json(const RunControl&)> make;
};
/// Plan of a data set, still without items. Its last document is the manifest, and says the plan's key.
[[nodiscard]] JobPlan plan_project(const JobInputs& inputs, const std::filesystem::path& output,
                                   std::vector<ProjectDocument> documents);
/// Plans a capture project with its truth: `capture.json` and `truth/truth.json`.
[[nodiscard]] JobPlan plan_capture(const JobInputs& inputs, const std::filesystem::path& output,
                                   std::function<Json(const RunControl&)> capture,
                                   std::function<Json(const RunControl&)> truth);
/// An item for each photograph, which makes these maps of the truth too. @param write  Of (frame, folder).
void add_frames(JobPlan& plan, int num_frames, const std::vector<std::string>& maps,
                const std::function<void(int, const std::filesystem::path&, const RunControl&)>& write);

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
/// The camera as `camera` of a capture project has it.
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
