#include "transfer/lookup/texture_files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "libcommon/core/files.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/image/color.h"
#include "patinate/image/image_io.h"
#include "patinate/transfer/transfer_reader.h"
#include "tests/support/errors.h"
#include "tests/support/histories.h"
#include "tests/support/meshes.h"
#include "tests/support/temp_folder.h"
#include "transfer/job/transfer_job.h"

namespace patinate::transfer {
namespace {

using testing_support::TempFolder;

/// A plane of two charts with gutters, 150 texels wide, aged with a history of 48 x 40.
class WrittenTextures : public testing::Test {
 protected:
  static constexpr int kSide = 150;
  void SetUp() override {
    std::filesystem::create_directory(folder_ / "history");
    testing_support::write_history(folder_ / "history", 48, 40, 3, testing_support::blotches);
    TransferTask task;
    task.history = std::make_shared<const HistoryReader>(folder_ / "history");
    task.input.map = std::make_shared<TexelMap>(testing_support::cut_plane(64.0), kSide, kSide);
    task.mesh_name = "plane.obj";
    task.input.texel_size_mm = task.input.map->median_texel_size_mm();
    ImageF guide(kSide, kSide);
    for (int i = 0; i < kSide * kSide; ++i) guide.data()[i] = static_cast<float>(i % kSide) / kSide;
    task.input.controls.push_back({"x", "image", guide, {}, 1.0, ControlMapping::Rank});
    ASSERT_EQ(run_job(plan_transfer(task, folder_ / "transfer"), {}, {}), JobStatus::Done);
  }
  void rewrite_coordinates(const std::function<void(ImageF&)>& change) {
    const auto file = folder_ / "transfer/coordinates.exr";
    ImageF coordinates = read_channels(file, {"source.x", "source.y"});
    change(coordinates);
    write_exr(file, coordinates, {"source.x", "source.y"}, ExrDepth::Float);
  }
  [[nodiscard]] std::string complaint() const {
    return testing_support::error_of<IoError>(
        [&] { const TextureWriter writer{TransferFolder(folder_ / "transfer")}; });
  }
  TempFolder folder_;
};

TEST_F(WrittenTextures, AreThoseOfTheReaderToTheByteKeptOrReadAgain) {
  const TransferReader reader(folder_ / "transfer");
  const ImageU8 coverage = reader.coverage();
  ASSERT_LT(std::count(coverage.values().begin(), coverage.values().end(), 255), kSide * kSide);  // There are gutters.
  const TransferFolder transfer(folder_ / "transfer");
  for (const auto& options :
       {CoordinateStripsOptions{}, CoordinateStripsOptions{.kept_texels = 0, .strip_texels = 1}}) {
    TextureWriter writer(transfer, options);
    for (const char* extension : {".png", ".exr"}) {
      const auto file = [&](const std::string& name) { return folder_ / (name + extension); };
      std::vector<TextureFile> textures;
      for (double time : {1.0, 1.25})
        textures.push_back({{file("rows" + std::to_string(time))}, transfer.history().sample(time), "key"});
      writer.write(textures);
      for (double time : {1.0, 1.25}) {
        write_color(file("whole"), reader.sample(time), "key");
        EXPECT_EQ(read_file(file("rows" + std::to_string(time))), read_file(file("whole"))) << time << extension;
      }
    }
  }
}

TEST_F(WrittenTextures, RowsAreTheCodesOfTheWholeTexture) {
  const TransferReader reader(folder_ / "transfer");
  const TransferFolder transfer(folder_ / "transfer");
  const ImageF colors = transfer.history().sample(1.25);
  const ImageU8 whole = srgb8_from_linear(reader.sample(1.25));
  for (const auto& options :
       {CoordinateStripsOptions{}, CoordinateStripsOptions{.kept_texels = 0, .strip_texels = 1}}) {
    std::vector<std::uint8_t> rows;
    const TextureWriter writer(transfer, options);
    writer.gather_rows(0, colors, color_codes, [&](std::span<const std::uint8_t> part) {
      EXPECT_EQ(part.size() % (3 * kSide), 0u);
      rows.insert(rows.end(), part.begin(), part.end());
    });
    EXPECT_TRUE(std::ranges::equal(rows, whole.values()));
    EXPECT_THROW(writer.gather_rows(0, ImageF(47, 40, 3), color_codes, [](auto) {}), InvalidInput);
    EXPECT_THROW(writer.normal_rows(0, ImageF(48, 40, 3), [](auto) {}), InvalidInput) << "opened without turns";
  }
}

TEST_F(WrittenTextures, TimeMapsAreThoseOfTheReaderToTheByteKeptOrReadAgain) {
  const TransferReader reader(folder_ / "transfer");
  const TransferFolder transfer(folder_ / "transfer");
  ImageF times(kSide, kSide);
  for (std::int64_t i = 0; i < times.num_pixels(); ++i) times.data()[i] = static_cast<float>(i % 97) * 0.025f - 0.2f;
  for (Between between : {Between::Blend, Between::Hold}) {
    for (const char* extension : {".png", ".exr"}) {
      const std::vector<std::filesystem::path> files{folder_ / (std::string("rows") + extension)};
      const auto whole = folder_ / (std::string("whole") + extension);
      write_color(whole, reader.sample_tiles(times, between)[0], "key");
      for (const auto& options :
           {CoordinateStripsOptions{}, CoordinateStripsOptions{.kept_texels = 0, .strip_texels = 1}}) {
        for (const std::int64_t frame_bytes : {0, 1 << 20}) {
          write_time_map(transfer, times, between, files, "key", {.frame_bytes = frame_bytes}, {}, options);
          EXPECT_EQ(read_file(files[0]), read_file(whole)) << extension << " " << frame_bytes;
        }
      }
    }
  }
  EXPECT_THROW(write_time_map(transfer, ImageF(kSide, kSide - 1), Between::Blend, std::vector{folder_ / "t.png"}, ""),
               InvalidInput);
  EXPECT_THROW(write_time_map(transfer, times, Between::Blend, {}, ""), InvalidInput);
}

TEST_F(WrittenTextures, AtAFramesTimeAreThatFrame) {
  const TransferFolder transfer(folder_ / "transfer");
  const std::vector<TextureFile> textures{{{folder_ / "t.exr"}, transfer.history().sample(2.0)}};
  TextureWriter(transfer).write(textures);
  const ImageF texture = read_color(folder_ / "t.exr"), frame = transfer.history().read_frame(2);
  const ImageF s = read_channels(transfer.manifest().tiles[0].coordinates, {"source.x", "source.y"}),
               expected = gather(frame, s);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      if (s.at(x, y, 0) < 0.0f) continue;
      for (int c = 0; c < 3; ++c)  // Of half floats, as frames are; between pixels they are rounded again.
        ASSERT_NEAR(texture.at(x, y, c), expected.at(x, y, c), std::ldexp(1.0, -11));
    }
  }
}

