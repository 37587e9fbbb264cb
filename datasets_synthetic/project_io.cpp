#include "datasets_synthetic/project_io.h"

#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>

#include "patinate/datasets/crackle.h"
#include "patinate/image/image_io.h"

namespace patinate::datasets {

namespace fs = std::filesystem;

std::string digits(int index, int count) {
  char text[16];
  std::snprintf(text, sizeof(text), "%0*d", count, index);
  return text;
}

fs::path photo_file(int index) { return fs::path("frames") / (digits(index) + ".png"); }
fs::path truth_file(const std::string& name, int index) { return fs::path("truth") / name / (digits(index) + ".exr"); }

JobPlan plan_project(const JobInputs& inputs, const fs::path& output, std::vector<ProjectDocument> documents) {
  JobPlan plan = inputs.plan(output, documents.back().file.generic_string());
  plan.join = [documents = std::move(documents), key = plan.key](const fs::path& folder, const RunControl& control) {
    for (const ProjectDocument& document : documents) {
      Json json = document.make(control);
      if (&document == &documents.back()) json["key"] = key;
      save_json(folder / document.file, json);
    }
  };
  return plan;
}

JobPlan plan_capture(const JobInputs& inputs, const fs::path& output, std::function<Json(const RunControl&)> capture,
                     std::function<Json(const RunControl&)> truth) {
  return plan_project(inputs, output, {{"capture.json", std::move(capture)}, {"truth/truth.json", std::move(truth)}});
}

void add_frames(JobPlan& plan, int num_frames, const std::vector<std::string>& maps,
                const std::function<void(int, const fs::path&, const RunControl&)>& write) {
  for (int i = 0; i < num_frames; ++i) {
    JobItem item{.name = "frame-" + digits(i),
                 .outputs = {photo_file(i)},
                 .run = [write, i](const fs::path& folder, const RunControl& control) { write(i, folder, control); }};
    for (const std::string& map : maps) item.outputs.push_back(truth_file(map, i));
    plan.items.push_back(std::move(item));
  }
}

void save_photograph(const fs::path& file, const ImageF& linear, double noise, std::int64_t seed, int picture) {
  fs::create_directories(file.parent_path());
  write_codes(file, photograph(linear, noise, seed, picture));
}

void save_truth_map(const fs::path& file, const ImageF& values, const std::string& key) {
  static const std::array<std::vector<std::string>, 3> kChannels{{{"Y"}, {"strength", "roughness"}, {"R", "G", "B"}}};
  fs::create_directories(file.parent_path());
  write_exr(file, values, kChannels.at(static_cast<std::size_t>(values.channels() - 1)), ExrDepth::Float, key);
}

Json vector_json(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

Json matrix_json(const Eigen::MatrixXd& m) {
  Json rows = Json::array();
  for (Eigen::Index r = 0; r < m.rows(); ++r) {
    rows.push_back(Json::array());
    for (Eigen::Index c = 0; c < m.cols(); ++c) rows.back().push_back(m(r, c));
  }
  return rows;
}

Json camera_json(const Camera& camera) {
  const CameraParameters& p = camera.parameters();
  Eigen::Matrix3d matrix;
  matrix << p.fx, 0.0, p.cx, 0.0, p.fy, p.cy, 0.0, 0.0, 1.0;
  return {{"width", p.width},
          {"height", p.height},
          {"matrix", matrix_json(matrix)},
          {"distortion", p.distortion},
          {"rotation", matrix_json(p.rotation)},
          {"translation", vector_json(p.translation)}};
}

Json fixed_capture(const std::string& name, const std::string& time_unit) {
  return {{"format", "patinate.capture"}, {"version", 1},      {"name", name}, {"kind", "fixed"},
          {"time_unit", time_unit},       {"response", "srgb"}};
}

Json truth_header(const std::string& kind, const std::vector<std::pair<std::string, std::string>>& options) {
  Json json{{"format", "patinate.synthetic"}, {"version", 1}, {"kind", kind}};
  for (const auto& [name, value] : options) json["options"][name] = value;
  return json;
}

Json truth_frames(int num_frames, double interval, std::initializer_list<const char*> maps) {
  Json frames = Json::array();
  for (int i = 0; i < num_frames; ++i) {
    Json frame{{"time", i * interval}};
    for (const char* map : maps) frame[map] = truth_file(map, i).lexically_relative("truth").generic_string();
    frames.push_back(std::move(frame));
  }
  return frames;
}

}  // namespace patinate::datasets
