// Histories that never were a folder: every step of a transfer gives what the same history on disk gives, to the bit.
#include "patinate/history/memory_history.h"

#include <gtest/gtest.h>

#include <memory>

#include "patinate/history/write_history.h"
#include "patinate/transfer/age.h"
#include "patinate/transfer/time_map.h"
#include "patinate/transfer/transfer_io.h"
#include "tests/support/histories.h"
#include "tests/support/meshes.h"
#include "tests/support/temp_folder.h"
#include "transfer/lookup/packed_lookup.h"
#include "transfer/synthesis/map_audit.h"
#include "transfer/synthesis/transfer_controls.h"

namespace patinate::transfer {
namespace {

constexpr int kMemorySource = 56, kAtlas = 64;

/// The same history twice. Its values are half floats, as a folder keeps them.
struct Both {
  testing_support::TempFolder folder;
  std::shared_ptr<const History> memory, disk;
  std::shared_ptr<const TexelMap> map = std::make_shared<TexelMap>(testing_support::cut_plane(kAtlas), kAtlas, kAtlas);

  explicit Both(MemoryHistoryImages images = testing_support::half_images(kMemorySource, kMemorySource, 4,
                                                                          testing_support::blotches)) {
    memory = std::make_shared<const MemoryHistory>(std::move(images));
    write_history(folder.path(), *memory);
    disk = std::make_shared<const HistoryReader>(folder.path());
  }
  [[nodiscard]] ImageF ramp() const {
    ImageF values(kAtlas, kAtlas);
    for (TexelId t = 0; t < map->num_texels(); ++t) values.data()[t] = static_cast<float>(t % kAtlas) / (kAtlas - 1.0f);
    return values;
  }
  [[nodiscard]] TransferInput input(const std::shared_ptr<const History>& history) const {
    return {.history = history,
            .map = map,
            .texel_size_mm = 1.0,
            .controls = {{"x", "ramp", ramp(), {}, 1.0, ControlMapping::Rank}}};
  }
};

TEST(MemoryTransfer, EqualsTheTransferFromAFolder) {
  const Both both;
  for (TransferMethod method : {TransferMethod::Fast, TransferMethod::Reference}) {
    const TransferOptions options{.method = method, .reference = {.num_passes = 1}};
    const TransferResult memory = transfer(both.input(both.memory), options),
                         disk = transfer(both.input(both.disk), options);
    EXPECT_EQ(memory.coordinates, disk.coordinates);
    EXPECT_EQ(memory.matched_controls, disk.matched_controls);
    EXPECT_EQ(memory.energy.energy, disk.energy.energy);
    EXPECT_EQ(memory.explained_variance, disk.explained_variance);
  }
}

TEST(MemoryTransfer, EqualsTheAudit) {
  const Both both;
  const TransferResult made = transfer(both.input(both.memory));
  MapToAudit map{.surface = both.map,
                 .coordinates = coordinate_image(made, kAtlas, kAtlas, kMemorySource),
                 .pixel_mm = 1.0,
                 .controls = {{"x", both.ramp()}}};
  const OptimumAudit memory = audit_map(*both.memory, map, {}, 200, 1), disk = audit_map(*both.disk, map, {}, 200, 1);
  EXPECT_GT(memory.num_audited, 0);
  EXPECT_EQ(memory.energy, disk.energy);
  EXPECT_EQ(memory.ratio, disk.ratio);
}

TEST(MemoryTransfer, EqualsTheLookupAtATimeOfItsOwnPerTexel) {
  const Both both;
  const ImageF coordinates = coordinate_image(transfer(both.input(both.memory)), kAtlas, kAtlas, kMemorySource);
  ImageF times = both.ramp();
  for (float& t : times.values()) t *= 9.0f;  // From the first frame to the last.
  const PackedPlaces places = pack_coordinates(coordinates, kMemorySource, kMemorySource);
  EXPECT_EQ(gather_at_times(*both.memory, places, times, Between::Blend),
            gather_at_times(*both.disk, places, times, Between::Blend));
}

TEST(MemoryTransfer, AgesAMeshAsTheFolderDoes) {
  const Both both;
  const AgeOptions options{.resolution = 64};
  const AgedMesh memory = age_mesh(both.memory, testing_support::cut_plane(kAtlas), "x=height", options),
                 disk = age_mesh(both.disk, testing_support::cut_plane(kAtlas), "x=height", options);
  EXPECT_EQ(memory.coordinates, disk.coordinates);
  EXPECT_EQ(memory.texture(2.5), disk.texture(2.5));
}

// A library's parts are known to the value: nobody reads a file for them.
TEST(MemoryTransfer, KnowsThePartsOfALibrary) {
  MemoryHistoryImages images = testing_support::half_images(kMemorySource, kMemorySource, 3, testing_support::blotches);
  ImageF which(kMemorySource, kMemorySource);
  for (int y = 0; y < kMemorySource; ++y) {
    for (int x = kMemorySource / 2; x < kMemorySource; ++x) which.at(x, y) = 1.0f;
  }
  images.controls.push_back({{.name = kLibraryControl, .unit = kLibraryControlUnit}, which});
  images.parts = {
      {.name = "left", .x = 0, .width = kMemorySource / 2, .height = kMemorySource, .key = "l"},
      {.name = "right", .x = kMemorySource / 2, .width = kMemorySource / 2, .height = kMemorySource, .key = "r"}};
  const Both both(std::move(images));
  ASSERT_EQ(both.disk->facts().parts, both.memory->facts().parts);
  const auto of = [&](const std::shared_ptr<const History>& history) {
    TransferInput input = both.input(history);
    input.controls.push_back(make_transfer_control(*history, parse_control_spec("history=ramp"),
                                                   {both.ramp(), 0.0, 1.0, "relative", {}}, both.map->coverage()));
    return transfer(input);
  };
  const TransferResult memory = of(both.memory);
  EXPECT_EQ(memory.coordinates, of(both.disk).coordinates);
  int num_right = 0, num_asked = 0;
  for (TexelId t = 0; t < both.map->num_texels(); ++t) {
    if (!both.map->is_covered(t) || t % kAtlas < kAtlas - 12) continue;
    ++num_asked;
    num_right += memory.coordinates[t] % kMemorySource >= kMemorySource / 2;
  }
  EXPECT_GE(num_right, 0.99 * num_asked);
}

}  // namespace
}  // namespace patinate::transfer
