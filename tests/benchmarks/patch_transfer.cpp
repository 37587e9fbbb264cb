#include "tests/benchmarks/patch_transfer.h"

#include <array>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "patinate/core/json.h"
#include "patinate/history/history.h"
#include "patinate/image/image_io.h"
#include "patinate/transfer/transfer_reader.h"
#include "tests/support/histories.h"
#include "tests/support/meshes.h"
#include "transfer/job/transfer_job.h"

namespace patinate::benchmarks {

ImageF patch_coordinates(int side, bool has_gutters) {
  ImageF coordinates(side, side, 2, -1.0f);
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      if (has_gutters && x / 32 % 4 == 3) continue;
      const int patch = x / 32 * 131 + y / 32 * 197;
      coordinates.at(x, y, 0) = static_cast<float>((x + patch * 37) % kPatchSource);
      coordinates.at(x, y, 1) = static_cast<float>((y + patch * 53) % kPatchSource);
    }
  }
  return coordinates;
}

void write_patch_transfer(const std::filesystem::path& folder, int side, bool has_maps) {
  std::filesystem::create_directory(folder / "history");
  testing_support::write_history(folder / "history", kPatchSource, kPatchSource, 2, testing_support::blotches);
  if (has_maps) add_material_maps(folder / "history");
  transfer::TransferTask task;
  task.history = std::make_shared<const HistoryReader>(folder / "history");
  task.input.map = std::make_shared<TexelMap>(testing_support::cut_plane(64.0), 64, 64);
  task.mesh_name = "plane.obj";
  task.input.texel_size_mm = task.input.map->median_texel_size_mm();
  task.input.controls.push_back({"x", "image", ImageF(64, 64), {}, 1.0, transfer::ControlMapping::Rank});
  for (std::size_t i = 0; i < 64 * 64; ++i) task.input.controls[0].values.data()[i] = static_cast<float>(i % 64);
  (void)run_job(transfer::plan_transfer(task, folder / "transfer"), {}, {});
  Json json = load_json(folder / "transfer/transfer.json");
  json["width"] = json["height"] = side;
  save_json(folder / "transfer/transfer.json", json);
  write_exr(folder / "transfer/coordinates.exr", patch_coordinates(side, true),
            {transfer::kCoordinateChannels[0], transfer::kCoordinateChannels[1]}, ExrDepth::Float);
}

void add_material_maps(const std::filesystem::path& history) {
  HistoryManifest manifest = read_history_manifest(history);
  // Blotches again, each map those of another time, so that no map is another one.
  const auto value = [](int x, int y, int frame, int channel) {
    return testing_support::blotches(x, y, frame, channel % 3);
  };
  for (std::size_t f = 0; f < manifest.frames.size(); ++f) {
    const int index = static_cast<int>(f);
    for (const std::string_view view : kFrameExtraNames) {
      const std::string name(view);
      if (name == "stddev") continue;
      const auto channels = static_cast<int>(frame_extra_channels(name).size());
      ImageF map(manifest.width, manifest.height, channels);
      for (int y = 0; y < map.height(); ++y) {
        for (int x = 0; x < map.width(); ++x) {
          const auto pixel = map.pixel(x, y);
          for (int c = 0; c < channels; ++c) pixel[c] = value(x, y, index + 1, c + channels);
          if (name != "normal") continue;
          const float slope_x = 0.4f * (pixel[0] - 0.5f), slope_y = 0.4f * (pixel[1] - 0.5f);
          const float length = std::sqrt(slope_x * slope_x + slope_y * slope_y + 1.0f);
          pixel[0] = slope_x / length;
          pixel[1] = slope_y / length;
          pixel[2] = 1.0f / length;
        }
      }
      HistoryWriter::write_frame_extra(history, index, name, map);
      manifest.frames[f].extras.push_back({name, HistoryWriter::frame_extra_file(index, name)});
    }
  }
  write_history_manifest(history / kHistoryManifestFile, manifest);
}

}  // namespace patinate::benchmarks
