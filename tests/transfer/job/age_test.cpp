#include "patinate/transfer/age.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>

#include "libcommon/image/between_pixels.h"
#include "patinate/core/error.h"
#include "patinate/patinate.h"
#include "patinate/transfer/transfer_io.h"
#include "tests/support/histories.h"
#include "tests/support/meshes.h"
#include "tests/support/temp_folder.h"
#include "transfer/guidance/scale.h"

namespace patinate::transfer {
namespace {

TEST(AgeMesh, GivesATextureOfTheHistorysColorsAtAnyTime) {
  const testing_support::TempFolder folder;
  testing_support::write_history(folder.path(), 48, 48, 3, testing_support::blotches);
  const auto history = std::make_shared<const HistoryReader>(folder.path());
  const AgedMesh aged = age_mesh(history, testing_support::cut_plane(64), "x=height", {.resolution = 64});
  const ImageF frame = history->read_frame(2);
  const ImageF texture = aged.texture(history->times()[2]);
  ASSERT_EQ(texture.width(), 64);
  int num_covered = 0;
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      if (aged.coverage.at(x, y) == 0) continue;
      ++num_covered;
      std::array<float, 3> color{};
      look_at<3>(frame.data(), frame.width(), frame.height(), aged.coordinates.at(x, y, 0),
                 aged.coordinates.at(x, y, 1), color.data());
      for (int c = 0; c < 3; ++c) ASSERT_EQ(texture.at(x, y, c), color[c]);
    }
  }
  EXPECT_GT(num_covered, 1000);
}

TEST(AgeMesh, HoldsAFrameUntilTheVeryTimeOfTheNext) {
  const testing_support::TempFolder folder;
  testing_support::write_history(folder.path(), 48, 48, 3, testing_support::blotches);
  const auto history = std::make_shared<const HistoryReader>(folder.path());
  const AgedMesh aged = age_mesh(history, testing_support::cut_plane(64), "x=height", {.resolution = 64});
  const std::vector<double> times = history->times();
  const double before = std::nextafter(times[2], times[1]);  // A float would round it to times[2].
  EXPECT_EQ(aged.texture(before, Between::Hold), aged.texture(times[1]));
  EXPECT_EQ(aged.texture(times[2], Between::Hold), aged.texture(times[2]));
  EXPECT_NE(aged.texture(times[1]), aged.texture(times[2]));
}

TEST(AgeMesh, UnwrapsAMeshWithoutUvs) {
  const testing_support::TempFolder folder;
  testing_support::write_history(folder.path(), 48, 48, 2, testing_support::blotches);
  Mesh mesh = testing_support::cut_plane(64);
  mesh.uvs.clear();
  mesh.uv_triangles.clear();
  const auto history = std::make_shared<const HistoryReader>(folder.path());
  const AgedMesh aged = age_mesh(history, mesh, "x=height", {.resolution = 64});
  EXPECT_TRUE(aged.mesh.has_uvs());
}

// The steps that one call goes through are those of one's own: a map that was made apart guides alike.
TEST(AgeMesh, IsASurfaceAndAPairOfControls) {
  const testing_support::TempFolder folder;
  testing_support::write_history(folder.path(), 48, 48, 2, testing_support::blotches);
  const auto history = std::make_shared<const HistoryReader>(folder.path());
  const Mesh mesh = testing_support::cut_plane(64);
  const AgeOptions options{.resolution = 64};
  const AgedMesh at_once = age_mesh(history, mesh, "x=height", options);
  const AgingSurface surface = make_aging_surface(mesh, options, &history->facts());
  const AgedMesh by_steps =
      age_surface(history, surface, {make_control_pair(*history, "x=height", *surface.map)}, options);
  EXPECT_EQ(by_steps.coordinates, at_once.coordinates);
  EXPECT_EQ(by_steps.controls.at(0).source, "x");
}

TEST(AgeMesh, ShowsTheMeanOfThePixelsThatATexelCovers) {
  const testing_support::TempFolder folder;
  testing_support::write_history(folder.path(), 64, 64, 2, testing_support::blotches);
  const auto history = std::make_shared<const HistoryReader>(folder.path());
  const AgeOptions options{.resolution = 16, .mm_per_unit = 1.0, .texel_size_mm = 1e-3};
  const AgedMesh aged = age_mesh(history, testing_support::cut_plane(64), "x=height", options);
  const AgingSurface& surface = aged.surface;
  const double pixels = surface.map->median_texel_size_mm() / surface.texel_size_mm;
  ASSERT_GT(pixels, 2.0);
  const HistoryReader expected(folder.path(), footprint_px(*surface.map, surface.texel_size_mm, Footprint::Mean));
  EXPECT_EQ(aged.shown->read_frame(1), expected.read_frame(1));
  AgeOptions one_pixel = options;
  one_pixel.transfer.footprint = Footprint::Pixel;
  const AgedMesh sharp = age_mesh(history, testing_support::cut_plane(64), "x=height", one_pixel);
  EXPECT_EQ(sharp.shown->read_frame(1), history->read_frame(1));
}

TEST(AgeMesh, SaysWhichControlsThereAre) {
  const testing_support::TempFolder folder;
  testing_support::write_history(folder.path(), 48, 48, 2, testing_support::blotches);
  const auto history = std::make_shared<const HistoryReader>(folder.path());  // Has two controls.
  EXPECT_THROW((void)age_mesh(history, testing_support::cut_plane(64), "height"), ParseError);
  EXPECT_THROW((void)age_mesh(history, testing_support::cut_plane(64), "nothing=height"), InvalidInput);
}

