#include "analysis/grading/grade_job.h"

#include <memory>

#include "analysis/grading/grade_report.h"
#include "analysis/grading/panel_mask.h"
#include "libcommon/core/text.h"
#include "libcommon/job/job_inputs.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"

namespace patinate::analysis {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kStageVersion = 3;  ///< Raised when the same input gives other figures.

JobInputs grade_inputs(const GradeTask& task, const SeriesFile& series) {
  JobInputs inputs("grade", kStageVersion);
  inputs.add_content("history", "the history", series.key());
  for (const auto& [name, corners] : task.polygons) {
    std::string text;
    for (const double c : corners) text += (text.empty() ? "" : ",") + number_text(c);
    inputs.add_value("--region " + name, text);
  }
  for (const auto& [name, file] : task.masks) inputs.add_file("--region " + name, file);
  if (task.scribe.is_wanted && task.scribe.given.empty()) inputs.add_value("--scribe", "auto");
  for (const Scribe& s : task.scribe.given) {
    std::string text;
    for (const double c : {s.x0, s.y0, s.x1, s.y1, s.width_mm}) text += (text.empty() ? "" : ",") + number_text(c);
    inputs.add_value("--scribe", text);
  }
  if (!task.labels.empty()) inputs.add_file("--labels", task.labels);
  if (!task.rules.empty()) inputs.add_file("--rules", task.rules);
  if (!task.limits.empty()) inputs.add_file("--limits", task.limits);
  inputs.add_options(option_values(task.options));
  return inputs;
}

std::vector<GradeRegion> regions_of(const GradeTask& task, const TextureSeries& series) {
  std::vector<GradeRegion> regions;
  for (const auto& [name, corners] : task.polygons) {
    if (!series.pixel_mm())
      throw InvalidInput("--region " + name + ": corners are in mm, and the size of a pixel of " + series.name() +
                         " is not known; give a mask, or state the scale when the history is made");
    regions.push_back({name, polygon_mask(series.width(), series.height(), *series.pixel_mm(), corners)});
  }
  for (const auto& [name, file] : task.masks) regions.push_back({name, read_mask(file)});
  return regions;
}

}  // namespace

JobPlan plan_grade(GradeTask task, const fs::path& output) {
  check_ranges(task.options);
  const auto series = std::make_shared<const SeriesFile>(open_series(task.history));
  const auto rules =
      std::make_shared<const GradeRules>(task.rules.empty() ? standard_grade_rules() : read_grade_rules(task.rules));
  if (task.scribe.is_wanted && !series->series.pixel_mm())
    throw InvalidInput("--scribe: its ends are in mm, and the size of a pixel of " + series->series.name() +
                       " is not known");
  const auto limits = std::make_shared<const std::vector<GradeLimit>>(
      task.limits.empty() ? std::vector<GradeLimit>{}
                          : read_grade_limits(task.limits, *rules, series->series.facts().time_unit));
  JobPlan plan = grade_inputs(task, *series).plan(output, kGradeReportFile);
  plan.parallel_items = false;
  plan.join = [task = std::move(task), series, rules, limits, key = plan.key](const fs::path& folder,
                                                                              const RunControl& control) {
    GradedSurface surface = grade_surface(series->series,
                                          {.regions = regions_of(task, series->series),
                                           .scribe = task.scribe,
                                           .rust = rules->rust,
                                           .labels = task.labels.empty() ? ImageU8() : read_mask(task.labels),
                                           .options = task.options},
                                          control);
    std::vector<LimitResult> results = check_limits(*limits, surface, *rules);
    write_grade_report(folder, {.series = *series,
                                .task = task,
                                .rules = *rules,
                                .surface = std::move(surface),
                                .limits = std::move(results),
                                .key = key});
  };
  return plan;
}

}  // namespace patinate::analysis
