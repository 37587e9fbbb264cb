// Maps of a history taken apart: roughness and the like over time.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "analysis/factorization/factorization_document.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"
#include "tests/analysis/factorization/factored_places.h"
#include "tests/support/temp_folder.h"

namespace patinate::analysis {
namespace {

namespace fs = std::filesystem;
using testing_support::kQuickFactorization;
using testing_support::true_curve;

constexpr int kWidth = 24, kHeight = 16, kFrames = 30;
constexpr float kColor = 0.25f, kStrength = 0.5f;

double time_of(int frame) { return 100.0 * frame / (kFrames - 1); }
/// Roughness of place i at a frame: it dulls as a factorization has it.
double roughness_of(const PlaceFactors& p, int frame) {
  return 0.25 + 0.6 * true_curve(1, p.rate * time_of(frame) - p.offset);
}

/// One color for ever; roughness that changes, known but for the first place.
void write_dulling(const fs::path& folder, const std::vector<PlaceFactors>& truth) {
  HistoryManifest m;
  m.name = "dulling";
  m.width = kWidth;
  m.height = kHeight;
  HistoryWriter writer(folder, m);
  for (int frame = 0; frame < kFrames; ++frame) {
    ImageF color(kWidth, kHeight, 3, kColor), gloss(kWidth, kHeight, 2);
    for (std::size_t i = 1; i < truth.size(); ++i) {
      gloss.data()[2 * i] = kStrength;
      gloss.data()[2 * i + 1] = static_cast<float>(roughness_of(truth[i], frame));
    }
    writer.write_frame(frame, time_of(frame), color);
    HistoryWriter::write_frame_extra(folder, frame, "specular", gloss);
    writer.add_written_frame_extra(frame, "specular");
  }
  writer.finish();
}

std::string problem_of(const FactorizationTask& task, const fs::path& output) {
  try {
    run_job(plan_factorization(task, output), {}, {});
  } catch (const InvalidInput& e) {
    return e.what();
  }
  return "";
}

TEST(FactorQuantity, OfRoughnessFindsItsClocksAndLeavesTheRestAsItIs) {
  const testing_support::TempFolder folder;
  std::vector<PlaceFactors> truth = testing_support::factored_places({.count = kWidth * kHeight}).truth;
  write_dulling(folder / "dulling", truth);
  run_job(plan_factorization(
              {.history = folder / "dulling", .of = FactorQuantity::Roughness, .options = kQuickFactorization},
              folder / "factors"),
          {}, {});
  const HistoryReader made(folder / "factors/history");
  ASSERT_EQ(made.num_frames(), kFrames);
  double squares = 0.0;
  for (const int frame : {0, 11, 29}) {
    const ImageF gloss = *made.read_frame_extra(frame, "specular"), color = made.read_frame(frame);
    EXPECT_TRUE(std::all_of(color.values().begin(), color.values().end(), [](float v) { return v == kColor; }));
    EXPECT_EQ(gloss.data()[0], 0.0f);  // Nobody knows the first place's gloss: it stays so.
    EXPECT_EQ(gloss.data()[1], 0.0f);
    for (std::size_t i = 1; i < truth.size(); ++i) {
      EXPECT_EQ(gloss.data()[2 * i], kStrength);
      squares += std::pow(static_cast<double>(gloss.data()[2 * i + 1]) - roughness_of(truth[i], frame), 2);
    }
  }
  // Bound as for colors that follow the formula (factorization_test.cpp): what 24 pieces of a spline cannot follow.
  EXPECT_LT(std::sqrt(squares / (3.0 * static_cast<double>(truth.size() - 1))), 0.002);
  const ImageF rate = read_channels(folder / "factors/maps/rate.exr", {"Y"});
  std::vector<PlaceFactors> known(truth.begin() + 1, truth.end());
  apply_gauge(clock_gauge(known), known);
  std::vector<double> off;
  for (std::size_t i = 0; i < known.size(); ++i)
    off.push_back(std::abs(static_cast<double>(rate.data()[i + 1]) / known[i].rate - 1.0));
  std::sort(off.begin(), off.end());
  EXPECT_LT(off[off.size() * 95 / 100], 0.01);  // The same; one channel of 30 times where those have three of 48.
  EXPECT_EQ(static_cast<int>(read_factorization(folder / "factors").frames.size()), kFrames);
}

TEST(FactorQuantity, WhatCannotBeTakenApartIsOneLine) {
  const testing_support::TempFolder folder;
  write_dulling(folder / "dulling", testing_support::factored_places({.count = kWidth * kHeight}).truth);
  FactorizationTask task{
      .history = folder / "dulling", .of = FactorQuantity::Metalness, .options = kQuickFactorization};
  EXPECT_EQ(problem_of(task, folder / "out"), (folder / "dulling").string() +
                                                  ": not every frame has a map of metalness; all of them have color, "
                                                  "roughness, specular");
  task.of = FactorQuantity::Roughness;
  task.times = {120.0};
  EXPECT_NE(problem_of(task, folder / "out").find("times: "), std::string::npos);
  task.times = {};
  task.options.clock = FactorClock::Channels;
  EXPECT_NE(problem_of(task, folder / "out").find("clock: "), std::string::npos);
  EXPECT_FALSE(fs::exists(folder / "out"));
  EXPECT_THROW((void)parse_factor_quantity("gloss"), InvalidInput);
}

}  // namespace
}  // namespace patinate::analysis