TEST(TransferScale, FollowsWhatIsKnown) {
  const TransferScale known = choose_scale(10.0, 0.25, 0.05);
  EXPECT_EQ(known.mm_per_mesh_unit, 10.0);
  EXPECT_EQ(known.texel_size_mm, 0.25);
  const TransferScale no_pixel = choose_scale(10.0, {}, 0.05);
  EXPECT_EQ(no_pixel.texel_size_mm, 0.5);  // One texel.
  EXPECT_EQ(no_pixel.source, ScaleSource::PixelAssumed);
  const TransferScale no_unit = choose_scale({}, 0.25, 0.05);
  EXPECT_EQ(no_unit.mm_per_mesh_unit, 5.0);  // A texel of 0.05 units becomes one pixel of 0.25 mm.
  EXPECT_EQ(no_unit.source, ScaleSource::MeshScaled);
  for (double bad : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW((void)choose_scale(bad, 1.0, 1.0), InvalidInput);
    EXPECT_THROW((void)choose_scale(1.0, bad, 1.0), InvalidInput);
    EXPECT_THROW((void)choose_scale(1.0, 1.0, bad), InvalidInput);
  }
}

TEST(TransferScale, GivesEveryPixelATexelWithinBounds) {
  EXPECT_EQ(choose_resolution(1024, 0.5, 0.25, 1), 2048);
  EXPECT_EQ(choose_resolution(1024, 0.001, 0.25, 1), 256);
  EXPECT_EQ(choose_resolution(1024, 5.0, 0.25, 1), 4096);
  EXPECT_EQ(choose_resolution(1024, 5.0, 0.25, 4), 2048);  // Four tiles: together as many texels as one of 4096.
}

// What a program sees of a transfer is the same when it has made it and when it has read it.
TEST(AgedMesh, IsTheSameFromItsFolder) {
  const testing_support::TempFolder folder;
  testing_support::write_history(folder.path() / "history", 48, 48, 3, testing_support::blotches);
  const auto history = read_history(folder.path() / "history");
  const AgingSurface surface =
      make_aging_surface(testing_support::cut_plane(64), {.resolution = 64}, &history->facts());
  const AgedMesh made = age(history, surface, {{"x", control(surface, "height")}}, {.seed = 3});
  made.save(folder.path() / "aged");
  const AgedMesh read = read_aged_mesh(folder.path() / "aged");
  EXPECT_EQ(read.coordinates, made.coordinates);
  EXPECT_EQ(read.coverage, made.coverage);
  EXPECT_EQ(read.sheet().names, made.sheet().names);
  const ImageF a = made.texture(history->times()[1]), b = read.texture(history->times()[1]);
  EXPECT_EQ(a, b);
  EXPECT_THROW(read.save(folder.path() / "again"), InvalidInput);
}

// Charts are mirrored and the history lies along gravity, so that normals turn and change sides.
TEST(AgedMesh, HasTheSameMapsFromItsFolder) {
  const testing_support::TempFolder folder;
  constexpr int kSide = 48;
  testing_support::write_history(folder.path() / "history", kSide, kSide, 2, testing_support::blotches);
  HistoryWriter writer(folder.path() / "history", HistoryReader(folder.path() / "history").manifest());
  ImageF normals(kSide, kSide, 3), heights(kSide, kSide, 1);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const Eigen::Vector3f n =
          Eigen::Vector3f(std::sin(0.7f * static_cast<float>(x)), std::cos(0.9f * static_cast<float>(y)), 1.0f)
              .normalized();
      std::copy(n.data(), n.data() + 3, normals.pixel(x, y).data());
      heights.at(x, y) = static_cast<float>(x + y) / (2.0f * kSide);
    }
  }
  for (const auto& [name, values] : {std::pair{"normal", &normals}, std::pair{"height", &heights}}) {
    HistoryWriter::write_frame_extra(folder.path() / "history", 0, name, *values);
    writer.add_written_frame_extra(0, name);
  }
  writer.finish();
  const auto history = read_history(folder.path() / "history");
  Mesh mesh = testing_support::quilt_plane(20.0, 3);
  for (Vec2& uv : mesh.uvs) uv.x() = 1.0 - uv.x();
  const AgingSurface surface = make_aging_surface(mesh, {.resolution = 64}, &history->facts());
  const AgedMesh made = age(history, surface, {{"x", control(surface, "height")}}, {.seed = 3});
  made.save(folder.path() / "aged");
  const AgedMesh read = read_aged_mesh(folder.path() / "aged");
  EXPECT_EQ(made.material_map(MaterialMap::Height, 0.0), read.material_map(MaterialMap::Height, 0.0));
  const ImageF found = made.material_map(MaterialMap::Normal, 0.0);
  EXPECT_EQ(found, read.material_map(MaterialMap::Normal, 0.0));
  EXPECT_NE(found, made.gather_sheet(normals));  // They were turned.
  EXPECT_THROW((void)made.material_map(MaterialMap::Metalness, 0.0), InvalidInput);
}

TEST(Age, RefusesAMapOfAnotherSurface) {
  const testing_support::TempFolder folder;
  testing_support::write_history(folder.path(), 48, 48, 2, testing_support::blotches);
  const auto history = read_history(folder.path());
  const Mesh mesh = testing_support::cut_plane(64);
  const AgingSurface small = make_aging_surface(mesh, {.resolution = 32}, &history->facts());
  const AgingSurface large = make_aging_surface(mesh, {.resolution = 64}, &history->facts());
  EXPECT_THROW((void)age(history, large, {{"x", control(small, "height")}}), InvalidInput);
}

}  // namespace
}  // namespace patinate::transfer
