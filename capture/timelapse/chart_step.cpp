#include "capture/timelapse/chart_step.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "capture/chart/find_chart.h"
#include "capture/chart/judge_chart.h"
#include "capture/timelapse/align_step.h"
#include "capture/timelapse/chart_report.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kChartVersion = 1;

/// The photograph that shows the chart of a frame.
const CapturePhoto& chart_photo(const CaptureProject& project, std::size_t index) {
  const CapturePhoto& frame = project.frames[index];
  // Frames that cannot be aligned may have been left out since.
  for (const CapturePhoto& photo : project.chart->photos) {
    if (photo.number == frame.number) return photo;
  }
  return frame;
}

ChartSight look_at(const CaptureProject& project, std::size_t index) {
  const ChartSettings& chart = *project.chart;
  const CapturePhoto& photo = chart_photo(project, index);
  const ImageF linear = read_whole_photo(project, photo);
  const ChartPlace place = chart.corners ? place_chart(*chart.corners) : find_chart(linear, chart.table);
  if (!place.photo_from_chart) return {.problem = place.problem};
  const SaturationPhoto sensor = saturation_photo(project, photo, linear);
  return measure_chart(linear, {.photo = &sensor.photo, .level = sensor.level, .has_codes = photo.has_codes},
                       *place.photo_from_chart, chart.table);
}

/// Chart in all photographs.
struct SeriesChart {
  std::vector<ChartSight> sights;
  std::vector<std::size_t> used;  ///< Those without problems.
  ChartFit fit;                   ///< Fit of `used`.
};

ChartFit fit_used(SeriesChart& series, const ChartTable& table) {
  series.used.clear();
  std::vector<ChartSight> sights;
  for (std::size_t i = 0; i < series.sights.size(); ++i) {
    if (!series.sights[i].problem.empty()) continue;
    series.used.push_back(i);
    sights.push_back(series.sights[i]);
  }
  return sights.empty() ? ChartFit{} : fit_chart(sights, table);
}

/// @throws IoError
void refuse_problems(const CaptureProject& project, const SeriesChart& series) {
  if (!series.used.empty() && project.chart->interpolates) return;
  std::string first, others;
  int num_others = 0;
  for (std::size_t i = 0; i < series.sights.size(); ++i) {
    if (series.sights[i].problem.empty()) continue;
    const CapturePhoto& photo = chart_photo(project, i);
    if (first.empty()) {
      first = photo.name() + " " + series.sights[i].problem;
      continue;
    }
    constexpr int kMost = 8;
    if (++num_others <= kMost) others += "; " + photo.name() + " " + series.sights[i].problem;
  }
  if (first.empty()) return;
  throw IoError(project.file.string(),
                "`chart`: " + first + others +
                    (series.used.empty() ? "; no photograph is left"
                                         : "; take them again, `exclude` them, or give \"missing\": \"interpolate\" in "
                                           "`chart`, by which they take their light from those before and after"));
}

/// Between the photographs before and after it whose chart is used: logarithms of gains by time.
ChartLight photo_light(const CaptureProject& project, const SeriesChart& series, std::size_t index) {
  const auto after = std::lower_bound(series.used.begin(), series.used.end(), index);
  const auto light = [&](auto at) { return series.fit.lights[static_cast<std::size_t>(at - series.used.begin())]; };
  if (after == series.used.end()) return light(after - 1);
  if (*after == index || after == series.used.begin()) return light(after);
  const double from = project.frames[*(after - 1)].time, to = project.frames[*after].time;
  const double share = (project.frames[index].time - from) / (to - from);
  const ChartLight a = light(after - 1), b = light(after);
  const auto between_them = [share](double x, double y) { return (1.0 - share) * x + share * y; };
  ChartLight mixed{.slope_x = between_them(a.slope_x, b.slope_x),
                   .slope_y = between_them(a.slope_y, b.slope_y),
                   .radius2 = between_them(a.radius2, b.radius2)};
  for (std::size_t c = 0; c < 3; ++c) mixed.gain[c] = std::exp(between_them(std::log(a.gain[c]), std::log(b.gain[c])));
  return mixed;
}

Json light_json(const ChartLight& light) {
  return {{"gain", light.gain}, {"slope", {light.slope_x, light.slope_y}}, {"radius2", light.radius2}};
}

