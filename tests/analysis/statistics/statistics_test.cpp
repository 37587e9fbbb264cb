#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <sstream>

#include "analysis/statistics/history_statistics.h"
#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"
#include "patinate/image/image_io.h"
#include "tests/support/histories.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_data.h"

namespace patinate::analysis {
namespace {

using testing_support::TempFolder;

TEST(ColorClasses, EveryPixelBelongsToTheNearestCode) {
  const std::vector<ColorClass> classes{parse_color_class("white=#ffffff"), parse_color_class("Green=#00fF00"),
                                        parse_color_class("black=#000000")};
  ImageF image(4, 1, 3);
  const std::array<std::array<float, 3>, 4> codes{
      {{0.9f, 0.9f, 0.9f}, {0.2f, 0.7f, 0.1f}, {0.1f, 0.2f, 0.1f}, {0.3f, 0.3f, 0.3f}}};
  for (int x = 0; x < 4; ++x) {
    for (int c = 0; c < 3; ++c) image.at(x, 0, c) = linear_from_srgb(codes[x][c]);
  }
  EXPECT_EQ(class_shares(image, {}, classes), (std::vector<double>{0.25, 0.25, 0.5}));
  ImageU8 mask(4, 1);
  EXPECT_THROW((void)class_shares(image, mask, classes), InvalidInput);
  mask.at(1, 0) = 255;
  EXPECT_EQ(class_shares(image, mask, classes), (std::vector<double>{0.0, 1.0, 0.0}));
  for (const char* bad : {"", "#ffffff", "a=ffffff", "a=#fffff", "a=#gggggg", "=#ffffff", "a=#fffffff"})
    EXPECT_THROW((void)parse_color_class(bad), InvalidInput) << bad;
}

TEST(HistoryStatistics, OfARampAreItsTimesAndShares) {
  const TempFolder folder;
  // Columns 0 to 15 never change; the others go from white to black over frames 2 to 6.
  testing_support::write_history(folder.path(), 32, 32, 9, [](int x, int, int f, int) {
    return x < 16 ? 1.0f : linear_from_srgb(std::clamp(1.0f - 0.25f * static_cast<float>(f - 2), 0.0f, 1.0f));
  });
  const HistoryStatistics s =
      history_statistics(open_series(folder.path()).series,
                         {parse_color_class("white=#ffffff"), parse_color_class("black=#000000")}, 0, 5.0);
  EXPECT_EQ(s.ages_share, 0.5);
  EXPECT_EQ(s.covered.front(), 0.0);
  EXPECT_EQ(s.covered[3], 0.5);
  EXPECT_NEAR(s.mean_lab.front()[0], 100.0, 1e-4);
  EXPECT_NEAR(s.mean_lab.back()[0], 50.0, 1e-4);
  EXPECT_EQ(s.class_shares.front(), (std::vector<double>{1.0, 0.0}));
  EXPECT_EQ(s.class_shares.back(), (std::vector<double>{0.5, 0.5}));
  ASSERT_TRUE(s.onset && s.saturation);
  EXPECT_GT(s.onset->median, 2.0);
  EXPECT_LT(s.onset->median, 3.0);
  EXPECT_GT(s.saturation->median, 5.0);
  EXPECT_LT(s.saturation->median, 6.0);
  EXPECT_FALSE(s.correlation_length.front());  // Constant.
}

TEST(HistoryStatistics, ClassesOfABananaFollowThePublishedCurve) {
  PATINATE_REQUIRE_DATA(folder, "timelapse/banana_14_B");
  const char* palette[] = {"w=#ffffff",  "g1=#576a26", "g2=#919e39", "yg=#b1ab3e", "y1=#d6c350",
                           "y2=#eece5a", "yb=#d1a123", "b1=#966521", "b2=#5c361f", "b3=#261d19"};
  std::vector<ColorClass> classes;
  for (const char* p : palette) classes.push_back(parse_color_class(p));
  std::map<std::string, std::vector<double>> published;
  std::istringstream rows(read_file(folder / "_meta/data-colors.csv"));
  for (std::string row; std::getline(rows, row);) {
    const std::vector<std::string> cells = split(row, ',');
    if (cells.size() != 19 || cells[7].find("14_B") == std::string::npos) continue;
    std::vector<double>& shares = published[cells[7].substr(1, cells[7].size() - 2)];
    for (std::size_t k = 9; k < 19; ++k) shares.push_back(parse_number(cells[k]).value());
  }
  ASSERT_EQ(published.size(), 20u);
  // Theirs were counted on smaller copies of the photographs: mixed pixels along edges and on speckles change class.
  // One class in ten steps of lightness holds about 1 % of the picture within half an 8-bit code of its border.
  constexpr double kMixedPixels = 0.02;
  int number = 0;
  for (const auto& [file, shares] : published) {
    if (number++ % 5 != 0) continue;  // Four of the twenty photographs.
    const std::vector<double> found = class_shares(read_color(folder / file), {}, classes);
    for (std::size_t k = 0; k < shares.size(); ++k)
      EXPECT_NEAR(found[k], shares[k], kMixedPixels) << file << " " << classes[k].name;
  }
}

}  // namespace
}  // namespace patinate::analysis
