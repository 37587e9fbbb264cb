#include "analysis/cracks/line_structure.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "analysis/cracks/line_mask.h"
#include "analysis/cracks/line_pixels.h"
#include "patinate/core/error.h"

namespace patinate::analysis {
namespace {

constexpr int kSide = 200, kPitch = 40, kCell = kPitch - 1, kCells = 4;  // Lines at 20, 60 ... 180.

/// A grid whose lines run to the border: 4 x 4 cells touch neither border.
ImageU8 grid(int width = 1) {
  ImageU8 lines(kSide, kSide);
  const auto is_line = [&](int v) { return (v + kPitch / 2 + width / 2) % kPitch < width; };
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) lines.at(x, y) = is_line(x) || is_line(y) ? 255 : 0;
  }
  return lines;
}

/// Ten pixels of the line x = 60 are away between rows of cells `row` and the next.
void cut(ImageU8& lines, int column, int row) {
  for (int y = -5; y < 5; ++y) {
    for (int x = -3; x <= 3; ++x) lines.at(column * kPitch + 20 + x, row * kPitch + kPitch + y) = 0;
  }
}

ImageU8 turned(const ImageU8& in) {
  ImageU8 out(in.height(), in.width());
  for (int y = 0; y < in.height(); ++y) {
    for (int x = 0; x < in.width(); ++x) out.at(in.height() - 1 - y, x) = in.at(x, y);
  }
  return out;
}
ImageU8 mirrored(const ImageU8& in) {
  ImageU8 out(in.width(), in.height());
  for (int y = 0; y < in.height(); ++y) {
    for (int x = 0; x < in.width(); ++x) out.at(in.width() - 1 - x, y) = in.at(x, y);
  }
  return out;
}

TEST(LineStructure, AGridOfCellsIsClosedAndHasNoEnds) {
  const LineStructure s = measure_structure(grid(), {}, {});
  EXPECT_EQ(s.num_ends, 0);
  EXPECT_EQ(s.num_junctions, 25);
  EXPECT_EQ(s.cells_px.size(), 16u);
  EXPECT_EQ(s.median_cell_px(), kCell * kCell);
  EXPECT_DOUBLE_EQ(s.closed_share(), kCells * kCells * kCell * kCell / double{kSide * kSide});
  EXPECT_DOUBLE_EQ(s.share(), (5.0 * kSide + 5.0 * (kSide - 5)) / (kSide * kSide));
  EXPECT_NEAR(s.length_px, 10 * (kSide - 1) * 0.948, 1e-6);
  // Six pixels of both ends of each line are border, and of the steps those count that begin inside.
  EXPECT_NEAR(s.inner_length_px, 10 * (kSide - 12) * 0.948, 1e-6);
}

TEST(LineStructure, EveryGapHasTwoEnds) {
  ImageU8 lines = grid();
  int gaps = 0;
  for (const auto& [column, row] : {std::pair{1, 0}, std::pair{2, 1}, std::pair{3, 3}}) {
    cut(lines, column, row);
    ++gaps;
    const LineStructure s = measure_structure(lines, {}, {});
    EXPECT_EQ(s.num_ends, 2 * gaps);
    EXPECT_EQ(s.cells_px.size(), 16u - static_cast<std::size_t>(gaps));  // Two cells become one.
    EXPECT_EQ(s.num_junctions, 25);
    EXPECT_DOUBLE_EQ(s.ends_per_px().value(), 2.0 * gaps / s.inner_length_px);
  }
  // A gap to a cell that touches the border opens one.
  cut(lines, 0, 1);
  EXPECT_DOUBLE_EQ(measure_structure(lines, {}, {}).closed_px, 15.0 * kCell * kCell + 10.0 * gaps);
}

TEST(LineStructure, WideLinesSayTheSame) {
  ImageU8 lines = grid(5);
  cut(lines, 1, 0);
  cut(lines, 2, 1);
  const LineStructure s = measure_structure(lines, {}, {});
  EXPECT_EQ(s.num_ends, 4);
  EXPECT_EQ(s.cells_px.size(), 14u);
  EXPECT_EQ(s.num_junctions, 25);
  // Center lines lie to a pixel: a cell's sides move by one at most, and 14 of 16 cells are whole.
  EXPECT_NEAR(s.closed_px, 16.0 * kCell * kCell, 16.0 * 4.0 * kPitch);
}

TEST(LineStructure, ShortSpursAreLeftOutAndLongOnesAreEnds) {
  const LineStructure plain = measure_structure(grid(), {}, {});
  for (const int length : {1, 4, 5, 12}) {
    ImageU8 lines = grid();
    for (int i = 1; i <= length; ++i) lines.at(80, 60 - i) = 255;
    const LineStructure s = measure_structure(lines, {}, {});
    EXPECT_EQ(s.num_ends, length < 5 ? 0 : 1) << length;
    EXPECT_NEAR(s.length_px, plain.length_px + (length < 5 ? 0.0 : 0.948 * length), 1e-6) << length;
    EXPECT_EQ(s.num_junctions, length < 5 ? 25 : 26) << length;
    EXPECT_EQ(s.cells_px.size(), 16u);
    EXPECT_EQ(measure_structure(lines, {}, {}, {.spur_px = 0.0}).num_ends, length < 2 ? 0 : 1)
        << length;  // A single pixel on a line is thinned away.
  }
  ImageU8 dot(40, 40);
  dot.at(20, 20) = 255;
  EXPECT_EQ(measure_structure(dot, {}, {}).length_px, 0.0);
}