Json camera_json(const ChartCamera& camera) {
  Json responses = Json::array();
  for (const ChannelResponse& r : camera.response)
    responses.push_back({{"middle", r.middle}, {"low", r.low}, {"high", r.high}, {"bend", r.bend}});
  return {{"response", responses},
          {"sensor", camera.sensor},
          {"color", camera.color},
          {"vignetting", optional_json(camera.vignetting)}};
}

Json chart_json(const CaptureProject& project, const SeriesChart& series) {
  const std::vector<std::string> names = photo_names(project.frames);
  Json photos = Json::array();
  for (std::size_t i = 0; i < series.sights.size(); ++i) {
    ChartLight light = photo_light(project, series, i);
    const CapturePhoto& shows = chart_photo(project, i);
    // A photograph of the chart alone may be exposed otherwise than the frame.
    const double there = shows.exposure.amount(), here = project.frames[i].exposure.amount();
    for (double& gain : light.gain) gain *= there > 0.0 && here > 0.0 ? there / here : 1.0;
    Json entry{{"photo", names[i]}, {"number", project.frames[i].number}};
    if (!project.chart->photos.empty()) entry["chart"] = shows.name();
    const auto used = std::lower_bound(series.used.begin(), series.used.end(), i);
    if (used != series.used.end() && *used == i) {
      const ChartResidual& residual = series.fit.residuals[static_cast<std::size_t>(used - series.used.begin())];
      entry["mean_ciede2000"] = residual.mean;
      entry["worst_ciede2000"] = residual.worst;
      entry["worst_patch"] = project.chart->table[residual.worst_patch].name;
    } else {
      entry["problem"] = series.sights[i].problem;
    }
    entry["light"] = light_json(light);
    photos.push_back(std::move(entry));
  }
  return {{"camera", camera_json(series.fit.camera)}, {"deviation", series.fit.deviation}, {"photos", photos}};
}

void measure_charts(const IngestWork& work, const fs::path& folder, const RunControl& control) {
  const CaptureProject& project = work.project;
  const ChartTable& table = project.chart->table;
  SeriesChart series;
  series.sights.resize(project.frames.size());
  parallel_for(static_cast<std::int64_t>(series.sights.size()), 1, control, [&](std::int64_t begin, std::int64_t) {
    series.sights[static_cast<std::size_t>(begin)] = look_at(project, static_cast<std::size_t>(begin));
  });
  series.fit = fit_used(series, table);
  bool is_any_wrong = false;
  for (std::size_t k = 0; k < series.used.size(); ++k) {
    std::string& problem = series.sights[series.used[k]].problem;
    problem = judge_chart(series.fit, k, table);
    is_any_wrong = is_any_wrong || !problem.empty();
  }
  if (is_any_wrong) series.fit = fit_used(series, table);  // Without what is hidden.
  refuse_problems(project, series);
  if (series.fit.status == ChartFitStatus::NoResponse)
    throw IoError(
        project.file.string(),
        "`chart`: codes do not rise with the light of its patches; give the `response` of the photographs, or "
        "photographs without effects");
  save_json(folder / kChartFile, chart_json(project, series));
}

ColorTable& color_table(const IngestWork& work, const fs::path& folder) {
  ColorTable& table = *work.colors;
  const std::lock_guard lock(table.mutex);
  if (table.is_loaded) return table;
  const Json json = load_json(folder / kChartFile);
  const Json& camera = json.at("camera");
  for (std::size_t c = 0; c < 3; ++c) {
    const Json& r = camera.at("response").at(c);
    table.camera.response[c] = {.middle = r.at("middle").get<double>(),
                                .low = r.at("low").get<double>(),
                                .high = r.at("high").get<double>(),
                                .bend = r.at("bend").get<Color3>()};
  }
  table.camera.sensor = camera.at("sensor").get<Matrix3>();
  table.camera.color = camera.at("color").get<Matrix3>();
  if (!camera.at("vignetting").is_null()) table.camera.vignetting = camera.at("vignetting").get<double>();
  for (const Json& photo : json.at("photos")) {
    const Json& light = photo.at("light");
    table.lights[photo.at("number").get<int>()] = {.gain = light.at("gain").get<Color3>(),
                                                   .slope_x = light.at("slope").at(0).get<double>(),
                                                   .slope_y = light.at("slope").at(1).get<double>(),
                                                   .radius2 = light.at("radius2").get<double>()};
  }
  table.deviation = json.at("deviation").get<Color3>();
  table.is_loaded = true;
  return table;
}

}  // namespace

