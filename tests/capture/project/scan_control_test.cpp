#include "capture/project/scan_control.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "capture/timelapse/ingest.h"
#include "libcommon/core/files.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/mesh_io.h"
#include "tests/capture/timelapse/ingest_folder.h"
#include "tests/libcommon/geometry/shapes.h"
#include "tests/support/errors.h"
#include "tests/support/temp_folder.h"

namespace patinate::capture {
namespace {

namespace fs = std::filesystem;
using testing_support::has;
using testing_support::ingest;
using testing_support::ingest_error;
using testing_support::make_icosphere;
using testing_support::make_patch;
using testing_support::TempFolder;

constexpr int kPhotoWidth = 90, kPhotoHeight = 75;
constexpr double kRadius = 20.0, kDistance = 100.0;

/// Looks from z = kDistance down at the origin; y of the world is up.
Camera camera_above(double k1 = -0.1) {
  CameraParameters p;
  p.width = kPhotoWidth, p.height = kPhotoHeight;
  p.fx = p.fy = 160.0;
  p.cx = 46.0, p.cy = 36.0;
  p.distortion = {k1, 0.02, 1e-3, -5e-4, 0.0};
  p.rotation << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  p.translation = {0, 0, kDistance};
  return Camera(p);
}

const PhotoPart kWhole{.x0 = 0,
                       .y0 = 0,
                       .width = kPhotoWidth,
                       .height = kPhotoHeight,
                       .num_columns = kPhotoWidth,
                       .num_rows = kPhotoHeight};

Vec3 vector_at(const ImageF& image, int x, int y) {
  return {static_cast<double>(image.at(x, y, 0)), static_cast<double>(image.at(x, y, 1)),
          static_cast<double>(image.at(x, y, 2))};
}

TEST(ScanMaps, ASphereIsWhereItIsAndEvenlyCurved) {
  const double scale = 2.0;
  const ScanMaps maps = scan_maps(make_icosphere(kRadius, 5), camera_above(), kWhole, {.scale_mm = scale});
  // Closed form of mean_curvature() on a sphere; the rest is discretization.
  const double expected = -1.0 / kRadius / (1.0 + scale * scale / (kRadius * kRadius));
  // Middle of an edge of 1.2 mm under the sphere: edge^2 / (8 R).
  constexpr double kFacets = 0.01;
  ASSERT_GT(maps.num_seen, 1000);
  double sum = 0.0;
  for (int y = 0; y < kPhotoHeight; ++y) {
    for (int x = 0; x < kPhotoWidth; ++x) {
      if (maps.seen.at(x, y) == 0) {
        EXPECT_EQ(vector_at(maps.position_mm, x, y).norm() + vector_at(maps.normal, x, y).norm(), 0.0);
        continue;
      }
      const Vec3 position = vector_at(maps.position_mm, x, y);
      EXPECT_NEAR(position.norm(), kRadius, kFacets);
      EXPECT_LT((vector_at(maps.normal, x, y) - position / position.norm()).norm(), 0.01);
      EXPECT_NEAR(static_cast<double>(maps.curvature_per_mm.at(x, y)), expected, 0.02 * std::abs(expected));
      const auto seen = camera_above().project(position);
      ASSERT_TRUE(seen);
      EXPECT_LT((*seen - Vec2(x, y)).norm(), 1e-3);  // Positions and rays are float.
      sum += static_cast<double>(maps.curvature_per_mm.at(x, y));
    }
  }
  EXPECT_NEAR(sum / static_cast<double>(maps.num_seen), expected, 0.003 * std::abs(expected));
}

TEST(ScanMaps, APartOfThePhotographReducedSeesTheSamePlaces) {
  const Mesh sphere = make_icosphere(kRadius, 3);
  const ScanMaps whole = scan_maps(sphere, camera_above(), kWhole);
  // Centers of blocks of three by three pixels are pixels.
  const PhotoPart part{.x0 = 31, .y0 = 14, .width = 45, .height = 36, .num_columns = 15, .num_rows = 12};
  const ScanMaps reduced = scan_maps(sphere, camera_above(), part);
  ASSERT_GT(reduced.num_seen, 100);
  for (int y = 0; y < 12; ++y) {
    for (int x = 0; x < 15; ++x) {
      const int px = 31 + 3 * x + 1, py = 14 + 3 * y + 1;
      EXPECT_EQ(reduced.seen.at(x, y), whole.seen.at(px, py));
      EXPECT_EQ(vector_at(reduced.position_mm, x, y), vector_at(whole.position_mm, px, py));
      EXPECT_EQ(reduced.curvature_per_mm.at(x, y), whole.curvature_per_mm.at(px, py));
    }
  }
}

TEST(ScanMaps, TheSideThatIsSeenIsOutside) {
  Mesh sphere = make_icosphere(kRadius, 3);
  const ScanMaps outside = scan_maps(sphere, camera_above(), kWhole);
  for (Triangle& t : sphere.triangles) std::swap(t[1], t[2]);
  const ScanMaps turned = scan_maps(sphere, camera_above(), kWhole);
  ASSERT_GT(outside.num_seen, 1000);
  EXPECT_EQ(outside.seen, turned.seen);
  for (std::int64_t i = 0; i < outside.seen.num_pixels(); ++i) {
    EXPECT_NEAR(outside.curvature_per_mm.data()[i], turned.curvature_per_mm.data()[i], 1e-5);
    EXPECT_NEAR(outside.normal.data()[3 * i + 2], turned.normal.data()[3 * i + 2], 1e-4);
  }
}

TEST(ScanMaps, TexelsOfAPlaneHaveTheSizeThatTheFocalLengthGives) {
  const Mesh plane = make_patch(20, 20, [](double u, double v) { return Vec3(200 * u - 100, 200 * v - 100, 0); });
  CameraParameters p = camera_above().parameters();
  p.distortion = {};
  PhotoPart part = kWhole;
  part.num_columns = 45;  // Two pixels of the photograph wide, one high.
  const ScanMaps maps = scan_maps(plane, Camera(p), part);
  EXPECT_EQ(maps.num_seen, 45 * kPhotoHeight);
  const double pixel_mm = kDistance / 160.0;
  for (float size : maps.texel_size_mm.values())
    EXPECT_NEAR(static_cast<double>(size), pixel_mm * std::sqrt(2.0), 1e-5);
  for (float curvature : maps.curvature_per_mm.values())
    EXPECT_NEAR(curvature, 0.0F, 1e-2F);  // The border is not flat to a smoothed surface.
}

TEST(ScanMaps, EveryNumberOfThreadsGivesTheSameBits) {
  const Mesh sphere = make_icosphere(kRadius, 2);
  RunControl one, three;
  one.num_threads = 1;
  three.num_threads = 3;
  const ScanMaps a = scan_maps(sphere, camera_above(), kWhole, {}, one),
                 b = scan_maps(sphere, camera_above(), kWhole, {}, three);
  EXPECT_EQ(a.position_mm, b.position_mm);
  EXPECT_EQ(a.curvature_per_mm, b.curvature_per_mm);
}

/// A furrowed relief, 50 mm wide, of which the camera sees more than all: z = 2 cos(2 pi x / 20), furrows at x = -10
/// and 10.
Mesh relief() {
  return make_patch(60, 60, [](double u, double v) {
    const double x = 50 * u - 25;
    return Vec3(x, 50 * v - 25, 2.0 * std::cos(x * std::acos(-1.0) / 10.0));
  });
}

const char* const kCamera =
    R"({"width": 90, "height": 75, "matrix": [[160, 0, 46], [0, 160, 36], [0, 0, 1]], "distortion": [-0.1, 0.02, 0, 0, 0],
        "rotation": [[1, 0, 0], [0, -1, 0], [0, 0, -1]], "translation": [0, 0, 10]})";

