#include "transfer/files/flow_io.h"

#include <algorithm>
#include <cmath>

#include "libcommon/core/text.h"
#include "libcommon/image/image_rows.h"
#include "patinate/atlas/direction_field.h"
#include "patinate/core/error.h"

namespace patinate::transfer {

void put_patch(ImageF& strip, int x, int y, const TexelMap& map, const FlowFrames& frames) {
  int triangle = -1;
  FrameInUv in_uv;
  for (int row = 0; row < strip.height(); ++row) {
    for (int column = 0; column < strip.width(); ++column) {
      const TexelId t = TexelId{y + row} * map.width() + x + column;
      const bool is_covered = map.is_covered(t);
      if (is_covered && map.triangle(t) != triangle) {
        triangle = map.triangle(t);
        in_uv = frame_in_uv(frames[static_cast<std::size_t>(triangle)], map.tangents(triangle));
      }
      strip.at(column, row, 2) = is_covered ? static_cast<float>(in_uv.angle) : 0.0f;
      strip.at(column, row, 3) = is_covered && in_uv.is_mirrored ? 1.0f : 0.0f;
    }
  }
}

void read_flow_tile(const TransferManifest& manifest, const TexelMap& map, int tile, FlowFrames& frames) {
  constexpr int kRows = 64;
  const Sheet& sheet = map.sheet();
  const std::filesystem::path& file = manifest.tiles[static_cast<std::size_t>(tile)].coordinates;
  ImageRowReader reader(file, {kPatchChannels[0], kPatchChannels[1]});
  if (reader.width() != sheet.tile_width || reader.height() != sheet.tile_height) {
    throw IoError(file.string(), "is " + size_text(reader.width(), reader.height()) + "; expected " +
                                     size_text(sheet.tile_width, sheet.tile_height));
  }
  for (int begin = 0; begin < reader.height(); begin += kRows) {
    const ImageF patch = reader.read(begin, std::min(begin + kRows, reader.height()));
    for (int y = 0; y < patch.height(); ++y) {
      for (int x = 0; x < patch.width(); ++x) {
        const TexelId t = TexelId{sheet.first_y(tile) + begin + y} * map.width() + sheet.first_x(tile) + x;
        if (!map.is_covered(t)) continue;
        if (!std::isfinite(patch.at(x, y, 0)))
          throw IoError(file.string(),
                        "holds a " + std::string(kPatchChannels[0]) + " that is no number; make the transfer again");
        const int triangle = map.triangle(t);
        frames[static_cast<std::size_t>(triangle)] =
            frame_from_uv({static_cast<double>(patch.at(x, y, 0)), patch.at(x, y, 1) > 0.5f}, map.tangents(triangle));
      }
    }
  }
}

std::shared_ptr<const FlowFrames> as_stored(const std::shared_ptr<const FlowFrames>& frames, const TexelMap& map) {
  if (!frames) return nullptr;
  auto stored = std::make_shared<FlowFrames>(uv_frames(map));
  int last = -1;
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    if (!map.is_covered(t) || map.triangle(t) == last) continue;
    last = map.triangle(t);
    const FrameInUv in_uv = frame_in_uv((*frames)[static_cast<std::size_t>(last)], map.tangents(last));
    (*stored)[static_cast<std::size_t>(last)] =
        frame_from_uv({static_cast<double>(static_cast<float>(in_uv.angle)), in_uv.is_mirrored}, map.tangents(last));
  }
  return stored;
}

std::shared_ptr<const FlowFrames> read_flow_frames(const TransferManifest& manifest, const TexelMap& map) {
  if (manifest.flow == "uv") return nullptr;
  auto frames = std::make_shared<FlowFrames>(uv_frames(map));  // Triangles without a texel keep theirs.
  for (int tile = 0; tile < map.sheet().num_tiles(); ++tile) read_flow_tile(manifest, map, tile, *frames);
  return frames;
}

}  // namespace patinate::transfer