TEST(LineStructure, AnEndNearTheBorderIsNone) {
  for (const int at : {3, 5, 6, 20}) {
    ImageU8 lines(80, 80);
    for (int x = at; x < 40; ++x) lines.at(x, 40) = 255;
    EXPECT_EQ(measure_structure(lines, {}, {}).num_ends, at < 6 ? 1 : 2) << at;
    // Lines beside the outside of a mask, along x and along y.
    ImageU8 mask(80, 80, 1, 255);
    for (int y = 0; y < 80; ++y) {
      for (int x = 50; x < 80; ++x) mask.at(x, y) = 0;
    }
    ImageU8 wide(80, 80);
    for (int x = 20; x < 50 - at; ++x) wide.at(x, 40) = 255;
    EXPECT_EQ(measure_structure(wide, mask, {}).num_ends, at < 6 ? 1 : 2) << at;
    EXPECT_EQ(measure_structure(turned(wide), turned(mask), {}).num_ends, at < 6 ? 1 : 2) << at;
  }
}

TEST(LineStructure, MirroredAndTurnedPicturesSayTheSame) {
  for (const int width : {1, 4}) {
    ImageU8 lines = grid(width);
    cut(lines, 1, 0);
    cut(lines, 0, 2);
    for (int i = 1; i <= 9; ++i) lines.at(80, 60 - width / 2 - i) = 255;
    const LineStructure s = measure_structure(lines, {}, {});
    for (const ImageU8& other : {turned(lines), turned(turned(lines)), mirrored(lines), mirrored(turned(lines))}) {
      const LineStructure o = measure_structure(other, {}, {});
      EXPECT_EQ(o.num_ends, s.num_ends);
      EXPECT_EQ(o.num_junctions, s.num_junctions);
      EXPECT_EQ(o.cells_px.size(), s.cells_px.size());
      EXPECT_EQ(o.share(), s.share());
      if (width > 1) continue;  // Thinning takes even widths from one side first.
      EXPECT_EQ(o.closed_px, s.closed_px);
      EXPECT_NEAR(o.length_px, s.length_px, 1e-6);
      EXPECT_NEAR(o.inner_length_px, s.inner_length_px, 0.948 * 12.0);  // A step belongs to its first pixel.
    }
  }
}

TEST(LineStructure, LengthIsToldByQuarter) {
  ImageU8 quarter(kSide, kSide, 1, 9);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) quarter.at(x, y) = x < 40 ? 0 : x < 80 ? 2 : 9;
  }
  const LineStructure s = measure_structure(grid(), {}, quarter);
  for (const std::size_t q : {0u, 2u}) {  // One line down, and 40 px of five across.
    EXPECT_NEAR(s.quarter_length_px[q], 0.948 * (kSide - 1 + 5 * 40), 1e-6);
    EXPECT_EQ(s.quarter_surface_px[q], 40.0 * kSide);
  }
  EXPECT_EQ(s.quarter_surface_px[1], 0.0);
}

TEST(LineStructure, ChartsAddUp) {
  LineStructure twice = measure_structure(grid(), {}, {});
  const LineStructure once = twice;
  twice += once;
  EXPECT_EQ(twice.num_junctions, 50);
  EXPECT_EQ(twice.closed_share(), once.closed_share());
  EXPECT_EQ(twice.median_cell_px(), once.median_cell_px());
  EXPECT_THROW((void)measure_structure(grid(), ImageU8(3, 3), {}), InvalidInput);
  EXPECT_THROW((void)measure_structure(grid(), {}, ImageU8(3, 3)), InvalidInput);
  EXPECT_THROW((void)measure_structure(grid(), {}, {}, {.spur_px = -1.0}), InvalidInput);
}

TEST(LineMask, LinesAreAsMuchDarkerOrBrighterAsTheyWereDrawn) {
  const ImageU8 truth = grid(3);
  ImageF dark(kSide, kSide), bright = dark;
  for (std::int64_t i = 0; i < dark.num_pixels(); ++i) {
    dark.data()[i] = truth.data()[i] != 0 ? 40.0f : 52.0f;
    bright.data()[i] = -dark.data()[i];
  }
  const ImageF contrast = line_contrast(dark, {}, LineKind::Dark, 4);
  EXPECT_EQ(contrast, line_contrast(bright, {}, LineKind::Bright, 4));
  EXPECT_EQ(lines_at(contrast, 12.0, 30), truth);
  const ImageU8 none = lines_at(contrast, 12.1, 30);
  EXPECT_TRUE(std::all_of(none.values().begin(), none.values().end(), [](std::uint8_t v) { return v == 0; }));
  // Lines as wide as the square, and what lies outside a mask, are no lines.
  const ImageF wide = line_contrast(dark, {}, LineKind::Dark, 1);
  EXPECT_EQ(wide.at(60, 100), 0.0f);
  ImageU8 mask(kSide, kSide, 1, 255);
  for (int y = 0; y < kSide; ++y) mask.at(62, y) = 0, dark.at(62, y) = 90.0f;
  const ImageF masked = line_contrast(dark, mask, LineKind::Dark, 4);
  EXPECT_EQ(masked.at(60, 80), 12.0f);
  EXPECT_EQ(masked.at(62, 80), 0.0f);
  EXPECT_THROW((void)line_contrast(dark, {}, LineKind::Dark, 0), InvalidInput);
  EXPECT_THROW((void)line_contrast(dark, ImageU8(3, 3), LineKind::Dark, 4), InvalidInput);
}

}  // namespace
}  // namespace patinate::analysis
