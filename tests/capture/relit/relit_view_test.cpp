#include "capture/relit/relit_view.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>

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

}  // namespace
}  // namespace patinate::capture
