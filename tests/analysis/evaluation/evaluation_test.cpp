#include "analysis/evaluation/evaluation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "analysis/evaluation/coherence.h"
#include "libcommon/core/random.h"
#include "patinate/core/error.h"
#include "tests/support/histories.h"
#include "tests/support/meshes.h"

namespace patinate::analysis {
namespace {

constexpr int kBlotchySide = 96;

SynthesisSource blotchy_source(int side = kBlotchySide) {
  SynthesisSource source;
  ImageF frame(side, side, 3);
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      for (int c = 0; c < 3; ++c)
        frame.at(x, y, c) = 255.0f * std::clamp(testing_support::blotches(x, y, 2, c), 0.0f, 1.0f);
    }
  }
  source.frames = {frame};
  source.control = ImageF(side, side);
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) source.control.at(x, y) = static_cast<float>(x) / static_cast<float>(side - 1);
  }
  return source;
}

/// Where texel (x, y) comes from, over a flat surface as large as the source.
template <class Where>
SynthesizedMap flat_map(const SynthesisSource& source, Where&& where) {
  SynthesizedMap map{.name = "map",
                     .surface = flat_surface(source.width(), source.height(), 1.0),
                     .coordinates = ImageF(source.width(), source.height(), 2),
                     .control = source.control};
  for (int y = 0; y < source.height(); ++y) {
    for (int x = 0; x < source.width(); ++x) {
      const auto [sx, sy] = where(x, y);
      map.coordinates.at(x, y, 0) = static_cast<float>(sx);
      map.coordinates.at(x, y, 1) = static_cast<float>(sy);
    }
  }
  return map;
}

double value_of(const Evaluation& e, const std::string& name) {
  for (const Figure& f : e.figures) {
    if (f.name == name) return f.value.value();
  }
  throw std::runtime_error("no figure " + name);
}
const Figure& figure_named(const Evaluation& e, const std::string& name) {
  return *std::find_if(e.figures.begin(), e.figures.end(), [&](const Figure& f) { return f.name == name; });
}

EvaluationOptions quick_evaluation() {
  EvaluationOptions o;
  o.num_samples = 2000;
  return o;
}

TEST(Evaluation, TheSourceItselfLosesNothing) {
  const SynthesisSource source = blotchy_source();
  const Evaluation e = evaluate(source,
                                flat_map(source,
                                         [](int x, int y) {
                                           return std::pair{x, y};
                                         }),
                                quick_evaluation(), 1);
  for (const char* zero : {"control_error_mean", "control_error_p95", "control_error_s3_mean", "control_error_s3_p95",
                           "gradient_emd", "spectrum", "rep64", "scale_error_median", "scale_error_p99"}) {
    EXPECT_EQ(value_of(e, zero), 0.0) << zero;
  }
  EXPECT_EQ(value_of(e, "coherent_share"), 1.0);
  EXPECT_EQ(value_of(e, "texels_per_piece"), kBlotchySide * kBlotchySide);
  EXPECT_EQ(value_of(e, "used_share"), 1.0);
  // Two draws from one picture differ by chance alone, as the floor does.
  EXPECT_LT(value_of(e, "patch_swd"), 2.0 * figure_named(e, "patch_swd").split.value());
  EXPECT_FALSE(figure_named(e, "seam_gradient_ratio").value) << "a picture has no seams";
  EXPECT_EQ(figure_named(e, "seam_gradient_ratio").undefined, "the surface has no seams");
}

