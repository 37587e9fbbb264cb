#include "patinate/simulation/compose.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "libcommon/core/instruction_set.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"
#include "simulation/rules/scene_maps.h"
#include "tests/simulation/composition/compose_scene.h"
#include "tests/support/errors.h"
#include "tests/support/meshes.h"
#include "tests/support/reference_compose.h"
#include "tests/support/threads.h"

namespace patinate::simulation {
namespace {

using testing_support::any_appearance;
using testing_support::ComposeScene;
using testing_support::cut_plane;
using testing_support::error_of;
using testing_support::has;
using testing_support::set_any_amounts;
using testing_support::unit_plane;

constexpr int kAtlasSide = 64;

MaterialAppearance plain_look(const Vec3& color) {
  MaterialAppearance look;
  look.color.color = color;
  return look;
}

double linear_of(std::uint8_t code) { return static_cast<double>(linear_from_srgb(static_cast<float>(code) / 255.0f)); }

std::vector<TileIndex> all_tiles(const ComposeScene& scene) {
  std::vector<TileIndex> tiles(scene.surface->grid().num_tiles());
  std::iota(tiles.begin(), tiles.end(), TileIndex{0});
  return tiles;
}

/// A map with every sRGB code, a texel each.
ImageF all_codes() {
  ImageF map(kAtlasSide, kAtlasSide, 3);
  for (int y = 0; y < kAtlasSide; ++y) {
    for (int x = 0; x < kAtlasSide; ++x) {
      for (int c = 0; c < 3; ++c)
        map.at(x, y, c) = linear_from_srgb(static_cast<float>((y * kAtlasSide + x + 85 * c) % 256) / 255.0f);
    }
  }
  return map;
}

TEST(Composer, NewSurfacesHaveTheSecondColorWhereTheirPatternIs) {
  const Vec3 light(0.5, 0.4, 0.3), dark(0.2, 0.1, 0.05);
  const ComposeScene scene(testing_support::unit_plane(100.0), 96, {{}}, [&](Scene& s) {
    s.objects[0].preset.color.color = light;
    s.objects[0].preset.second_color = dark;
    s.objects[0].preset.pattern = "noise";
  });
  Composer composer = scene.composer();
  (void)composer.compose(*scene.atlas, {});
  const std::vector<std::string> name{"noise"};
  const SurfaceParameter noise = make_parameters(name, scene.scene, scene.scene_mesh, *scene.surface, {}).front();
  const std::vector<ReferenceTexel> slow =
      compose_reference(scene.scene, scene.scene_mesh, *scene.atlas, ColorForm::Normalized);
  for (TexelIndex t = 0; t < scene.surface->grid().num_texels(); ++t) {
    if (!scene.surface->is_covered(t)) continue;
    for (int c = 0; c < 3; ++c) {
      const double expected = light[c] + parameter_at(noise, t) * (dark[c] - light[c]);
      const int code = srgb8_from_linear(static_cast<float>(expected));
      ASSERT_NEAR(composer.codes()[t] >> (8 * c) & 255, code, 1);
      ASSERT_NEAR(srgb8_from_linear(static_cast<float>(slow[t].color[c])), code, 1);
    }
  }
}

TEST(Composer, GivesBackTheOriginalsExactlyWhereNothingChanged) {
  const ComposeScene untouched(unit_plane(64.0), kAtlasSide, {plain_look({1, 0, 0})}, [](Scene& scene) {
    scene.objects[0].color_map = all_codes();
    scene.objects[0].specular_map = ImageF(kAtlasSide, kAtlasSide);
    scene.objects[0].height_map = ImageF(kAtlasSide, kAtlasSide);
    for (int i = 0; i < kAtlasSide * kAtlasSide; ++i) {
      scene.objects[0].specular_map.data()[i] = static_cast<float>(i % 256) / 255.0f;
      scene.objects[0].height_map.data()[i] =
          static_cast<float>(i % 77) / 16.0f;  // whole quanta: a texel is 1 mm, a quantum 1/1024
    }
  });
  ComposeScene touched(unit_plane(64.0), kAtlasSide, {plain_look({1, 0, 0})},
                       [&](Scene& scene) { scene.objects = untouched.scene.objects; });
  touched.set(0, [](int x, int, const Vec3&) { return x % 8 == 3 ? 1.0 : 0.0; });  // one column of each tile is aged
  for (const ComposeScene* scene : {&untouched, static_cast<const ComposeScene*>(&touched)}) {
    Composer composer = scene->composer();
    (void)composer.compose(*scene->atlas, {});
    const ImageU8 color = composer.color_srgb8(), specular = composer.specular8();
    const ImageF height = composer.height_mm();
    for (int y = 0; y < kAtlasSide; ++y) {
      for (int x = 0; x < kAtlasSide; ++x) {
        if (scene == &touched && x % 8 == 3) continue;
        for (int c = 0; c < 3; ++c) ASSERT_EQ(color.at(x, y, c), (y * kAtlasSide + x + 85 * c) % 256) << x << " " << y;
        ASSERT_EQ(specular.at(x, y), (y * kAtlasSide + x) % 256);
        ASSERT_FLOAT_EQ(height.at(x, y), scene->scene.objects[0].height_map.at(x, y));
      }
    }
  }
}

TEST(Composer, AmountOneAtStrengthOneIsTheMaterialsColor) {
  for (const ColorForm form : {ColorForm::Normalized, ColorForm::Published}) {
    for (int code = 0; code < 256; code += 5) {
      const Vec3 color(linear_of(static_cast<std::uint8_t>(code)), linear_of(static_cast<std::uint8_t>(255 - code)),
                       0.3141);
      ComposeScene scene(unit_plane(16.0), 16, {plain_look({0.5, 0.5, 0.5}), plain_look(color)});
      scene.set(1, [](int x, int, const Vec3&) { return x < 8 ? 1.0 : 3.7; });
      Composer composer = scene.composer(form);
      (void)composer.compose(*scene.atlas, {});
      const ImageU8 got = composer.color_srgb8();
      for (const int x : {0, 15}) {
        EXPECT_EQ(got.at(x, 5, 0), code);
        EXPECT_EQ(got.at(x, 5, 1), 255 - code);
        EXPECT_EQ(got.at(x, 5, 2), srgb8_from_linear(0.3141f));
      }
    }
  }
}

/// Codes of a white material on white, by amount 0, 1/16, 2/16, ... along x.
ImageU8 white_on_white(ColorForm form) {
  ComposeScene scene(unit_plane(32.0), 32, {plain_look({1, 1, 1}), plain_look({1, 1, 1})}, [](Scene& s) {
    s.objects[0].preset.color.color = {1, 1, 1};
  });
  scene.set(0, [](int x, int, const Vec3&) { return x / 32.0; });
  scene.set(1, [](int x, int, const Vec3&) { return x / 32.0; });
  Composer composer = scene.composer(form);
  (void)composer.compose(*scene.atlas, {});
  return composer.color_srgb8();
}

TEST(Composer, WeightsSumToOneWhereThePublishedFormDarkensThinLayers) {
  const ImageU8 normalized = white_on_white(ColorForm::Normalized), published = white_on_white(ColorForm::Published);
  for (int x = 0; x < 32; ++x) {
    EXPECT_EQ(normalized.at(x, 3, 0), 255) << x;
    const double a = x / 16.0;
    const double expected = a < 1.0 ? 1.0 - a + a * a : 1.0;  // 0.75 at a half cover
    EXPECT_EQ(published.at(x, 3, 0), srgb8_from_linear(static_cast<float>(expected))) << x;
  }
}

TEST(Composer, FormsAgreeWhereMaterialsCoverTheSurface) {
  ComposeScene scene(unit_plane(64.0), kAtlasSide, any_appearance(4, 3));
  set_any_amounts(scene, 3);
  scene.scene.appearance[0].strength = 2.0;
  scene.scene.appearance[0].variation = 0.0;
  scene.set(0, [](int, int, const Vec3&) { return 0.6; });  // weight 1.2 everywhere
  Composer normalized = scene.composer(), published = scene.composer(ColorForm::Published);
  (void)normalized.compose(*scene.atlas, {});
  (void)published.compose(*scene.atlas, {});
  EXPECT_EQ(normalized.color_srgb8(), published.color_srgb8());
}

TEST(Composer, MoreOfAMaterialIsNeverLessOfItsColor) {
  ComposeScene scene(unit_plane(64.0), kAtlasSide, {plain_look({0.02, 0.9, 0.4}), plain_look({0.5, 0.1, 0.7})});
  scene.set(0, [](int x, int y, const Vec3&) { return (y * kAtlasSide + x) / 1024.0; });
  Composer composer = scene.composer();
  (void)composer.compose(*scene.atlas, {});
  const ImageU8 color = composer.color_srgb8();
  for (int i = 1; i < kAtlasSide * kAtlasSide; ++i) {
    EXPECT_LE(color.data()[3 * i], color.data()[3 * (i - 1)]);          // from 0.5 down to 0.02
    EXPECT_GE(color.data()[3 * i + 1], color.data()[3 * (i - 1) + 1]);  // from 0.5 up to 0.9
  }
}

TEST(Composer, OrderOfMaterialsDoesNotMatter) {
  std::vector<MaterialAppearance> appearance = any_appearance(3, 8);
  for (MaterialAppearance& look : appearance)
    look.variation = look.specular_variation = look.height_variation = 0.0;  // noise is by material
  ComposeScene one(unit_plane(64.0), kAtlasSide, appearance);
  std::swap(appearance[0], appearance[2]);
  ComposeScene other(unit_plane(64.0), kAtlasSide, appearance);
  const auto amount = [](int m) {
    return [m](int x, int y, const Vec3&) { return (x * (m + 1) % 13 + y % (m + 2)) / 13.0; };
  };
  for (int m = 0; m < 3; ++m) one.set(m, amount(m));
  for (int m = 0; m < 3; ++m) other.set(2 - m, amount(m));
  Composer a = one.composer(), b = other.composer();
  (void)a.compose(*one.atlas, {});
  (void)b.compose(*other.atlas, {});
  EXPECT_TRUE(std::equal(a.codes().begin(), a.codes().end(), b.codes().begin()));
  EXPECT_TRUE(std::equal(a.normals().begin(), a.normals().end(), b.normals().begin()));
}

TEST(Composer, WhatIsTakenAwayLowersTheSurfaceAndLeavesTheColor) {
  MaterialAppearance metal = plain_look({0, 1, 0});
  metal.height_mm = 2.0;
  metal.specular = 0.5;
  ComposeScene scene(unit_plane(64.0), kAtlasSide, {metal}, [](Scene& s) {
    s.objects[0].preset.amounts[0] = 1.0;
    s.objects[0].preset.specular = 0.8;
  });
  scene.set(0, [](int, int, const Vec3&) { return 0.25; });
  Composer composer = scene.composer();
  (void)composer.compose(*scene.atlas, {});
  EXPECT_EQ(composer.color_srgb8().at(5, 5, 1), srgb8_from_linear(0.5f));
  EXPECT_NEAR(static_cast<double>(composer.height_mm().at(5, 5)), -1.5, 0.5 / 1024);  // half a quantum
  EXPECT_NEAR(composer.specular8().at(5, 5) / 255.0, 0.8 - 0.75 * 0.5,
              0.75 / 255);  // a code of the preset's value, and half a code
}

TEST(Composer, VariationKeepsTheMeanAndHasItsSpread) {
  MaterialAppearance look = plain_look({1, 1, 1});
  look.variation = 0.5;
  look.height_mm = 1.0;
  look.height_variation = 1.0;
  ComposeScene scene(unit_plane(256.0), 256, {look}, [](Scene& s) { s.objects[0].preset.color.color = {0, 0, 0}; });
  scene.set(0, [](int, int, const Vec3&) { return 0.5; });
  Composer composer = scene.composer();
  (void)composer.compose(*scene.atlas, {});
  const ImageU8 color = composer.color_srgb8();
  const ImageF height = composer.height_mm();
  double sum = 0.0, squares = 0.0, height_sum = 0.0, height_squares = 0.0, beside = 0.0, below = 0.0;
  const int n = 256 * 256;
  for (int y = 0; y < 256; ++y) {
    for (int x = 0; x < 256; ++x) {
      const double v = linear_of(color.at(x, y, 0)), h = static_cast<double>(height.at(x, y)) - 0.5;
      sum += v;
      squares += v * v;
      height_sum += h;
      height_squares += h * h;
      beside += h * (static_cast<double>(height.at((x + 1) % 256, y)) - 0.5);
      below += h * (static_cast<double>(height.at(x, (y + 1) % 256)) - 0.5);
    }
  }
  const double sd = 0.25 / std::sqrt(3.0);  // uniform in 0.5 (1 +- 0.5)
  EXPECT_NEAR(sum / n, 0.5, 4.0 * sd / 256.0);
  EXPECT_NEAR(std::sqrt(squares / n - std::pow(sum / n, 2)), sd, 4.0 * sd / 256.0);
  const double height_sd = 0.5 / std::sqrt(3.0);
  EXPECT_NEAR(height_sum / n, 0.0, 4.0 * height_sd / 256.0);
  EXPECT_NEAR(std::sqrt(height_squares / n), height_sd, 4.0 * height_sd / 256.0);
  EXPECT_LT(std::abs(beside / height_squares), 4.0 / 256.0);  // neighbors know nothing of each other
  EXPECT_LT(std::abs(below / height_squares), 4.0 / 256.0);
}

TEST(Composer, AgreesWithTheSlowVersionToACode) {
  for (const ColorForm form : {ColorForm::Normalized, ColorForm::Published, ColorForm::Printed}) {
    for (std::uint64_t seed = 0; seed < 3; ++seed) {
      ComposeScene scene(cut_plane(96.0), 96, any_appearance(8, seed), [&](Scene& s) {
        s.objects[0].preset.amounts = {0.4, 0, 0.2, 0, 0, 1.0, 0, 0.3};
        if (seed == 0) return;
        s.objects[0].color_map = all_codes();
        s.objects[0].specular_map = ImageF(20, 30, 1, 0.4f);
        s.objects[0].height_map = ImageF(48, 48);
        for (int i = 0; i < 48 * 48; ++i) s.objects[0].height_map.data()[i] = static_cast<float>(i % 48) / 9.0f;
        if (seed == 2) s.appearance[1].color.image = all_codes();
      });
      set_any_amounts(scene, seed);
      Composer composer = scene.composer(form);
      (void)composer.compose(*scene.atlas, {});
      const std::vector<ReferenceTexel> slow = compose_reference(scene.scene, scene.scene_mesh, *scene.atlas, form);
      int num_covered = 0;
      for (TexelIndex t = 0; t < scene.surface->grid().num_texels(); ++t) {
        if (!scene.surface->is_covered(t)) continue;
        ++num_covered;
        const std::uint32_t code = composer.codes()[t];
        for (int c = 0; c < 3; ++c) {
          ASSERT_NEAR(code >> (8 * c) & 255, srgb8_from_linear(static_cast<float>(slow[t].color[c])), 1)
              << "texel " << t << " seed " << seed;
        }
        ASSERT_NEAR(code >> 24, std::round(255.0 * slow[t].specular), 1) << t;
        // Seven terms of half a quantum each; factors to 13 bits.
        ASSERT_NEAR(composer.height_mm(t), slow[t].height_mm, 4.0 * scene.surface->median_texel_size_mm() / 1024.0)
            << t;
        for (int c = 0; c < 3; ++c) {
          const std::uint8_t normal =
              composer.normals()[TileGrid::tile_of(t) * 192 + static_cast<std::uint32_t>(c) * 64 + t % 64];
          ASSERT_NEAR(normal, std::floor(128.0 + 127.5 * slow[t].normal[c]), 1) << t;
        }
      }
      EXPECT_GT(num_covered, 1000);
    }
  }
}

TEST(Composer, GivesTheSameBytesForAnyNumberOfThreadsAndInstructionSet) {
  ComposeScene scene(cut_plane(200.0), 200, any_appearance(6, 5));
  set_any_amounts(scene, 5);
  Composer plain = scene.composer();
  plain.use(InstructionSet::Baseline);
  (void)plain.compose(*scene.atlas, {}, testing_support::with_threads(1));
  std::string missing;
  for (const InstructionSet set : {InstructionSet::Baseline, InstructionSet::Avx2, InstructionSet::Avx512}) {
    if (!has_instruction_set(set)) {
      missing += " " + std::string(kInstructionSetNames[static_cast<std::size_t>(set)]);
      continue;
    }
    for (const int threads : {1, 2, 3, 8}) {
      Composer composer = scene.composer();
      composer.use(set);
      (void)composer.compose(*scene.atlas, {}, testing_support::with_threads(threads));
      EXPECT_TRUE(std::equal(plain.codes().begin(), plain.codes().end(), composer.codes().begin()));
      EXPECT_TRUE(std::equal(plain.normals().begin(), plain.normals().end(), composer.normals().begin()));
      EXPECT_EQ(plain.height_mm(), composer.height_mm());
    }
  }
  if (!missing.empty()) GTEST_SKIP() << "this machine lacks" << missing << "; the others agree";
}

TEST(Composer, RecomposesOnlyWhatChangedAndAsIfItWereAll) {
  ComposeScene scene(cut_plane(200.0), 200, any_appearance(3, 6));
  set_any_amounts(scene, 6);
  Composer composer = scene.composer();
  (void)composer.compose(*scene.atlas, {});
  EXPECT_TRUE(composer.compose(*scene.atlas, {}).empty());
  EXPECT_TRUE(composer.compose(*scene.atlas, all_tiles(scene)).empty());  // dirty, but the same
  const std::vector<std::uint32_t> codes(composer.codes().begin(), composer.codes().end());
  const std::vector<std::uint8_t> normals(composer.normals().begin(), composer.normals().end());
  // A few tiles: two inside, and all that touch the cut.
  std::vector<TileIndex> dirty;
  const TileGrid& grid = scene.surface->grid();
  scene.set(1, [&](int x, int y, const Vec3& p) {
    const TexelIndex t = grid.index(x, y);
    const bool is_chosen =
        std::abs(p.x() - 100.0) < 2.0 || TileGrid::tile_of(t) == TileGrid::tile_of(grid.index(40, 130));
    if (is_chosen) dirty.push_back(TileGrid::tile_of(t));
    return is_chosen ? 1.7 : scene.atlas->amount(1, t) / double{kAmountOne};
  });
  const std::vector<TileIndex> changed = composer.compose(*scene.atlas, dirty);
  Composer anew = scene.composer();
  (void)anew.compose(*scene.atlas, {});
  EXPECT_TRUE(std::equal(anew.codes().begin(), anew.codes().end(), composer.codes().begin()));
  EXPECT_TRUE(std::equal(anew.normals().begin(), anew.normals().end(), composer.normals().begin()));
  EXPECT_LT(changed.size(), grid.num_tiles() / 3);
  for (TileIndex tile = 0; tile < grid.num_tiles(); ++tile) {
    const bool is_same = std::equal(&codes[tile * 64], &codes[tile * 64] + 64, &composer.codes()[tile * 64]) &&
                         std::equal(&normals[tile * 192], &normals[tile * 192] + 192, &composer.normals()[tile * 192]);
    const bool is_told = std::binary_search(changed.begin(), changed.end(), tile);
    EXPECT_TRUE(is_same || is_told) << tile;
  }
}

TEST(Composer, OtherLooksAndFormsGiveWhatComposingAnewGives) {
  ComposeScene scene(unit_plane(100.0), 100, any_appearance(4, 1));
  set_any_amounts(scene, 1);
  Composer composer = scene.composer();
  (void)composer.compose(*scene.atlas, {});
  scene.scene.appearance = any_appearance(4, 2);
  composer.set_appearance(scene.scene.appearance);
  composer.set_form(ColorForm::Published);
  EXPECT_FALSE(composer.compose(*scene.atlas, {}).empty());
  Composer anew = scene.composer(ColorForm::Published);
  (void)anew.compose(*scene.atlas, {});
  EXPECT_EQ(anew.color_srgb8(), composer.color_srgb8());
  EXPECT_EQ(anew.specular8(), composer.specular8());
  EXPECT_EQ(anew.height_mm(), composer.height_mm());
  EXPECT_EQ(anew.normal8(), composer.normal8());
}

TEST(Composer, StaysInRangeForTheLargestValuesThatThereAre) {
  std::vector<MaterialAppearance> appearance(8);
  for (std::size_t i = 0; i < appearance.size(); ++i) {
    appearance[i] = {.color = {{1, 1, 1}, {}},
                     .strength = 1000.0,
                     .variation = 1.0,
                     .specular = i % 2 == 0 ? 1.0 : -1.0,
                     .specular_variation = 1.0,
                     .height_mm = i < 6 ? 1e6 : -1e6,
                     .height_variation = 1.0};
  }
  ComposeScene scene(unit_plane(1.0), kAtlasSide, appearance, [](Scene& s) {
    s.objects[0].height_map = ImageF(8, 8, 1, std::numeric_limits<float>::infinity());
    s.objects[0].height_map.at(3, 3) = -1e30f;
    s.objects[0].color_map = ImageF(8, 8, 3, std::numeric_limits<float>::quiet_NaN());
    s.objects[0].specular_map = ImageF(8, 8, 1, -std::numeric_limits<float>::infinity());
  });
  for (int m = 0; m < 8; ++m)
    scene.set(m, [m](int x, int y, const Vec3&) { return (x + m) % 2 == 0 || y % 3 == m % 3 ? 4.0 : 0.0; });
  Composer composer = scene.composer();
  (void)composer.compose(*scene.atlas, {});
  const ImageF height = composer.height_mm();
  for (const float h : height.values()) ASSERT_TRUE(std::isfinite(h));
  for (TexelIndex t = 0; t < scene.surface->grid().num_texels(); ++t) {
    EXPECT_EQ(composer.codes()[t] & 0xFFFFFF, 0xFFFFFFu);  // every texel has some, and it covers all
    const std::array<double, 2> slope = composer.slopes(t);
    EXPECT_LE(std::max(std::abs(slope[0]), std::abs(slope[1])), 16.0);
  }
}

TEST(Composer, FillsGuttersFromTheNearestTexel) {
  ComposeScene scene(cut_plane(100.0), 100, any_appearance(3, 4));
  set_any_amounts(scene, 4);
  Composer composer = scene.composer();
  (void)composer.compose(*scene.atlas, {});
  const ImageU8 color = composer.color_srgb8(), normal = composer.normal8();
  for (int y = 0; y < 100; ++y) {
    for (int x = 1; x < 100; ++x) {
      const TexelIndex t = scene.surface->grid().index(x, y), left = scene.surface->grid().index(x - 1, y);
      EXPECT_NE(normal.at(x, y, 2), 0);
      if (!scene.surface->is_covered(left) || scene.surface->is_covered(t)) continue;
      for (int c = 0; c < 3; ++c)
        EXPECT_EQ(color.at(x, y, c), color.at(x - 1, y, c));  // beside a chart: its last texel
    }
  }
}

TEST(Composer, RefusesWhatDoesNotFit) {
  ComposeScene scene(unit_plane(10.0), 16, any_appearance(2, 1)), other(unit_plane(10.0), 16, any_appearance(2, 1));
  Composer composer = scene.composer();
  EXPECT_TRUE(has(error_of([&] { (void)composer.compose(*other.atlas, {}); }), "not that of the composer"));
  EXPECT_TRUE(has(error_of([&] { composer.set_appearance(any_appearance(3, 1)); }),
                  "3 appearances were given for 2 materials"));
  std::vector<MaterialAppearance> appearance = any_appearance(2, 1);
  appearance[1].variation = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(has(error_of([&] { composer.set_appearance(appearance); }), "variation"));
  (void)composer.compose(*scene.atlas, {});
  const std::vector<TileIndex> outside{1u << 30};
  EXPECT_TRUE(has(error_of([&] { (void)composer.compose(*scene.atlas, outside); }), "no tile"));
}

// Heights that were replaced before a stop are not seen to change again; their normals must still be made.
TEST(Composer, AfterAStopTheNextCallGivesWhatAnUninterruptedOneGives) {
  ComposeScene scene(unit_plane(60.0), 256, any_appearance(3, 5));
  set_any_amounts(scene, 9);
  Composer whole = scene.composer();
  const std::vector<TileIndex> changed = whole.compose(*scene.atlas, {});
  for (const double stop_at : {0.2, 0.59, 0.61, 0.8}) {
    Composer stopped = scene.composer();
    std::stop_source source;
    RunControl control{.on_progress =
                           [&](double f) {
                             if (f >= stop_at) source.request_stop();
                           },
                       .stop = source.get_token(),
                       .num_threads = 1};
    EXPECT_THROW((void)stopped.compose(*scene.atlas, {}, control), Canceled) << stop_at;
    EXPECT_EQ(stopped.compose(*scene.atlas, {}), changed) << stop_at;
    EXPECT_TRUE(std::equal(whole.codes().begin(), whole.codes().end(), stopped.codes().begin())) << stop_at;
    EXPECT_TRUE(std::equal(whole.normals().begin(), whole.normals().end(), stopped.normals().begin())) << stop_at;
  }
}

}  // namespace
}  // namespace patinate::simulation
