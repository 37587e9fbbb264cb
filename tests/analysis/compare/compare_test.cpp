// Whole comparisons of histories on disk.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "analysis/compare/compare_job.h"
#include "analysis/figures/control_classes.h"
#include "libcommon/core/files.h"
#include "libcommon/job/job.h"
#include "patinate/analysis/report_parts.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/image/image_io.h"
#include "tests/analysis/compare/report_figure.h"
#include "tests/support/histories.h"
#include "tests/support/temp_folder.h"

namespace patinate::analysis {
namespace {

using testing_support::blotches;
using testing_support::report_figure;
using testing_support::TempFolder;
using testing_support::write_history;

constexpr int kHistorySide = 64, kFrames = 9;

float warped(int x, int y, int frame, int channel) {  // Half as fast; whole frames of the original at every second.
  const float a = blotches(x, y, frame / 2, channel), b = blotches(x, y, (frame + 1) / 2, channel);
  return (a + b) / 2.0f;
}

Json compared_report(const TempFolder& folder, const CompareTask& task, const std::string& name, int num_threads = 0) {
  RunControl control;
  control.num_threads = num_threads;
  EXPECT_EQ(run_job(plan_compare(task, folder / name), {}, control), JobStatus::Done);
  return load_json(folder / name / kCompareReportFile);
}

double value(const Json& report, const std::string& name) {
  return report_figure(report, name).at("value").get<double>();
}

std::string error_text(const std::function<void()>& call) {
  try {
    call();
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

class Compare : public testing::Test {
 protected:
  void SetUp() override { write_history(folder_ / "a", kHistorySide, kHistorySide, kFrames, blotches); }
  CompareTask task(const std::string& b) const {
    CompareTask t{.a = folder_ / "a",
                  .b = folder_ / b,
                  .through = {},
                  .options = {},
                  .command = "patinate history compare a " + b};
    t.options.num_resamples = 15;
    return t;
  }
  TempFolder folder_;
};

TEST_F(Compare, AHistoryAgainstItselfIsZeroEverywhere) {
  const Json report = compared_report(folder_, task("a"), "r");
  for (const Json& f : report.at("figures")) {
    const std::string name = f.at("name");
    const bool is_no_distance = name == "ssim_mean" || name.find("median_") != std::string::npos ||
                                name == "time_shift_known" || name.rfind("rank_", 0) == 0;
    if (name == "ssim_mean") {
      EXPECT_EQ(f.at("value"), 1.0);
    }
    if (is_no_distance) continue;
    ASSERT_FALSE(f.at("value").is_null()) << f.dump();
    EXPECT_EQ(f.at("value"), 0.0) << f.dump();
    if (f.contains("high")) {
      EXPECT_EQ(f.at("high"), 0.0) << f.dump();  // Same places: drawn together.
    }
  }
  EXPECT_GT(report_figure(report, "color_distribution").at("split").get<double>(), 0.0);  // Halves of it do differ.
  EXPECT_TRUE(report.at("undefined_sections").empty());
}

TEST_F(Compare, HalfTheSpeedIsFoundAsAClockAndLeavesLittle) {
  write_history(folder_ / "slow", kHistorySide, kHistorySide, 2 * kFrames - 1, warped);
  const Json report = compared_report(folder_, task("slow"), "r");
  EXPECT_GT(value(report, "ciede2000_mean"), 0.5);
  EXPECT_GT(value(report, "onset_distance"), 0.0);
  EXPECT_GT(value(report, "onset_median_b"), value(report, "onset_median_a"));
  CompareTask by_span = task("slow");
  by_span.options.clock = Clock::Span;
  const Json same = compared_report(folder_, by_span, "span");
  EXPECT_EQ(value(same, "ciede2000_mean"), 0.0);  // A's frames are every second of B's.
  EXPECT_EQ(value(same, "residual_after_warp"), 0.0);
}

TEST_F(Compare, WritesTheSameBytesOnAnyNumberOfThreads) {
  write_history(folder_ / "b", kHistorySide, kHistorySide, kFrames,
                [](int x, int y, int f, int c) { return 0.9f * blotches(y, x, f, c); });
  (void)compared_report(folder_, task("b"), "one", 1);
  (void)compared_report(folder_, task("b"), "four", 4);
  for (const char* file :
       {kCompareReportFile, kComparePageFile, "curves/color_distribution.csv", "curves/spectrum.csv"}) {
    EXPECT_EQ(read_file(folder_ / "one" / file), read_file(folder_ / "four" / file)) << file;
  }
  EXPECT_EQ(run_job(plan_compare(task("b"), folder_ / "one"), {}, {}), JobStatus::UpToDate);
}

TEST_F(Compare, ThePageCarriesEverythingAndNoNan) {
  const Json report = compared_report(folder_, task("a"), "r");
  const std::string page = read_file(folder_ / "r" / kComparePageFile);
  EXPECT_NE(page.find("<svg"), std::string::npos);
  EXPECT_NE(page.find("data:image/png"), std::string::npos);
  EXPECT_EQ(page.find("src=\"curves"), std::string::npos);
  EXPECT_NE(page.find("patinate history compare a a"), std::string::npos);
  for (const std::string& text : {page, report.dump()}) {
    EXPECT_EQ(text.find(">nan"), std::string::npos);
    EXPECT_EQ(text.find(":nan"), std::string::npos);
  }
  EXPECT_FALSE(report.at("curves").empty());
  for (const Json& c : report.at("curves"))
    EXPECT_TRUE(std::filesystem::exists(folder_ / "r" / c.at("file").get<std::string>()));
}

TEST_F(Compare, OtherSizesHaveNoPlacesButDistributions) {
  write_history(folder_ / "b", 48, 40, kFrames, blotches);
  const Json report = compared_report(folder_, task("b"), "r");
  ASSERT_EQ(report.at("undefined_sections").size(), 1u);
  EXPECT_NE(report.at("undefined_sections")[0].at("reason").get<std::string>().find("64 x 64 pixels, B 48 x 40"),
            std::string::npos);
  EXPECT_GT(report_figure(report, "color_distribution").at("high").get<double>(), value(report, "color_distribution"));
}

TEST_F(Compare, ThroughATransferFindsTheSameTexelsAgain) {
  // An atlas that shows the history turned by 180 degrees, and a hole in it.
  ImageF coordinates(kHistorySide, kHistorySide, 2, -1.0f);
  for (int y = 0; y < kHistorySide; ++y) {
    for (int x = 4; x < kHistorySide; ++x) {
      coordinates.at(x, y, 0) = static_cast<float>(kHistorySide - 1 - x);
      coordinates.at(x, y, 1) = static_cast<float>(kHistorySide - 1 - y);
    }
  }
  std::filesystem::create_directories(folder_ / "t");
  write_exr(folder_ / "t/coordinates.exr", coordinates, {"source.x", "source.y"}, ExrDepth::Float);
  write_atomically(
      folder_ / "t/transfer.json",
      R"({"format": "patinate.transfer", "version": 1, "width": 64, "height": 64, "history": {"path": "../a", "key": "", "name": "test",
    "width": 64, "height": 64}, "coordinates": "coordinates.exr", "texel_size_mm": 1, "mesh": {"made_from": "mesh.obj"}})");
  write_history(folder_ / "turned", kHistorySide, kHistorySide, kFrames,
                [](int x, int y, int f, int c) { return blotches(kHistorySide - 1 - x, kHistorySide - 1 - y, f, c); });
  CompareTask through = task("turned");
  through.through = folder_ / "t";
  EXPECT_EQ(value(compared_report(folder_, through, "r"), "ciede2000_mean"), 0.0);
  CompareTask itself = task("t");
  itself.a = folder_ / "t";
  EXPECT_EQ(value(compared_report(folder_, itself, "s"), "ciede2000_p95"), 0.0);
  write_history(folder_ / "small", 8, 8, 2, blotches);
  through.a = folder_ / "small";
  EXPECT_NE(
      error_text([&] { (void)plan_compare(through, folder_ / "e"); }).find("looks into a history of 64 x 64 pixels"),
      std::string::npos);
}

TEST_F(Compare, SaysWhatCannotBeSaid) {
  const auto constant = [](int, int, int, int) { return 0.25f; };
  write_history(folder_ / "constant", kHistorySide, kHistorySide, kFrames, constant);
  CompareTask stated = task("constant");
  stated.options.places = Places::Equal;
  const Json report = compared_report(folder_, stated, "r");
  EXPECT_NE(report_figure(report, "onset_distance").at("undefined").get<std::string>().find("B does not age visibly"),
            std::string::npos);
  EXPECT_NE(report_figure(report, "time_shift_median")
                .at("undefined")
                .get<std::string>()
                .find("no place ages visibly on both sides"),
            std::string::npos);
  EXPECT_TRUE(report_figure(report, "correlation_length_distance").at("value").is_null());
  write_history(folder_ / "single", kHistorySide, kHistorySide, 1, blotches);
  const Json single = compared_report(folder_, task("single"), "s");
  EXPECT_NE(report_figure(single, "onset_distance").at("undefined").get<std::string>().find("only one common time"),
            std::string::npos);
  EXPECT_EQ(value(single, "ciede2000_mean"), 0.0);
}

/// Detail of some surface, from a seed.
float grains(int x, int y, int seed) { return blotches((x + 37 * seed) % 512, (y + 53 * seed) % 512, 0, 1); }

TEST_F(Compare, PlacesArePairedWhereThePicturesShowThatTheyAreTheSame) {
  // One surface that ages in another way, and another one.
  write_history(folder_ / "treated", kHistorySide, kHistorySide, kFrames, [](int x, int y, int f, int c) {
    return blotches(x, y, 0, c) * (1.0f - 0.06f * static_cast<float>(c == 0 ? f : 0));
  });
  write_history(folder_ / "other", kHistorySide, kHistorySide, kFrames, [](int x, int y, int f, int c) {
    return grains(x, y, 7) * (1.0f - 0.03f * static_cast<float>(f + c));
  });
  EXPECT_TRUE(compared_report(folder_, task("treated"), "t").at("undefined_sections").empty());
  const Json report = compared_report(folder_, task("other"), "o");
  ASSERT_EQ(report.at("undefined_sections").size(), 1u);
  EXPECT_NE(report.at("undefined_sections")[0].at("reason").get<std::string>().find("--places equal"),
            std::string::npos);
  CompareTask stated = task("other");
  stated.options.places = Places::Equal;
  EXPECT_TRUE(compared_report(folder_, stated, "stated").at("undefined_sections").empty());
}

TEST_F(Compare, TheSameSurfaceAtAnotherSizeIsAsCoarse) {
  // Four pixels of the fine one are a pixel of the coarse one.
  constexpr int kFine = 4 * kHistorySide;
  write_history(folder_ / "fine", kFine, kFine, 3, [](int x, int y, int f, int c) { return blotches(x, y, f, c); });
  write_history(folder_ / "coarse", kHistorySide, kHistorySide, 3, [](int x, int y, int f, int c) {
    float sum = 0.0f;
    for (int k = 0; k < 16; ++k) sum += blotches(4 * x + k % 4, 4 * y + k / 4, f, c) / 16.0f;
    return sum;
  });
  CompareTask t = task("coarse");
  t.a = folder_ / "fine";
  const Json report = compared_report(folder_, t, "r");
  // Means of the same places: what is left is the rounding of files to half floats, 2^-11 of a value; of octaves of
  // power twice that over log 2, and ten times as much where a ring has little power.
  EXPECT_LT(value(report, "correlation_length_distance"), 0.015);
  EXPECT_LT(value(report, "spectrum_distance"), 0.015);
}

TEST_F(Compare, EqualMasksOfPhotographsAreNoCharts) {
  const auto is_inside = [](int x, int y) { return (x - 31.5) * (x - 31.5) + (y - 31.5) * (y - 31.5) < 900.0; };
  for (const auto& [name, seed] : {std::pair("dish", 1), std::pair("other_dish", 8)}) {
    write_history(folder_ / name, kHistorySide, kHistorySide, 3, [s = seed](int x, int y, int f, int c) {
      return grains(x, y, s) * (1.0f - 0.03f * static_cast<float>(f + c));
    });
    ImageU8 mask(kHistorySide, kHistorySide);
    for (int y = 0; y < kHistorySide; ++y) {
      for (int x = 0; x < kHistorySide; ++x) mask.at(x, y) = is_inside(x, y) ? 255 : 0;
    }
    write_codes(folder_ / name / "mask.png", mask);
    HistoryManifest manifest = read_history_manifest(folder_ / name);
    manifest.mask = "mask.png";
    write_history_manifest(folder_ / name / kHistoryManifestFile, manifest);
  }
  CompareTask t = task("other_dish");
  t.a = folder_ / "dish";
  EXPECT_EQ(compared_report(folder_, t, "r").at("undefined_sections").size(), 1u);
}

TEST_F(Compare, ASpanThatIsHardlyComparedIsSaid) {
  write_history(folder_ / "long", kHistorySide, kHistorySide, 60, blotches);
  const Json report = compared_report(folder_, task("long"), "r");
  ASSERT_EQ(report.at("warnings").size(), 1u);
  const std::string warning = report.at("warnings")[0];
  EXPECT_NE(warning.find("only 14 % of B's time is compared"), std::string::npos) << warning;  // 8 of 59
  EXPECT_NE(read_file(folder_ / "r/report.html").find("only 14 % of B"), std::string::npos);
  CompareTask once = task("a");
  once.options.num_times = 1;
  EXPECT_TRUE(compared_report(folder_, once, "same").at("warnings").empty());
}

TEST_F(Compare, CracksAreMeasuredWhenAskedForAndMissedWhereThereAreNone) {
  const auto bricks = [](int x, int y, int f, int) {
    return f > 0 && (y % 16 < 2 || (x + y / 16 % 2 * 12) % 24 < 2) ? 0.05f : 0.5f;
  };
  write_history(folder_ / "bricks", kHistorySide, kHistorySide, 3, bricks);
  write_history(folder_ / "plain", kHistorySide, kHistorySide, 3, [](int, int, int, int) { return 0.5f; });
  CompareTask t = task("plain");
  t.a = folder_ / "bricks";
  t.options.cracks = true;
  const Json report = compared_report(folder_, t, "r");
  EXPECT_NEAR(value(report, "junction_angle_a"), 90.0, 6.0);  // Arms of 6 px.
  EXPECT_NEAR(value(report, "crack_width_a"), 2.0, 0.3);
  EXPECT_EQ(value(report, "crack_share_b"), 0.0);
  EXPECT_NE(
      report_figure(report, "junction_angle_b").at("undefined").get<std::string>().find("no dark lines are found in B"),
      std::string::npos);
  EXPECT_TRUE(report_figure(report, "cell_area_distance").at("value").is_null());
}

TEST_F(Compare, RefusesWhatHasNothingInCommon) {
  write_history(folder_ / "b", kHistorySide, kHistorySide, 3, blotches);
  HistoryManifest late = read_history_manifest(folder_ / "b");
  for (HistoryFrame& f : late.frames) f.time += 100.0;
  write_history_manifest(folder_ / "b/history.json", late);
  EXPECT_NE(error_text([&] {
              (void)plan_compare(task("b"), folder_ / "e");
            }).find("A covers 0 to 8 s, B 100 to 102 s: no time in common; --clock span"),
            std::string::npos);
  const auto half = [&](const std::string& name, bool left) {
    write_history(folder_ / name, kHistorySide, kHistorySide, 3, blotches);
    ImageU8 mask(kHistorySide, kHistorySide);
    for (int y = 0; y < kHistorySide; ++y) {
      for (int x = 0; x < kHistorySide; ++x) mask.at(x, y) = (x < kHistorySide / 2) == left ? 255 : 0;
    }
    write_codes(folder_ / name / "mask.png", mask);
    HistoryManifest m = read_history_manifest(folder_ / name);
    m.mask = "mask.png";
    write_history_manifest(folder_ / name / "history.json", m);
  };
  half("left", true), half("right", false);
  CompareTask t = task("right");
  t.a = folder_ / "left";
  const Json report = compared_report(folder_, t, "r");
  ASSERT_EQ(report.at("undefined_sections").size(), 1u);
  EXPECT_EQ(report.at("undefined_sections")[0].at("reason"), "the masks of A and B have no texel in common");
}

TEST(ControlClasses, AreByPhysicalValueWhenThatMeansTheSameOnBothSides) {
  HistoryFacts a, b;
  a.controls = {{"height", 0.0, 10.0, "mm"}};
  b.controls = {{"height", 5.0, 20.0, "mm"}};
  const SharedControl physical = shared_controls(a, b).at(0);
  EXPECT_EQ(physical.rule, ClassRule::Physical);
  // 5 to 10 mm in five classes: 0.65 of A is 6.5 mm, class 1; 0.2 of A is 2 mm, outside; 0.25 of B is 8.75 mm, class 3.
  EXPECT_EQ(control_classes({0.65f, 0.2f, 1.0f}, a.controls[0], physical, 5), (std::vector<int>{1, -1, 4}));
  EXPECT_EQ(control_classes({0.25f, 0.5f}, b.controls[0], physical, 5), (std::vector<int>{3, -1}));
  b.controls[0].unit = "1/mm";
  const SharedControl other = shared_controls(a, b).at(0);
  EXPECT_EQ(other.rule, ClassRule::Rank);
  EXPECT_EQ(other.note, "by rank: the units differ (mm, 1/mm)");
  b.controls[0] = {"height", 100.0, 200.0, "mm"};
  EXPECT_NE(shared_controls(a, b).at(0).note.find("hardly overlap (0 to 10 mm; 100 to 200 mm)"), std::string::npos);
  EXPECT_EQ(control_classes({0.3f, 0.1f, 0.9f, 0.5f, 0.7f}, a.controls[0], shared_controls(a, b).at(0), 5),
            (std::vector<int>{1, 0, 4, 2, 3}));
  b.controls[0] = {"height", 5.0, 5.0, "mm"};
  EXPECT_NE(shared_controls(a, b).at(0).undefined.find("constant"), std::string::npos);
  b.controls[0].name = "other";
  EXPECT_EQ(shared_controls(a, b).size(), 1u);  // The only one of each.
  b.controls.push_back({"third", 0.0, 1.0, "mm"});
  EXPECT_TRUE(shared_controls(a, b).empty());
}

TEST(ReportParts, SurviveTheirJson) {
  Section s{.name = "n", .title = "t", .paragraphs = {"p"}};
  s.figures.push_back({.name = "f", .title = "F", .unit = "u", .value = 1.5, .low = 1.0, .high = 2.0, .split = 0.5});
  s.figures.push_back({.name = "g", .title = "G", .unit = "u", .undefined = "why"});
  s.curves.push_back({.name = "c",
                      .title = "C",
                      .x_name = "x, s",
                      .y_name = "y",
                      .x = {0, 1},
                      .columns = {{"one", {1.0, std::nullopt}, {{0, 2}, {0, 2}}}}});
  s.pictures = {{.name = "p", .caption = "P", .source = "data:,p"}};
  const Section back = section_from_json(section_json(s));
  EXPECT_EQ(section_json(back).dump(), section_json(s).dump());
  ASSERT_EQ(back.pictures.size(), 1u);
  EXPECT_EQ(back.pictures[0].source, "data:,p");
  EXPECT_EQ(curve_csv(back.curves[0]), "\"x, s\",one [y],one low [y],one high [y]\n0,1,0,2\n1,,0,2\n");
  EXPECT_EQ(figures_csv(std::vector<Section>{back}),
            "section,figure,unit,value,low (95 %),high (95 %),A split in "
            "two,undefined,after,before\nn,f,u,1.5,1,2,0.5,,,\nn,g,u,,,,,why,,\n");
  s.figures[0].value = std::nan("");
  EXPECT_THROW((void)section_json(s), InvalidInput);
}

}  // namespace
}  // namespace patinate::analysis
