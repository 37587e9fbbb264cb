#include "datasets_synthetic/drying.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "datasets_synthetic/drying_io.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/image/image_io.h"
#include "tests/support/temp_folder.h"

namespace patinate::datasets {
namespace {

DryingOptions small(DryingOrder order) { return {.width = 96, .height = 80, .num_frames = 4, .order = order}; }

TEST(Drying, WetAlbedoIsTheSumOverReflectionsInTheFilm) {
  // Light enters with 1 - r, is reflected by the ground, and of what comes to the film from below p goes back down.
  const double r = 0.066, p = 1.0 - (1.0 - r) / (1.333 * 1.333);
  for (const double dry : {0.0, 0.05, 0.3, 0.7, 1.0}) {
    double sum = 0.0, down = 1.0 - r;
    for (int i = 0; i < 200; ++i) {
      const double up = down * dry;
      sum += up * (1.0 - p);
      down = up * p;
    }
    EXPECT_NEAR(wet_albedo(dry), sum, 1e-12);
  }
  EXPECT_NEAR(wet_albedo(1.0), 1.0 - r, 1e-12);  // White ground keeps nothing.
}

TEST(Drying, TheFilmIsGoneWhenItsWaterHasLeft) {
  for (const DryingOrder order : {DryingOrder::Rim, DryingOrder::Thickness}) {
    const DryingPatch patch(small(order));
    int num_inside = 0;
    for (int y = 0; y < 80; ++y) {
      for (int x = 0; x < 96; ++x) {
        const double inside = patch.depth(x, y), onset = patch.onset_min(x, y);
        if (!(inside > 0.0)) {
          EXPECT_EQ(onset, -1.0);
          EXPECT_EQ(patch.look(x, y, 0.0).wetness, 0.0);
          EXPECT_EQ(patch.look(x, y, 0.0).albedo, patch.dry_albedo(x, y));
          continue;
        }
        ++num_inside;
        const double slower = order == DryingOrder::Rim ? std::sqrt(inside) : 1.0;
        EXPECT_NEAR(onset, patch.film_mm(x, y) / 0.15 * 60.0 * slower, 1e-9);
        // Dark and glossy until then; one time constant later 1/e of the water is left in the pores.
        EXPECT_EQ(patch.look(x, y, onset).wetness, patch.look(x, y, 0.0).wetness);
        EXPECT_EQ(patch.look(x, y, onset).film, 0.0);
        EXPECT_NEAR(patch.look(x, y, onset + 15.0).wetness, std::exp(-1.0) * patch.look(x, y, 0.0).wetness, 1e-12);
      }
    }
    EXPECT_GT(num_inside, 1500);
  }
}

TEST(Drying, GoesFromDarkAndGlossyToLightAndDullAndNeverBack) {
  const DryingPatch patch(small(DryingOrder::Thickness));
  for (int y = 0; y < 80; y += 3) {
    for (int x = 0; x < 96; x += 3) {
      DryingLook before = patch.look(x, y, 0.0);
      for (double time = 5.0; time <= 300.0; time += 5.0) {
        const DryingLook look = patch.look(x, y, time);
        EXPECT_LE(look.wetness, before.wetness);
        EXPECT_LE(look.specular, before.specular);
        EXPECT_GE(look.roughness, before.roughness);
        for (int c = 0; c < 3; ++c) EXPECT_GE(look.albedo[c], before.albedo[c]);
        before = look;
      }
    }
  }
}

TEST(Drying, PhotographWithoutGlossIsTheAlbedoAndGlossOnlyAddsToTheFilm) {
  DryingOptions o = small(DryingOrder::Rim);
  const DryingPatch shiny(o);
  o.gloss = 0.0;
  const DryingPatch dull(o);
  const double time = 20.0;
  const ImageF with = drying_photo(shiny, time), without = drying_photo(dull, time);
  double added = 0.0;
  for (int y = 0; y < 80; ++y) {
    for (int x = 0; x < 96; ++x) {
      const DryingLook look = dull.look(x, y, time);
      for (int c = 0; c < 3; ++c) {
        EXPECT_EQ(without.at(x, y, c), static_cast<float>(look.albedo[c]));
        EXPECT_GE(with.at(x, y, c), without.at(x, y, c));
        if (look.film == 0.0) {
          EXPECT_EQ(with.at(x, y, c), without.at(x, y, c));
        }
      }
      added = std::max(added, static_cast<double>(with.at(x, y, 1)) - static_cast<double>(without.at(x, y, 1)));
    }
  }
  EXPECT_GT(added, 0.05);
  RunControl one, three;
  one.num_threads = 1;
  three.num_threads = 3;
  EXPECT_EQ(drying_photo(shiny, time, one), drying_photo(shiny, time, three));
}

TEST(Drying, ProjectFolderHoldsWhatALabWouldHaveAndTheTruth) {
  const testing_support::TempFolder temp;
  const DryingOptions o = small(DryingOrder::Rim);
  run_job(plan_drying(o, temp / "drying"), {}, {});
  const Json capture = load_json(temp / "drying/capture.json");
  EXPECT_EQ(capture.at("kind"), "fixed");
  EXPECT_EQ(capture.at("time_unit"), "min");
  EXPECT_EQ(probe_image(temp / "drying/frames/0003.png").width, 96);
  const Json truth = load_json(temp / "drying/truth/truth.json");
  EXPECT_EQ(truth.at("options").at("order"), "rim");
  const Json& last = truth.at("frames").at(3);
  const DryingPatch patch(o);
  const DryingLook look = patch.look(48, 40, last.at("time").get<double>());
  const auto file = [&](const char* name) { return temp / "drying/truth" / last.at(name).get<std::string>(); };
  EXPECT_EQ(read_gray(file("wetness")).at(48, 40), static_cast<float>(look.wetness));
  EXPECT_EQ(read_channels(file("albedo"), {"R", "G", "B"}).at(48, 40, 2), static_cast<float>(look.albedo[2]));
  EXPECT_EQ(read_channels(file("specular"), {"strength", "roughness"}).at(48, 40, 1),
            static_cast<float>(look.roughness));
  EXPECT_EQ(read_gray(temp / "drying/truth/onset.exr").at(48, 40), static_cast<float>(patch.onset_min(48, 40)));
}

TEST(Drying, OptionsOutOfRangeAreRefused) {
  EXPECT_THROW(DryingPatch({.width = 8}), InvalidInput);
  EXPECT_THROW(DryingPatch({.pores_min = 0.0}), InvalidInput);
  EXPECT_THROW(DryingPatch({.noise = std::nan("")}), InvalidInput);
}

}  // namespace
}  // namespace patinate::datasets
