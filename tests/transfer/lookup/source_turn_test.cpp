#include "transfer/lookup/source_turn.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>

#include "patinate/image/image_io.h"
#include "patinate/transfer/transfer_reader.h"
#include "tests/support/errors.h"
#include "tests/support/histories.h"
#include "tests/support/meshes.h"
#include "tests/support/temp_folder.h"
#include "transfer/files/flow_io.h"
#include "transfer/job/transfer_job.h"
#include "transfer/lookup/texture_files.h"

namespace patinate::transfer {
namespace {

constexpr double kSourceSide = 48.0;  // mm, and pixels of the source.
constexpr int kAtlas = 96;

/// A relief of waves over the source's pixels; x right, y up, z out.
Eigen::Vector3f relief(int x, int y) {
  return Eigen::Vector3f(0.6f * std::sin(0.7f * static_cast<float>(x)),
                         0.5f * std::cos(0.9f * static_cast<float>(y) + 0.3f * static_cast<float>(x)), 1.0f)
      .normalized();
}

/// A square of nine charts, each turned by an angle of its own, on which the source lies as on a table: x along world
/// x, up along world y.
class TurnedCharts : public testing::TestWithParam<bool> {
 protected:
  void SetUp() override {
    std::filesystem::create_directory(folder_ / "history");
    const int size = static_cast<int>(kSourceSide);
    testing_support::write_history(folder_ / "history", size, size, 2, testing_support::blotches);
    HistoryWriter writer(folder_ / "history", HistoryReader(folder_ / "history").manifest());
    ImageF normals(size, size, 3);
    for (int y = 0; y < size; ++y) {
      for (int x = 0; x < size; ++x) {
        for (int c = 0; c < 3; ++c) normals.at(x, y, c) = relief(x, y)[c];
      }
    }
    HistoryWriter::write_frame_extra(folder_ / "history", 0, "normal", normals);
    writer.add_written_frame_extra(0, "normal");
    writer.finish();
    Mesh mesh = testing_support::quilt_plane(kSourceSide, 3);
    if (GetParam()) {
      for (Vec2& uv : mesh.uvs) uv.x() = 1.0 - uv.x();  // Mirror images of the surface.
    }
    TransferTask task;
    task.history = std::make_shared<const HistoryReader>(folder_ / "history");
    task.input.map = map_ = std::make_shared<TexelMap>(mesh, kAtlas, kAtlas);
    task.mesh_name = "quilt.obj";
    task.input.texel_size_mm = map_->median_texel_size_mm();
    task.input.controls.push_back({"x", "image", ImageF(kAtlas, kAtlas), {}, 1.0, ControlMapping::Rank});
    for (int i = 0; i < kAtlas * kAtlas; ++i) task.input.controls[0].values.data()[i] = static_cast<float>(i % kAtlas);
    task.options.method = TransferMethod::Fast;
    ASSERT_EQ(run_job(plan_transfer(task, folder_ / "transfer"), {}, {}), JobStatus::Done);
    lay_source();
  }
  /// Coordinates by the formula instead of a search.
  void lay_source() {
    ImageF coordinates(kAtlas, kAtlas, 4, -1.0f);
    for (int y = 0; y < kAtlas; ++y) {
      for (int x = 0; x < kAtlas; ++x) {
        const TexelId t = std::int64_t{y} * kAtlas + x;
        if (!map_->is_covered(t)) continue;
        const Vec3 p = map_->position_mm(t);
        coordinates.at(x, y, 0) = static_cast<float>(std::clamp(std::floor(p.x()), 0.0, kSourceSide - 1.0));
        coordinates.at(x, y, 1) =
            static_cast<float>(std::clamp(kSourceSide - 1.0 - std::floor(p.y()), 0.0, kSourceSide - 1.0));
        const auto [along_u, along_v] = uv_axes(t);
        coordinates.at(x, y, 2) = static_cast<float>(std::atan2(along_v.x(), along_u.x()));  // World x in the UV frame.
        coordinates.at(x, y, 3) = GetParam() ? 1.0f : 0.0f;
      }
    }
    write_exr(folder_ / "transfer/coordinates.exr", coordinates,
              {"source.x", "source.y", kPatchChannels[0], kPatchChannels[1]}, ExrDepth::Float);
  }
  /// Unit vectors on the surface along growing u and v.
  [[nodiscard]] std::pair<Vec3, Vec3> uv_axes(TexelId t) const {
    const auto steps = map_->mm_per_texel(map_->point(t).triangle);
    return {steps.col(0).normalized(), -steps.col(1).normalized()};
  }
  testing_support::TempFolder folder_;
  std::shared_ptr<const TexelMap> map_;
};

// The truth: the relief where the source lies on the surface, in the world, under several lamps. Tolerance: 2^-20 turns
// and float rounding.
TEST_P(TurnedCharts, AreLitAsTheSurfaceThatTheyShow) {
  const TransferReader transfer(folder_ / "transfer");
  const ImageF found = transfer.sample_map(MaterialMap::Normal, 0.0), source = transfer.coordinates();
  const std::array<Vec3, 4> lamps{Vec3(1, 0, 1).normalized(), Vec3(0, 1, 1).normalized(),
                                  Vec3(-1, 0.3, 0.8).normalized(), Vec3(0, 0, 1)};
  double plain_error = 0.0;
  for (int y = 0; y < kAtlas; ++y) {
    for (int x = 0; x < kAtlas; ++x) {
      const TexelId t = std::int64_t{y} * kAtlas + x;
      if (!map_->is_covered(t)) continue;
      const Vec3 truth =
          relief(static_cast<int>(source.at(x, y, 0)), static_cast<int>(source.at(x, y, 1))).cast<double>();
      const auto [along_u, along_v] = uv_axes(t);
      const Vec3 normal = static_cast<double>(found.at(x, y, 0)) * along_u +
                          static_cast<double>(found.at(x, y, 1)) * along_v +
                          Vec3(0, 0, static_cast<double>(found.at(x, y, 2)));
      for (const Vec3& lamp : lamps)
        ASSERT_NEAR(std::max(0.0, normal.dot(lamp)), std::max(0.0, truth.dot(lamp)), 2e-5) << x << ' ' << y;
      plain_error =
          std::max(plain_error, (truth.x() * along_u + truth.y() * along_v + Vec3(0, 0, truth.z()) - truth).norm());
    }
  }
  EXPECT_GT(plain_error, 0.5);  // Without turning they would not be.
}

TEST_P(TurnedCharts, AFileOfNormalsIsWhatTheReaderGives) {
  const TransferReader reader(folder_ / "transfer");
  const ImageF expected = reader.sample_map(MaterialMap::Normal, 0.0);
  const TransferFolder transfer(folder_ / "transfer");
  const ImageF source = sample_material_map(transfer.history(), MaterialMap::Normal, 0.0, Between::Blend);
  for (std::int64_t kept : {std::int64_t{0}, std::int64_t{1} << 24}) {
    const TextureWriter writer(transfer, {.kept_texels = kept, .strip_texels = 1, .with_turns = true});
    const std::vector<TextureFile> files{{{folder_ / "n.exr"}, source, "", TextureKind::Normal},
                                         {{folder_ / "n.png"}, source, "", TextureKind::Normal}};
    writer.write(files);
    EXPECT_EQ(read_channels(folder_ / "n.exr", {"X", "Y", "Z"}), expected);
    const ImageF codes = read_channels(folder_ / "n.png", {"R", "G", "B"});
    for (std::size_t i = 0; i < codes.values().size(); ++i)
      ASSERT_NEAR(codes.data()[i], 0.5f + 0.5f * expected.data()[i], 0.5f / 255.0f + 1e-6f);
  }
  EXPECT_THROW(
      TextureWriter(transfer).write(std::vector<TextureFile>{{{folder_ / "m.exr"}, source, "", TextureKind::Normal}}),
      InvalidInput);
}

INSTANTIATE_TEST_SUITE_P(AndMirrored, TurnedCharts, testing::Bool());

TEST(SourceTurn, AngleAndMirrorComeBack) {
  for (bool is_mirrored : {false, true}) {
    for (float angle : {0.0f, 0.3f, -2.0f, 3.1f, 40.0f}) {
      const std::vector<std::uint32_t> turns(2, pack_turn(angle, is_mirrored));
      std::vector<float> axes{1, 0, 0, 0, 1, 0};
      turn_normals(turns, axes);
      const float side = is_mirrored ? -1.0f : 1.0f;
      // Half a step of 2^-20 turns is 3e-6.
      EXPECT_NEAR(axes[0], std::cos(angle), 1e-5f);
      EXPECT_NEAR(axes[1], std::sin(angle), 1e-5f);
      EXPECT_NEAR(axes[3], -side * std::sin(angle), 1e-5f);
      EXPECT_NEAR(axes[4], side * std::cos(angle), 1e-5f);
    }
  }
  EXPECT_EQ(pack_turn(0.0f, false), pack_turn(static_cast<float>(2.0 * std::numbers::pi), false));
}

TEST(SourceTurn, SaysWhichTexelHasNone) {
  const std::vector<std::uint32_t> indices{3, kNoValue, 4, 5};
  std::vector<std::uint32_t> turns(4);
  pack_checked_turns("c.exr", std::vector<float>{0, 0, 7, 7, 0, 1, 0, 0}, 2, 2, indices, turns);
  EXPECT_EQ(turns[1], kNoValue);
  const std::string said = testing_support::error_of<IoError>([&] {
    pack_checked_turns("c.exr", std::vector<float>{0, 0, 7, 7, 0, 1, 0, 0.5f}, 2, 2, indices, turns);
  });
  EXPECT_TRUE(testing_support::has(said, "texel (1, 3)")) << said;
}

}  // namespace
}  // namespace patinate::transfer
