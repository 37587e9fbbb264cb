#include "datasets_synthetic/plate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "datasets_synthetic/plate_io.h"
#include "libcommon/output/microfacet.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/image/image_io.h"
#include "tests/support/temp_folder.h"

namespace patinate::datasets {
namespace {

TEST(Plate, ShowsItsAlbedoUnderTheLampAndTheTopOfItsLobeInTheMirrorsDirection) {
  const PlateOptions o{.size = 129, .num_frames = 2, .texture = 0.0};
  const GlossyPlate plate(o);
  // The mirror's place: where the line from the lamp to the camera's mirror image meets the plate.
  const Light lamp = plate.lamp(0);
  const double zl = lamp.position.z(), zc = plate.camera().z();
  const Vec3 mirror = (zc * lamp.position + zl * plate.camera()) / (zl + zc);
  const double texel = o.side_mm / o.size;
  const int mx = static_cast<int>(std::lround(mirror.x() / texel + 64.0)),
            my = static_cast<int>(std::lround(64.0 - mirror.y() / texel));
  const ImageF photo = plate_photo(plate, 0);
  const auto reflected = [&](int x, int y) {
    const Vec3 p = plate.position(x, y);
    return M_PI * static_cast<double>(photo.at(x, y, 0)) / light_at(lamp, p)[0] -
           plate.look(x, y, 0).albedo[0] * direction_to(lamp, p).z();
  };
  // GGX at its top: F0 / (4 alpha^2) times masking, which is within 1 % of 1 here, and the energy made good, 1 + F0 of
  // the rest at most.
  const double alpha = o.roughness * o.roughness, top = o.specular / (4.0 * alpha * alpha);
  EXPECT_NEAR(reflected(mx, my) / top, 1.0, 0.03);
  EXPECT_LT(reflected(0, 128), 0.3 * top);
}

TEST(Plate, AMovingLampStandsAsFarOffAndASecondOneElsewhere) {
  const GlossyPlate still({.size = 32}), moving({.size = 32, .moving = true});
  EXPECT_EQ(still.lamp(0).position, still.lamp(5).position);
  EXPECT_GT((moving.lamp(0).position - moving.lamp(1).position).norm(), 50.0);
  for (const int frame : {1, 4}) EXPECT_NEAR(moving.lamp(frame).position.norm(), still.lamp(0).position.norm(), 1e-9);
}

TEST(Plate, PatinaGrowsFromNothingToMoreThanHalf) {
  const GlossyPlate plate({.size = 96, .num_frames = 8});
  double before = -1.0;
  for (int frame = 0; frame < 8; ++frame) {
    double sum = 0.0;
    for (int y = 0; y < 96; ++y)
      for (int x = 0; x < 96; ++x) sum += plate.look(x, y, frame).patina / (96.0 * 96.0);
    EXPECT_GE(sum, before);
    before = sum;
    if (frame == 0) {
      EXPECT_LT(sum, 0.02);
    }
  }
  EXPECT_GT(before, 0.5);
}

TEST(Plate, ProjectFolderHoldsWhatALabWouldHaveAndTheTruth) {
  const testing_support::TempFolder temp;
  const PlateOptions o{.size = 48, .num_frames = 3, .moving = true};
  run_job(plan_plate(o, temp / "plate"), {}, {});
  const Json capture = load_json(temp / "plate/capture.json");
  EXPECT_EQ(capture.at("kind"), "fixed");
  EXPECT_EQ(capture.at("lights").size(), 3u);
  EXPECT_EQ(probe_image(temp / "plate/frames/0002.png").width, 48);
  const Json truth = load_json(temp / "plate/truth/truth.json");
  const GlossyPlate plate(o);
  const PlateLook look = plate.look(20, 30, 2);
  const Json& last = truth.at("frames").at(2);
  const auto file = [&](const char* name) { return temp / "plate/truth" / last.at(name).get<std::string>(); };
  EXPECT_EQ(read_gray(file("patina")).at(20, 30), static_cast<float>(look.patina));
  EXPECT_EQ(read_channels(file("albedo"), {"R", "G", "B"}).at(20, 30, 1), static_cast<float>(look.albedo[1]));
}

TEST(Plate, OptionsOutOfRangeAreRefused) {
  EXPECT_THROW(GlossyPlate({.size = 8}), InvalidInput);
  EXPECT_THROW(GlossyPlate({.roughness = 0.0}), InvalidInput);
  EXPECT_THROW(GlossyPlate({.noise = std::numeric_limits<double>::quiet_NaN()}), InvalidInput);
}

}  // namespace
}  // namespace patinate::datasets
