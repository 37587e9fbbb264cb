#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "capture/chart/chart_fit.h"
#include "capture/chart/unclamped_lab.h"
#include "capture/timelapse/chart_report.h"
#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "patinate/core/json.h"
#include "patinate/image/image_io.h"
#include "patinate/metrics/difference.h"
#include "tests/capture/chart/chart_scene.h"
#include "tests/capture/timelapse/ingest_folder.h"
#include "tests/support/errors.h"
#include "tests/support/temp_folder.h"

namespace patinate::capture {
namespace {

using namespace testing_support;
namespace fs = std::filesystem;

/// Even light: what lies beside the chart is then as bright as on it. sRGB codes of 8 bits.
ChartScene even_scene(ChartSpoil spoil = ChartSpoil::None) {
  return {.width = 480, .height = 320, .camera = 1, .vignetting = 0.0, .slope = 0.0, .spoil = spoil, .seed = 4};
}

constexpr std::array<double, 4> kExposures{1.0, 0.8, 1.15, 0.9};
constexpr std::array<double, 4> kReds{1.0, 1.1, 0.95, 1.05};

ChartExposure exposure_of(int photo) {
  const auto i = static_cast<std::size_t>(photo);
  return {.exposure = kExposures[i],
          .white_balance = {kReds[i], 1.0, 1.0 / kReds[i]},
          .noise_seed = static_cast<std::uint32_t>(photo + 1)};
}

ChartPhoto write_photo(const fs::path& file, const ChartScene& scene, int photo) {
  ChartPhoto made = render_chart(scene, exposure_of(photo));
  ImageU8 codes(scene.width, scene.height, 3);
  for (std::int64_t i = 0; i < 3 * codes.num_pixels(); ++i)
    codes.data()[i] = static_cast<std::uint8_t>(std::lround(255.0f * made.codes.data()[i]));
  fs::create_directories(file.parent_path());
  write_codes(file, codes);
  // Colors that a camera's codes do not hold are not measured here.
  std::erase_if(made.patches, [](const KnownPatch& patch) {
    constexpr double kInside = 0.05;
    return *std::min_element(patch.linear.begin(), patch.linear.end()) < kInside;
  });
  return made;
}

void write_project(const fs::path& folder, const std::string& more) {
  write_atomically(folder / "capture.json",
                   R"({"format": "patinate.capture", "version": 1, "name": "chart", "kind": "fixed", )"
                   R"("frames": {"pattern": "frames/*.png", "interval": 1}, )" +
                       more + "}");
}

/// Photographs 000.png to 003.png, and the project. @param spoil  Of 002.png.
ChartPhoto write_series(const fs::path& folder, const std::string& more, ChartSpoil spoil = ChartSpoil::None) {
  ChartPhoto first;
  for (int i = 0; i < 4; ++i) {
    const ChartPhoto photo = write_photo(folder / "frames" / (zero_padded(static_cast<std::uint64_t>(i), 3) + ".png"),
                                         even_scene(i == 2 ? spoil : ChartSpoil::None), i);
    if (i == 0) first = photo;
  }
  write_project(folder, more);
  return first;
}

std::array<double, 3> lab_of(const ImageF& frame, const KnownPatch& patch) {
  std::array<double, 3> sum{};
  double count = 0.0;
  for (int y = patch.y + 2; y < patch.y + patch.side - 2; ++y) {
    for (int x = patch.x + 2; x < patch.x + patch.side - 2; ++x) {
      for (std::size_t c = 0; c < 3; ++c) sum[c] += static_cast<double>(frame.at(x, y, static_cast<int>(c)));
      count += 1.0;
    }
  }
  for (double& v : sum) v /= count;
  return unclamped_lab(sum);
}

/// Mean CIEDE2000 of the patches beside the chart, from what they are.
double error_of_frame(const ImageF& frame, const std::vector<KnownPatch>& patches) {
  double sum = 0.0;
  for (const KnownPatch& patch : patches) sum += ciede2000(lab_of(frame, patch), patch.lab);
  return sum / static_cast<double>(patches.size());
}

double drift_of_frame(const ImageF& frame, const ImageF& first, const std::vector<KnownPatch>& patches) {
  double sum = 0.0;
  for (const KnownPatch& patch : patches) sum += ciede2000(lab_of(frame, patch), lab_of(first, patch));
  return sum / static_cast<double>(patches.size());
}

constexpr const char* kAuto = R"("chart": "auto")";
constexpr double kMaxDrift = 0.3;  ///< CIEDE2000; a third of what is seen side by side.
/// A 3 x 3 matrix leaves one to two of smooth surfaces; photographs as they are differ by five and more.
constexpr double kMaxError = 2.5;

TEST(ChartIngest, FramesHaveTheirTrueColorsWhateverExposureAndWhiteBalanceDid) {
  const TempFolder folder;
  const std::vector<KnownPatch> patches = write_series(folder.path(), kAuto).patches;
  const HistoryReader history = ingest(folder.path());
  const ImageF first = history.read_frame(0);
  for (int i = 0; i < 4; ++i) {
    EXPECT_LT(error_of_frame(history.read_frame(i), patches), kMaxError) << i;
    EXPECT_LT(drift_of_frame(history.read_frame(i), first, patches), kMaxDrift) << i;
  }
  const Json chart = read_chart(folder / "out");
  const std::vector<ChartDrift> drift = chart_drift(chart);
  ASSERT_EQ(drift.size(), 4u);
  constexpr double kNear = 0.03;  // The camera's matrix mixes channels after white balance.
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(drift[i].exposure, kExposures[i], kNear) << i;
  EXPECT_TRUE(has(chart_notes(chart).at(1), "red over green"));
  EXPECT_TRUE(has(read_file(folder / "out/report.html"), "Light by the chart"));
}

TEST(ChartIngest, GivenCornersGiveWhatIsFound) {
  const TempFolder folder;
  const ChartPhoto photo = write_series(folder.path(), kAuto);
  const ImageF found = ingest(folder.path()).read_frame(1);
  std::string corners;
  for (const Eigen::Vector2d& c : photo.corners)
    corners += (corners.empty() ? "[" : ", [") + number_text(c.x()) + ", " + number_text(c.y()) + "]";
  fs::remove_all(folder / "out");
  write_project(folder.path(), R"("chart": {"corners": [)" + corners + "]}");
  EXPECT_LT(drift_of_frame(ingest(folder.path()).read_frame(1), found, photo.patches), kMaxDrift);
}

TEST(ChartIngest, APhotographWithoutAChartIsNamedWithWhatAllowsIt) {
  const TempFolder folder;
  const std::vector<KnownPatch> patches = write_series(folder.path(), kAuto, ChartSpoil::Absent).patches;
  const std::string error = ingest_error(folder.path());
  EXPECT_TRUE(has(error, "002.png shows no chart")) << error;
  EXPECT_TRUE(has(error, R"("missing": "interpolate")")) << error;
  fs::remove_all(folder / "out");
  write_project(folder.path(), R"("chart": {"missing": "interpolate"})");
  const HistoryReader history = ingest(folder.path());
  bool is_warned = false;
  for (const HistoryWarning& warning : history.facts().warnings)
    is_warned = is_warned || has(warning.text, "(002.png) is interpolated");
  EXPECT_TRUE(is_warned);
  const std::vector<ChartDrift> drift = chart_drift(read_chart(folder / "out"));
  EXPECT_NEAR(drift[2].exposure, std::sqrt(drift[1].exposure * drift[3].exposure), 1e-6);  // Halfway in time.
}

TEST(ChartIngest, AHiddenPatchIsNamedWithItsPhotograph) {
  const TempFolder folder;
  write_series(folder.path(), kAuto, ChartSpoil::Hidden);
  EXPECT_TRUE(has(ingest_error(folder.path()), "partly hidden"));
}

TEST(ChartIngest, PhotographsOfTheChartAloneMayStandBesideTheFrames) {
  const TempFolder folder;
  std::vector<KnownPatch> patches;
  for (int i = 0; i < 2; ++i) {
    const std::string name = std::to_string(i) + ".png";
    patches = write_photo(folder / "frames" / name, even_scene(ChartSpoil::Absent), i).patches;
    (void)write_photo(folder / "charts" / name, even_scene(), i);
  }
  write_project(folder.path(), R"("chart": {"photos": "charts/*.png"})");
  const HistoryReader history = ingest(folder.path());
  EXPECT_LT(error_of_frame(history.read_frame(1), patches), kMaxError);
  fs::remove(folder / "charts/1.png");
  EXPECT_TRUE(has(ingest_error(folder.path()), "for each of the 2 images"));
}

TEST(ChartIngest, AUsersTableIsTakenAtItsWord) {
  const TempFolder folder;
  const std::vector<KnownPatch> patches = write_series(folder.path(), kAuto).patches;
  std::string rows;
  for (const ChartPatch& patch : classic_chart(ChartEdition::Since2014))
    rows += patch.name + "," + number_text(patch.x) + "," + number_text(patch.y) + "," + number_text(patch.lab[0]) +
            "," + number_text(patch.lab[1]) + "," + number_text(patch.lab[2]) + "\n";
  write_atomically(folder / "patches.csv", rows);
  write_project(folder.path(), R"("chart": {"table": "patches.csv", "white": "D65"})");
  EXPECT_LT(error_of_frame(ingest(folder.path()).read_frame(3), patches), kMaxError);
}

TEST(ChartIngest, DeviationsHoldWhatTheChartLeaves) {
  const TempFolder folder;
  write_series(folder.path(), kAuto);
  (void)write_photo(folder / "frames/004.png", even_scene(), 1);
  IngestOptions options;
  options.add_deviations = true;
  const HistoryReader history = ingest(folder.path(), options);
  const double known = read_chart(folder / "out").at("deviation").at(1).get<double>();
  const ImageF frame = history.read_frame(2),
               deviation = read_color(folder / "out" / HistoryWriter::frame_extra_file(2, "stddev"));
  for (int x = 0; x < frame.width(); x += 40) {
    const double least = known * (static_cast<double>(frame.at(x, 100, 1)) + kChartFloor);
    constexpr double kHalfRounding = 1.0 / 1024.0;
    EXPECT_GE(static_cast<double>(deviation.at(x, 100, 1)), (1.0 - kHalfRounding) * least);
  }
}

TEST(ChartIngest, WhatCannotBeIsOneLine) {
  const TempFolder folder;
  write_series(folder.path(), kAuto);
  const auto complaint = [&](const std::string& more) {
    write_project(folder.path(), more);
    return ingest_error(folder.path());
  };
  EXPECT_TRUE(has(complaint(R"("chart": "yes")"), "/chart"));
  EXPECT_TRUE(has(complaint(R"("chart": {"corner": [[1, 2]]})"), "did you mean `corners`"));
  EXPECT_TRUE(has(complaint(R"("chart": {"corners": [[1, 2], [3, 4]]})"), "/chart/corners"));
  EXPECT_TRUE(has(complaint(R"("chart": {"corners": [[0, 0], [0, 90], [90, 90], [90, 0]]})"), "clockwise"));
  EXPECT_TRUE(has(complaint(R"("chart": {"edition": "1976"})"), "/chart/edition"));
  EXPECT_TRUE(has(complaint(R"("chart": {"white": "D50"})"), "no `white` without a `table`"));
  EXPECT_TRUE(has(complaint(R"("chart": "auto", "reference_patch": [0, 0, 9, 9])"), "leave one of the two out"));
  write_project(folder.path(), kAuto);
  IngestOptions deflicker;
  deflicker.repair.deflicker = true;
  EXPECT_TRUE(has(ingest_error(folder.path(), deflicker), "--deflicker guesses what `chart` measures"));
}

}  // namespace
}  // namespace patinate::capture
