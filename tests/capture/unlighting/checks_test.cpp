// Checks that need no truth: photographs predicted from the others, and codes decoded by the wrong curve.
#include <gtest/gtest.h>

#include "capture/unlighting/leave_one_out.h"
#include "capture/unlighting/response_check.h"
#include "patinate/image/color.h"
#include "tests/capture/unlighting/lit_relief.h"

namespace patinate::capture {
namespace {

using namespace testing_support;

TEST(LeaveOneOut, ExactPhotographsForetellEachOther) {
  const LitRelief scene = lit_relief({.size = 48, .cast_shadows = false});
  const UnlightOptions options;
  for (const LeaveOneOutError& e : leave_one_out(scene.input, options, unlight(scene.input, options))) {
    EXPECT_GT(e.num_samples, 1000);
    EXPECT_LT(e.rms, 1e-4);  // Photographs are float.
    EXPECT_LT(e.median, 1e-4);
  }
}

TEST(LeaveOneOut, ALampInAWrongPlaceStandsOut) {
  LitRelief scene = lit_relief({.size = 48, .cast_shadows = false, .normal_noise_deg = 1.0, .noise_share = 0.005});
  scene.input.lights[2].position += Vec3(0, 0, 60.0);
  const UnlightOptions options{.specular = SpecularMode::None};
  const std::vector<LeaveOneOutError> errors = leave_one_out(scene.input, options, unlight(scene.input, options));
  for (std::size_t k = 0; k < errors.size(); ++k) {
    if (k == 2) continue;
    EXPECT_GT(errors[2].median, 2.0 * errors[k].median) << k;
  }
}

/// Codes of the same scene, taken for linear values, or decoded once too often.
UnlightInput through(UnlightInput input, float (*curve)(float)) {
  for (ImageF& photo : input.photos) {
    for (float& v : photo.values()) v = curve(v);
  }
  return input;
}

TEST(ResponseCheck, UndecodedCodesAreNoticedAndRightOnesAreNotDoubted) {
  LitReliefOptions o{.size = 40, .normal_noise_deg = 1.8, .noise_share = 0.005, .coding = Coding::Srgb8};
  for (const double gloss : {0.0, 0.1}) {
    o.gloss = gloss;
    LitRelief scene = lit_relief(o);
    scene.input.blockers = &scene.scan;
    const Response linear{.kind = Response::Kind::Linear}, srgb{.kind = Response::Kind::Srgb};
    EXPECT_TRUE(check_response(through(scene.input, srgb_from_linear), {}, linear).is_doubtful);
    EXPECT_TRUE(check_response(through(scene.input, linear_from_srgb), {}, srgb).is_doubtful);
    EXPECT_FALSE(check_response(scene.input, {}, srgb).is_doubtful);
    EXPECT_FALSE(check_response(scene.input, {}, linear).is_doubtful);
  }
}

TEST(ResponseCheck, UndecodedCodesCostAFifthOfTheAlbedo) {
  LitRelief scene = lit_relief({.size = 48, .normal_noise_deg = 1.8, .noise_share = 0.005, .coding = Coding::Srgb8});
  scene.input.blockers = &scene.scan;
  const UnlightResult right = unlight(scene.input), wrong = unlight(through(scene.input, srgb_from_linear));
  EXPECT_LT(relative_error_percent(right, scene.albedo), 1.1);
  EXPECT_GT(relative_error_percent(wrong, scene.albedo), 20.0);
}

}  // namespace
}  // namespace patinate::capture
