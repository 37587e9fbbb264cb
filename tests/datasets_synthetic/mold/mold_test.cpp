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
    const RigidTransform back = rig.scanner_from_object[step].inverse();
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

TEST(Mold, MetalReflectsInItsColorWithoutDiffuseLightAndPatinaDoesNot) {
  MoldOptions o = checked_mold({.metal = true});
  const Mold mold(o);
  int num_metal = 0, num_patina = 0;
  for (double y = -58.0; y <= 58.0; y += 1.0) {
    for (double x = -58.0; x <= 58.0; x += 1.0) {
      if (std::hypot(x, y) > 58.0) continue;
      for (const double time_d : {0.0, 60.0}) {
        const MoldLook look = mold.look(x, y, time_d);
        EXPECT_GE(look.metalness, 0.0);
        EXPECT_LE(look.metalness, 1.0);
        EXPECT_DOUBLE_EQ(look.specular, look.reflectance.mean());
        if (look.metalness > 0.999) {
          ++num_metal;
          EXPECT_LT(look.albedo.maxCoeff(), 0.001);
          EXPECT_GT(look.reflectance[0], 1.3 * look.reflectance[2]);
          EXPECT_GT(look.reflectance.minCoeff(), 0.2);  // No stone reflects as much.
        } else if (look.metalness < 0.001) {
          ++num_patina;
          EXPECT_NEAR(look.reflectance[0], 0.04, 0.001);
          EXPECT_NEAR(look.reflectance[2], 0.04, 0.001);
        }
      }
    }
  }
  EXPECT_GT(num_metal, 1000);
  EXPECT_GT(num_patina, 1000);
}

TEST(Mold, ExactPhotographsOfMetalAreAlbedoAndTheLobeOfItsReflectance) {
  MoldOptions o = small_exact();
  o.metal = true;
  const Mold mold(o);
  const MoldRig rig = mold_rig(o);
  const Mesh surface = mold_surface(mold, rig, 1);
  const MoldPhotos photos = mold_photos(mold, rig, 1, surface);
  const MoldView view = mold_view(rig, surface);
  for (int y = 0; y < o.height; y += 3) {
    for (int x = 0; x < o.width; x += 3) {
      if (view.mask.at(x, y) == 0) continue;
      const Vec3 p = vector_at(view.position_mm, x, y), n = vector_at(view.normal, x, y);
      const MoldLook look = mold.look(static_cast<double>(view.object_mm.at(x, y, 0)),
                                      static_cast<double>(view.object_mm.at(x, y, 1)), o.interval_d);
      const Vec3 to_camera = (rig.camera.center() - p).normalized();
      for (std::size_t i = 0; i < rig.lights.size(); ++i) {
        const Vec3 away = rig.lights[i].position - p, to_light = away.normalized();
        if (!(n.dot(to_light) > 0.01) || !(n.dot(to_camera) > 0.01)) continue;
        const Vec3 share = look.albedo / std::numbers::pi + metal_lobe(look, n, to_light, to_camera);
        const Vec3 expected = share.cwiseProduct(rig.lights[i].intensity) * n.dot(to_light) / away.squaredNorm();
        // Floats of maps and photographs, through the slopes of colors and of the lobe (normals of 1e-7, 1 / alpha).
        EXPECT_LT((vector_at(photos.lit[i], x, y) - expected).norm(), 3e-5 * (1.0 + expected.norm()));
      }
    }
  }
}

TEST(Mold, ReliefGrowsWithThePatinaAndIsWhatScansOfTwoStepsDifferBy) {
  MoldOptions o = small();
  o.relief_mm = 0.3;
  o.scan_noise_mm = 0.0;
  const Mold mold(checked_mold(o));
  const MoldRig rig = mold_rig(o);
  const double end = 2 * o.interval_d;
  double largest = 0.0;
  for (double y = -55.0; y <= 55.0; y += 2.5) {
    for (double x = -55.0; x <= 55.0; x += 2.5) {
      if (std::hypot(x, y) > 55.0) continue;
      EXPECT_EQ(mold.relief(x, y, 0.0), 0.0);
      const double risen = mold.relief(x, y, end);
      largest = std::max(largest, risen);
      const Vec3 top = Vec3(x, y, mold.height(x, y)) + risen * mold.normal(x, y);
      EXPECT_NEAR(top.z(), mold.height(top.x(), top.y(), end), 1e-7);  // Newton's last step.
      if (mold.is_lacquered(x, y)) {
        EXPECT_LT(std::abs(risen), 0.02 * o.relief_mm);  // At its edge, where the lacquer is 0.99.
      }
    }
  }
  EXPECT_GT(largest, o.relief_mm);  // Where its noise adds.
  const PointCloud scan = mold_scan(mold, rig, 2);
  const RigidTransform back = rig.scanner_from_object[2].inverse();
  for (const Vec3& point : scan.points) {
    const Vec3 p = back.apply(point);
    ASSERT_NEAR(p.z(), mold.height(p.x(), p.y(), end), 1e-7);
  }
}

TEST(Mold, TruthOfMetalAndReliefIsWritten) {
  const TempFolder temp;
  const std::filesystem::path folder = temp.path() / "mold";
  MoldOptions o = small();
  o.metal = true;
  o.relief_mm = 0.3;
  run_job(plan_mold(o, folder), {}, {});
  const Json truth = load_json(folder / "truth/truth.json");
  const Json& step = truth.at("steps").at(2);
  const auto file = [&](const char* map) { return folder / "truth" / step.at(map).get<std::string>(); };
  const ImageF reflectance = read_channels(file("reflectance"), {"R", "G", "B"}),
               specular = read_channels(file("specular"), {"strength", "roughness"}),
               relief = read_gray(file("relief")), metalness = read_gray(file("metalness")),
               normals = read_channels(file("normals"), {"X", "Y", "Z"});
  const ImageU8 mask = read_mask(folder / "truth/mask.png");
  float highest = 0.0f;
  for (int y = 0; y < o.height; ++y) {
    for (int x = 0; x < o.width; ++x) {
      if (mask.at(x, y) == 0) continue;
      const Vec3 f0 = vector_at(reflectance, x, y);
      EXPECT_NEAR(f0.mean(), static_cast<double>(specular.at(x, y, 0)), 1e-6);
      EXPECT_NEAR(vector_at(normals, x, y).norm(), 1.0, 1e-6);
      EXPECT_LE(metalness.at(x, y), 1.0f);
      highest = std::max(highest, relief.at(x, y));
    }
  }
  EXPECT_GT(highest, 0.1f);
}

TEST(Mold, OptionsOutOfRangeAreRefused) {
  MoldOptions o;
  o.noise = std::nan("");
  EXPECT_THROW((void)checked_mold(o), InvalidInput);
  o = {};
  o.scan_spacing_mm = 20.0;
  EXPECT_THROW((void)checked_mold(o), InvalidInput);
  o = {};
  o.relief_mm = 2.0;  // More than a 60th of the radius.
  EXPECT_THROW((void)checked_mold(o), InvalidInput);
  o = {};
  o.num_lights = 0;
  EXPECT_THROW((void)checked_mold(o), InvalidInput);
}

}  // namespace
}  // namespace patinate::datasets
