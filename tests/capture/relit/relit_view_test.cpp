#include "capture/relit/relit_view.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>

namespace patinate::capture {
namespace {

constexpr int kSide = 48;
constexpr double kHalf_mm = 15.3;  ///< Half of the plate's side: its outline runs through pixels.

/// 1 mm a pixel at the plate, straight from above.
Camera camera_above() {
  CameraParameters p;
  p.width = p.height = kSide;
  p.fx = p.fy = 1000.0;
  p.cx = p.cy = 0.5 * (kSide - 1);
  p.rotation = Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal();
  p.translation = {0.0, 0.0, 1000.0};
  return Camera(p);
}

/// A square plate in its plane, moved.
Mesh plate(const Vec3& moved) {
  Mesh mesh;
  for (const double y : {-kHalf_mm, kHalf_mm}) {
    for (const double x : {-kHalf_mm, kHalf_mm}) mesh.positions.emplace_back(moved + Vec3(x, y, 0.0));
  }
  mesh.triangles = {{0, 1, 3}, {0, 3, 2}};
  return with_scan_normals(mesh, 0);
}

/// The white plate on black: each pixel is the mean over its area, as in a camera.
ImageF photograph(const Vec3& moved) {
  const auto share = [](double middle, double low, double high) {
    return std::max(0.0, std::min(middle + 0.5, high) - std::max(middle - 0.5, low));
  };
  ImageF photo(kSide, kSide, 1);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const double u = x - 0.5 * (kSide - 1), v = 0.5 * (kSide - 1) - y;
      photo.at(x, y) = static_cast<float>(share(u, moved.x() - kHalf_mm, moved.x() + kHalf_mm) *
                                          share(v, moved.y() - kHalf_mm, moved.y() + kHalf_mm));
    }
  }
  return photo;
}

TEST(RelitView, NothingFromOutsideIsMixedIntoTheRimOfAMovedObject) {
  const Camera camera = camera_above();
  const auto view_of = [&](const Vec3& moved) {
    const Mesh mesh = plate(moved);
    return view_scan(mesh, RayScene(mesh), camera);
  };
  const ScanView reference = view_of(Vec3::Zero());
  for (const Vec3& moved : {Vec3(0.0, 0.0, 0.0), Vec3(0.4, 0.0, 0.0), Vec3(-0.45, 0.3, 0.0), Vec3(1.3, -2.6, 0.0)}) {
    RigidTransform step_from_reference;
    step_from_reference.translation = moved;
    const StepPlaces places = find_places(reference, view_of(moved), camera, step_from_reference);
    const PlacedPhoto placed = place_photo(photograph(moved), places, std::numeric_limits<float>::infinity());
    int num_valid = 0;
    for (std::int64_t i = 0; i < placed.values.num_pixels(); ++i) {
      if (placed.valid.data()[i] == 0) continue;
      ++num_valid;
      // Sums of weights, in floats.
      EXPECT_NEAR(placed.values.data()[i], 1.0f, 1e-6f)
          << moved.transpose() << " at " << i % kSide << ", " << i / kSide;
    }
    // Two pixels along the outline are of no place: its own, and those beside them.
    const double least = 2.0 * kHalf_mm - 2.0 * 3.0;
    EXPECT_GE(num_valid, least * least) << moved.transpose();
  }
}

/// Places of all pixels, moved by half a pixel.
StepPlaces half_a_pixel_on() {
  StepPlaces places{ImageF(kSide, kSide, 2), ImageU8(kSide, kSide)};
  for (int y = 2; y < kSide - 3; ++y) {
    for (int x = 2; x < kSide - 3; ++x) {
      places.place_px.at(x, y, 0) = static_cast<float>(x) + 0.5f;
      places.place_px.at(x, y, 1) = static_cast<float>(y);
      places.seen.at(x, y) = 255;
    }
  }
  return places;
}

