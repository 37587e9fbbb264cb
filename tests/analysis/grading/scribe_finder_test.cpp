#include "analysis/grading/scribe_finder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "patinate/datasets/panel.h"
#include "patinate/image/color.h"

namespace patinate::analysis {
namespace {

/// An unexposed panel; the scribe is all that is on it.
datasets::Panel panel_with(bool has_scribe, std::int64_t seed, double lightness, bool is_crossed = false) {
  return datasets::make_panel({.width = 400,
                               .height = 300,
                               .num_frames = 2,
                               .edge_mm = 3.0,
                               .scribe = has_scribe,
                               .cross = is_crossed,
                               .creep_mm = 1.0,
                               .paint = {lightness, -2.0, 4.0},
                               .color_change = {0.0, 0.0, 0.0},
                               .seed = seed});
}

ImageF linear_from_codes(const ImageU8& photo) {
  ImageF out(photo.width(), photo.height(), 3);
  for (std::int64_t i = 0; i < 3 * out.num_pixels(); ++i)
    out.data()[i] = linear_from_srgb(static_cast<float>(photo.data()[i]) / 255.0f);
  return out;
}

std::vector<Scribe> found_on(const datasets::Panel& panel) {
  const ImageF color = linear_from_codes(panel.frames.front().photo);
  return find_scribes(color, ImageU8(color.width(), color.height(), 1, 255), panel.options.pixel_mm);
}

/// Across, the fit is far better than a pixel; an end is known to a pixel and what the blur takes, and a tenth of the
/// scribe at each end is not used.
void expect_same(const Scribe& found, const datasets::PanelScribe& cut, double pixel_mm) {
  const Vec2 a(found.x0, found.y0), b(found.x1, found.y1);
  const bool is_forward = (a - cut.from_mm).norm() < (a - cut.to_mm).norm();
  const Vec2 &begin = is_forward ? a : b, &end = is_forward ? b : a;
  const Vec2 along = (cut.to_mm - cut.from_mm).normalized(), across(-along.y(), along.x());
  for (const auto& [place, truth] : {std::pair(begin, cut.from_mm), std::pair(end, cut.to_mm)}) {
    EXPECT_NEAR((place - truth).dot(across), 0.0, 0.5 * pixel_mm);
    EXPECT_NEAR((place - truth).dot(along), 0.0, 3.0 * pixel_mm);
  }
  EXPECT_NEAR(found.width_mm, cut.width_mm, pixel_mm);
}

TEST(FindScribes, LieWhereThePanelWasCut) {
  for (const double lightness : {30.0, 78.0, 92.0}) {
    for (std::int64_t seed = 1; seed <= 4; ++seed) {
      SCOPED_TRACE(std::to_string(lightness) + ", seed " + std::to_string(seed));
      const datasets::Panel panel = panel_with(true, seed, lightness);
      const std::vector<Scribe> found = found_on(panel);
      ASSERT_EQ(found.size(), 1U);
      expect_same(found.front(), panel.scribes.front(), panel.options.pixel_mm);
    }
  }
}

TEST(FindScribes, AreBothArmsOfACross) {
  for (const double lightness : {30.0, 78.0, 92.0}) {
    for (std::int64_t seed = 1; seed <= 4; ++seed) {
      SCOPED_TRACE(std::to_string(lightness) + ", seed " + std::to_string(seed));
      const datasets::Panel panel = panel_with(true, seed, lightness, true);
      const std::vector<Scribe> found = found_on(panel);
      ASSERT_EQ(found.size(), 2U);
      // The first arm leans to the right where it goes down.
      const bool is_first = (found[0].x1 - found[0].x0) * (found[0].y1 - found[0].y0) > 0.0;
      expect_same(found[0], panel.scribes[is_first ? 0 : 1], panel.options.pixel_mm);
      expect_same(found[1], panel.scribes[is_first ? 1 : 0], panel.options.pixel_mm);
    }
  }
}

TEST(FindScribes, AreNoneOnAPanelWithoutOne) {
  for (const double lightness : {30.0, 78.0, 92.0}) {
    for (std::int64_t seed = 11; seed <= 14; ++seed)
      EXPECT_TRUE(found_on(panel_with(false, seed, lightness)).empty()) << lightness << ", seed " << seed;
  }
}

TEST(FindScribes, AreNoEdgesOfThePanel) {
  // The panel lies on a dark table: its edges are long, straight and dark.
  ImageF color = linear_from_codes(panel_with(false, 21, 78.0).frames.front().photo);
  ImageU8 mask(color.width(), color.height(), 1, 255);
  for (int y = 0; y < color.height(); ++y) {
    for (int x = 0; x < 60; ++x) {
      for (int c = 0; c < 3; ++c) color.at(x, y, c) = 0.02f;
      mask.at(x, y) = 0;
    }
  }
  EXPECT_TRUE(find_scribes(color, mask, 0.1).empty());
}

}  // namespace
}  // namespace patinate::analysis