TEST_F(WrittenTextures, CoordinatesThatMeanNothingAreOneLine) {
  EXPECT_EQ(complaint(), "");
  rewrite_coordinates([](ImageF& s) { std::ranges::copy(std::array{48.0f, 5.0f}, s.pixel(3, 70).begin()); });
  EXPECT_NE(complaint().find("coordinates.exr: texel (3, 70) points outside the history"), std::string::npos)
      << complaint();
  Json json = load_json(folder_ / "transfer/transfer.json");
  json["subpixel"] = false;
  save_json(folder_ / "transfer/transfer.json", json);
  rewrite_coordinates([](ImageF& s) {
    for (float& place : s.values()) place = std::floor(place);
    std::ranges::copy(std::array{4.5f, 5.0f}, s.pixel(3, 70).begin());
  });
  EXPECT_NE(complaint().find("texel (3, 70) points between the history's pixels"), std::string::npos) << complaint();
  rewrite_coordinates([](ImageF& s) { s = ImageF(kSide, kSide - 1, 2, -1.0f); });
  EXPECT_NE(complaint().find("is 150 x 149; expected 150 x 150"), std::string::npos) << complaint();
  write_exr(folder_ / "transfer/coordinates.exr", ImageF(kSide, kSide, 2), {"source.x", "source.z"}, ExrDepth::Float);
  EXPECT_NE(complaint().find("has no channel `source.y`; there are: source.x source.z"), std::string::npos)
      << complaint();
  write_atomically(folder_ / "transfer/coordinates.exr", "v/1\1");
  EXPECT_NE(complaint().find("is no readable image"), std::string::npos) << complaint();
  std::filesystem::remove(folder_ / "transfer/coordinates.exr");
  EXPECT_NE(complaint().find("does not exist"), std::string::npos) << complaint();
}

TEST_F(WrittenTextures, ATransferWithoutACoveredTexelIsBlack) {
  rewrite_coordinates([](ImageF& s) { s = ImageF(kSide, kSide, 2, -1.0f); });
  const TransferFolder transfer(folder_ / "transfer");
  const std::vector<TextureFile> textures{{{folder_ / "t.png"}, transfer.history().sample(2.0)}};
  TextureWriter(transfer).write(textures);
  EXPECT_EQ(read_color(folder_ / "t.png"), ImageF(kSide, kSide, 3));
}

}  // namespace
}  // namespace patinate::transfer