TEST(RelitView, RidgesThreePixelsWideAreNotFlattenedByMotion) {
  // A ridge and a groove of three pixels each. At half a pixel the spline keeps 9/8 cos(w/2) - 1/8 cos(3w/2) of a wave,
  // 0.974 of this one, and weights of two pixels keep cos(w/2), 0.866.
  const double w = std::numbers::pi / 3.0, kept = 9.0 / 8.0 * std::cos(0.5 * w) - std::cos(1.5 * w) / 8.0;
  ImageF photo(kSide, kSide, 1);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) photo.at(x, y) = static_cast<float>(2.0 + std::cos(w * x));
  }
  const StepPlaces places = half_a_pixel_on();
  const PlacedPhoto placed = place_photo(photo, places, std::numeric_limits<float>::infinity());
  for (int x = 2; x < kSide - 3; ++x)
    EXPECT_NEAR(static_cast<double>(placed.values.at(x, 20)), 2.0 + kept * std::cos(w * (x + 0.5)), 1e-5) << x;
  // A saturated pixel beside the nearest ones takes no place away, and nothing of it is in the sample.
  photo.at(20, 20) = 100.0f;
  const PlacedPhoto beside = place_photo(photo, places, 50.0f);
  EXPECT_EQ(beside.valid.at(20, 20), 0);
  ASSERT_NE(beside.valid.at(21, 20), 0);
  EXPECT_NEAR(static_cast<double>(beside.values.at(21, 20)), 2.0 + std::cos(0.5 * w) * std::cos(w * 21.5), 1e-5);
}

TEST(RelitView, DeviationsSayHowFarAPixelsMeanIsOffItsCenter) {
  // Flat to the left, a parabola with the second difference 0.08 to the right.
  ImageF albedo(kSide, kSide, 3), stddev(kSide, kSide, 3, 0.003f);
  ImageU8 mask(kSide, kSide, 1, 255);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      for (int c = 0; c < 3; ++c)
        albedo.at(x, y, c) = x < 24 ? 0.5f : 0.5f + 0.04f * static_cast<float>((x - 24) * (x - 24));
    }
  }
  for (int y = 0; y < kSide; ++y) mask.at(10, y) = 0;
  albedo.at(10, 20, 0) = 9.0f;
  StepPlaces places = half_a_pixel_on();
  places.place_px.at(41, 20, 0) = 41.0f;
  add_sampling_deviation(albedo, mask, places, stddev);
  EXPECT_EQ(stddev.at(5, 20, 1), 0.003f) << "a flat surface";
  EXPECT_EQ(stddev.at(11, 20, 0), 0.003f) << "what is outside of the mask does not count";
  // At a center at least what the mean over the pixel is off on a parabola, 1/24 of the second difference, and no more
  // than an edge would be, 0.29 of it; between centers more.
  EXPECT_GT(stddev.at(41, 20, 2), 0.08f / 24.0f);
  EXPECT_LT(stddev.at(41, 20, 2), 0.08f * 0.29f);
  EXPECT_GT(stddev.at(40, 20, 2), stddev.at(41, 20, 2));
  // A sample from one side only, half a pixel from its place, is off by half of the slope.
  ImageF ramp(kSide, kSide, 3), of_ramp(kSide, kSide, 3);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      for (int c = 0; c < 3; ++c) ramp.at(x, y, c) = 0.01f * static_cast<float>(x);
    }
  }
  places.whole = ImageU8(kSide, kSide, 1, 255);
  places.whole.at(31, 20) = 0;
  add_sampling_deviation(ramp, ImageU8(kSide, kSide, 1, 255), places, of_ramp);
  EXPECT_NEAR(of_ramp.at(30, 20, 0), 0.005f, 1e-6f);
  EXPECT_NEAR(of_ramp.at(30, 25, 0), 0.0f, 1e-6f);
}

}  // namespace
}  // namespace patinate::capture
