#include "app/fit/fit_captures.h"

#include <algorithm>

namespace patinate::app {

namespace fs = std::filesystem;

namespace {

/// Between the seeds of one capture and those of the next: a fit uses fewer.
constexpr std::uint64_t kSeedsOfCapture = 100'000;

}  // namespace

FitScene scene_of_capture(std::size_t capture, const fs::path& file, const std::vector<analysis::FitRange>& ranges,
                          const std::vector<std::string>& controls, const RunControl& control) {
  return FitScene(file, ranges, controls, control)
      .with_seed_shift(static_cast<std::uint64_t>(capture) * kSeedsOfCapture);
}

std::vector<analysis::FitParameter> joint_parameters(const std::vector<FitScene>& scenes,
                                                     const std::vector<analysis::FitRange>& ranges,
                                                     const std::vector<std::string>& names) {
  std::vector<analysis::FitParameter> parameters;
  for (std::size_t r = 0; r < ranges.size(); ++r) {
    if (!ranges[r].is_own) {
      parameters.push_back(scenes.front().parameters()[r]);
      continue;
    }
    for (std::size_t c = 0; c < scenes.size(); ++c) {
      analysis::FitParameter& p = parameters.emplace_back(scenes[c].parameters()[r]);
      p.capture = c;
      p.words = shown_name(p) + " (" + names[c] + ")";
    }
  }
  return parameters;
}

std::vector<std::string> capture_names(const std::vector<std::string>& given) {
  std::vector<std::string> names;
  for (const std::string& text : given) {
    const fs::path path = fs::path(text).lexically_normal();
    names.push_back((path.has_filename() ? path : path.parent_path()).filename().string());
  }
  std::vector<std::string> sorted = names;
  std::sort(sorted.begin(), sorted.end());
  return std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end() ? names : given;
}

std::vector<std::string> add_captures(analysis::FitTask& task, const std::vector<FitSource>& sources,
                                      const std::vector<analysis::FitRange>& ranges, const fs::path& output,
                                      const RunControl& control) {
  std::vector<FitScene> scenes;
  for (std::size_t c = 0; c < sources.size(); ++c) {
    const FitSource& source = sources[c];
    std::vector<std::string> controls;
    const analysis::TextureSeries series = analysis::open_series(source.history).series;
    for (const ControlFacts& f : series.facts().controls) controls.push_back(f.name);
    const FitScene scene = scene_of_capture(c, source.scene, ranges, controls, control);
    scenes.push_back(scene);
    task.captures.push_back({.history = source.history,
                             .name = source.name,
                             .outline = scene.outline(),
                             .age = scene.age(),
                             .write_model = [scene, output](const fs::path& folder, const std::string& file,
                                                            const std::vector<double>& values) {
                               scene.write(folder, file, output, values);
                             }});
  }
  std::vector<std::string> names;
  for (const FitSource& s : sources) names.push_back(s.name);
  task.parameters = joint_parameters(scenes, ranges, names);
  task.model_name = scenes.front().outline().name;
  const bool is_one_scene =
      std::all_of(sources.begin(), sources.end(), [&](const FitSource& s) { return s.scene == sources.front().scene; });
  task.add_inputs = [scenes, is_one_scene](JobInputs& inputs) {
    for (std::size_t c = 0; c < (is_one_scene ? 1 : scenes.size()); ++c) scenes[c].add_inputs(inputs);
  };
  return scenes.front().notes();
}

}  // namespace patinate::app
