#include "capture/background/background.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>

#include "capture/project/plain_object.h"
#include "capture/timelapse/ingest.h"
#include "libcommon/core/files.h"
#include "libcommon/core/random.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"
#include "tests/capture/timelapse/ingest_folder.h"
#include "tests/support/errors.h"
#include "tests/support/temp_folder.h"

namespace patinate::capture {
namespace {

constexpr int kSide = 120;
constexpr double kRadius = 30.0;
constexpr double kGrain = 0.012;  ///< 3 codes of 255.
using Color = std::array<float, 3>;
constexpr Color kGray{0.58f, 0.56f, 0.55f}, kLeaf{0.35f, 0.5f, 0.2f};

double from_center(int x, int y) { return std::hypot(x - 0.5 * (kSide - 1), y - 0.5 * (kSide - 1)); }

/// A leaf on a card under a lamp that leaves 0.7 of its light in the corners, with a spot of the card's color on it.
ImageF leaf_on_card(std::uint64_t seed, const Color& card = kGray, const Color& leaf = kLeaf) {
  RandomStream random(seed, 0);
  ImageF codes(kSide, kSide, 3);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const double r = from_center(x, y);
      const bool is_leaf = r < kRadius && r > 6.0;
      const float light = static_cast<float>(1.0 - 0.15 * r * r / (0.5 * kSide * kSide / 4.0));
      for (int c = 0; c < 3; ++c) {
        const auto k = static_cast<std::size_t>(c);
        codes.at(x, y, c) = light * (is_leaf ? leaf[k] : card[k]) + static_cast<float>(kGrain * random.normal());
      }
    }
  }
  return codes;
}

/// Pixels that are wrong, but for those within `rim_px` of the outline.
int num_wrong(const ImageU8& background, bool is_spot_background, double rim_px = 2.0) {
  int num = 0;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const double r = from_center(x, y);
      if (std::abs(r - kRadius) < rim_px || std::abs(r - 6.0) < rim_px) continue;
      const bool expected = r > kRadius || (is_spot_background && r < 6.0);
      num += (background.at(x, y) != 0) != expected;
    }
  }
  return num;
}

TEST(PlainBackground, ReachesToTheOutlineAndNotIntoSpotsOfItsColor) {
  const PlainBackground found = plain_background(leaf_on_card(1), {});
  EXPECT_TRUE(found.is_plain());
  // Grain of three channels is beyond five deviations in 1.5 of 100,000 pixels: of 14,400 none is expected.
  EXPECT_GT(found.border_share, 0.999);
  EXPECT_LE(num_wrong(found.mask, false), 4);
}

TEST(PlainBackground, APictureThatIsFullOfMaterialHasNone) {
  ImageF codes(kSide, kSide, 3);
  RandomStream random(2, 0);
  for (float& v : codes.values()) v = 0.5f + 0.15f * static_cast<float>(random.normal());
  EXPECT_FALSE(plain_background(codes, {}).is_plain());
}

TEST(PlainBackground, WhatAPhotographDoesNotShowIsNoBorder) {
  ImageF codes = leaf_on_card(3);
  ImageU8 known(kSide, kSide, 1, 255);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < 12; ++x) {
      known.at(x, y) = 0;
      for (int c = 0; c < 3; ++c) codes.at(x, y, c) = 0.0f;
    }
  }
  const PlainBackground found = plain_background(codes, known);
  EXPECT_TRUE(found.is_plain());
  EXPECT_LE(num_wrong(found.mask, false), 4);
}

TEST(KeyedBackground, TakesAllShadesOfAColorWhereverTheyAre) {
  const Color blue{0.1f, 0.25f, 0.7f};
  // Another name for the same paint: a third darker.
  const ImageU8 found = keyed_background(leaf_on_card(4, blue), {0.07f, 0.17f, 0.47f});
  EXPECT_EQ(num_wrong(found, true), 0);
}

