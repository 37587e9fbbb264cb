#include "datasets_synthetic/mold.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "datasets_synthetic/mold_io.h"
#include "datasets_synthetic/mold_light.h"
#include "libcommon/core/files.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/mesh_io.h"
#include "tests/support/temp_folder.h"

namespace patinate::datasets {
namespace {

using testing_support::TempFolder;

MoldOptions small() {
  MoldOptions o;
  o.width = 96;
  o.height = 72;
  o.num_steps = 3;
  o.num_lights = 3;
  o.scan_spacing_mm = 1.5;
  return o;
}
MoldOptions small_exact() {
  MoldOptions o = small();
  o.exact = true;
  return checked_mold(o);
}

Vec3 vector_at(const ImageF& image, int x, int y) {
  return {static_cast<double>(image.at(x, y, 0)), static_cast<double>(image.at(x, y, 1)),
          static_cast<double>(image.at(x, y, 2))};
}

TEST(Mold, ExactPhotographsAreTheFormulaOfTheFormatToRounding) {
  const MoldOptions o = small_exact();
  const Mold mold(o);
  const MoldRig rig = mold_rig(o);
  for (int step : {0, 2}) {
    const Mesh surface = mold_surface(mold, rig, step);
    const MoldPhotos photos = mold_photos(mold, rig, step, surface);
    const MoldView view = mold_view(rig, surface);
    int num_checked = 0;
    for (int y = 0; y < o.height; ++y) {
      for (int x = 0; x < o.width; ++x) {
        if (view.mask.at(x, y) == 0) continue;
        const Vec3 p = vector_at(view.position_mm, x, y), n = vector_at(view.normal, x, y);
        const MoldLook look = mold.look(static_cast<double>(view.object_mm.at(x, y, 0)),
                                        static_cast<double>(view.object_mm.at(x, y, 1)), step * o.interval_d);
        for (std::size_t i = 0; i < rig.lights.size(); ++i) {
          const Vec3 away = rig.lights[i].position - p;
          const double cosine = std::max(0.0, n.dot(away.normalized()));
          const Vec3 expected =
              look.albedo.cwiseProduct(rig.lights[i].intensity) / std::numbers::pi * cosine / away.squaredNorm();
          EXPECT_LT((vector_at(photos.lit[i], x, y) - expected).norm(),
                    1e-5);  // Floats of maps and photographs, through color's slope.
          ++num_checked;
        }
      }
    }
    EXPECT_GT(num_checked, 3000);
  }
}

TEST(Mold, ScanPointsLieOnTheMovedHeightFunction) {
  MoldOptions o = small();
  o.scan_noise_mm = 0.0;
  const Mold mold(checked_mold(o));
  const MoldRig rig = mold_rig(o);
  EXPECT_LT((rig.scanner_from_object[0].matrix() - Eigen::Matrix4d::Identity()).norm(), 1e-15);
  for (int step = 0; step < 3; ++step) {
    const PointCloud scan = mold_scan(mold, rig, step);
    const RigidTransform back = rig.scanner_from_object[static_cast<std::size_t>(step)].inverse();
    EXPECT_GT(scan.triangles.size(), 5000u);
    for (std::size_t i = 0; i < scan.points.size(); ++i) {
      const Vec3 p = back.apply(scan.points[i]);
      ASSERT_NEAR(p.z(), mold.height(p.x(), p.y()), 1e-7);  // Newton's last step.
      ASSERT_LT((back.rotation * scan.normals[i] - mold.normal(p.x(), p.y())).norm(), 1e-9);
    }
  }
}

TEST(Mold, ScannerNoiseHasTheStandardDeviationAskedFor) {
  MoldOptions o = small();
  o.scan_noise_mm = 0.0;
  const PointCloud clean = mold_scan(Mold(o), mold_rig(o), 1);
  o.scan_noise_mm = 0.05;
  const PointCloud noisy = mold_scan(Mold(o), mold_rig(o), 1);
  ASSERT_EQ(clean.points.size(), noisy.points.size());
  EXPECT_TRUE(noisy.normals.empty());
  double sum = 0.0;
  for (std::size_t i = 0; i < clean.points.size(); ++i) sum += (noisy.points[i] - clean.points[i]).squaredNorm();
  const double n = static_cast<double>(clean.points.size()), found = std::sqrt(sum / n);
  EXPECT_NEAR(found, 0.05, 4.0 * 0.05 / std::sqrt(2.0 * n));  // Four standard deviations of an estimated deviation.
}

TEST(Mold, HighlightsOnlyAddLightAndCastShadowsOnlyTakeIt) {
  MoldOptions o = small_exact();
  const MoldRig rig = mold_rig(o);
  const Mold diffuse(o);
  const Mesh surface = mold_surface(diffuse, rig, 0);
  const MoldPhotos plain = mold_photos(diffuse, rig, 0, surface);
  MoldOptions polished = o, shaded = o;
  polished.highlights = 1.0;
  shaded.shadows = true;
  const MoldPhotos shiny = mold_photos(Mold(polished), rig, 0, surface),
                   dark = mold_photos(Mold(shaded), rig, 0, surface);
  int num_brighter = 0, num_shadowed = 0;
  for (std::size_t i = 0; i < rig.lights.size(); ++i) {
    for (std::size_t k = 0; k < plain.lit[i].values().size(); ++k) {
      const float value = plain.lit[i].values()[k];
      EXPECT_GE(shiny.lit[i].values()[k], value);
      EXPECT_LE(dark.lit[i].values()[k], value);
      num_brighter += shiny.lit[i].values()[k] > value + 0.3f;
    }
    for (std::size_t k = 0; k < dark.in_light[i].values().size(); ++k)
      num_shadowed += dark.in_light[i].values()[k] < plain.in_light[i].values()[k];
  }
  EXPECT_GT(num_brighter, 50);
  EXPECT_GT(num_shadowed, 50);
}

TEST(Mold, PatinaComesFirstToHollowsDullsThemAndSparesTheLacquer) {
  const MoldOptions o = checked_mold(MoldOptions{});
  const Mold mold(o);
  double hollow_change = 0.0, ridge_change = 0.0;
  int num_hollow = 0, num_ridge = 0, num_lacquered = 0;
  for (double y = -58.0; y <= 58.0; y += 1.0) {
    for (double x = -58.0; x <= 58.0; x += 1.0) {
      if (std::hypot(x, y) > 58.0) continue;
      const MoldLook fresh = mold.look(x, y, 0.0), aged = mold.look(x, y, 30.0);
      const double change = (aged.albedo - fresh.albedo).norm();
      if (mold.is_lacquered(x, y)) {
        ++num_lacquered;
        EXPECT_LT((mold.look(x, y, 60.0).albedo - fresh.albedo).norm(),
                  0.02);  // At its edge, where the lacquer is 0.99.
      } else if (mold.curvature(x, y) > 0.03) {
        hollow_change += change;
        ++num_hollow;
        EXPECT_LE(aged.specular, fresh.specular);
      } else if (mold.curvature(x, y) < -0.03) {
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

TEST(Mold, PhotographsAreTheSameForAnyNumberOfThreads) {
  const MoldOptions o = checked_mold(small());
  const Mold mold(o);
  const MoldRig rig = mold_rig(o);
  RunControl one, three;
  one.num_threads = 1;
  three.num_threads = 3;
  const Mesh surface = mold_surface(mold, rig, 1, one);
  EXPECT_EQ(surface.positions, mold_surface(mold, rig, 1, three).positions);
  EXPECT_EQ(mold_photos(mold, rig, 1, surface, one).lit, mold_photos(mold, rig, 1, surface, three).lit);
  EXPECT_EQ(mold_scan(mold, rig, 1, one).points, mold_scan(mold, rig, 1, three).points);
}

TEST(Mold, ProjectFolderHoldsWhatALabWouldHaveAndTheTruth) {
  const TempFolder temp;
  const std::filesystem::path folder = temp.path() / "mold";
  run_job(plan_mold(small(), folder), {}, {});
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

TEST(Mold, OptionsOutOfRangeAreRefused) {
  MoldOptions o;
  o.noise = std::nan("");
  EXPECT_THROW((void)checked_mold(o), InvalidInput);
  o = {};
  o.scan_spacing_mm = 20.0;
  EXPECT_THROW((void)checked_mold(o), InvalidInput);
  o = {};
  o.num_lights = 0;
  EXPECT_THROW((void)checked_mold(o), InvalidInput);
}

}  // namespace
}  // namespace patinate::datasets
