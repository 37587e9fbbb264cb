#include "transfer/exemplar/compared_layers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "libcommon/core/random.h"
#include "patinate/history/memory_history.h"
#include "patinate/transfer/appearance_space.h"

namespace patinate::transfer {
namespace {

constexpr int kLayerSide = 96;

bool is_metal(int x, int y) { return (x / 9 + y / 7) % 2 == 0; }

/// Two frames of colors that say nothing, and a map in both.
MemoryHistoryImages noise_with(const std::string& map, const std::function<float(int, int)>& value) {
  MemoryHistoryImages images{.name = "noise", .texel_size_mm = 0.1, .frames = {}};
  RandomStream random(3, 1);
  for (int f = 0; f < 2; ++f) {
    MemoryFrame frame{.time = static_cast<double>(f), .color = ImageF(kLayerSide, kLayerSide, 3)};
    for (float& v : frame.color.values()) {
      const double root = 0.3 + 0.4 * random.uniform();
      v = static_cast<float>(root * root);
    }
    ImageF extra(kLayerSide, kLayerSide, static_cast<int>(frame_extra_channels(map).size()));
    for (int y = 0; y < kLayerSide; ++y) {
      for (int x = 0; x < kLayerSide; ++x) extra.at(x, y, 0) = value(x, y);
    }
    frame.extras.push_back({map, std::move(extra)});
    images.frames.push_back(std::move(frame));
  }
  return images;
}

/// Share of the appearance's variance that tells the two kinds of places apart.
double share_between(const MemoryHistory& history, double material) {
  AppearanceOptions options;
  options.spatial_radius_px = 0;
  options.structure = 0.0;
  options.material_maps = material;
  const AppearanceSpace space = build_appearance_space(history, 1, options);
  const AppearanceImage& a = space.levels[0];
  double between = 0.0;
  for (int k = 0; k < kAppearanceSize; ++k) {
    double sum[2] = {0.0, 0.0}, count[2] = {0.0, 0.0};
    for (int y = 0; y < kLayerSide; ++y) {
      for (int x = 0; x < kLayerSide; ++x) {
        sum[is_metal(x, y)] += a.at(x, y, k);
        count[is_metal(x, y)] += 1.0;
      }
    }
    const double all = (sum[0] + sum[1]) / (count[0] + count[1]);
    for (int i : {0, 1}) between += count[i] / (count[0] + count[1]) * std::pow(sum[i] / count[i] - all, 2);
  }
  return between / space.variances[0];
}

// All components are kept: 2 frames of 3 colors, and of 1 metalness. Half of the colors' variance is a third of all.
TEST(ComparedLayers, MetalTellsPlacesApartThatLookAlike) {
  const MemoryHistory history(noise_with("metalness", [](int x, int y) { return is_metal(x, y) ? 1.0f : 0.0f; }));
  // The mean of n values of a component is off by its spread / sqrt(n): eight of them, squared, 4 sigma.
  const double chance = 8.0 * 16.0 / (0.5 * kLayerSide * kLayerSide);
  EXPECT_LT(share_between(history, 0.0), chance);
  EXPECT_NEAR(share_between(history, 0.5), 1.0 / 3.0, 0.02);  // Samples are 8192 of 9216 pixels.
  EXPECT_NEAR(share_between(history, 1.0), 1.0 / 2.0, 0.02);
}

TEST(ComparedLayers, WhatHardlyVariesIsNotMadeLarge) {
  RandomStream random(5, 1);
  const MemoryHistory history(
      noise_with("metalness", [&](int, int) { return 0.5f + 1e-4f * static_cast<float>(random.normal()); }));
  const ImageU8 mask = history.read_mask();
  std::vector<ComparedLayer> layers = compared_layers(history, mask, {});
  ASSERT_EQ(layers.size(), 4u);
  SampleMatrix samples(100, 8);
  for (Eigen::Index i = 0; i < 100; ++i) {
    for (Eigen::Index c = 0; c < 8; ++c) samples(i, c) = (c % 4 == 3 ? 1e-4 : 0.1) * random.normal();
  }
  weigh_materials(layers, samples, 0.5);
  EXPECT_EQ(layers[1].weight, 1.0);
}

TEST(ComparedLayers, OfHeightReliefCountsAndNotTheShape) {
  const MemoryHistory history(noise_with("height", [](int x, int y) {
    return 3.0f * static_cast<float>(x) / kLayerSide + (is_metal(x, y) ? 0.05f : 0.0f);  // mm, a pixel is 0.1.
  }));
  const ImageU8 mask = history.read_mask();
  const std::vector<ComparedLayer> layers = compared_layers(history, mask, {});
  const ImageF relief = layers[1].read();
  double metal = 0.0, other = 0.0, slope = 0.0;
  int num_metal = 0, num = 0;
  for (int y = 30; y < kLayerSide - 30; ++y) {  // Farther from the border than the Gaussian reaches.
    for (int x = 30; x < kLayerSide - 30; ++x, ++num) {
      (is_metal(x, y) ? metal : other) += static_cast<double>(relief.at(x, y));
      num_metal += is_metal(x, y);
      slope += (x - 47.5) * static_cast<double>(relief.at(x, y));
    }
  }
  EXPECT_NEAR(metal / num_metal - other / (num - num_metal), 0.5, 0.1);  // Less what the mean around takes of it.
  // The ramp would give 0.3125 pixels of height a pixel.
  double squares = 0.0;
  for (int x = 30; x < kLayerSide - 30; ++x) squares += 36.0 * (x - 47.5) * (x - 47.5);
  EXPECT_LT(std::abs(slope / squares), 0.05 * 0.3125);
}

TEST(ComparedLayers, ConstantMapsCountOnceAndTheObjectsHeightDoesNot) {
  MemoryHistoryImages images = noise_with("normal", [](int, int) { return 0.0f; });
  for (MemoryFrame& frame : images.frames) frame.extras.clear();
  images.maps.push_back({"height", ImageF(kLayerSide, kLayerSide, 1)});
  images.maps.push_back({"specular", ImageF(kLayerSide, kLayerSide, 2)});
  const MemoryHistory history(std::move(images));
  const ImageU8 mask = history.read_mask();
  const std::vector<ComparedLayer> layers = compared_layers(history, mask, {});
  ASSERT_EQ(layers.size(), 3u);
  EXPECT_TRUE(layers[2].material.has_value());
  EXPECT_EQ(layers[2].num_channels, 2);
  AppearanceOptions colors;
  colors.material_maps = 0.0;
  EXPECT_EQ(compared_layers(history, mask, colors).size(), 2u);
}

}  // namespace
}  // namespace patinate::transfer
