// Histories that never were a folder: what is said of them is what is said of the same history on disk, to the bit.
#include "patinate/history/memory_history.h"

#include <gtest/gtest.h>

#include <memory>

#include "analysis/compare/sections.h"
#include "analysis/fit/fit_objective.h"
#include "analysis/statistics/history_statistics.h"
#include "patinate/analysis/factorization.h"
#include "patinate/history/write_history.h"
#include "tests/analysis/fit/fit_model.h"
#include "tests/support/histories.h"
#include "tests/support/temp_folder.h"

namespace patinate::analysis {
namespace {

constexpr int kSide = 40, kFrames = 6;

float slower(int x, int y, int frame, int channel) { return testing_support::blotches(x, y, frame / 2, channel); }

MemoryHistoryImages images_of(const std::function<float(int, int, int, int)>& color) {
  MemoryHistoryImages images = testing_support::half_images(kSide, kSide, kFrames, color);
  images.frames[2].mask = ImageU8(kSide, kSide, 1, 255);
  images.frames[2].mask.at(9, 9) = 0;
  return images;
}

/// One history, twice.
struct Both {
  testing_support::TempFolder folder;
  std::shared_ptr<const History> memory, disk;

  explicit Both(const std::function<float(int, int, int, int)>& color = testing_support::blotches) {
    memory = std::make_shared<const MemoryHistory>(images_of(color));
    write_history(folder.path(), *memory);
    disk = std::make_shared<const HistoryReader>(folder.path());
  }
};

void expect_equal(const Section& memory, const Section& disk) {
  ASSERT_EQ(memory.figures.size(), disk.figures.size());
  for (std::size_t i = 0; i < memory.figures.size(); ++i) {
    const Figure &m = memory.figures[i], &d = disk.figures[i];
    EXPECT_EQ(m.value, d.value) << m.name;
    EXPECT_EQ(m.low, d.low) << m.name;
    EXPECT_EQ(m.split, d.split) << m.name;
  }
  ASSERT_EQ(memory.pictures.size(), disk.pictures.size());
  for (std::size_t i = 0; i < memory.pictures.size(); ++i) EXPECT_EQ(memory.pictures[i].image, disk.pictures[i].image);
}

TEST(MemoryHistoryAnalysis, ComparesAsFoldersDo) {
  const Both a, b(slower);
  const CompareOptions options{.num_resamples = 20};
  const ComparedPair memory = load_pair(TextureSeries(a.memory), TextureSeries(b.memory), options);
  const ComparedPair disk =
      load_pair(open_series(a.folder.path()).series, open_series(b.folder.path()).series, options);
  EXPECT_EQ(memory.a.rgb, disk.a.rgb);
  expect_equal(look_section(memory), look_section(disk));
  expect_equal(places_section(memory, options), places_section(disk, options));
  expect_equal(colors_section(memory, options), colors_section(disk, options));
  expect_equal(controls_section(memory, options), controls_section(disk, options));
  expect_equal(structure_section(memory, options), structure_section(disk, options));
  EXPECT_GT(colors_section(memory, options).figures.at(0).value.value(), 0.5)
      << "the two differ, so that equal figures say something";
}

TEST(MemoryHistoryAnalysis, ComparesThroughAnAtlas) {
  const Both a;
  ImageF turned(kSide, kSide, 2);  // The history mirrored.
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x)
      turned.at(x, y, 0) = static_cast<float>(kSide - 1 - x), turned.at(x, y, 1) = static_cast<float>(y);
  }
  const TextureSeries series(a.memory, {.name = "a wall", .coordinates = turned, .texel_mm = 0.5});
  EXPECT_EQ(series.name(), "test on a wall");
  const ImageF own = a.memory->sample(2.0), looked_up = series.sample(2.0);
  EXPECT_EQ(looked_up.at(3, 5, 1), own.at(kSide - 4, 5, 1));
  turned.at(0, 0, 0) = static_cast<float>(kSide);
  EXPECT_THROW((void)TextureSeries(a.memory, {.name = "a wall", .coordinates = turned, .texel_mm = {}}), InvalidInput);
}

TEST(MemoryHistoryAnalysis, FactorizesAsFoldersDo) {
  const Both both;
  const FactorizationOptions options{.num_intervals = 8, .num_training = 32};
  const Factorization memory = factorize(*both.memory, options), disk = factorize(*both.disk, options);
  EXPECT_EQ(memory.models[0].curve.coefficients, disk.models[0].curve.coefficients);
  ASSERT_EQ(memory.factors[0].size(), static_cast<std::size_t>(kSide * kSide));
  int num_fitted = 0;
  for (std::size_t i = 0; i < memory.factors[0].size(); ++i) {
    EXPECT_EQ(memory.factors[0][i].rate, disk.factors[0][i].rate);
    EXPECT_EQ(memory.factors[0][i].gain, disk.factors[0][i].gain);
    num_fitted += memory.factors[0][i].status == PlaceStatus::Fitted ? 1 : 0;
  }
  EXPECT_GT(num_fitted, 0);
  const PlaceSeries places = place_series(*both.memory, std::vector<std::uint32_t>{0, 9 * kSide + 9});
  EXPECT_EQ(places.is_seen[kFrames + 2], 0) << "the frame's own mask";
}

TEST(MemoryHistoryAnalysis, IsFittedAsAFolderIs) {
  const Both both;
  const AgedSurface frames = testing_support::green_plate(testing_support::kGreenTruth);
  const SurfaceOutline outline{.name = frames.name,
                               .width = frames.mask.width(),
                               .height = frames.mask.height(),
                               .time_unit = frames.time_unit,
                               .times = frames.times,
                               .control_names = {"x"}};
  const std::vector<FitTerm> terms{{FitFigure::ColorDistribution}, {FitFigure::MeanColor}, {FitFigure::ColorByControl}};
  const ObjectiveOptions options{.clock = Clock::Span};
  const ObjectiveValue memory = FitObjective(TextureSeries(both.memory), outline, terms, options)(frames);
  const ObjectiveValue disk = FitObjective(open_series(both.folder.path()).series, outline, terms, options)(frames);
  ASSERT_TRUE(memory.objective.has_value()) << memory.problem;
  EXPECT_EQ(memory.objective, disk.objective);
  EXPECT_EQ(memory.figures, disk.figures);
}

TEST(MemoryHistoryAnalysis, HasTheStatisticsOfTheFolder) {
  const Both both;
  const HistoryStatistics memory = history_statistics(TextureSeries(both.memory), {}, 0, 5.0),
                          disk = history_statistics(open_series(both.folder.path()).series, {}, 0, 5.0);
  EXPECT_EQ(memory.times, disk.times);
  EXPECT_EQ(memory.mean_lab, disk.mean_lab);
  EXPECT_EQ(memory.covered, disk.covered);
  EXPECT_EQ(memory.correlation_length, disk.correlation_length);
}

}  // namespace
}  // namespace patinate::analysis
