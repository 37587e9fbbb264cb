#include "capture/calibration/response.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "libcommon/core/random.h"
#include "patinate/core/error.h"

namespace patinate::capture {
namespace {

/// Photographs of a ramp of light through a response, with noise of half a code.
std::vector<ImageU8> series(const std::vector<double>& exposures, double (*code_of)(double), std::uint64_t seed = 1) {
  std::vector<ImageU8> photos;
  for (std::size_t k = 0; k < exposures.size(); ++k) {
    ImageU8 photo(160, 40, 1);
    for (int y = 0; y < 40; ++y) {
      RandomStream random(seed, 100 * k + static_cast<std::size_t>(y), 0);
      for (int x = 0; x < 160; ++x) {
        const double light = 0.002 * std::pow(500.0, (x + y / 40.0) / 160.0);
        const double code = 255.0 * code_of(std::min(1.0, light * exposures[k])) + 0.5 * random.normal();
        photo.at(x, y) = static_cast<std::uint8_t>(std::lround(std::clamp(code, 0.0, 255.0)));
      }
    }
    photos.push_back(photo);
  }
  return photos;
}

double srgb(double v) { return static_cast<double>(srgb_from_linear(static_cast<float>(v))); }
double gamma_18(double v) { return std::pow(v, 1 / 1.8); }
double linear(double v) { return v; }
/// Neither: a film's toe and shoulder.
double film(double v) { return 0.5 * (1 - std::cos(3.14159265358979 * std::pow(v, 0.5))); }

const std::vector<double> kExposures{0.25, 0.5, 1, 2, 4};

TEST(RecoverResponse, SrgbGammaAndLinearCamerasAreTold) {
  const ResponseCurve s = recover_response(series(kExposures, srgb), kExposures);
  EXPECT_EQ(s.status, ResponseStatus::Converged);
  EXPECT_EQ(s.closest.text(), "srgb");
  EXPECT_LT(s.closest_rms, 0.01);
  const ResponseCurve g = recover_response(series(kExposures, gamma_18), kExposures);
  EXPECT_EQ(g.closest.kind, Response::Kind::Gamma);
  EXPECT_NEAR(g.closest.gamma, 1.8, 0.05);
  EXPECT_EQ(recover_response(series(kExposures, linear), kExposures).closest.text(), "linear");
}

TEST(RecoverResponse, AnyRisingCurveIsFoundWithinFourPercent) {
  const ResponseCurve curve = recover_response(series(kExposures, film), kExposures);
  EXPECT_EQ(curve.status, ResponseStatus::Converged);
  // linear of a code is the inverse of film(), up to a factor: compared where the hat weighs most.
  const auto truth = [](int code) { return std::pow(std::acos(1 - 2 * code / 255.0) / 3.14159265358979, 2); };
  const double scale = curve.linear[128] / truth(128);
  for (int code = 20; code <= 235; code += 5) {
    EXPECT_NEAR(curve.linear[code] / scale / truth(code), 1.0, 0.04) << code;
  }
  // None of the three is this camera.
  EXPECT_GT(curve.closest_rms, 2.0 * recover_response(series(kExposures, srgb), kExposures).closest_rms);
}

TEST(RecoverResponse, CurvesRise) {
  const ResponseCurve curve = recover_response(series(kExposures, srgb), kExposures);
  for (std::size_t i = 1; i < 256; ++i) EXPECT_GE(curve.linear[i], curve.linear[i - 1]);
  EXPECT_EQ(curve.linear[255], 1.0);
}

TEST(RecoverResponse, ADarkSeriesIsUndetermined) {
  const std::vector<double> dark{0.01, 0.02, 0.04};
  EXPECT_EQ(recover_response(series(dark, linear), dark).status, ResponseStatus::Undetermined);
}

TEST(RecoverResponse, MistakesAreNamed) {
  const auto error = [](std::vector<ImageU8> photos, const std::vector<double>& exposures) {
    try {
      (void)recover_response(photos, exposures);
    } catch (const InvalidInput& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  const std::vector<ImageU8> good = series(kExposures, srgb);
  EXPECT_NE(error({good[0]}, {1}).find("at least two"), std::string::npos);
  EXPECT_NE(error(good, {1, 2}).find("needs an exposure"), std::string::npos);
  EXPECT_NE(error({good[0], good[1]}, {1, 1}).find("all alike"), std::string::npos);
  EXPECT_NE(error({good[0], good[1]}, {1, -1}).find("> 0"), std::string::npos);
  EXPECT_NE(error({good[0], ImageU8(10, 10)}, {1, 2}).find("differ in size"), std::string::npos);
  EXPECT_NE(error({ImageU8(64, 64), ImageU8(64, 64)}, {1, 2}).find("do not change"), std::string::npos);
  EXPECT_NE(error({ImageU8(64, 64, 3, 255), ImageU8(64, 64, 3, 255)}, {1, 2}).find("do not change"), std::string::npos);
}

}  // namespace
}  // namespace patinate::capture