TEST(Evaluation, AShuffleKeepsColorsAndLosesTheRest) {
  const SynthesisSource source = blotchy_source();
  std::vector<int> order(kBlotchySide * kBlotchySide);
  std::iota(order.begin(), order.end(), 0);
  RandomStream random(7, 0);
  for (std::size_t i = order.size(); i-- > 1;)
    std::swap(order[i], order[random.below(static_cast<std::uint32_t>(i + 1))]);
  const Evaluation e = evaluate(
      source,
      flat_map(
          source,
          [&](int x, int y) {
            return std::pair{order[y * kBlotchySide + x] % kBlotchySide, order[y * kBlotchySide + x] / kBlotchySide};
          }),
      quick_evaluation(), 1);
  EXPECT_LT(value_of(e, "coherent_share"), 0.002);
  EXPECT_LT(value_of(e, "texels_per_piece"), 1.01);
  EXPECT_EQ(value_of(e, "used_share"), 1.0);
  EXPECT_EQ(value_of(e, "rep64"), 0.0);
  // Independent uniform values on [0, 1] are 1/3 apart.
  EXPECT_NEAR(value_of(e, "control_error_mean"), 1.0 / 3.0, 0.01);
  EXPECT_GT(value_of(e, "patch_swd"), 5.0 * figure_named(e, "patch_swd").split.value());
  EXPECT_GT(value_of(e, "gradient_emd"), 5.0);
  EXPECT_EQ(figure_named(e, "scale_error_median").undefined, "no copied piece is 8 texels long");
}

TEST(Evaluation, TilesRepeatAndAreCountedAsPieces) {
  const SynthesisSource source = blotchy_source();
  const Evaluation e = evaluate(source,
                                flat_map(source,
                                         [](int x, int y) {
                                           return std::pair{x % 32, y % 32};
                                         }),
                                quick_evaluation(), 1);
  EXPECT_EQ(value_of(e, "rep64"), 1.0);
  EXPECT_EQ(value_of(e, "texels_per_piece"), 32.0 * 32.0);
  EXPECT_NEAR(value_of(e, "used_share"), 1.0 / 9.0, 1e-12);
}

TEST(Evaluation, RepetitionCountsFromFourToSixtyFourTexels) {
  const SynthesisSource source = blotchy_source(160);
  // Columns 0 and `gap` show the same, all others themselves.
  for (const auto& [gap, share] :
       {std::pair{3, 0.0}, std::pair{4, 2.0 / 160.0}, std::pair{64, 2.0 / 160.0}, std::pair{65, 0.0}}) {
    const Evaluation e = evaluate(source,
                                  flat_map(source,
                                           [gap = gap](int x, int y) {
                                             return std::pair{x == gap ? 0 : x, y};
                                           }),
                                  quick_evaluation(), 1);
    const double mixed = value_of(e, "rep64");  // Rows near make pairs that are a little farther: at 65 none, at 3
                                                // those with 3 or more rows between.
    if (gap == 3)
      EXPECT_LE(mixed, 2.0 / 160.0);
    else
      EXPECT_NEAR(mixed, share, 1e-12) << gap;
  }
}

TEST(Evaluation, AWrongScaleIsMeasured) {
  const SynthesisSource source = blotchy_source();
  // Every step is two source pixels: what is shown is half as large as it should be.
  const Evaluation e = evaluate(source,
                                flat_map(source,
                                         [](int x, int y) {
                                           return std::pair{2 * x % kBlotchySide, 2 * y % kBlotchySide};
                                         }),
                                quick_evaluation(), 1);
  EXPECT_NEAR(value_of(e, "scale_error_median"), 1.0, 1e-9);
  EXPECT_LT(value_of(e, "coherent_share"), 0.001);
  EvaluationOptions halved = quick_evaluation();
  halved.source_step = 2;
  EXPECT_GT(value_of(evaluate(source,
                              flat_map(source,
                                       [](int x, int y) {
                                         return std::pair{2 * x % kBlotchySide, 2 * y % kBlotchySide};
                                       }),
                              halved, 1),
                     "coherent_share"),
            0.97);
}

/// A plane cut in two charts, the right one turned by 90 degrees: a picture laid over it as one has no seam.
SynthesizedMap over_cut_plane(const SynthesisSource& source, int resolution, double shift_mm) {
  const double side = source.width();
  SynthesizedMap map{.name = "cut",
                     .surface = std::make_shared<TexelMap>(testing_support::cut_plane(side), resolution, resolution),
                     .coordinates = ImageF(resolution, resolution, 2, -1.0f),
                     .control = {}};
  const TexelMap& surface = *map.surface;
  for (TexelId t = 0; t < surface.num_texels(); ++t) {
    if (!surface.is_covered(t)) continue;
    Vec3 p = surface.position_mm(t);
    if (p.x() > side / 2.0) p.y() = std::fmod(p.y() + shift_mm, side);
    map.coordinates.data()[2 * t] = static_cast<float>(std::clamp(std::floor(p.x()), 0.0, side - 1.0));
    map.coordinates.data()[2 * t + 1] = static_cast<float>(std::clamp(std::floor(p.y()), 0.0, side - 1.0));
  }
  return map;
}