TEST(UnchangingBackground, IsWhatStaysInAllPhotographsAndTouchesTheBorder) {
  std::vector<ImageF> series;
  for (int i = 0; i < 6; ++i) {
    const float aged = 0.06f * static_cast<float>(i);
    series.push_back(leaf_on_card(10 + static_cast<std::uint64_t>(i), kGray, {0.35f + aged, 0.5f - aged, 0.2f}));
  }
  // A change of 0.21 from the middle is above 0.012 up to 1.6 sigma = 2.4 px outside of the outline once it is
  // smoothed; threads of background thinner than 3 px do not count, one more on either side. Smoothed grain is beyond
  // 0.012 = 5.3 of its deviations once in 300,000 pixels and photographs, at the border, where half of the window is
  // missing, once in 3,000: three places of 3 x 3 px.
  EXPECT_LE(num_wrong(unchanging_background(series), false, 4.0), 27);
  EXPECT_THROW((void)unchanging_background({series.front()}), InvalidInput);
}

TEST(BackgroundRule, ListsWhatThereIs) {
  EXPECT_EQ(background_rule("#ff8000").color[1], 128.0f / 255.0f);
  for (const char* wrong : {"", "blue", "#12345", "#gggggg", "#1234567"}) {
    EXPECT_THROW((void)background_rule(wrong), InvalidInput) << wrong;
  }
}

/// Three photographs of the leaf, as a project.
void write_leaves(const std::filesystem::path& folder, const std::vector<ImageF>& photographs) {
  std::filesystem::create_directories(folder / "frames");
  for (std::size_t i = 0; i < photographs.size(); ++i) {
    ImageU8 codes(kSide, kSide, 3);
    for (std::int64_t k = 0; k < 3 * codes.num_pixels(); ++k)
      codes.data()[k] =
          static_cast<std::uint8_t>(std::lround(255.0f * std::clamp(photographs[i].data()[k], 0.0f, 1.0f)));
    write_codes(folder / "frames" / (std::to_string(i) + ".png"), codes);
  }
  write_atomically(folder / "capture.json", R"({"format": "patinate.capture", "version": 1, "name": "leaf",
    "kind": "fixed", "frames": {"pattern": "frames/*.png", "interval": 1}})");
}

/// A photograph, moved to the right by `by_px` pixels.
ImageF moved_by(const ImageF& photograph, int by_px) {
  ImageF moved = photograph;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x)
      for (int c = 0; c < 3; ++c) moved.at(x, y, c) = photograph.at(std::max(0, x - by_px), y, c);
  }
  return moved;
}

std::optional<PlainObject> plain_object_of(const std::vector<ImageF>& photographs) {
  const testing_support::TempFolder folder;
  write_leaves(folder.path(), photographs);
  std::vector<std::filesystem::path> files;
  for (std::size_t i = 0; i < photographs.size(); ++i)
    files.push_back(folder.path() / "frames" / (std::to_string(i) + ".png"));
  return find_plain_object(files);
}

TEST(PlainObject, IsOneLargePartInEveryPhotograph) {
  const std::optional<PlainObject> still = plain_object_of({leaf_on_card(1), leaf_on_card(2), leaf_on_card(3)});
  ASSERT_TRUE(still);
  // The spot of the card's color is enclosed, so it belongs to the leaf; its outline is known to a pixel.
  EXPECT_NEAR(still->share, std::numbers::pi * kRadius * kRadius / (kSide * kSide),
              2.0 * std::numbers::pi * kRadius / (kSide * kSide));
  EXPECT_FALSE(still->has_moved);
  // A leaf of a radius of 30 that moved by 10 shares 0.65 of the area that both cover.
  const std::optional<PlainObject> moved =
      plain_object_of({leaf_on_card(1), leaf_on_card(2), moved_by(leaf_on_card(3), 10)});
  ASSERT_TRUE(moved);
  EXPECT_TRUE(moved->has_moved);
}

TEST(PlainObject, IsNoCoatThatRusts) {
  // The first photograph of a coat is as plain as a card; so are those on which the rust is not yet large.
  const ImageF coat = leaf_on_card(1, kGray, kGray);
  EXPECT_FALSE(plain_object_of({coat, leaf_on_card(2), leaf_on_card(3)}));
  EXPECT_FALSE(plain_object_of({coat, coat, coat}));
  // Another card is another background: its color is further off than a camera's balance.
  EXPECT_FALSE(plain_object_of({leaf_on_card(1), leaf_on_card(2), leaf_on_card(3, {0.2F, 0.2F, 0.6F})}));
}

