#include "capture/chart/chart_table.h"

#include <cmath>
#include <optional>

#include "capture/chart/unclamped_lab.h"
#include "libcommon/core/text.h"
#include "libcommon/core/text_lines.h"
#include "libcommon/image/color_matrix.h"
#include "patinate/core/error.h"
#include "patinate/metrics/difference.h"

namespace patinate::capture {

namespace {

using Lab = std::array<double, 3>;

struct PublishedPatch {
  const char* name;
  Lab since_2014, before_2014;  ///< D50, 2 degrees.
};

// [X-Rite 2016], "New color specifications for ColorChecker SG and Classic charts".
constexpr std::array<PublishedPatch, 24> kClassic{{
    {"dark skin", {37.54, 14.37, 14.92}, {37.986, 13.555, 14.059}},
    {"light skin", {64.66, 19.27, 17.50}, {65.711, 18.130, 17.810}},
    {"blue sky", {49.32, -3.82, -22.54}, {49.927, -4.880, -21.905}},
    {"foliage", {43.46, -12.74, 22.72}, {43.139, -13.095, 21.905}},
    {"blue flower", {54.94, 9.61, -24.79}, {55.112, 8.844, -25.399}},
    {"bluish green", {70.48, -32.26, -0.37}, {70.719, -33.397, -0.199}},
    {"orange", {62.73, 35.83, 56.50}, {62.661, 36.067, 57.096}},
    {"purplish blue", {39.43, 10.75, -45.17}, {40.020, 10.410, -45.964}},
    {"moderate red", {50.57, 48.64, 16.67}, {51.124, 48.239, 16.248}},
    {"purple", {30.10, 22.54, -20.87}, {30.325, 22.976, -21.587}},
    {"yellow green", {71.77, -24.13, 58.19}, {72.532, -23.709, 57.255}},
    {"orange yellow", {71.51, 18.24, 67.37}, {71.941, 19.363, 67.857}},
    {"blue", {28.37, 15.42, -49.80}, {28.778, 14.179, -50.297}},
    {"green", {54.38, -39.72, 32.27}, {55.261, -38.342, 31.370}},
    {"red", {42.43, 51.05, 28.62}, {42.101, 53.378, 28.190}},
    {"yellow", {81.80, 2.67, 80.41}, {81.733, 4.039, 79.819}},
    {"magenta", {50.63, 51.28, -14.12}, {51.935, 49.986, -14.574}},
    {"cyan", {49.57, -29.71, -28.32}, {51.038, -28.631, -28.638}},
    {"white 9.5", {95.19, -1.03, 2.93}, {96.539, -0.425, 1.186}},
    {"neutral 8", {81.29, -0.57, 0.44}, {81.257, -0.638, -0.335}},
    {"neutral 6.5", {66.89, -0.75, -0.06}, {66.766, -0.734, -0.504}},
    {"neutral 5", {50.76, -0.13, 0.14}, {50.867, -0.153, -0.270}},
    {"neutral 3.5", {35.63, -0.46, -0.48}, {35.656, -0.421, -1.231}},
    {"black 2", {20.64, 0.07, -0.46}, {20.461, -0.079, -0.973}},
}};

Lab xyz_from_lab(const Lab& lab, const std::array<double, 3>& white) {
  const double fy = (lab[0] + 16.0) / 116.0;
  const std::array<double, 3> f{fy + lab[1] / 500.0, fy, fy - lab[2] / 200.0};
  Lab xyz{};
  for (std::size_t i = 0; i < 3; ++i)
    xyz[i] = white[i] * (f[i] > 6.0 / 29.0 ? f[i] * f[i] * f[i] : (116.0 * f[i] - 16.0) * 27.0 / 24389.0);
  return xyz;
}

/// D50's white as profiles have it [ICC.1:2010, 7.2.16].
constexpr std::array<double, 3> kD50White{0.9642, 1.0, 0.8249};

void set_color(ChartPatch& patch, const Lab& lab, ChartWhite white) {
  if (white == ChartWhite::D65) {
    patch.linear = linear_from_lab(lab);
    patch.lab = lab;
    return;
  }
  patch.linear = product(rec709_from_d50(), xyz_from_lab(lab, kD50White));
  patch.lab = unclamped_lab(patch.linear);
}

constexpr double kSamePlace = 1e-3;  ///< Across the chart; a patch is a hundred times as large.

}  // namespace

ChartTable classic_chart(ChartEdition edition) {
  ChartTable table;
  for (std::size_t i = 0; i < kClassic.size(); ++i) {
    const int index = static_cast<int>(i);
    ChartPatch patch{.name = kClassic[i].name,
                     .x = patch_place(index % kChartColumns, kChartColumns),
                     .y = patch_place(index / kChartColumns, kChartRows)};
    set_color(patch, edition == ChartEdition::Since2014 ? kClassic[i].since_2014 : kClassic[i].before_2014,
              ChartWhite::D50);
    table.push_back(std::move(patch));
  }
  return table;
}

ChartTable read_chart_table(const std::filesystem::path& file, ChartWhite white) {
  const std::vector<std::string> header{"name", "x", "y", "L", "a", "b"};
  constexpr std::uint64_t kMaxBytes = 1 << 20;
  const TextLines lines(file, kMaxBytes);
  ChartTable table;
  for (const TextLines::Line& line : lines.lines()) {
    if (line.is_empty()) continue;
    const std::vector<std::string> fields = split(line.text, ',');
    if (fields == header) continue;
    if (fields.size() != header.size())
      lines.fail(line, "found " + std::to_string(fields.size()) + " fields; expected name,x,y,L,a,b");
    std::array<double, 5> numbers{};
    for (std::size_t k = 0; k < numbers.size(); ++k) {
      const std::optional<double> number = parse_number(fields[k + 1]);
      constexpr std::array<double, 5> kLow{0.0, 0.0, 0.0, -200.0, -200.0}, kHigh{1.0, 1.0, 100.0, 200.0, 200.0};
      if (!number || !(*number >= kLow[k] && *number <= kHigh[k]))
        lines.fail(line, header[k + 1] + " is `" + fields[k + 1] + "`; expected a number in [" + number_text(kLow[k]) +
                             ", " + number_text(kHigh[k]) + "]");
      numbers[k] = *number;
    }
    ChartPatch patch{.name = fields[0], .x = numbers[0], .y = numbers[1]};
    for (const ChartPatch& other : table) {
      if (other.name == patch.name) lines.fail(line, "the patch `" + patch.name + "` is there already");
      if (std::hypot(other.x - patch.x, other.y - patch.y) < kSamePlace)
        lines.fail(line, "the patches `" + other.name + "` and `" + patch.name + "` are in one place");
    }
    set_color(patch, {numbers[2], numbers[3], numbers[4]}, white);
    table.push_back(std::move(patch));
  }
  if (table.size() < kMinPatches)
    throw IoError(lines.file(), "names " + std::to_string(table.size()) + " patches; expected " +
                                    std::to_string(kMinPatches) + " or more lines of name,x,y,L,a,b");
  return table;
}

bool is_classic_layout(const ChartTable& table) {
  constexpr double kNear = 0.2;  // Share of the distance of two patches.
  if (table.size() != kClassic.size()) return false;
  for (std::size_t i = 0; i < table.size(); ++i) {
    const int index = static_cast<int>(i);
    const double dx =
        (table[i].x - patch_place(index % kChartColumns, kChartColumns)) * (kChartColumns - 1 + kPatchSide);
    const double dy = (table[i].y - patch_place(index / kChartColumns, kChartRows)) * (kChartRows - 1 + kPatchSide);
    if (!(std::hypot(dx, dy) < kNear)) return false;
  }
  return true;
}

}  // namespace patinate::capture