/// Mean color difference of pixels beside each other: along x between columns x and x + 1 (or all), and along y when
/// all.
double mean_difference(const ImageF& frame, int column) {
  double sum = 0.0;
  int n = 0;
  const auto add = [&](int x, int y, int dx, int dy) {
    double squares = 0.0;
    for (int c = 0; c < 3; ++c)
      squares +=
          std::pow(static_cast<double>(frame.at(x + dx, y + dy, c)) - static_cast<double>(frame.at(x, y, c)), 2.0);
    sum += std::sqrt(squares);
    ++n;
  };
  for (int y = 0; y + 1 < frame.height(); ++y) {
    for (int x = 0; x + 1 < frame.width(); ++x) {
      if (column < 0 || x == column) add(x, y, 1, 0);
      if (column < 0) add(x, y, 0, 1);
    }
  }
  return sum / n;
}

TEST(Evaluation, ASeamOfAPictureLaidOverItCannotBeTold) {
  const SynthesisSource source = blotchy_source();
  const Evaluation whole = evaluate(source, over_cut_plane(source, 192, 0.0), quick_evaluation(), 1),
                   broken = evaluate(source, over_cut_plane(source, 192, 40.0), quick_evaluation(), 1);
  // Difference of the picture itself between the two columns where it is cut.
  const double expected =
      mean_difference(source.frames[0], kBlotchySide / 2 - 1) / mean_difference(source.frames[0], -1);
  EXPECT_NEAR(value_of(whole, "seam_gradient_ratio"), expected, 0.03);
  EXPECT_GT(value_of(broken, "seam_gradient_ratio"), 2.0 * expected);
}

TEST(Evaluation, PictureOfTheToolIsExplained) {
  const SynthesisSource source = blotchy_source();
  const SynthesizedMap map = flat_map(source, [](int x, int y) { return std::pair{y, x}; });
  MadePicture made{.frame = 0, .codes = ImageF(kBlotchySide, kBlotchySide, 3)};
  for (int y = 0; y < kBlotchySide; ++y) {
    for (int x = 0; x < kBlotchySide; ++x) {
      for (int c = 0; c < 3; ++c)
        made.codes.at(x, y, c) =
            std::round(source.frames[0].at(y, x, c)) + (x < kBlotchySide / 4 && y == 0 ? 40.0f : 0.0f);
    }
  }
  EXPECT_NEAR(value_of(evaluate(source, map, quick_evaluation(), 1, &made), "explained_pixels"),
              1.0 - 0.25 / kBlotchySide, 1e-3);
}

TEST(Evaluation, SameForAnyNumberOfThreads) {
  const SynthesisSource source = blotchy_source();
  const SynthesizedMap map = over_cut_plane(source, 128, 13.0);
  RunControl one, three;
  one.num_threads = 1;
  three.num_threads = 3;
  const Evaluation a = evaluate(source, map, quick_evaluation(), 1, nullptr, one),
                   b = evaluate(source, map, quick_evaluation(), 1, nullptr, three);
  ASSERT_EQ(a.figures.size(), b.figures.size());
  for (std::size_t i = 0; i < a.figures.size(); ++i)
    EXPECT_EQ(a.figures[i].value, b.figures[i].value) << a.figures[i].name;
  EXPECT_EQ(a.hash, b.hash);
}

TEST(Evaluation, CoordinatesOutsideTheSourceAreNamed) {
  const SynthesisSource source = blotchy_source();
  SynthesizedMap map = flat_map(source, [](int x, int y) { return std::pair{x, y}; });
  map.coordinates.at(5, 7, 0) = 96.0f;
  try {
    (void)evaluate(source, map, quick_evaluation(), 1);
    FAIL();
  } catch (const InvalidInput& e) {
    EXPECT_STREQ(e.what(), "map: texel 5, 7 comes from 96, 7, which is not in the source of 96 x 96");
  }
}

}  // namespace
}  // namespace patinate::analysis