void check_chart(const IngestWork& work) {
  const CaptureProject& project = work.project;
  if (!project.chart) return;
  const std::string file = project.file.string();
  if (project.reference_patch)
    throw InvalidInput(file + ": `chart` measures what `reference_patch` keeps; leave one of the two out");
  if (work.options.repair.deflicker)
    throw InvalidInput(file + ": --deflicker guesses what `chart` measures; leave one of the two out");
  if (project.rig)
    throw InvalidInput(file + ": `lights` and `chart` both say how bright the surface is; leave one of the two out");
  if (project.is_handheld() && project.chart->corners && project.chart->photos.empty())
    throw InvalidInput(file +
                       ": `corners` of a `chart` are for a camera that stands still; leave them out: in "
                       "photographs from the hand it is looked for");
}

void add_chart_item(std::vector<JobItem>& items, const std::shared_ptr<const IngestWork>& work) {
  if (!work->project.chart) return;
  items.push_back(
      {.name = "chart",
       .outputs = {kChartFile},
       .run =
           [work](const fs::path& folder, const RunControl& control) {
             measure_charts(*work, folder, control);
             control.report(1.0);
           },
       .key = chart_key(*work),
       .stage = needs_alignment(*work) ? 1 : 0,
       // Core seconds: the search reduces photographs to one size, then looks at that.
       .weight = 0.2 * static_cast<double>(work->project.frames.size()) + 7e-8 * num_photo_pixels(work->project)});
}

std::string chart_key(const IngestWork& work) {
  const CaptureProject& project = work.project;
  if (!project.chart) return "";
  const ChartSettings& chart = *project.chart;
  ContentHash hash;
  hash.add("chart").add(kChartVersion).add(project.response.text()).add(std::int64_t{chart.interpolates});
  for (const ChartPatch& patch : chart.table) {
    hash.add(patch.name).add(patch.x).add(patch.y);
    for (const double v : patch.lab) hash.add(v);
  }
  if (chart.corners) {
    for (const Eigen::Vector2d& corner : *chart.corners) hash.add(corner.x()).add(corner.y());
  }
  for (std::size_t i = 0; i < project.frames.size(); ++i) hash.add(work.photo_keys[i]).add(project.frames[i].time);
  for (const std::string& key : work.chart_photo_keys) hash.add(key);
  return hash.hex();
}

void add_chart_inputs(JobInputs& inputs, const IngestWork& work) {
  if (work.project.chart) inputs.add_value("chart", chart_key(work));
}

std::int64_t apply_chart(const IngestWork& work, int index, const fs::path& folder, ImageF& photo) {
  if (!work.project.chart) return 0;
  const ColorTable& table = color_table(work, folder);
  return apply_chart(table.camera, table.lights.at(work.project.frames[index].number), photo);
}

void add_chart_deviation(const IngestWork& work, const fs::path& folder, const ImageF& color, ImageF& deviation) {
  if (!work.project.chart) return;
  const ColorTable& table = color_table(work, folder);
  for (std::int64_t i = 0; i < 3 * color.num_pixels(); ++i) {
    const double known = table.deviation[static_cast<std::size_t>(i % 3)] *
                         (std::max(0.0, static_cast<double>(color.data()[i])) + kChartFloor);
    deviation.data()[i] = static_cast<float>(std::hypot(static_cast<double>(deviation.data()[i]), known));
  }
}

std::vector<HistoryWarning> report_chart(const IngestWork& work, const fs::path& folder) {
  if (!work.project.chart) return {};
  const Json chart = load_json(folder / kChartFile);
  if (fs::exists(folder / kSurveyFile)) {
    Json survey = load_json(folder / kSurveyFile);
    survey["chart"] = chart;
    save_json(folder / kSurveyFile, survey);
  }
  return chart_warnings(chart);
}

}  // namespace patinate::capture
