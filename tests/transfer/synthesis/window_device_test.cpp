#include "transfer/synthesis/window_device.h"

#include <gtest/gtest.h>

#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "libcommon/core/random.h"
#include "patinate/atlas/direction_field.h"
#include "patinate/datasets/objects.h"
#include "tests/support/lost_device.h"
#include "tests/support/meshes.h"
#include "tests/support/on_devices.h"
#include "transfer/synthesis/reference.h"
#include "transfer/synthesis/wavefronts.h"
#include "transfer/synthesis/window_search.h"

namespace patinate::transfer {
namespace {

using device::Device;
using device::DeviceInfo;

/// What the exact search is given: a source with a hole that repeats, so that costs are equal at several pixels, and
/// texels of charts that are turned, mirrored and of two densities.
struct WindowTask {
  Neighborhood neighborhood;
  SourceLevel source;
  SynthesisLevel level;
  std::vector<double> weights;

  struct Kind {
    int num_controls = 1;
    int radius_px = 3;
    bool is_flat = false;  ///< All pixels look alike.
  };
  WindowTask(const Mesh& mesh, int resolution, const Kind& kind)
      : neighborhood(Neighborhood::square(kind.radius_px)), weights(static_cast<std::size_t>(kind.num_controls), 1.0) {
    constexpr int kSide = 64;
    AppearanceImage appearance(kSide, kSide, kAppearanceSize);
    ControlImage controls(kSide, kSide, kind.num_controls);
    ImageU8 mask(kSide, kSide, 1, 255);
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        const int fx = x % 48, fy = y % 40;
        for (int d = 0; d < kAppearanceSize; ++d)
          appearance.at(x, y, d) = static_cast<std::int16_t>(
              kind.is_flat ? 0 : (fx * (13 + d) + fy * (29 - 3 * d)) % (600 >> d) - (300 >> d));
        for (int c = 0; c < kind.num_controls; ++c)
          controls.at(x, y, c) =
              static_cast<std::uint16_t>(kind.is_flat ? 2000 : (fx * 60 + fy * (11 + 17 * c)) % (kControlSteps + 1));
        if ((x - 20) * (x - 20) + (y - 44) * (y - 44) < 30) mask.at(x, y) = 0;
      }
    }
    level.source = make_source_level(std::move(appearance), std::move(controls), mask, 20000.0, neighborhood);
    const auto map = std::make_shared<const TexelMap>(mesh, resolution, resolution);
    ControlImage wanted(resolution, resolution, kind.num_controls);
    for (int y = 0; y < resolution; ++y) {
      for (int x = 0; x < resolution; ++x) {
        for (int c = 0; c < kind.num_controls; ++c)
          wanted.at(x, y, c) = static_cast<std::uint16_t>((c == 0 ? x : y) * kControlSteps / resolution);
      }
    }
    const double texel_mm = map->median_texel_size_mm();
    level.destination = make_destination_level(map, std::move(wanted), neighborhood,
                                               {.frames = std::make_shared<const FlowFrames>(uv_frames(*map)),
                                                .pixel_mm = 1.2 * texel_mm,
                                                .step_mm = 1.2 * texel_mm});
  }
  [[nodiscard]] CoordinateMap synthesize(const ReferenceOptions& options, const SearchDevice* device) const {
    return synthesize_reference(level.source, level.destination, neighborhood, 0.7, weights, 3, options, {}, device);
  }
  [[nodiscard]] std::vector<AuditedTexel> audit(const CoordinateMap& coordinates, const SearchDevice* device) const {
    const std::vector<TexelId> texels(level.destination.texels.begin(), level.destination.texels.end());
    return audit_texels(level, neighborhood, coordinates, texels, 0.7, weights, {}, device);
  }
};

/// Pixels of the source by chance, some that have not their whole neighborhood there, some texels without any.
CoordinateMap any_coordinates(const SynthesisLevel& level) {
  CoordinateMap coordinates(static_cast<std::size_t>(level.destination.map->num_texels()), -1);
  const auto num_pixels = static_cast<std::uint32_t>(level.source.is_usable.size());
  for (const TexelId t : level.destination.texels) {
    RandomStream random(8, static_cast<std::uint64_t>(t));
    if (random.below(9) != 0)
      coordinates[static_cast<std::size_t>(t)] = static_cast<std::int32_t>(random.below(num_pixels));
  }
  return coordinates;
}

class WindowsOnDevices : public testing_support::OnDevices<> {
 protected:
  /// Every device, and each as if it were a GPU, with more items a texel.
  void SetUp() override {
    OnDevices::SetUp();
    for (const DeviceInfo& info : std::vector(all)) {
      all.push_back(info);
      all.back().is_gpu = !info.is_gpu;
    }
  }
  /// Its failures end the test.
  [[nodiscard]] static SearchDevice search_on(const DeviceInfo& info) {
    return SearchDevice(Device(info),
                        [](const device::DeviceError& error) { ADD_FAILURE() << error.what() << error.detail(); });
  }
};

