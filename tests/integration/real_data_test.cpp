// The main job on real photographs and real meshes: ingest, control, transfer, lookup. Needs $PATINATE_DATA.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "capture/project/capture_project.h"
#include "capture/timelapse/ingest.h"
#include "libcommon/core/files.h"
#include "libcommon/image/between_pixels.h"
#include "libcommon/job/job.h"
#include "libcommon/metrics/correlation.h"
#include "patinate/controls/control_kinds.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/mesh_io.h"
#include "patinate/transfer/transfer_reader.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_data.h"
#include "transfer/job/transfer_job.h"

namespace patinate {
namespace {

using testing_support::TempFolder;

constexpr int kAtlas = 512;
// The flash's streak on the copper plate, which moves with nothing and ages with nothing: these columns are masked.
constexpr int kStreakBegin = 88, kStreakEnd = 156;

void ingest(const std::filesystem::path& project_file, const std::string& project,
            const std::filesystem::path& history) {
  write_atomically(project_file, project);
  ASSERT_EQ(run_job(capture::plan_ingest(capture::read_capture_project(project_file), {}, history), {}, {}),
            JobStatus::Done);
}

/// 26 frames over 8 h, the streak masked.
void ingest_copper(const TempFolder& folder, const std::filesystem::path& frames) {
  ImageU8 mask(256, 256, 1, 255);
  for (int y = 0; y < 256; ++y) {
    for (int x = kStreakBegin; x < kStreakEnd; ++x) mask.at(x, y) = 0;
  }
  write_codes(folder / "mask.png", mask);
  ingest(
      folder / "capture.json",
      R"({"format": "patinate.capture", "version": 1, "name": "copper", "kind": "fixed", "time_unit": "min", "response": "srgb",
             "frames": {"pattern": ")" +
          (frames / "*.png").string() + R"(", "interval": 19.4}, "mask": "mask.png"})",
      folder / "history");
}

/// The mesh scaled so that one texel equals one pixel, and a control of it.
transfer::TransferTask make_task(const std::filesystem::path& history, Mesh mesh, const std::string& source,
                                 const std::string& destination) {
  mesh = with_normals(std::move(mesh));
  const double size = TexelMap(mesh, kAtlas, kAtlas).median_texel_size_mm();
  scale_mesh(mesh, 1.0 / size);
  transfer::TransferTask task;
  task.history = std::make_shared<const HistoryReader>(history);
  task.mesh_name = "mesh";
  task.mm_per_mesh_unit = 1.0 / size;
  task.input.map = std::make_shared<TexelMap>(std::move(mesh), kAtlas, kAtlas);
  ControlMap made = make_control_expression(destination, *task.input.map);
  task.input.controls.push_back({source,
                                 destination,
                                 std::move(made.values),
                                 {made.low, made.high, made.unit},
                                 1.0,
                                 transfer::ControlMapping::Rank});
  return task;
}

/// Rank correlation over the covered texels between the destination's control and the source's at their coordinates.
double control_agreement(const transfer::TransferTask& task, const transfer::TransferReader& transfer) {
  const ImageF source = transfer.history().read_control(task.input.controls[0].source);
  std::vector<double> wanted, got;
  for (int y = 0; y < kAtlas; ++y) {
    for (int x = 0; x < kAtlas; ++x) {
      const float sx = transfer.coordinates().at(x, y, 0);
      if (sx < 0.0f) continue;
      wanted.push_back(static_cast<double>(task.input.controls[0].values.at(x, y)));
      const NearestPixel at = nearest_pixel(sx, transfer.coordinates().at(x, y, 1));
      got.push_back(static_cast<double>(source.at(at.x, at.y)));
    }
  }
  return rank_correlation(wanted, got);
}

/// Mean over what a mask covers, per channel.
std::array<double, 3> mean_color(const ImageF& image, const ImageU8& mask) {
  std::array<double, 3> sum{};
  double count = 0.0;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      if (mask.at(x, y) == 0) continue;
      for (int c = 0; c < 3; ++c) sum[c] += static_cast<double>(image.at(x, y, c));
      count += 1.0;
    }
  }
  for (double& s : sum) s /= count;
  return sum;
}

void expect_frames_exact(const transfer::TransferReader& transfer) {
  for (int f : {0, transfer.history().num_frames() - 1}) {
    const ImageF frame = transfer.history().read_frame(f);
    const ImageF texture = transfer.sample(transfer.history().manifest().frames[f].time);
    const ImageF expected = transfer::gather(frame, transfer.coordinates());
    const ImageU8 coverage = transfer.coverage();
    for (int y = 0; y < kAtlas; ++y) {
      for (int x = 0; x < kAtlas; ++x) {
        if (coverage.at(x, y) != 0) {
          ASSERT_EQ(texture.at(x, y, 1), expected.at(x, y, 1));
        }
      }
    }
  }
}

