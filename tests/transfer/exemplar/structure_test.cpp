#include "transfer/exemplar/structure.h"

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <utility>

#include "libcommon/core/random.h"
#include "patinate/core/error.h"
#include "patinate/history/memory_history.h"
#include "tests/support/histories.h"
#include "transfer/exemplar/regions.h"

namespace patinate::transfer {
namespace {

constexpr int kPictureSide = 160;
constexpr int kCell = 32;

ImageF picture(const std::function<float(int x, int y)>& lightness) {
  ImageF image(kPictureSide, kPictureSide);
  for (int y = 0; y < kPictureSide; ++y) {
    for (int x = 0; x < kPictureSide; ++x) image.at(x, y) = lightness(x, y);
  }
  return image;
}

/// Lines two pixels wide, every kCell pixels, and a little noise.
bool is_on_line(int x, int y) { return x % kCell < 2 || y % kCell < 2; }
float noise(int x, int y) {
  return static_cast<float>(
      RandomStream(1, static_cast<std::uint64_t>(y) * kPictureSide + static_cast<std::uint64_t>(x)).uniform());
}
ImageF grid(float line, float cell) {
  return picture([=](int x, int y) { return (is_on_line(x, y) ? line : cell) + noise(x, y); });
}

ImageU8 everything() { return ImageU8(kPictureSide, kPictureSide, 1, 255); }

TEST(Structure, OfAGridAreItsLines) {
  for (bool dark : {true, false}) {
    const SourceStructure structure = line_structure(dark ? grid(40, 70) : grid(70, 40), everything());
    ASSERT_FALSE(structure.empty());
    EXPECT_EQ(structure.kind, dark ? StructureKind::DarkLines : StructureKind::BrightLines);
    constexpr double kShare = 1.0 - (kCell - 2.0) * (kCell - 2.0) / (1.0 * kCell * kCell);
    EXPECT_NEAR(structure.share, kShare, 0.01);  // At the picture's border a closing sees half a line.
    // The middle of a cell lies 15 pixels from a line, and 98 % of the pixels lie nearer.
    EXPECT_GT(structure.scale_px, 10.0);
    EXPECT_LE(structure.scale_px, 16.0);
    const auto line = structure.channels.pixel(kCell, kCell + 10),
               cell = structure.channels.pixel(kCell + 16, kCell + 16);
    EXPECT_EQ(line[0], 0.0f);
    EXPECT_GT(cell[0], 1.0f);
    EXPECT_GT(line[3], 0.9f);
    EXPECT_EQ(cell[3], 0.0f);
  }
}

// Lines as dense as those of a crackle glaze, which cover 24 to 35 %.
TEST(Structure, LinesThatCoverTooMuchAreRefusedWithTheirShare) {
  constexpr int kNarrow = 11;
  int on = 0;
  const ImageF narrow = picture([&](int x, int y) {
    const bool is_on = x % kNarrow < 2 || y % kNarrow < 2;
    on += is_on ? 1 : 0;
    return (is_on ? 40.0f : 70.0f) + noise(x, y);
  });
  const SourceStructure structure = line_structure(narrow, everything());
  EXPECT_TRUE(structure.empty());
  EXPECT_NEAR(structure.refused_line_share, static_cast<double>(on) / (kPictureSide * kPictureSide), 0.02);
  EXPECT_EQ(line_structure(grid(40, 70), everything()).refused_line_share, 0.0);
}

TEST(Structure, ChannelsKeepTheirRange) {
  const SourceStructure structure = line_structure(grid(20, 90), everything());
  for (int y = 0; y < kPictureSide; ++y) {
    for (int x = 0; x < kPictureSide; ++x) {
      for (int c = 0; c < kStructureSize; ++c) {
        ASSERT_GE(structure.channels.at(x, y, c), 0.0f);
        ASSERT_LE(structure.channels.at(x, y, c), c < 2 ? 2.0f : 1.0f);
      }
    }
  }
}

TEST(Structure, NeitherNoiseNorSpotsNorAFlatPictureHaveAny) {
  EXPECT_TRUE(line_structure(picture([](int x, int y) { return 50.0f + 20.0f * noise(x, y); }), everything()).empty());
  EXPECT_TRUE(line_structure(picture([](int, int) { return 50.0f; }), everything()).empty());
  const auto spots = [](int x, int y) {
    const int dx = x % kCell - kCell / 2, dy = y % kCell - kCell / 2;
    return dx * dx + dy * dy < 25 ? 30.0f : 70.0f;
  };
  EXPECT_TRUE(line_structure(picture(spots), everything()).empty());
}

TEST(Structure, LinesAmongGrainAreFoundAndGrainAloneHasNone) {
  // Dark specks of two pixels, as many as a tenth of the surface, as dark as the lines.
  const auto grain = [](int x, int y) {
    return RandomStream(2, static_cast<std::uint64_t>(y / 2) * kPictureSide + static_cast<std::uint64_t>(x / 2))
               .uniform() < 0.1;
  };
  const auto among = [&](bool lines) {
    return picture(
        [=](int x, int y) { return (grain(x, y) || (lines && is_on_line(x, y)) ? 40.0f : 70.0f) + noise(x, y); });
  };
  EXPECT_TRUE(line_structure(among(false), everything()).empty());
  const SourceStructure found = line_structure(among(true), everything());
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found.channels.pixel(kCell, kCell + 10)[0], 0.0f) << "on a line";
}

TEST(Structure, AControlOfTheHistorySaysWhereItIs) {
  MemoryHistoryImages images =
      testing_support::half_images(kPictureSide, kPictureSide, 1, [](int, int, int, int) { return 0.5f; });
  MemoryControl cracks{.facts = {.name = "cracks"},
                       .values = picture([](int x, int y) { return is_on_line(x, y) ? 1.0f : 0.0f; })};
  images.controls.push_back(cracks);
  const MemoryHistory history(std::move(images));
  EXPECT_TRUE(find_structure(history, everything()).empty()) << "the picture is gray";
  const SourceStructure given = find_structure(history, everything(), {.structure_map = "cracks"});
  ASSERT_FALSE(given.empty());
  EXPECT_NE(given.kind, StructureKind::Regions);
  EXPECT_EQ(given.channels.pixel(kCell, kCell + 10)[0], 0.0f);
  EXPECT_GT(given.channels.pixel(kCell + 16, kCell + 16)[0], 1.0f);
  // "x" rises from left to right: half of it is high.
  EXPECT_EQ(find_structure(history, everything(), {.structure_map = "x"}).kind, StructureKind::Regions);
  EXPECT_TRUE(find_structure(history, everything(), {.structure = 0.0, .structure_map = "cracks"}).empty());
  EXPECT_THROW((void)find_structure(history, everything(), {.structure_map = "veins"}), InvalidInput);
}

TEST(Structure, WhatLiesOutsideOfTheMaskIsNotLookedAt) {
  ImageU8 mask = everything();
  for (int y = 0; y < kPictureSide; ++y) {
    for (int x = kPictureSide / 2; x < kPictureSide; ++x) mask.at(x, y) = 0;
  }
  const ImageF half =
      picture([](int x, int y) { return x >= kPictureSide / 2 && is_on_line(x, y) ? 30.0f : 70.0f + noise(x, y); });
  EXPECT_TRUE(line_structure(half, mask).empty());
  EXPECT_FALSE(line_structure(half, everything()).empty());
}

/// Round patches of one color on another, and noise.
ImageF patches(int radius, float contrast) {
  ImageF image(kPictureSide, kPictureSide, 3);
  for (int y = 0; y < kPictureSide; ++y) {
    for (int x = 0; x < kPictureSide; ++x) {
      const int dx = x % 40 - 20, dy = y % 40 - 20;
      const float patch = dx * dx + dy * dy < radius * radius ? contrast : 0.0f;
      const std::array<float, 3> color{0.3f + patch, 0.3f, 0.3f - 0.5f * patch};
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = color[c] + 0.04f * noise(x, y);
    }
  }
  return image;
}

TEST(Regions, OfPatchesAreTheirInside) {
  const Regions regions = find_regions(patches(10, 0.3f), everything());
  ASSERT_FALSE(regions.is_second.empty());
  EXPECT_NEAR(regions.share, 3.14159 * 100.0 / 1600.0, 0.02);
  EXPECT_NEAR(regions.width_px, 10.0, 2.0) << "twice the area of a disk over its border is its radius";
  EXPECT_NE(regions.is_second.at(20, 20), regions.is_second.at(0, 0));
}

TEST(Regions, NeitherNoiseNorAGradientNorSpecklesHaveAny) {
  EXPECT_TRUE(find_regions(patches(10, 0.0f), everything()).is_second.empty());
  EXPECT_TRUE(find_regions(patches(3, 0.3f), everything()).is_second.empty()) << "a neighborhood sees them whole";
  ImageF gradient(kPictureSide, kPictureSide, 3);
  for (int y = 0; y < kPictureSide; ++y) {
    for (int x = 0; x < kPictureSide; ++x) {
      for (int c = 0; c < 3; ++c)
        gradient.at(x, y, c) = 0.1f + 0.8f * static_cast<float>(x) / kPictureSide + 0.1f * noise(x, y);
    }
  }
  EXPECT_TRUE(find_regions(gradient, everything()).is_second.empty());
}

TEST(Structure, APictureSmallerThanAnyLineHasNone) {
  EXPECT_TRUE(line_structure(ImageF(4, 4), ImageU8(4, 4, 1, 255)).empty());
}

}  // namespace
}  // namespace patinate::transfer