TEST_F(WindowsOnDevices, PassTheirOwnCheck) {
  for (const DeviceInfo& info : all) {
    const device::CheckResult check = check_window_search(Device(info));
    EXPECT_TRUE(check.is_passed()) << info.name << ": " << check.num_different << " of " << check.num_items;
  }
}

// The CPU's pixels whatever the options: the least cost alone, a window that holds the whole source, one or two
// controls, small and large neighborhoods, and a source of one color, where every pixel is as good as any other.
TEST_F(WindowsOnDevices, GiveTheReferencesCoordinates) {
  const Mesh patchwork = testing_support::patchwork_plane(48.0, 3);
  struct Case {
    const char* name;
    WindowTask::Kind kind;
    ReferenceOptions options;
  };
  for (const Case& c :
       {Case{"default", {}, {.window_px = 24}}, Case{"two controls", {.num_controls = 2}, {.window_px = 24}},
        Case{"the least alone", {}, {.window_px = 24, .epsilon = 0.0}},
        Case{"the whole source", {.radius_px = 2}, {.window_px = 4096, .num_passes = 2}},
        Case{"a large neighborhood", {.radius_px = 5}, {.window_px = 16, .num_passes = 2}},
        Case{"one color", {.is_flat = true}, {.window_px = 4096, .num_passes = 2}},
        Case{"anything goes", {}, {.window_px = 40, .epsilon = 1.0, .num_passes = 1}}}) {
    const WindowTask task(patchwork, 48, c.kind);
    const CoordinateMap here = task.synthesize(c.options, nullptr);
    for (const DeviceInfo& info : all) {
      const SearchDevice search = search_on(info);
      EXPECT_EQ(task.synthesize(c.options, &search), here) << c.name << ", " << info.is_gpu;
    }
  }
}

TEST_F(WindowsOnDevices, GiveTheSameOnACurvedMesh) {
  const WindowTask task(datasets::sculpture(), 64, {});
  const ReferenceOptions options{.window_px = 32, .num_passes = 2};
  const CoordinateMap here = task.synthesize(options, nullptr);
  const SearchDevice search = search_on(all[0]);
  EXPECT_EQ(task.synthesize(options, &search), here);
  EXPECT_EQ(task.audit(here, &search), task.audit(here, nullptr));
}

TEST_F(WindowsOnDevices, AuditAsTheCpuDoes) {
  for (const WindowTask::Kind& kind :
       {WindowTask::Kind{}, WindowTask::Kind{.num_controls = 2, .radius_px = 2}, WindowTask::Kind{.is_flat = true}}) {
    const WindowTask task(testing_support::patchwork_plane(40.0, 3), 40, kind);
    const CoordinateMap coordinates = any_coordinates(task.level);
    const std::vector<AuditedTexel> here = task.audit(coordinates, nullptr);
    for (const DeviceInfo& info : all) {
      const SearchDevice search = search_on(info);
      EXPECT_EQ(task.audit(coordinates, &search), here) << info.is_gpu;
    }
  }
}

/// A square whose triangles are moved about, some to a line or a point in space, in the atlas, or in both.
Mesh broken_plane(double side_mm, std::uint64_t seed) {
  Mesh mesh = testing_support::patchwork_plane(side_mm, 3);
  RandomStream random(seed, 0);
  const auto any_of = [&](std::size_t size) { return random.below(static_cast<std::uint32_t>(size)); };
  for (std::size_t i = 0; i < 6; ++i) {
    Triangle& corners = mesh.triangles[any_of(mesh.triangles.size())];
    Triangle& uvs = mesh.uv_triangles[any_of(mesh.uv_triangles.size())];
    corners[any_of(3)] = corners[any_of(3)];
    if (i % 2 == 0) uvs[any_of(3)] = uvs[any_of(3)];
    mesh.positions[any_of(mesh.positions.size())] += Vec3(random.uniform(), random.uniform(), 20 * random.uniform());
    Vec2& uv = mesh.uvs[any_of(mesh.uvs.size())];
    uv += 0.2 * random.uniform() * (Vec2(0.5, 0.5) - uv);
  }
  return mesh;
}

TEST_F(WindowsOnDevices, DoAsTheCpuOnTrianglesWithoutArea) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const WindowTask task(broken_plane(32.0, seed), 32, {.num_controls = 1 + static_cast<int>(seed % 2)});
    const ReferenceOptions options{
        .window_px = 8 + 7 * static_cast<int>(seed), .epsilon = 0.05 * static_cast<double>(seed % 3), .num_passes = 2};
    const CoordinateMap here = task.synthesize(options, nullptr);
    const SearchDevice search = search_on(all[0]);
    EXPECT_EQ(task.synthesize(options, &search), here) << seed;
    EXPECT_EQ(task.audit(here, &search), task.audit(here, nullptr)) << seed;
  }
}

/// What a device that works for some launches said when it failed.
struct LostDevice {
  std::vector<std::string> failures;
  SearchDevice search;
  LostDevice(const DeviceInfo& info, int num_launches)
      : search(Device(info, testing_support::driver_with_launches(num_launches)),
               [this](const device::DeviceError& error) { failures.emplace_back(error.what()); }) {}
};

