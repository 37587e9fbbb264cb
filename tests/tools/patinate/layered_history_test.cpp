#include "app/history/layered_history.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "patinate/core/error.h"
#include "patinate/history/history_sampling.h"
#include "patinate/history/memory_history.h"

namespace patinate::app {
namespace {

constexpr int kSide = 8;

ImageF gray(float value) { return {kSide, kSide, 3, value}; }

/// Gray over time, with a height that opens: column x is below -0.5 mm from time x on.
MemoryHistoryImages opening(int num_frames) {
  MemoryHistoryImages images{.name = "paint", .frames = {}};
  for (int i = 0; i < num_frames; ++i) {
    ImageF height(kSide, kSide);
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) height.at(x, y) = i >= x ? -1.0f : 0.0f;
    }
    images.frames.push_back({.time = static_cast<double>(i), .color = gray(0.5f), .extras = {{"height", height}}});
  }
  ImageF ramp(kSide, kSide);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) ramp.at(x, y) = static_cast<float>(x) / (kSide - 1);
  }
  images.controls.push_back({.facts = {.name = "ramp"}, .values = ramp});
  return images;
}

/// History as bright as it is old, and 0.25 mm high.
MemoryHistoryImages clock_of(int num_frames) {
  MemoryHistoryImages images{.name = "rust", .frames = {}};
  for (int i = 0; i < num_frames; ++i)
    images.frames.push_back({.time = static_cast<double>(i),
                             .color = gray(0.01f * static_cast<float>(i)),
                             .extras = {{"height", ImageF(kSide, kSide, 1, 0.25f)}}});
  return images;
}

std::shared_ptr<const History> in_memory(MemoryHistoryImages images) {
  return std::make_shared<const MemoryHistory>(std::move(images));
}

std::shared_ptr<const History> layered(MemoryHistoryImages below, MemoryHistoryImages above, const std::string& where) {
  return layered_history({.below = in_memory(std::move(below)), .above = in_memory(std::move(above)), .where = where});
}

TEST(LayeredHistory, IsTheUpperOneWhereTheExpressionSaysAndTheLowerOneElsewhere) {
  const auto history = layered(opening(4), clock_of(4), "smoothstep(0.5, 0.50001, ramp)");
  for (int i = 0; i < history->num_frames(); ++i) {
    const ImageF frame = history->read_frame(i);
    EXPECT_EQ(frame.at(0, 3, 0), 0.5f);
    EXPECT_FLOAT_EQ(frame.at(kSide - 1, 3, 0), 0.01f * static_cast<float>(history->facts().frames[i].time));
  }
  EXPECT_EQ(history->facts().controls.at(0).name, "ramp");
  EXPECT_EQ(history->facts().name, "paint + rust");
}

TEST(LayeredHistory, EveryPlaceIsAsOldAsItHasBeenOpen) {
  const auto history = layered(opening(6), clock_of(8), "smoothstep(0, 1, -height)");
  // Column 3 passes the half in the middle between the frames 2 and 3; the upper history goes on behind the lower.
  EXPECT_GT(history->facts().frames.back().time, 6.0);
  for (int i = 0; i < history->num_frames(); ++i) {
    const double time = history->facts().frames[i].time;
    if (time < 3.0) continue;
    EXPECT_NEAR(history->read_frame(i).at(3, 0, 0), 0.01 * std::min(7.0, time - 2.5), 1e-6) << time;
  }
}

TEST(LayeredHistory, HeightsAreAdded) {
  const auto history = layered(opening(4), clock_of(4), "smoothstep(0, 1, -height)");
  const ImageF height = sample_material_map(*history, MaterialMap::Height, 3.0, Between::Blend);
  EXPECT_FLOAT_EQ(height.at(0, 0), -0.75f);
  EXPECT_FLOAT_EQ(height.at(kSide - 1, 0), 0.0f);
}

TEST(LayeredHistory, LiesMmOnMmAndIsMirroredWhereItEnds) {
  MemoryHistoryImages below = opening(2), above = clock_of(2);
  below.texel_size_mm = 1.0;
  above.texel_size_mm = 2.0;  // 16 mm wide, as two of the lower.
  for (MemoryFrame& frame : above.frames) {
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) frame.color.at(x, y, 0) = static_cast<float>(x);
    }
  }
  const ImageF coarse = layered(below, above, "1")->read_frame(1);
  EXPECT_FLOAT_EQ(coarse.at(4, 2, 0), 1.75f);  // Its pixel's middle, 4.5 mm, is at 2.25 - 0.5 of the upper pixels.
  above.texel_size_mm = 1.0;
  below.texel_size_mm = 1.0;
  MemoryHistoryImages small = above;
  for (MemoryFrame& frame : small.frames) {
    ImageF part(4, 4, 3);
    for (int y = 0; y < 4; ++y) {
      for (int x = 0; x < 4; ++x) part.at(x, y, 0) = static_cast<float>(x);
    }
    frame.color = part;
    frame.extras.clear();
  }
  const ImageF mirrored = layered(below, small, "1")->read_frame(1);
  for (int x = 0; x < kSide; ++x) EXPECT_EQ(mirrored.at(x, 0, 0), static_cast<float>(x < 4 ? x : 7 - x));
}

TEST(LayeredHistory, ShowsNothingOfWhatIsOutsideTheUpperMask) {
  MemoryHistoryImages above = clock_of(2);
  above.mask = ImageU8(kSide, kSide, 1, 255);
  above.mask.at(5, 5) = 0;
  const ImageF frame = layered(opening(2), above, "1")->read_frame(1);
  EXPECT_EQ(frame.at(5, 5, 0), 0.5f);
  EXPECT_FLOAT_EQ(frame.at(4, 5, 0), 0.01f);
}

TEST(LayeredHistory, WhatCannotBeLaidIsSaid) {
  EXPECT_THROW((void)layered(opening(2), clock_of(2), "ramq"), ParseError);
  EXPECT_THROW((void)layered(opening(2), clock_of(2), "map.png"), ParseError);
  EXPECT_THROW((void)layered(opening(2), clock_of(2), "0.4*ramp"), InvalidInput);
}

}  // namespace
}  // namespace patinate::app