/// Three photographs of a relief that is given in cm.
void write_project(const fs::path& folder, const std::string& more, const std::string& camera = kCamera) {
  fs::create_directories(folder / "frames");
  for (int i = 0; i < 3; ++i)
    write_codes(folder / "frames" / (std::to_string(i) + ".png"),
                ImageU8(kPhotoWidth, kPhotoHeight, 3, static_cast<std::uint8_t>(60 + 40 * i)));
  Mesh mesh = relief();
  scale_mesh(mesh, 0.1);
  write_obj(folder / "relief.obj", mesh);
  write_atomically(folder / "capture.json",
                   R"({"format": "patinate.capture", "version": 1, "name": "relief", "kind": "fixed",
                       "frames": {"pattern": "frames/*.png", "interval": 1}, "scan": {"mesh": "relief.obj", "camera": )" +
                       camera + "}" + more + "}");
}

TEST(IngestScan, GivesAccessibilityMapsAndAMask) {
  const TempFolder folder;
  write_project(folder.path(), R"(, "unit": "cm", "roi": [0, 3, 90, 69])");
  IngestOptions options;
  options.scan.scale_mm = 2.0;
  const HistoryReader history = ingest(folder.path(), options);
  ASSERT_EQ(history.manifest().controls.size(), 1u);  // No `progress`: something was measured.
  const ControlFacts& control = history.control("accessibility");
  EXPECT_EQ(control.unit, "1/mm");
  // Curvature at the furrow of z = 2 cos(k x) is k^2 = 0.099 (half of z''), less what a scale of 2 mm averages out.
  EXPECT_GT(control.high, 0.06);
  EXPECT_LT(control.high, 0.11);
  EXPECT_NEAR(control.low, -control.high, 0.015);
  const ImageF values = history.read_control("accessibility");
  const ImageF position = history.read_map("position"), normal = history.read_map("normal");
  const ImageU8 mask = history.read_mask();
  ASSERT_EQ(position.height(), 69);
  double outside = 0;
  for (int y = 0; y < 69; ++y) {
    for (int x = 0; x < kPhotoWidth; ++x) {
      if (mask.at(x, y) == 0) {
        ++outside;
        continue;
      }
      const auto from_furrow = std::abs(std::abs(position.at(x, y, 0)) - 10.0F);
      if (std::abs(position.at(x, y, 1)) > 20.0F) continue;
      if (from_furrow < 1.0F) {
        EXPECT_GT(values.at(x, y), 0.85F);
      }
      if (std::abs(position.at(x, y, 0)) < 1.0F) {
        EXPECT_LT(values.at(x, y), 0.15F);
      }
      EXPECT_GT(normal.at(x, y, 2), 0.5F);
    }
  }
  EXPECT_GT(outside, 0);
  ASSERT_TRUE(history.manifest().texel_size_mm);
  EXPECT_NEAR(*history.manifest().texel_size_mm, kDistance / 160.0, 0.1);
}

