#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include "analysis/evaluation/evaluation.h"
#include "libcommon/core/random.h"
#include "tests/support/meshes.h"

namespace patinate::analysis {
namespace {

constexpr int kGridSide = 240, kPitch = 40;
constexpr float kGround = 180.0f, kLine = 60.0f;  // Codes: L* of 73 and 25.

/// A grid of lines 3 px wide, at 20, 60 ... 220; 5 x 5 cells are closed. The control grows along x.
SynthesisSource grid_source(float ground = kGround, float line = kLine) {
  SynthesisSource source;
  source.frames = {ImageF(kGridSide, kGridSide, 3)};
  source.control = ImageF(kGridSide, kGridSide);
  const auto is_line = [](int v) { return (v + kPitch / 2 + 1) % kPitch < 3; };
  for (int y = 0; y < kGridSide; ++y) {
    for (int x = 0; x < kGridSide; ++x) {
      for (int c = 0; c < 3; ++c) source.frames[0].at(x, y, c) = is_line(x) || is_line(y) ? line : ground;
      source.control.at(x, y) = static_cast<float>(x) / static_cast<float>(kGridSide - 1);
    }
  }
  return source;
}

/// A plane of width x height texels of `texel_mm`, and where each comes from.
template <class Where>
SynthesizedMap plane(int width, int height, double texel_mm, Where&& where) {
  SynthesizedMap map{.name = "plane",
                     .surface = flat_surface(width, height, texel_mm),
                     .coordinates = ImageF(width, height, 2),
                     .control = {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto [sx, sy] = where(x, y);
      map.coordinates.at(x, y, 0) = static_cast<float>(sx);
      map.coordinates.at(x, y, 1) = static_cast<float>(sy);
    }
  }
  return map;
}
SynthesizedMap identity(const SynthesisSource& source) {
  SynthesizedMap map = plane(source.width(), source.height(), 1.0, [](int x, int y) { return std::pair{x, y}; });
  map.control = source.control;
  return map;
}

EvaluationOptions few_samples() { return {.num_samples = 100, .num_directions = 1}; }

const Figure& figure_of(const std::vector<Figure>& figures, const std::string& name) {
  const auto found = std::find_if(figures.begin(), figures.end(), [&](const Figure& f) { return f.name == name; });
  if (found == figures.end()) throw std::runtime_error("no figure " + name);
  return *found;
}
double value_in(const Evaluation& e, const std::string& name) { return figure_of(e.figures, name).value.value(); }
double split_in(const Evaluation& e, const std::string& name) { return figure_of(e.figures, name).split.value(); }

TEST(StructureFigures, TheSourceItselfKeepsItsLines) {
  const SynthesisSource source = grid_source();
  const Evaluation e = evaluate(source, identity(source), few_samples(), 1);
  for (const char* name : {"line_share", "dead_ends", "closed_share", "line_length", "median_cell", "junctions",
                           "line_length_q1", "line_length_q2", "line_length_q3", "line_length_q4"})
    EXPECT_EQ(value_in(e, name), split_in(e, name)) << name;
  EXPECT_EQ(value_in(e, "dead_ends"), 0.0);
  // 25 cells between center lines 40 px apart.
  EXPECT_DOUBLE_EQ(value_in(e, "closed_share"), 25.0 * 39.0 * 39.0 / (kGridSide * kGridSide));
  EXPECT_EQ(value_in(e, "median_cell"), 39.0 * 39.0);
  EXPECT_EQ(value_in(e, "closed_share_crops"), value_in(e, "closed_share"));
  EXPECT_DOUBLE_EQ(value_in(e, "junctions"), 36.0 / (kGridSide * kGridSide));
  // 12 lines from border to border; thinning takes half of their width, and a pixel, from both ends.
  EXPECT_NEAR(value_in(e, "line_length") * kGridSide * kGridSide, 12.0 * (kGridSide - 1) * 0.948, 12.0 * 5.0 * 0.948);
  ASSERT_EQ(e.lines.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(e.lines[i].threshold, (std::array{7.0, 10.0, 16.0}[i]));
    EXPECT_EQ(figure_of(e.lines[i].figures, "dead_ends").value, 0.0);
  }
  EXPECT_NE(figure_of(e.figures, "dead_ends").title.find("7, 10, 16 L*"), std::string::npos);
  EXPECT_TRUE(
      std::any_of(e.pictures.begin(), e.pictures.end(), [](const Picture& p) { return p.name == "plane_lines"; }));
}

/// Rings: a texture that looks the same at every rotation, so its windows have no preferred direction.
SynthesisSource ring_source() {
  SynthesisSource source;
  source.frames = {ImageF(400, 400, 3)};
  for (int y = 0; y < 400; ++y) {
    for (int x = 0; x < 400; ++x) {
      const int dx = x % 40 - 20, dy = y % 40 - 20;
      const double r = std::sqrt(dx * dx + dy * dy);
      for (int c = 0; c < 3; ++c) source.frames[0].at(x, y, c) = r > 13.0 && r < 16.5 ? kLine : kGround;
    }
  }
  return source;
}

// Windows across seams have as many closed rings as the source's windows; charts alone have cut them.
TEST(StructureFigures, WindowsLieAcrossSeamsOfTurnedCharts) {
  const SynthesisSource source = ring_source();
  constexpr int kCharts = 12, kSide = 400;
  SynthesizedMap map{.name = "quilt",
                     .surface = std::make_shared<TexelMap>(testing_support::quilt_plane(kSide, kCharts), 600, 600),
                     .coordinates = ImageF(600, 600, 2),
                     .control = {}};
  for (TexelId t = 0; t < map.surface->num_texels(); ++t) {
    if (!map.surface->is_covered(t)) continue;
    const Vec3 p = map.surface->position_mm(t);  // Mm are source pixels.
    map.coordinates.data()[2 * t] = static_cast<float>(std::clamp(p.x() - 0.5, 0.0, kSide - 1.0));
    map.coordinates.data()[2 * t + 1] = static_cast<float>(std::clamp(kSide - p.y() - 0.5, 0.0, kSide - 1.0));
  }
  const Evaluation e = evaluate(source, map, few_samples(), 1);
  EXPECT_LT(value_in(e, "closed_share"), 0.8 * split_in(e, "closed_share")) << "cut by charts";
  EXPECT_NEAR(value_in(e, "closed_share_surface"), split_in(e, "closed_share_surface"),
              0.15 * split_in(e, "closed_share_surface"));
  EXPECT_NEAR(value_in(e, "line_share_surface"), split_in(e, "line_share_surface"),
              0.1 * split_in(e, "line_share_surface"));
}

/// Upright lines, 40 px apart, and 14 where the control, which grows along x, is above 0.85.
SynthesisSource comb_source() {
  SynthesisSource source;
  source.frames = {ImageF(400, 400, 3)};
  source.control = ImageF(400, 400);
  for (int y = 0; y < 400; ++y) {
    for (int x = 0; x < 400; ++x) {
      for (int c = 0; c < 3; ++c)
        source.frames[0].at(x, y, c) = (x < 340 ? x % 40 - 20 : (x - 340) % 14 - 7) / 2 == 0 ? kLine : kGround;
      source.control.at(x, y) = static_cast<float>(x) / 399.0f;
    }
  }
  return source;
}

// No window of the source lies where only its last 60 columns are: lines are as frequent there as the control says.
TEST(StructureFigures, WindowsOfARareControlHaveTheLinesThatItHasInTheSource) {
  const SynthesisSource source = comb_source();
  const auto column = [](int x) { return x / 56 % 2 == 0 ? 343 + x % 56 : 398 - x % 56; };
  SynthesizedMap map = plane(392, 392, 1.0, [&](int x, int y) { return std::pair{column(x), y}; });
  map.control = ImageF(392, 392);
  for (int y = 0; y < 392; ++y) {
    for (int x = 0; x < 392; ++x) map.control.at(x, y) = source.control.at(column(x), y);
  }
  const Evaluation e = evaluate(source, map, few_samples(), 1);
  // Line shares of whole pictures of the source differ by as much from turn to turn.
  EXPECT_NEAR(value_in(e, "line_share_surface"), split_in(e, "line_share_surface"),
              0.1 * split_in(e, "line_share_surface"));
}

/// The plane of the source in strips of 19 texels with one left out between, all charts of their own.
SynthesizedMap strips(const SynthesisSource& source) {
  SynthesizedMap map = identity(source);
  Mesh mesh;
  const auto corner = [&](int x, int y) {
    mesh.positions.emplace_back(x, y, 0.0);
    mesh.uvs.emplace_back(static_cast<double>(x) / kGridSide, static_cast<double>(y) / kGridSide);
  };
  for (int x = 0; x < kGridSide; x += 20) {
    const int first = static_cast<int>(mesh.positions.size());
    corner(x, 0), corner(x + 19, 0), corner(x + 19, kGridSide), corner(x, kGridSide);
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.triangles.push_back({first, first + 2, first + 3});
  }
  mesh.uv_triangles = mesh.triangles;
  mesh.triangle_surface.assign(mesh.triangles.size(), 0);
  mesh.surfaces.resize(1);
  map.surface = std::make_shared<TexelMap>(mesh, kGridSide, kGridSide);
  return map;
}

// Upright lines lie along borders there, and are not found; so what is wanted is as much less.
TEST(StructureFigures, WhatIsWantedOfNarrowChartsIsWhatTheSourceShowsInThem) {
  const SynthesisSource source = grid_source();
  const Evaluation e = evaluate(source, strips(source), few_samples(), 1);
  const double share = value_in(e, "line_share");
  EXPECT_LT(share, 0.9 * split_in(e, "line_share"));
  // Cut out of corners 1 texel from where the strips lie, or more.
  EXPECT_NEAR(value_in(e, "line_share_wanted"), share, 0.1 * share);
  const Evaluation whole = evaluate(source, identity(source), few_samples(), 1);
  EXPECT_NEAR(value_in(whole, "line_share_wanted"), value_in(whole, "line_share"), 1e-9);
}

TEST(StructureFigures, PiecesThatDoNotFitHaveDeadEndsAndOpenCells) {
  // The right half is half a cell lower: lines across end at x = 120, 6 from the left, and 5 from the right (the sixth
  // lies on the picture's border). Texels are half a millimeter.
  SynthesisSource source = grid_source();
  source.pixel_mm = 0.5;
  const SynthesizedMap map = plane(kGridSide, kGridSide, 0.5, [](int x, int y) {
    return std::pair{x, x < 120 ? y : (y + 20) % kGridSide};
  });
  const Evaluation e = evaluate(source, map, few_samples(), 1);
  EXPECT_EQ(split_in(e, "dead_ends"), 0.0);
  const double length_mm = value_in(e, "line_length") * 120.0 * 120.0;
  // The measured length leaves out what is near the border: a twentieth at the ends of lines, and another twentieth on
  // the border itself.
  EXPECT_NEAR(value_in(e, "dead_ends") * length_mm, 1.1 * 11.0, 0.05 * 11.0);
  EXPECT_LT(value_in(e, "closed_share"), split_in(e, "closed_share"));
  EXPECT_EQ(value_in(e, "median_cell"), 39.0 * 39.0 / 4.0);
}

TEST(StructureFigures, BrightLinesAreMeasuredToo) {
  const SynthesisSource dark = grid_source(), bright = grid_source(kLine, kGround);
  const Evaluation a = evaluate(dark, identity(dark), few_samples(), 1),
                   b = evaluate(bright, identity(bright), few_samples(), 1);
  for (const char* name : {"line_share", "closed_share", "line_length", "median_cell"})
    EXPECT_EQ(value_in(a, name), value_in(b, std::string("bright_") + name)) << name;
  EXPECT_EQ(figure_of(b.figures, "dead_ends").undefined, "the source has no dark lines");
  EXPECT_THROW((void)value_in(a, "bright_dead_ends"), std::runtime_error);
}

TEST(StructureFigures, ThresholdsFollowFaintLines) {
  const SynthesisSource faint = grid_source(120.0f, 100.0f);  // L* of 50.4 and 42.4: 8 apart.
  const Evaluation e = evaluate(faint, identity(faint), few_samples(), 1);
  ASSERT_EQ(e.lines.size(), 3u);
  EXPECT_EQ(e.lines[0].threshold, 3.5);
  EXPECT_EQ(e.lines[2].threshold, 8.0);
}

TEST(StructureFigures, ASourceWithoutLinesSaysSo) {
  SynthesisSource flat;
  flat.frames = {ImageF(64, 64, 3, 90.0f)};
  SynthesisSource noise;
  noise.frames = {ImageF(256, 256, 3)};
  for (std::int64_t i = 0; i < 256 * 256; ++i) {
    for (int c = 0; c < 3; ++c)
      noise.frames[0].data()[3 * i + c] =
          static_cast<float>(128.0 + 12.0 * RandomStream(5, static_cast<std::uint64_t>(i)).normal());
  }
  for (const SynthesisSource& source : {flat, noise}) {
    const Evaluation e = evaluate(source, identity(source), few_samples(), 1);
    for (const char* name : {"line_share", "dead_ends", "closed_share", "line_length", "median_cell"}) {
      EXPECT_FALSE(figure_of(e.figures, name).value) << name;
      EXPECT_EQ(figure_of(e.figures, name).undefined, "the source has no lines") << name;
    }
    EXPECT_TRUE(e.lines.empty());
  }
}

TEST(StructureFigures, RoundedSizesOfTexelsChangeNothing) {
  SynthesisSource source = grid_source();
  const Evaluation a = evaluate(source, identity(source), few_samples(), 1);
  source.pixel_mm = 1.0 + 1e-6;
  const Evaluation b = evaluate(source, identity(source), few_samples(), 1);
  for (const char* name : {"closed_share", "line_length", "median_cell"})
    EXPECT_EQ(split_in(a, name), split_in(b, name)) << name;
}

TEST(StructureFigures, SmallerTexelsSayTheSameInMillimeters) {
  const SynthesisSource source = grid_source();
  const Evaluation e = evaluate(source,
                                plane(2 * kGridSide, 2 * kGridSide, 0.5,
                                      [](int x, int y) {
                                        return std::pair{x / 2, y / 2};
                                      }),
                                few_samples(), 1);
  for (const char* name : {"line_share", "dead_ends", "closed_share", "line_length", "median_cell"})
    EXPECT_EQ(value_in(e, name), split_in(e, name)) << name;
  // Center lines lie to half a pixel of the source, and their one texel is half as wide.
  EXPECT_NEAR(value_in(e, "median_cell"), 39.5 * 39.5, 40.0);
  EXPECT_EQ(value_in(e, "rep_all"), 0.0);
}

TEST(StructureFigures, BordersOfChartsAreNoEnds) {
  // Two charts, the right one turned: lines that go on over the cut end at it in the atlas.
  SynthesisSource source = grid_source();
  SynthesizedMap map{
      .name = "cut",
      .surface = std::make_shared<TexelMap>(testing_support::cut_plane(kGridSide), 2 * kGridSide, 2 * kGridSide),
      .coordinates = ImageF(2 * kGridSide, 2 * kGridSide, 2, -1.0f),
      .control = {}};
  for (TexelId t = 0; t < map.surface->num_texels(); ++t) {
    if (!map.surface->is_covered(t)) continue;
    const Vec3 p = map.surface->position_mm(t);
    map.coordinates.data()[2 * t] = static_cast<float>(std::clamp(std::floor(p.x()), 0.0, kGridSide - 1.0));
    map.coordinates.data()[2 * t + 1] = static_cast<float>(std::clamp(std::floor(p.y()), 0.0, kGridSide - 1.0));
  }
  RunControl one, three;
  one.num_threads = 1;
  three.num_threads = 3;
  const Evaluation a = evaluate(source, map, few_samples(), 1, nullptr, one),
                   b = evaluate(source, map, few_samples(), 1, nullptr, three);
  EXPECT_EQ(value_in(a, "dead_ends"), 0.0);
  ASSERT_EQ(a.figures.size(), b.figures.size());
  for (std::size_t i = 0; i < a.figures.size(); ++i)
    EXPECT_EQ(a.figures[i].value, b.figures[i].value) << a.figures[i].name;
}

/// Smooth waves.
SynthesisSource smooth_source() {
  SynthesisSource source;
  source.frames = {ImageF(96, 96, 3)};
  for (int y = 0; y < 96; ++y) {
    for (int x = 0; x < 96; ++x) {
      for (int c = 0; c < 3; ++c)
        source.frames[0].at(x, y, c) = static_cast<float>(128.0 + 60.0 * std::sin(x / 15.0 + c) * std::cos(y / 12.0));
    }
  }
  return source;
}

TEST(BorderContrast, IsOneWithoutBordersAndMoreWhereBlocksAreShuffled) {
  const SynthesisSource source = smooth_source();
  EXPECT_EQ(value_in(evaluate(source, identity(source), few_samples(), 1), "border_contrast"), 1.0);
  std::vector<int> order(36);  // Blocks of 16 px.
  std::iota(order.begin(), order.end(), 0);
  RandomStream random(3, 0);
  for (std::size_t i = order.size(); i-- > 1;)
    std::swap(order[i], order[random.below(static_cast<std::uint32_t>(i + 1))]);
  const auto where = [&](int x, int y) {
    const int block = order[y / 16 * 6 + x / 16];
    return std::pair{block % 6 * 16 + x % 16, block / 6 * 16 + y % 16};
  };
  // Steps of waves are at most 60 / 12 codes a channel; two places differ by tens.
  EXPECT_GT(value_in(evaluate(source, plane(96, 96, 1.0, where), few_samples(), 1), "border_contrast"), 4.0);
}

TEST(BorderContrast, IsOneWhereTheSourceRepeatsItself) {
  // Period 12: a piece from 12 px away continues as the source does.
  SynthesisSource source;
  source.frames = {ImageF(96, 96, 3)};
  for (int y = 0; y < 96; ++y) {
    for (int x = 0; x < 96; ++x) {
      for (int c = 0; c < 3; ++c) source.frames[0].at(x, y, c) = static_cast<float>(100 + 10 * (x % 12) + 3 * (y % 12));
    }
  }
  const auto where = [](int x, int y) { return std::pair{x < 48 ? x : x - 24, y}; };
  EXPECT_DOUBLE_EQ(value_in(evaluate(source, plane(96, 96, 1.0, where), few_samples(), 1), "border_contrast"), 1.0);
  SynthesisSource flat;
  flat.frames = {ImageF(96, 96, 3, 80.0f)};
  EXPECT_EQ(figure_of(evaluate(flat, plane(96, 96, 1.0, where), few_samples(), 1).figures, "border_contrast").undefined,
            "the source is flat where pieces meet");
}

TEST(Repetition, EvenUseOfTheWholeSourceIsNone) {
  const SynthesisSource source = smooth_source();
  const auto rep_all = [&](int height, auto&& where) {
    return value_in(evaluate(source, plane(96, height, 1.0, where), few_samples(), 1), "rep_all");
  };
  EXPECT_EQ(rep_all(96, [](int x, int y) { return std::pair{x, y}; }), 0.0);
  EXPECT_EQ(rep_all(192, [](int x, int y) { return std::pair{x, y % 96}; }), 0.0);
  EXPECT_NEAR(rep_all(144, [](int x, int y) { return std::pair{x, y % 96}; }), 0.0, 1e-12);  // Once and a half.
  // A ninth is used nine times.
  EXPECT_NEAR(rep_all(96, [](int x, int y) { return std::pair{x % 32, y % 32}; }), 8.0 / 9.0, 1e-12);
  // Half of the source for everything: of two uses one is too many, wherever the other is.
  EXPECT_NEAR(rep_all(96, [](int x, int y) { return std::pair{x, y % 48}; }), 0.5, 1e-12);
}

}  // namespace
}  // namespace patinate::analysis
