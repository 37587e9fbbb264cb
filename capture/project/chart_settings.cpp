#include "capture/project/chart_settings.h"

#include <string_view>

#include "capture/chart/find_chart.h"
#include "libcommon/core/files.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

constexpr std::array<std::string_view, 3> kChartMethods{"project", "off", "auto"};
constexpr std::array<std::string_view, 2> kEditions{"since 2014", "before 2014"};
constexpr std::array<std::string_view, 2> kWhites{"D50", "D65"};
constexpr std::array<std::string_view, 2> kMissing{"error", "interpolate"};

std::array<Eigen::Vector2d, 4> read_corners(const JsonReader& json) {
  const std::vector<JsonReader> points = json.elements(4);
  std::array<Eigen::Vector2d, 4> corners;
  if (points.size() != 4) json.fail("four corners [x, y]: of the first patch, then clockwise");
  for (std::size_t i = 0; i < 4; ++i) {
    const std::vector<double> at = points[i].numbers(2, between(-65536, 65536));
    corners[i] = {at[0], at[1]};
  }
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d a = corners[(i + 1) % 4] - corners[i], b = corners[(i + 2) % 4] - corners[(i + 1) % 4];
    if (std::abs(a.x() * b.y() - a.y() * b.x()) < 1.0) json.fail("four corners, no three of them on a line");
  }
  const ChartPlace place = place_chart(corners);
  if (!place.problem.empty()) json.fail("the corners clockwise as the photograph shows them, from the first patch on");
  return corners;
}

/// Photographs of the chart: number i belongs to image number i of `frames`.
std::vector<CapturePhoto> read_photos(const JsonReader& json, int num_images, const std::vector<CapturePhoto>& frames) {
  const fs::path pattern = json.path();
  const std::vector<fs::path> found = list_files(pattern.parent_path(), pattern.filename().string());
  if (static_cast<int>(found.size()) != num_images)
    json.fail("a pattern that matches a photograph of the chart for each of the " + std::to_string(num_images) +
              " images that `frames` lists; " + pattern.string() + " matches " + std::to_string(found.size()));
  std::vector<CapturePhoto> photos;
  for (const CapturePhoto& frame : frames) {
    const fs::path& file = found[static_cast<std::size_t>(frame.number)];
    const ImageInfo info = probe_image(file);
    if (info.num_frames != 1) json.fail("photographs; " + file.string() + " holds several images");
    if (!info.color_problem.empty()) throw IoError(file.string(), info.color_problem);
    photos.push_back(photo_of(file, info));
    photos.back().number = frame.number;
    photos.back().time = frame.time;
  }
  return photos;
}

ChartTable read_table(JsonReader& json) {
  if (json.has("table")) {
    if (json.has("edition")) json.member("edition").fail("no `edition` beside a `table`, which has values of its own");
    return read_chart_table(json.member("table").path(), static_cast<ChartWhite>(json.member("white").choice(kWhites)));
  }
  if (json.has("white")) json.member("white").fail("no `white` without a `table`");
  const bool is_given = json.has("edition");
  return classic_chart(is_given ? static_cast<ChartEdition>(json.member("edition").choice(kEditions))
                                : ChartEdition::Since2014);
}

}  // namespace

void describe(OptionVisitor& v, ChartOptions& o) {
  v.visit_choice({"chart",
                  "Color by a chart of 24 patches that every photograph shows; `project`: as `chart` of capture.json "
                  "says, else off"},
                 o.method, kChartMethods);
}

std::optional<ChartSettings> read_chart_settings(JsonReader& project, const ChartOptions& options, int num_images,
                                                 const std::vector<CapturePhoto>& frames) {
  std::optional<ChartSettings> settings;
  if (project.has("chart")) {
    JsonReader json = project.member("chart");
    if (!json.is_object() && !(json.is_string() && json.string() == "auto")) json.fail("\"auto\" or an object");
    if (json.is_object()) {
      settings.emplace(ChartSettings{.table = read_table(json)});
      if (json.has("corners")) settings->corners = read_corners(json.member("corners"));
      if (!settings->corners && !is_classic_layout(settings->table))
        json.fail("`corners`: only a table of 24 patches in 6 columns and 4 rows can be looked for");
      if (json.has("photos")) settings->photos = read_photos(json.member("photos"), num_images, frames);
      settings->interpolates = json.has("missing") && json.member("missing").choice(kMissing) == 1;
      json.finish();
    } else {
      settings.emplace(ChartSettings{.table = classic_chart(ChartEdition::Since2014)});
    }
  }
  if (options.method == ChartOptions::Method::Off) return std::nullopt;
  if (options.method == ChartOptions::Method::Auto && !settings)
    settings.emplace(ChartSettings{.table = classic_chart(ChartEdition::Since2014)});
  return settings;
}

}  // namespace patinate::capture
