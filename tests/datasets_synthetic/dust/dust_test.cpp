#include "datasets_synthetic/dust.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "datasets_synthetic/dust_io.h"
#include "libcommon/core/random.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/mesh_io.h"
#include "tests/support/temp_folder.h"

namespace patinate::datasets {
namespace {

DustOptions small(DustFollows follows) { return {.width = 72, .height = 90, .num_frames = 3, .follows = follows}; }

TEST(Dust, CoversWhatGrainsThatFallAnywhereCover) {
  // Thrown one by one onto a plate of many small places, each grain as large as one of them.
  DustOptions o = small(DustFollows::Facing);
  o.unevenness = 0.0;
  const DustyObject object(o);
  const DustPlace level{.facing = 1.0};
  constexpr int kPlaces = 20000;
  std::vector<bool> is_covered(kPlaces, false);
  RandomStream random(1, 0);
  int thrown = 0, num_covered = 0;
  for (const double time : {5.0, 20.0, 60.0}) {
    for (; thrown < static_cast<int>(o.rate * time * kPlaces); ++thrown) {
      auto place = is_covered[random.below(kPlaces)];
      num_covered += place ? 0 : 1;
      place = true;
    }
    const double expected = object.look(level, time).cover;
    EXPECT_NEAR(num_covered / static_cast<double>(kPlaces), expected,
                4.0 * std::sqrt(expected * (1.0 - expected) / kPlaces));
  }
}

TEST(Dust, LiesOnWhatLooksUpAndNeverOnWhatLooksDown) {
  DustOptions o = small(DustFollows::Facing);
  o.unevenness = 0.0;
  const DustyObject object(o);
  const DustView view = dust_view(object);
  int num_up = 0, num_down = 0;
  for (int y = 0; y < o.height; ++y) {
    for (int x = 0; x < o.width; ++x) {
      const std::optional<DustPlace> place = object.place(Vec2(x, y));
      if (!place) continue;
      const double up = place->normal.y();
      EXPECT_NEAR(object.amount(*place, 10.0), 10.0 * o.rate * std::pow(std::max(0.0, up), 3.0), 1e-12);
      EXPECT_EQ(static_cast<float>(place->facing), view.facing.at(x, y));
      num_up += up > 0.7 ? 1 : 0;
      if (up > 0.0) continue;
      ++num_down;
      EXPECT_EQ(object.look(*place, 1000.0).albedo, object.look(*place, 0.0).albedo);
    }
  }
  EXPECT_GT(num_up, 50);
  EXPECT_GT(num_down, 50);
}

TEST(Dust, TheSkyIsNeverSeenMoreThanFacingAllows) {
  // A place whose normal stands at an angle a to the vertical sees (1 + cos a) / 2 of the sky where nothing is in its
  // way.
  const DustyObject object(small(DustFollows::Exposure));
  int num_checked = 0, num_free = 0;
  for (int y = 0; y < 90; ++y) {
    for (int x = 0; x < 72; ++x) {
      const std::optional<DustPlace> place = object.place(Vec2(x, y));
      if (!place) continue;
      // The texel whose value it has lies nearer than the next pixel's place. 128 directions for the whole sky are off
      // by less than two of them.
      double free = 0.0;
      for (int j = -1; j <= 1; ++j) {
        for (int i = -1; i <= 1; ++i) {
          const std::optional<DustPlace> near = object.place(Vec2(x + i, y + j));
          if (near) free = std::max(free, 0.5 * (1.0 + near->normal.y()));
        }
      }
      EXPECT_LT(place->exposure, free + 2.0 / 128.0) << x << ' ' << y;
      num_free += place->exposure > 0.5 * (1.0 + place->normal.y()) - 0.04 ? 1 : 0;
      ++num_checked;
    }
  }
  ASSERT_GT(num_checked, 1000);
  EXPECT_GT(num_free, num_checked / 20);
}

TEST(Dust, PhotographInEvenLightWithoutGlossIsTheAlbedo) {
  DustOptions o = small(DustFollows::Exposure);
  o.noise = o.gloss = o.shading = 0.0;
  const DustyObject object(o);
  RunControl one, three;
  one.num_threads = 1;
  three.num_threads = 3;
  const ImageF photo = dust_photo(object, 30.0, one);
  EXPECT_EQ(photo, dust_photo(object, 30.0, three));
  const DustView view = dust_view(object);
  int num_checked = 0;
  for (int y = 0; y < o.height; ++y) {
    for (int x = 0; x < o.width; ++x) {
      if (view.mask.at(x, y) == 0) continue;
      const DustLook look = object.look(object.place(Vec2(x, y)).value(), 30.0);
      for (int c = 0; c < 3; ++c) EXPECT_EQ(photo.at(x, y, c), static_cast<float>(look.albedo[c]));
      ++num_checked;
    }
  }
  EXPECT_GT(num_checked, 1000);
}

TEST(Dust, ProjectFolderHoldsWhatALabWouldHaveAndTheTruth) {
  const testing_support::TempFolder temp;
  const DustOptions o = small(DustFollows::Facing);
  run_job(plan_dust(o, temp / "dust"), {}, {});
  const Json capture = load_json(temp / "dust/capture.json");
  EXPECT_EQ(capture.at("controls").at(0).at("name"), "facing");
  EXPECT_EQ(probe_image(temp / "dust/frames/0002.png").height, 90);
  EXPECT_GT(read_mesh(temp / "dust/mesh.obj").num_triangles(), 10000);
  const Json truth = load_json(temp / "dust/truth/truth.json");
  const auto file = [&](const char* name) {
    return temp / "dust/truth" / truth.at("frames").at(2).at(name).get<std::string>();
  };
  const DustyObject object(o);
  const DustLook look = object.look(object.place(Vec2(36, 30)).value(), 14.0);
  EXPECT_EQ(read_gray(file("cover")).at(36, 30), static_cast<float>(look.cover));
  EXPECT_EQ(read_channels(file("specular"), {"strength", "roughness"}).at(36, 30, 0),
            static_cast<float>(look.specular));
}

TEST(Dust, OptionsOutOfRangeAreRefused) {
  EXPECT_THROW(DustyObject({.rate = 0.0}), InvalidInput);
  EXPECT_THROW((void)plan_dust({.steepness = std::nan("")}, "x"), InvalidInput);
}

}  // namespace
}  // namespace patinate::datasets
