#include "datasets_synthetic/mould.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "datasets_synthetic/mould_io.h"
#include "datasets_synthetic/mould_light.h"
#include "patinate/core/error.h"
#include "libcommon/core/files.h"
#include "patinate/core/json.h"
#include "patinate/geometry/mesh_io.h"
#include "patinate/image/image_io.h"
#include "tests/support/temp_folder.h"

namespace patinate::datasets {
namespace {

using testing_support::TempFolder;

MouldOptions small() {
  MouldOptions o;
  o.width = 96;
  o.height = 72;
  o.num_steps = 3;
  o.num_lights = 3;
  o.scan_spacing_mm = 1.5;
  return o;
}
MouldOptions small_exact() {
  MouldOptions o = small();
  o.exact = true;
  return checked_mould(o);
}

Vec3 vector_at(const ImageF& image, int x, int y) {
  return {static_cast<double>(image.at(x, y, 0)), static_cast<double>(image.at(x, y, 1)), static_cast<double>(image.at(x, y, 2))};
}

TEST(Mould, ExactPhotographsAreTheFormulaOfTheFormatToRounding) {
  const MouldOptions o = small_exact();
  const Mould mould(o);
  const MouldRig rig = mould_rig(o);
  for (int step : {0, 2}) {
    const Mesh surface = mould_surface(mould, rig, step);
    const MouldPhotos photos = mould_photos(mould, rig, step, surface);
    const MouldView view = mould_view(rig, surface);
    int num_checked = 0;
    for (int y = 0; y < o.height; ++y) {
      for (int x = 0; x < o.width; ++x) {
        if (view.mask.at(x, y) == 0) continue;
        const Vec3 p = vector_at(view.position_mm, x, y), n = vector_at(view.normal, x, y);
        const MouldLook look = mould.look(static_cast<double>(view.object_mm.at(x, y, 0)), static_cast<double>(view.object_mm.at(x, y, 1)), step * o.interval_d);
        for (std::size_t i = 0; i < rig.lights.size(); ++i) {
          const Vec3 away = rig.lights[i].position - p;
          const double cosine = std::max(0.0, n.dot(away.normalized()));
          const Vec3 expected = look.albedo.cwiseProduct(rig.lights[i].intensity) / std::numbers::pi * cosine / away.squaredNorm();
          EXPECT_LT((vector_at(photos.lit[i], x, y) - expected).norm(), 1e-5);  // Floats of maps and photographs, through colour's slope.
          ++num_checked;
        }
      }
    }
    EXPECT_GT(num_checked, 3000);
  }
}

TEST(Mould, ScanPointsLieOnTheMovedHeightFunction) {
  MouldOptions o = small();
  o.scan_noise_mm = 0.0;
  const Mould mould(checked_mould(o));
  const MouldRig rig = mould_rig(o);
  EXPECT_LT((rig.scanner_from_object[0].matrix() - Eigen::Matrix4d::Identity()).norm(), 1e-15);
  for (int step = 0; step < 3; ++step) {
    const PointCloud scan = mould_scan(mould, rig, step);
    const RigidTransform back = rig.scanner_from_object[static_cast<std::size_t>(step)].inverse();
    EXPECT_GT(scan.triangles.size(), 5000u);
    for (std::size_t i = 0; i < scan.points.size(); ++i) {
      const Vec3 p = back.apply(scan.points[i]);
      ASSERT_NEAR(p.z(), mould.height(p.x(), p.y()), 1e-7);  // Newton's last step.
      ASSERT_LT((back.rotation * scan.normals[i] - mould.normal(p.x(), p.y())).norm(), 1e-9);
    }
  }
}

TEST(Mould, ScannerNoiseHasTheStandardDeviationAskedFor) {
  MouldOptions o = small();
  o.scan_noise_mm = 0.0;
  const PointCloud clean = mould_scan(Mould(o), mould_rig(o), 1);
  o.scan_noise_mm = 0.05;
  const PointCloud noisy = mould_scan(Mould(o), mould_rig(o), 1);
  ASSERT_EQ(clean.points.size(), noisy.points.size());
  EXPECT_TRUE(noisy.normals.empty());
  double sum = 0.0;
  for (std::size_t i = 0; i < clean.points.size(); ++i) sum += (noisy.points[i] - clean.points[i]).squaredNorm();
  const double n = static_cast<double>(clean.points.size()), found = std::sqrt(sum / n);
  EXPECT_NEAR(found, 0.05, 4.0 * 0.05 / std::sqrt(2.0 * n));  // Four standard deviations of an estimated deviation.
}

TEST(Mould, HighlightsOnlyAddLightAndCastShadowsOnlyTakeIt) {
  MouldOptions o = small_exact();
  const MouldRig rig = mould_rig(o);
  const Mould matt(o);
  const Mesh surface = mould_surface(matt, rig, 0);
  const MouldPhotos plain = mould_photos(matt, rig, 0, surface);
  MouldOptions polished = o, shaded = o;
  polished.highlights = 1.0;
  shaded.shadows = true;
  const MouldPhotos shiny = mould_photos(Mould(polished), rig, 0, surface), dark = mould_photos(Mould(shaded), rig, 0, surface);
  int num_brighter = 0, num_shadowed = 0;
  for (std::size_t i = 0; i < rig.lights.size(); ++i) {
    for (std::size_t k = 0; k < plain.lit[i].values().size(); ++k) {
      const float value = plain.lit[i].values()[k];
      EXPECT_GE(shiny.lit[i].values()[k], value);
      EXPECT_LE(dark.lit[i].values()[k], value);
      num_brighter += shiny.lit[i].values()[k] > value + 0.3f;
    }
    for (std::size_t k = 0; k < dark.in_light[i].values().size(); ++k) num_shadowed += dark.in_light[i].values()[k] < plain.in_light[i].values()[k];
  }
  EXPECT_GT(num_brighter, 50);
  EXPECT_GT(num_shadowed, 50);
}

TEST(Mould, PatinaComesFirstToHollowsDullsThemAndSparesTheLacquer) {
  const MouldOptions o = checked_mould(MouldOptions{});
  const Mould mould(o);
  double hollow_change = 0.0, ridge_change = 0.0;
  int num_hollow = 0, num_ridge = 0, num_lacquered = 0;
  for (double y = -58.0; y <= 58.0; y += 1.0) {
    for (double x = -58.0; x <= 58.0; x += 1.0) {
      if (std::hypot(x, y) > 58.0) continue;
      const MouldLook fresh = mould.look(x, y, 0.0), aged = mould.look(x, y, 30.0);
      const double change = (aged.albedo - fresh.albedo).norm();
      if (mould.is_lacquered(x, y)) {
        ++num_lacquered;
        EXPECT_LT((mould.look(x, y, 60.0).albedo - fresh.albedo).norm(), 0.02);  // At its edge, where the lacquer is 0.99.
      } else if (mould.curvature(x, y) > 0.03) {
        hollow_change += change;
        ++num_hollow;
        EXPECT_LE(aged.specular, fresh.specular);
      } else if (mould.curvature(x, y) < -0.03) {
        ridge_change += change;
        ++num_ridge;
      }
    }
  }
  ASSERT_GT(num_hollow, 100);
  ASSERT_GT(num_ridge, 100);
  ASSERT_GT(num_lacquered, 50);
  EXPECT_GT(hollow_change / num_hollow, 1.5 * ridge_change / num_ridge);
}

TEST(Mould, PhotographsAreTheSameForAnyNumberOfThreads) {
  const MouldOptions o = checked_mould(small());
  const Mould mould(o);
  const MouldRig rig = mould_rig(o);
  RunControl one, three;
  one.num_threads = 1;
  three.num_threads = 3;
  const Mesh surface = mould_surface(mould, rig, 1, one);
  EXPECT_EQ(surface.positions, mould_surface(mould, rig, 1, three).positions);
  EXPECT_EQ(mould_photos(mould, rig, 1, surface, one).lit, mould_photos(mould, rig, 1, surface, three).lit);
  EXPECT_EQ(mould_scan(mould, rig, 1, one).points, mould_scan(mould, rig, 1, three).points);
}

TEST(Mould, ProjectFolderHoldsWhatALabWouldHaveAndTheTruth) {
  const TempFolder temp;
  const std::filesystem::path folder = temp.path() / "mould";
  run_job(plan_mould(small(), folder), {}, {});
  const Json capture = load_json(folder / "capture.json");
  EXPECT_EQ(capture.at("kind"), "relit");
  EXPECT_EQ(capture.at("steps").size(), 3u);
  const Json& step = capture.at("steps").at(2);
  EXPECT_EQ(step.at("time"), 40.0);
  EXPECT_FALSE(step.contains("transform"));
  EXPECT_EQ(probe_image(folder / step.at("photos").at(1).get<std::string>()).width, 96);
  EXPECT_EQ(probe_image(folder / step.at("ambient").get<std::string>()).height, 72);
  const Mesh scan = read_mesh(folder / step.at("scan").get<std::string>());
  EXPECT_GT(scan.num_triangles(), 5000);
  const Json truth = load_json(folder / "truth/truth.json");
  EXPECT_EQ(truth.at("steps").size(), 3u);
  EXPECT_EQ(read_channels(folder / "truth/albedo/0002.exr", {"R", "G", "B"}).width(), 96);
}

TEST(Mould, OptionsOutOfRangeAreRefused) {
  MouldOptions o;
  o.noise = std::nan("");
  EXPECT_THROW((void)checked_mould(o), InvalidInput);
  o = {};
  o.scan_spacing_mm = 20.0;
  EXPECT_THROW((void)checked_mould(o), InvalidInput);
  o = {};
  o.num_lights = 0;
  EXPECT_THROW((void)checked_mould(o), InvalidInput);
}

}  // namespace
}  // namespace patinate::datasets
