#include "transfer/files/flow_io.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "libcommon/core/text.h"
#include "libcommon/image/image_rows.h"
#include "patinate/atlas/direction_field.h"
#include "patinate/core/error.h"
#include "transfer/synthesis/turns.h"

namespace patinate::transfer {

namespace {

/// Angle as files keep it. Seen from outside a piece turns against the clock as its source turns with it.
float stored_angle(const FrameInUv& frame, std::int16_t turn) {
  return static_cast<float>(frame.angle + (frame.is_mirrored ? -radians_of(turn) : radians_of(turn)));
}

/// Takes the angles of an atlas apart: into the frames of triangles, and turns of texels against those.
class FlowReader {
 public:
  explicit FlowReader(const TexelMap& map) : map_(map), first_(map.mesh().triangles.size()) {
    flow_.turns.resize(map.num_texels());
  }
  void add(TexelId t, float angle, bool is_mirrored) {
    std::optional<FrameInUv>& first = first_[map_.triangle(t)];
    if (!first) first = FrameInUv{static_cast<double>(angle), is_mirrored};
    const double turn = static_cast<double>(angle) - first->angle;
    flow_.turns[t] = turn_of(is_mirrored ? -turn : turn);
  }
  [[nodiscard]] LaidFlow finished() {
    FlowFrames frames = uv_frames(map_);  // Triangles without a texel keep theirs.
    for (std::size_t i = 0; i < frames.size(); ++i) {
      if (first_[i]) frames[i] = frame_from_uv(*first_[i], map_.tangents(static_cast<int>(i)));
    }
    flow_.frames = std::make_shared<const FlowFrames>(std::move(frames));
    if (std::all_of(flow_.turns.begin(), flow_.turns.end(), [](std::int16_t t) { return t == 0; })) flow_.turns.clear();
    return std::move(flow_);
  }

 private:
  const TexelMap& map_;
  std::vector<std::optional<FrameInUv>> first_;
  LaidFlow flow_;
};

/// Calls visit(texel, angle, is_mirrored) for the covered texels of a tile. @throws IoError
template <class Visit>
void for_each_angle(const TransferManifest& manifest, const TexelMap& map, int tile, const Visit& visit) {
  constexpr int kRows = 64;
  const Sheet& sheet = map.sheet();
  const std::filesystem::path& file = manifest.tiles[tile].coordinates;
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
        visit(t, patch.at(x, y, 0), patch.at(x, y, 1) > 0.5f);
      }
    }
  }
}

}  // namespace

void put_patch(ImageF& strip, int x, int y, const TexelMap& map, const FlowFrames& frames,
               const std::function<SourcePlace(TexelId t)>& place_of) {
  int triangle = -1;
  FrameInUv in_uv;
  for (int row = 0; row < strip.height(); ++row) {
    for (int column = 0; column < strip.width(); ++column) {
      const TexelId t = TexelId{y + row} * map.width() + x + column;
      const bool is_covered = map.is_covered(t);
      if (is_covered && map.triangle(t) != triangle) {
        triangle = map.triangle(t);
        in_uv = frame_in_uv(frames[triangle], map.tangents(triangle));
      }
      strip.at(column, row, 2) = is_covered ? stored_angle(in_uv, place_of(t).turn) : 0.0f;
      strip.at(column, row, 3) = is_covered && in_uv.is_mirrored ? 1.0f : 0.0f;
    }
  }
}

LaidFlow as_stored(const std::shared_ptr<const FlowFrames>& frames, std::span<const std::int16_t> turns,
                   const TexelMap& map) {
  if (!frames) return {};
  FlowReader reader(map);
  int triangle = -1;
  FrameInUv in_uv;
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    if (!map.is_covered(t)) continue;
    if (map.triangle(t) != triangle) {
      triangle = map.triangle(t);
      in_uv = frame_in_uv((*frames)[triangle], map.tangents(triangle));
    }
    const std::int16_t turn = turns.empty() ? std::int16_t{0} : turns[t];
    reader.add(t, stored_angle(in_uv, turn), in_uv.is_mirrored);
  }
  return reader.finished();
}

LaidFlow read_flow(const TransferManifest& manifest, const TexelMap& map) {
  if (manifest.flow == "uv") return {};
  FlowReader reader(map);
  for (int tile = 0; tile < map.sheet().num_tiles(); ++tile) {
    for_each_angle(manifest, map, tile,
                   [&](TexelId t, float angle, bool is_mirrored) { reader.add(t, angle, is_mirrored); });
  }
  return reader.finished();
}

}  // namespace patinate::transfer