/// Expects what every copper transfer must show, whatever the mesh.
void expect_copper_ages(const transfer::TransferTask& task, const transfer::TransferReader& transfer) {
  expect_frames_exact(transfer);
  for (int y = 0; y < kAtlas; ++y) {
    for (int x = 0; x < kAtlas; ++x) {
      const float sx = transfer.coordinates().at(x, y, 0);
      if (sx >= 0.0f) {
        ASSERT_TRUE(sx < kStreakBegin || sx >= kStreakEnd) << "a masked pixel was transferred";
      }
    }
  }
  EXPECT_LT(transfer.manifest().energy.control_error_mean, 0.06);
  EXPECT_GT(control_agreement(task, transfer), 0.9);
  // The photographs' own mean color, at the start and at the end: rank matching uses every part of the plate in its
  // proportion. 0.03 of full scale is a third of the change in red.
  const HistoryReader& history = transfer.history();
  const double last = history.manifest().frames.back().time;
  for (double time : {0.0, last}) {
    const auto photographs = mean_color(history.sample(time), history.read_mask());
    const auto mesh = mean_color(transfer.sample(time), transfer.coverage());
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(mesh[c], photographs[c], 0.03) << "time " << time << " channel " << c;
  }
  // Copper turns green-blue.
  const auto fresh = mean_color(transfer.sample(0.0), transfer.coverage()),
             aged = mean_color(transfer.sample(last), transfer.coverage());
  EXPECT_GT(fresh[0] / fresh[2], 1.05);
  EXPECT_LT(aged[0] / aged[2], 0.95);
}

TEST(RealData, CopperAgesTheHydrantByAccessibility) {
  PATINATE_REQUIRE_DATA(frames, "timelapse/copper_patinating/frames_every4");
  PATINATE_REQUIRE_DATA(mesh_file, "meshes/fire_hydrant/fire_hydrant_1k.gltf");
  TempFolder folder;
  ingest_copper(folder, frames);
  const transfer::TransferTask task = make_task(
      folder / "history", select_surfaces(read_mesh(mesh_file), "", "fire_hydrant"), "progress", "accessibility");
  ASSERT_EQ(run_job(transfer::plan_transfer(task, folder / "transfer"), {}, {}), JobStatus::Done);
  expect_copper_ages(task, transfer::TransferReader(folder / "transfer"));
}

TEST(RealData, CopperAgesTheBustByAccessibility) {
  PATINATE_REQUIRE_DATA(frames, "timelapse/copper_patinating/frames_every4");
  PATINATE_REQUIRE_DATA(mesh_file, "meshes/marble_bust/marble_bust_01_1k.gltf");
  TempFolder folder;
  ingest_copper(folder, frames);
  const transfer::TransferTask task = make_task(folder / "history", read_mesh(mesh_file), "progress", "accessibility");
  ASSERT_EQ(run_job(transfer::plan_transfer(task, folder / "transfer"), {}, {}), JobStatus::Done);
  expect_copper_ages(task, transfer::TransferReader(folder / "transfer"));
}

TEST(RealData, ABananaWithUnevenDatesRipensAFish) {
  PATINATE_NIGHTLY_ONLY();  // 75 s of processor time.
  PATINATE_REQUIRE_DATA(photos, "timelapse/banana_14_B");
  PATINATE_REQUIRE_DATA(mesh_file, "meshes/blub/blub_triangulated.obj");
  TempFolder folder;
  // The fruit fills the middle of the picture on every date; its background is white.
  ImageU8 mask(1488, 1141);
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x)
      mask.at(x, y) = std::hypot((x - 744) / 300.0, (y - 570) / 130.0) < 1.0 ? 255 : 0;
  }
  write_codes(folder / "mask.png", mask);
  ingest(
      folder / "capture.json",
      R"({"format": "patinate.capture", "version": 1, "name": "banana", "kind": "fixed", "time_unit": "d", "response": "srgb",
             "frames": {"pattern": ")" +
          (photos / "*.png").string() + R"("}, "scale": 0.25, "mask": "mask.png"})",
      folder / "history");
  const HistoryReader history(folder / "history");
  ASSERT_EQ(history.num_frames(), 20);
  // File names: 2020-05-28 18:20 to 2020-06-17 18:00.
  EXPECT_NEAR(history.manifest().frames.back().time - history.manifest().frames.front().time, 20.0 - 20.0 / 1440.0,
              1e-9);
  std::vector<double> steps;
  for (std::size_t i = 1; i < 20; ++i)
    steps.push_back(history.manifest().frames[i].time - history.manifest().frames[i - 1].time);
  EXPECT_GT(*std::max_element(steps.begin(), steps.end()), 1.3 * *std::min_element(steps.begin(), steps.end()));

  const transfer::TransferTask task = make_task(folder / "history", read_mesh(mesh_file), "progress", "facing");
  ASSERT_EQ(run_job(transfer::plan_transfer(task, folder / "transfer"), {}, {}), JobStatus::Done);
  const transfer::TransferReader transfer(folder / "transfer");
  expect_frames_exact(transfer);
  // Half way between two uneven dates is their mean.
  const auto& f = history.manifest().frames;
  ImageF mean = history.read_frame(4);
  const ImageF next = history.read_frame(5), between = transfer.sample(0.5 * (f[4].time + f[5].time));
  for (std::size_t i = 0; i < mean.values().size(); ++i) mean.data()[i] = 0.5f * (mean.data()[i] + next.data()[i]);
  const ImageF expected = transfer::gather(mean, transfer.coordinates());
  const ImageU8 coverage = transfer.coverage();
  for (int i = 0; i < kAtlas; ++i) {
    if (coverage.at(i, i) != 0) {
      EXPECT_NEAR(between.at(i, i, 0), expected.at(i, i, 0), 1e-4f);
    }
  }
}

}  // namespace
}  // namespace patinate