TEST(IngestScan, KeepsTheTexelSizeAndTheMaskOfTheProject) {
  const TempFolder folder;
  ImageU8 mask(kPhotoWidth, kPhotoHeight, 1, 255);
  for (int y = 0; y < kPhotoHeight; ++y) mask.at(46, y) = 0;
  write_codes(folder / "mask.png", mask);
  write_project(folder.path(), R"(, "unit": "cm", "texel_size_mm": 0.7, "mask": "mask.png")");
  const HistoryReader history = ingest(folder.path());
  EXPECT_EQ(history.manifest().texel_size_mm, 0.7);
  EXPECT_EQ(history.read_mask().at(46, 36), 0);
  EXPECT_EQ(history.read_mask().at(40, 36), 255);
}

TEST(IngestScan, ItsScaleIsPartOfTheKey) {
  const TempFolder folder;
  write_project(folder.path(), R"(, "unit": "cm")");
  const CaptureProject project = read_capture_project(folder / "capture.json");
  IngestOptions coarse;
  coarse.scan.scale_mm = 5.0;
  EXPECT_NE(plan_ingest(project, {}, folder / "out").key, plan_ingest(project, coarse, folder / "out").key);
}

TEST(IngestScan, SaysWhatIsWrongWithIt) {
  const TempFolder folder;
  write_project(folder.path(), "");
  EXPECT_TRUE(has(ingest_error(folder.path()), "but no `unit`"));
  write_project(folder.path(), R"(, "unit": "inch")");
  EXPECT_TRUE(has(ingest_error(folder.path()), "/unit"));
  std::string camera = kCamera;
  camera.replace(camera.find("\"width\": 90"), 11, "\"width\": 91");
  write_project(folder.path(), R"(, "unit": "cm")", camera);
  EXPECT_TRUE(has(ingest_error(folder.path()), "91 x 75"));
  camera = kCamera;
  camera.replace(camera.find("10]}"), 2, "-9");
  write_project(folder.path(), R"(, "unit": "cm")", camera);
  const std::string unseen = ingest_error(folder.path());
  EXPECT_TRUE(has(unseen, "the camera does not see the mesh: its middle lies 90 mm behind the camera; check `unit`"))
      << unseen;
  write_project(folder.path(), R"(, "unit": "cm", "controls": [{"name": "accessibility", "file": "frames/0.png"}])");
  EXPECT_TRUE(has(ingest_error(folder.path()), "no other control"));
  write_project(folder.path(), R"(, "unit": "cm")");
  write_atomically(folder / "relief.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n");
  EXPECT_TRUE(has(ingest_error(folder.path()), "relief.obj"));
}

}  // namespace
}  // namespace patinate::capture
