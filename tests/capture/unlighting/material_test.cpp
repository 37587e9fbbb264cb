// Materials: lobes that many texels share, metals among them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <vector>

#include "capture/project/relit_project.h"
#include "capture/relit/material_frame.h"
#include "capture/relit/relit_ingest.h"
#include "capture/unlighting/material_maps.h"
#include "datasets_synthetic/mold_io.h"
#include "libcommon/core/median.h"
#include "libcommon/core/random.h"
#include "libcommon/output/microfacet.h"
#include "patinate/core/json.h"
#include "patinate/history/history.h"
#include "patinate/image/image_io.h"
#include "tests/capture/unlighting/gloss_scene.h"
#include "tests/capture/unlighting/metal_scene.h"
#include "tests/support/temp_folder.h"

namespace patinate::capture {
namespace {

using testing_support::foretold;
using testing_support::ForetoldErrors;

UnlightResult with_materials(const UnlightInput& input) { return unlight(input, {.specular = SpecularMode::Material}); }

/// At every step of a mold that turns from metal to mineral. Matt and `auto` are the alternatives that exist; no number
/// is asked for but to be better.
TEST(Materials, LampsLeftOutAreForetoldBetterThanByLambertAndByTheLobesOfTiles) {
  constexpr std::size_t kLamp = 1;
  const auto steps =
      testing_support::metal_steps({.width = 96, .height = 72, .num_steps = 4, .num_lights = 8, .seed = 1});
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const UnlightInput& input = steps[i].input;
    const ForetoldErrors matt = foretold(input, {.specular = SpecularMode::None}, kLamp),
                         today = foretold(input, {.specular = SpecularMode::Auto}, kLamp),
                         found = foretold(input, {.specular = SpecularMode::Material}, kLamp);
    EXPECT_LT(found.mean, matt.mean) << i;
    EXPECT_LT(found.mean, today.mean) << i;
    EXPECT_LT(found.median, matt.median) << i;
    EXPECT_LT(found.median, today.median) << i;
  }
}

TEST(Materials, BareMetalIsFoundToBeMetalOfItsColorAndRoughness) {
  const auto steps = testing_support::metal_steps({.width = 96, .height = 72, .num_steps = 1, .num_lights = 8});
  const UnlightResult found = with_materials(steps[0].input);
  double metal = 0.0;
  for (const SurfaceMaterial& m : found.materials) {
    if (m.kind != MaterialKind::Metal || m.share < 0.1) continue;
    metal += m.share;
    // Roughness is searched for in steps of a thirtieth at last; two of them.
    EXPECT_NEAR(m.roughness, 0.50, 0.50 * 2.0 / 30.0);
    // Samples under a lobe count as a twentieth uncertain.
    EXPECT_NEAR(m.strength[1] / m.strength[0], 0.60 / 0.93, 0.05);
    EXPECT_NEAR(m.strength[2] / m.strength[0], 0.47 / 0.93, 0.05);
  }
  EXPECT_GT(metal, 0.9);  // All is metal but for pixels of the outline and of shadows' edges.
}

TEST(Materials, WhatIsMattOrLacqueredIsNotCalledMetal) {
  for (const testing_support::LobeModel lobe : {testing_support::LobeModel::None, testing_support::LobeModel::Ggx}) {
    const testing_support::GlossScene scene = testing_support::gloss_scene(
        {.lobe = lobe, .material = testing_support::Material::Plastic, .size = 64, .num_lights = 8});
    const UnlightResult found = with_materials(scene.input);
    double metal = 0.0, count = 0.0;
    for (std::int64_t i = 0; i < found.mask.num_pixels(); ++i) {
      if (found.mask.data()[i] == 0) continue;
      count += 1.0;
      metal += static_cast<double>(found.metalness.data()[i]);
    }
    EXPECT_LT(metal / count, 0.05);  // Metal is chosen at two standard deviations.
  }
}

const SurfaceMaterial& largest(const UnlightResult& found) {
  return *std::max_element(found.materials.begin(), found.materials.end(),
                           [](const auto& a, const auto& b) { return a.share < b.share; });
}

/// No model here has two lobes. Matt and `auto` are the alternatives that exist; no number is asked for but to be
/// better. Lacquer of two roughnesses, each over bare metal and over what has turned to mineral.
TEST(Materials, UnderAClearCoatLampsLeftOutAreForetoldBetterThanByLambertAndByTheLobesOfTiles) {
  constexpr std::size_t kLamp = 1;
  for (const double coat : {0.2, 0.3}) {
    const auto steps =
        testing_support::metal_steps({.width = 96, .height = 72, .num_steps = 4, .num_lights = 8, .seed = 1}, coat);
    for (const std::size_t i : {std::size_t{0}, std::size_t{3}}) {
      const UnlightInput& input = steps[i].input;
      const ForetoldErrors matt = foretold(input, {.specular = SpecularMode::None}, kLamp),
                           today = foretold(input, {.specular = SpecularMode::Auto}, kLamp),
                           found = foretold(input, {.specular = SpecularMode::Material}, kLamp);
      std::printf("coat %.1f, step %zu: Lambert %.1f (%.1f), auto %.1f (%.1f), material %.1f (%.1f) %%\n", coat, i,
                  100.0 * matt.mean, 100.0 * matt.median, 100.0 * today.mean, 100.0 * today.median, 100.0 * found.mean,
                  100.0 * found.median);
      EXPECT_LT(found.mean, matt.mean) << coat << ' ' << i;
      EXPECT_LT(found.mean, today.mean) << coat << ' ' << i;
      EXPECT_LT(found.median, matt.median) << coat << ' ' << i;
      EXPECT_LT(found.median, today.median) << coat << ' ' << i;
    }
  }
}

TEST(Materials, MetalUnderAClearCoatIsFoundAsMetalOfItsRoughnessAndMineralAsNone) {
  constexpr double kCoat = 0.2;
  const auto steps =
      testing_support::metal_steps({.width = 96, .height = 72, .num_steps = 4, .num_lights = 8, .seed = 1}, kCoat);
  const UnlightResult bare = with_materials(steps[0].input);
  const SurfaceMaterial& metal = largest(bare);
  EXPECT_EQ(metal.kind, MaterialKind::Metal);
  // As of bare metal: two of the last steps of the search. The coat adds a twentieth of the metal's strength at most,
  // in a lobe of its own width.
  EXPECT_NEAR(metal.roughness, 0.50, 0.50 * 2.0 / 30.0);
  // The coat takes 4 % on the way in and out each and gives 4 % of white back, in a narrower lobe.
  const double passes = (1.0 - testing_support::kCoatF0) * (1.0 - testing_support::kCoatF0);
  EXPECT_NEAR(metal.strength[1] / metal.strength[0], 0.60 / 0.93, 0.05 + 0.04 / (0.93 * passes));

  // Mineral of roughness 0.7 and more below: one lobe that lies between the coat's and its own, and no metal where none
  // is left.
  const UnlightResult covered = with_materials(steps[3].input);
  for (const SurfaceMaterial& m : covered.materials) {
    if (m.share < 0.3 || m.kind == MaterialKind::Matt) continue;
    EXPECT_NE(m.kind, MaterialKind::Metal);
    EXPECT_GT(m.roughness, kCoat * (1.0 - 2.0 / 30.0));
    EXPECT_LT(m.roughness, 0.9);
  }
}

/// White and tinted lobes over a color, on a dome and a saddle.
TEST(Materials, KnownLobesAreFoundWithTheirStrengthColorAndRoughness) {
  using testing_support::Material;
  for (const testing_support::Piece piece : {testing_support::Piece::Mold, testing_support::Piece::Saddle}) {
    for (const Material material : {Material::Plastic, Material::Metal}) {
      const testing_support::GlossScene scene = testing_support::gloss_scene({.piece = piece,
                                                                              .lobe = testing_support::LobeModel::Ggx,
                                                                              .material = material,
                                                                              .strength = 0.12,
                                                                              .width = 0.2,
                                                                              .size = 64,
                                                                              .num_lights = 8});
      const UnlightResult found = with_materials(scene.input);
      ASSERT_FALSE(found.materials.empty());
      const SurfaceMaterial& m = largest(found);
      EXPECT_EQ(m.kind, material == Material::Metal ? MaterialKind::Mixed : MaterialKind::Dielectric);
      // Two of the last steps of the search: 6 % of strength, 2 % of roughness.
      EXPECT_NEAR(m.strength.mean(), 0.12, 0.12 * 0.12);
      EXPECT_NEAR(m.roughness, std::sqrt(0.2), 0.04 * std::sqrt(0.2));
    }
  }
}

/// A step on which metal turns to mineral by degrees, with true lobes, and with one strength and color for all texels.
TEST(Materials, HighlightsAreFreerOnlyWhereTexelsDifferFromTheirMaterial) {
  const auto steps = testing_support::metal_steps({.width = 96, .height = 72, .num_steps = 4, .num_lights = 8});
  const testing_support::MetalStep& step = steps[2];
  const UnlightOptions options{.specular = SpecularMode::Material};
  for (const bool is_true : {true, false}) {
    UnlightWork work(step.input, options, RunControl{});
    const double own_freedom = work.highlight_freedom;
    work.form = {.tail = 2.0, .is_rendered = true};
    work.highlight_normal = work.normal;
    work.specular = ImageF(work.width, work.height, 2);
    work.highlight_tint = ImageF(work.width, work.height, 3);
    work.highlight_metal = ImageF(work.width, work.height, 2);
    for (int y = 0; y < work.height; ++y) {
      for (int x = 0; x < work.width; ++x) {
        if (!work.is_surface(x, y)) continue;
        const double roughness = static_cast<double>(step.roughness.at(x, y));
        const LobeEnergy energy = lobe_energy(roughness, vector_of(work.normal, x, y).dot(work.to_camera(x, y)));
        Vec3 strength(0.3, 0.2, 0.16);  // About the mean of all.
        for (int c = 0; c < 3 && is_true; ++c) {
          const auto f0 = static_cast<double>(step.reflectance.at(x, y, c));
          strength[c] = f0 * energy.compensation(f0);
        }
        work.specular.at(x, y, 0) = static_cast<float>(strength.mean());
        work.specular.at(x, y, 1) = static_cast<float>(roughness);
        for (int c = 0; c < 3; ++c) work.highlight_tint.at(x, y, c) = static_cast<float>(strength[c] / strength.mean());
      }
    }
    work.noise_scale = estimate_noise_scale(work, {});
    const double chosen = choose_freedom(work, {});
    if (is_true)
      EXPECT_EQ(chosen, own_freedom);
    else
      EXPECT_GT(chosen, own_freedom);
  }
}

/// The base color and F0 that `render` makes of a frame: docs/algorithms/appearance.md.
TEST(Materials, AFrameReflectsWhatWasMeasured) {
  for (int i = 0; i < 200; ++i) {
    RandomStream random(3, static_cast<std::uint64_t>(i), 1);
    const double f0 = 0.04 + 0.7 * random.uniform(), gray = 0.9 * (0.8 - f0) * random.uniform();
    const Vec3 color(0.9 + 0.3 * random.uniform(), 1.0, 0.8);
    const Vec3 albedo = gray / color.mean() * color, reflectance = f0 / color.mean() * color;
    UnlightResult result{.albedo = ImageF(1, 1, 3), .specular = ImageF(1, 1, 2), .mask = ImageU8(1, 1, 1, 255)};
    result.reflectance = ImageF(1, 1, 3);
    result.metalness = ImageF(1, 1);
    for (int c = 0; c < 3; ++c) {
      result.albedo.at(0, 0, c) = static_cast<float>(albedo[c]);
      result.reflectance.at(0, 0, c) = static_cast<float>(reflectance[c]);
    }
    const double m = metal_share(gray, f0);
    ASSERT_GE(m, 0.0);
    ASSERT_LE(m, 1.0);
    result.metalness.at(0, 0) = static_cast<float>(m);
    const MaterialFrame frame = material_frame(result);
    Vec3 diffuse, mirror;
    for (int c = 0; c < 3; ++c) {
      const bool has_tint = frame.tint.at(0, 0, c) > 0.0f;
      const double tint = has_tint ? static_cast<double>(frame.tint.at(0, 0, c)) : 1.0;
      const double metal = has_tint ? m : 0.0, own = static_cast<double>(frame.color.at(0, 0, c));
      const double base = (1.0 - metal) * own + metal * tint;
      diffuse[c] = (1.0 - metal) * base;
      mirror[c] = metal * base + (1.0 - metal) * static_cast<double>(frame.specular.at(0, 0, 0)) * tint;
    }
    // Pure metal's albedo is left out, and what little its F0 says of a mineral.
    const bool is_pure = m > 0.95;
    EXPECT_NEAR(mirror.mean(), f0, is_pure ? 0.05 : 1e-3) << gray << ' ' << m;
    if (!is_pure) {
      EXPECT_NEAR(diffuse.mean(), gray, 1e-3) << f0 << ' ' << m;
    }
  }
}

/// A mold whose patina grows out of it, through the whole of ingest.
TEST(Materials, AHistoryOfRelitStepsHasMetalItsColorAndHeightsTogether) {
  const testing_support::TempFolder temp;
  const datasets::MoldOptions o{.width = 96,
                                .height = 72,
                                .num_steps = 3,
                                .num_lights = 8,
                                .scan_spacing_mm = 0.25,
                                .metal = true,
                                .relief_mm = 0.8,
                                .transforms = true};
  run_job(datasets::plan_mold(o, temp.path() / "mold"), {}, {});
  RelitOptions options{.heights = true};
  options.unlight.specular = SpecularMode::Material;
  run_job(plan_relit_ingest(read_relit_project(temp.path() / "mold/capture.json"), options, temp.path() / "history"),
          {}, {});
  const HistoryReader reader(temp.path() / "history");
  for (const char* name : {"specular", "normal", "metalness", "tint", "height"})
    EXPECT_TRUE(reader.read_frame_extra(1, name).has_value()) << name;
  const ImageF metalness = *reader.read_frame_extra(0, "metalness"), tint = *reader.read_frame_extra(0, "tint");
  double metal = 0.0, count = 0.0;
  for (std::int64_t i = 0; i < metalness.num_pixels(); ++i) {
    const float* t = tint.data() + 3 * i;
    ASSERT_GE(metalness.data()[i], 0.0f);
    ASSERT_LE(metalness.data()[i], 1.0f);
    if (!(t[0] > 0.0f)) continue;
    count += 1.0;
    metal += t[0] > t[2] ? 1.0 : 0.0;
  }
  EXPECT_GT(count, 100.0);
  EXPECT_GT(metal / count, 0.9);  // Copper is redder than blue.

  const Json truth = load_json(temp.path() / "mold/truth/truth.json");
  const ImageF risen = read_gray(temp.path() / "mold/truth" / truth.at("steps").at(1).at("relief").get<std::string>());
  const ImageF first = *reader.read_frame_extra(0, "height"), found = *reader.read_frame_extra(1, "height");
  std::vector<double> off;
  double grown = 0.0, grown_found = 0.0;
  for (std::int64_t i = 0; i < found.num_pixels(); ++i) {
    EXPECT_EQ(first.data()[i], 0.0f);
    if (found.data()[i] == 0.0f) continue;
    off.push_back(std::abs(static_cast<double>(found.data()[i] - risen.data()[i])));
    if (risen.data()[i] < 0.2f) continue;
    grown += static_cast<double>(risen.data()[i]);
    grown_found += static_cast<double>(found.data()[i]);
  }
  ASSERT_GT(off.size(), 1000u);
  std::printf("heights: median off %.1f um; grown %.3f of %.3f\n", 1000.0 * median(off), grown_found, grown);
  // Planes through 60 points of 0.02 mm noise, in both scans: 3.7 um, four of them. A window of 2.2 mm blurs what the
  // patina's cells of 3 mm differ by, 0.1 mm, by (1.1 k)^2 / 8 of it with k = 2 pi / 6 mm: 17 um.
  EXPECT_LT(median(off), 4.0 * 0.02 * std::sqrt(2.0 / 60.0) + 0.017);
  EXPECT_NEAR(grown_found / grown, 1.0, 0.1);  // Places that have grown by 0.2 mm and more.
}

}  // namespace
}  // namespace patinate::capture