IngestOptions with_rule(const char* rule) {
  IngestOptions options;
  options.background.mask_background = rule;
  return options;
}

TEST(IngestBackground, IsOffTheMaskInEveryPhotographThatShowsIt) {
  const testing_support::TempFolder folder;
  write_leaves(folder.path(), {leaf_on_card(1), leaf_on_card(2), leaf_on_card(3)});
  const HistoryReader history = testing_support::ingest(folder.path(), with_rule("plain"));
  const ImageU8 mask = history.read_mask();
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const double r = from_center(x, y);
      // The rim is three pixels, and the outline's own two.
      if (r < kRadius - 5.0) {
        EXPECT_NE(mask.at(x, y), 0) << x << " " << y;
      }
      if (r > kRadius - 1.0) {
        EXPECT_EQ(mask.at(x, y), 0) << x << " " << y;
      }
    }
  }
  EXPECT_TRUE(history.manifest().warnings.empty());
}

TEST(IngestBackground, IsWhatTheProjectSaysUnlessTheOptionSaysOtherwise) {
  const testing_support::TempFolder folder;
  write_leaves(folder.path(), {leaf_on_card(1), leaf_on_card(2)});
  const std::string text = read_file(folder.path() / "capture.json");
  write_atomically(folder.path() / "capture.json", text.substr(0, text.rfind('}')) + R"(, "background": "plain"})");
  EXPECT_TRUE(testing_support::ingest(folder.path(), {}).manifest().mask);
  std::filesystem::remove_all(folder.path() / "out");
  EXPECT_FALSE(testing_support::ingest(folder.path(), with_rule("off")).manifest().mask);
  write_atomically(folder.path() / "capture.json", text.substr(0, text.rfind('}')) + R"(, "background": "white"})");
  const std::string error = testing_support::ingest_error(folder.path(), {});
  EXPECT_TRUE(testing_support::has(error, "background")) << error;
  EXPECT_TRUE(testing_support::has(error, "unchanging")) << error;
}

TEST(IngestBackground, ThatIsNowhereIsWarnedOf) {
  const testing_support::TempFolder folder;
  // All of it changes: nothing is unchanging.
  write_leaves(folder.path(), {leaf_on_card(1), leaf_on_card(2, {0.4F, 0.4F, 0.4F}, {0.1F, 0.1F, 0.1F})});
  const HistoryReader history = testing_support::ingest(folder.path(), with_rule("unchanging"));
  bool is_named = false;
  for (const HistoryWarning& w : history.manifest().warnings)
    is_named = is_named || testing_support::has(w.text, "finds no background");
  EXPECT_TRUE(is_named);
}

TEST(IngestBackground, APhotographThatAloneShowsItOnTheObjectIsNamed) {
  const testing_support::TempFolder folder;
  ImageF moved = leaf_on_card(3);
  const ImageF whole = moved;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x + 12 < kSide; ++x)
      for (int c = 0; c < 3; ++c) moved.at(x, y, c) = whole.at(x + 12, y, c);
  }
  write_leaves(folder.path(), {leaf_on_card(1), leaf_on_card(2), moved, leaf_on_card(4)});
  const HistoryReader history = testing_support::ingest(folder.path(), with_rule("plain"));
  bool is_named = false;
  for (const HistoryWarning& w : history.manifest().warnings)
    is_named = is_named || testing_support::has(w.text, "2.png alone shows background");
  EXPECT_TRUE(is_named);
}

TEST(IngestBackground, NoneIsAnErrorThatNamesThePhotograph) {
  const testing_support::TempFolder folder;
  RandomStream random(5, 0);
  ImageF full(kSide, kSide, 3);
  for (float& v : full.values()) v = 0.5f + 0.15f * static_cast<float>(random.normal());
  write_leaves(folder.path(), {full});
  const std::string error = testing_support::ingest_error(folder.path(), with_rule("plain"));
  EXPECT_TRUE(testing_support::has(error, "0.png")) << error;
  EXPECT_TRUE(testing_support::has(error, "no plain background")) << error;
}

}  // namespace
}  // namespace patinate::capture