TEST_F(WindowsOnDevices, AReferenceWhoseDeviceIsLostGoesOnWithTheSameCoordinates) {
  const WindowTask task(testing_support::cut_plane(32.0), 32, {});
  const ReferenceOptions options{.window_px = 24, .num_passes = 2};
  const CoordinateMap here = task.synthesize(options, nullptr);
  const auto num_fronts = static_cast<int>(wavefronts(task.level.destination).size());
  for (const int num_launches : {0, num_fronts / 2, num_fronts + 3, 2 * num_fronts - 1}) {
    LostDevice lost(all[0], num_launches);
    EXPECT_EQ(task.synthesize(options, &lost.search), here) << num_launches;
    ASSERT_EQ(lost.failures.size(), 1U) << "said once";
    EXPECT_NE(lost.failures[0].find("CL_OUT_OF_RESOURCES"), std::string::npos) << lost.failures[0];
  }
}

TEST_F(WindowsOnDevices, AnAuditWhoseDeviceIsLostGoesOnWithTheSameFigures) {
  const WindowTask task(testing_support::cut_plane(128.0), 256, {});  // More texels than are audited at a time.
  const CoordinateMap coordinates = any_coordinates(task.level);
  const std::vector<AuditedTexel> here = task.audit(coordinates, nullptr);
  for (const int num_launches : {0, 20}) {  // 256 texels each: in the first batch, and behind it.
    LostDevice lost(all[0], num_launches);
    EXPECT_EQ(task.audit(coordinates, &lost.search), here) << num_launches;
    EXPECT_EQ(lost.failures.size(), 1U) << num_launches;
  }
}

TEST_F(WindowsOnDevices, WhatNeedsMoreMemoryThanThereIsIsDoneByTheCpu) {
  const WindowTask task(testing_support::cut_plane(32.0), 32, {});
  DeviceInfo small = all[0];
  small.largest_buffer_bytes = 4096;
  std::string failure;
  const SearchDevice search(Device(small), [&](const device::DeviceError& error) { failure = error.what(); });
  const ReferenceOptions options{.window_px = 24, .num_passes = 1};
  EXPECT_EQ(task.synthesize(options, &search), task.synthesize(options, nullptr));
  EXPECT_NE(failure.find("too little memory"), std::string::npos) << failure;
}

// At their first word of progress: an eighth of a pass, or a batch of an audit, is done.
TEST_F(WindowsOnDevices, StopWhenAsked) {
  const WindowTask task(testing_support::cut_plane(128.0), 256, {});
  const SearchDevice search = search_on(all[0]);
  const auto stopping = [](std::stop_source& source) {
    RunControl control;
    control.stop = source.get_token();
    control.on_progress = [&source](double) { source.request_stop(); };
    return control;
  };
  std::stop_source reference, audit;
  const ReferenceOptions options{.window_px = 8, .num_passes = 1};
  EXPECT_THROW((void)synthesize_reference(task.level.source, task.level.destination, task.neighborhood, 0.7,
                                          task.weights, 3, options, stopping(reference), &search),
               Canceled);
  const std::vector<TexelId> texels(task.level.destination.texels.begin(), task.level.destination.texels.end());
  EXPECT_THROW((void)audit_texels(task.level, task.neighborhood, any_coordinates(task.level), texels, 0.7, task.weights,
                                  stopping(audit), &search),
               Canceled);
}

// The plain distance that a device compares is the one of the kernels that take 16 at once.
TEST(WindowKernel, DistancesAreThoseOfTheVectorKernels) {
  ProjectedGroup group{};
  ProjectedNeighborhood query{};
  RandomStream random(9, 0);
  const auto any = [&] { return static_cast<std::int16_t>(static_cast<int>(random.below(5600)) - 2800); };
  std::array<ProjectedNeighborhood, kGroupSize> projections{};
  for (int i = 0; i < kGroupSize; ++i) {
    for (std::size_t j = 0; j < query.size(); ++j)
      group.values[j / 2][i][j % 2] = projections[static_cast<std::size_t>(i)][j] = any();
  }
  for (std::int16_t& q : query) q = any();
  for (unsigned quarters = 1; quarters <= kAllQuarters; ++quarters) {
    ProjectedNeighborhood counts{};
    for (std::size_t j = 0; j < counts.size(); ++j) counts[j] = (quarters >> (j / 4) & 1U) != 0 ? -1 : 0;
    alignas(64) std::array<std::int32_t, kGroupSize> distances{};
    std::uint16_t mask = 0;
    reach_baseline::kKernel.points(&group, 1, query.data(), counts.data(), 2'000'000'000, distances.data(), &mask);
    for (std::size_t i = 0; i < distances.size(); ++i)
      EXPECT_EQ(window_kernel::projected_distance(query.data(), projections[i].data(), quarters), distances[i]);
  }
}

}  // namespace
}  // namespace patinate::transfer
