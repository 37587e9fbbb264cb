/// \file
/// The step of an ingest that measures color by a chart. Inside of ingest only.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "capture/chart/chart_fit.h"
#include "capture/timelapse/ingest_work.h"
#include "libcommon/job/job.h"
#include "patinate/history/history_value.h"

namespace patinate::capture {

/// Result of the chart, kept in the history's work: the camera, and every photograph's light.
inline constexpr const char* kChartFile = "survey/chart.json";

/// Result of the chart, loaded once.
struct ColorTable {
  std::mutex mutex;
  bool is_loaded = false;
  ChartCamera camera;
  std::map<int, ChartLight> lights;  ///< By the photograph's number.
  std::array<double, 3> deviation{};
};

/// @throws InvalidInput for what a chart cannot stand beside.
void check_chart(const IngestWork& work);
/// Adds the item that measures the chart, where the project names one. It stops with IoError where a photograph's chart
/// cannot be used (unless `missing` is "interpolate"), naming every such photograph and what is wrong; or where the
/// chart's colors are not those of its table.
void add_chart_item(std::vector<JobItem>& items, const std::shared_ptr<const IngestWork>& work);
/// Content of all that the colors of a frame depend on; "" without a chart.
[[nodiscard]] std::string chart_key(const IngestWork& work);
void add_chart_inputs(JobInputs& inputs, const IngestWork& work);

/// Makes a frame's photograph what the chart says that it shows: linear Rec. 709, D65. Nothing without a chart.
/// @param photo  As it was taken, before it is laid over another one. @returns Pixels of colors outside of Rec. 709.
std::int64_t apply_chart(const IngestWork& work, int index, const std::filesystem::path& folder, ImageF& photo);
/// Adds to a frame's standard deviations what the chart's colors are known by: deviation * (color + kChartFloor).
/// @param deviation  H x W x 3. @param color  The finished frame.
void add_chart_deviation(const IngestWork& work, const std::filesystem::path& folder, const ImageF& color,
                         ImageF& deviation);

/// Completes survey.json by `chart` and says what is to be warned of.
[[nodiscard]] std::vector<HistoryWarning> report_chart(const IngestWork& work, const std::filesystem::path& folder);

}  // namespace patinate::capture
