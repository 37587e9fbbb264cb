#include "transfer/job/forecast.h"

#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "patinate/core/error.h"
#include "patinate/history/memory_history.h"
#include "tests/support/histories.h"
#include "tests/support/meshes.h"

namespace patinate::transfer {
namespace {

constexpr int kSource = 64, kAtlas = 96;
constexpr double kSide_mm = 192.0;

/// A plane of 192 mm, nine times the area of a source of 64 pixels of a millimeter.
TransferInput onto_plane(const ImageF& values, ControlMapping mapping) {
  MemoryHistoryImages images = testing_support::half_images(kSource, kSource, 1, testing_support::blotches);
  for (MemoryControl& control : images.controls) control.facts.unit = "mm";
  return {.history = std::make_shared<const MemoryHistory>(std::move(images)),
          .map = std::make_shared<TexelMap>(testing_support::unit_plane(kSide_mm), kAtlas, kAtlas),
          .texel_size_mm = 1.0,
          .controls = {{"x", "map", values, {0.0, 1.0, ""}, 1.0, mapping}}};
}
ImageF ramp(float low, float high) {
  ImageF values(kAtlas, kAtlas);
  for (int y = 0; y < kAtlas; ++y) {
    for (int x = 0; x < kAtlas; ++x)
      values.at(x, y) = low + (high - low) * static_cast<float>(x) / static_cast<float>(kAtlas - 1);
  }
  return values;
}

TEST(TransferForecast, EqualUseNeedsAsManyCopiesAsTheSurfaceIsLarger) {
  const TransferForecast f = forecast_transfer(onto_plane(ramp(0, 1), ControlMapping::Rank));
  EXPECT_EQ(f.num_usable, kSource * kSource);
  EXPECT_NEAR(f.surface_mm2, kSide_mm * kSide_mm, 1e-6 * kSide_mm * kSide_mm);
  EXPECT_NEAR(f.surface_share, 9.0, 1e-6);
  EXPECT_NEAR(f.num_copies, 9.0, 0.5);
  EXPECT_GT(f.asked_share, 0.98);
  EXPECT_TRUE(warnings_of(f).empty());
}

TEST(TransferForecast, ANarrowControlNeedsMoreCopiesOfLess) {
  // The source's control "x" runs evenly from 0 to 1: an eighth of it is asked for.
  const TransferForecast f = forecast_transfer(onto_plane(ramp(0.5f, 0.625f), ControlMapping::Physical));
  EXPECT_NEAR(f.asked_share, 0.125, 4.0 / 64.0);  // Half a bin of 1/64 and one more to each side serve as well.
  EXPECT_NEAR(f.num_copies, 8.0 * 9.0, 8.0);
  EXPECT_EQ(f.narrowest, "x");
  const std::vector<std::string> warnings = warnings_of(f);
  ASSERT_EQ(warnings.size(), 2u);
  EXPECT_NE(warnings[0].find("control `x`"), std::string::npos) << warnings[0];
  EXPECT_NE(warnings[1].find("copies"), std::string::npos) << warnings[1];
}

TEST(TransferForecast, AMaskThatLeavesLittleIsSaid) {
  TransferInput input = onto_plane(ramp(0, 1), ControlMapping::Rank);
  input.source_mask = ImageU8(kSource, kSource, 1);
  for (int y = 0; y < kSource / 4; ++y) {
    for (int x = 0; x < kSource / 2; ++x) input.source_mask.at(x, y) = 255;
  }
  const TransferForecast f = forecast_transfer(input);
  EXPECT_EQ(f.num_usable, kSource * kSource / 8);
  EXPECT_NEAR(f.surface_share, 72.0, 1e-6);
  ASSERT_EQ(warnings_of(f).size(), 2u);
  EXPECT_NE(warnings_of(f)[0].find("512 of 4096 pixels"), std::string::npos) << warnings_of(f)[0];
}

TEST(TransferForecast, OnlyPixelsWithTheirWholeNeighborhoodCount) {
  TransferInput input = onto_plane(ramp(0, 1), ControlMapping::Rank);
  const TransferForecast whole = forecast_transfer(input);
  EXPECT_EQ(whole.num_whole, (kSource - 6) * (kSource - 6));
  EXPECT_EQ(forecast_transfer(input, 5).num_whole, (kSource - 10) * (kSource - 10));
  // Every seventh column is outside: nearly all can be used, and nothing can be compared.
  input.source_mask = ImageU8(kSource, kSource, 1, 255);
  for (int y = 0; y < kSource; ++y) {
    for (int x = 6; x < kSource; x += 7) input.source_mask.at(x, y) = 0;
  }
  const TransferForecast striped = forecast_transfer(input);
  EXPECT_EQ(striped.num_whole, 0);
  ASSERT_FALSE(warnings_of(striped).empty());
  EXPECT_NE(warnings_of(striped)[0].find("0 of them with their whole neighborhood of 7 x 7"), std::string::npos)
      << warnings_of(striped)[0];
  EXPECT_THROW((void)transfer(input), InvalidInput);
}

TEST(TransferForecast, ASourceOfFewerPixelsThanAWindowHasIsRefused) {
  TransferInput input = onto_plane(ramp(0, 1), ControlMapping::Rank);
  const auto keep = [&](int width, int height) {
    input.source_mask = ImageU8(kSource, kSource, 1);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) input.source_mask.at(x, y) = 255;
    }
  };
  input.texel_size_mm = 2.0;  // As large as a texel: nothing is halved.
  TransferOptions options;
  options.neighborhood_radius_px = 3;
  keep(13, 13);  // 7 x 7 of them have 7 x 7 pixels about them.
  EXPECT_NO_THROW((void)transfer(input, options));
  keep(13, 12);
  EXPECT_THROW((void)transfer(input, options), InvalidInput);
}

}  // namespace
}  // namespace patinate::transfer
