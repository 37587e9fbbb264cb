// Ages a mesh by a control of your own: here, how far below the rim a point lies, as if water ran down from it.
//     02_own_control HISTORY MESH.obj TEXTURE.png
#include <cmath>
#include <cstdio>
#include <exception>
#include <memory>

#include "patinate/atlas/texel_map.h"
#include "patinate/history/history.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/mesh_io.h"
#include "patinate/transfer/transfer.h"
#include "patinate/transfer/transfer_io.h"
#include "patinate/transfer/transfer_reader.h"

using namespace patinate;

/// A control map: one value in [0, 1] for every texel of the atlas. The texel map says which surface point a texel
/// shows.
ImageF below_the_rim(const TexelMap& map) {
  const Box box = bounding_box(map.mesh());
  ImageF control(map.width(), map.height());
  for (TexelId t = 0; t < map.num_texels(); ++t) {
    if (!map.is_covered(t)) continue;
    const double depth = (box.high.y() - map.position_mm(t).y()) / (box.high.y() - box.low.y());
    control.data()[t] = static_cast<float>(std::exp(-3.0 * depth));
  }
  return control;
}

int main(int argc, char** argv) try {
  if (argc != 4) {
    std::fputs("usage: 02_own_control HISTORY MESH.obj TEXTURE.png\n", stderr);
    return 2;
  }
  const auto history = std::make_shared<const HistoryReader>(argv[1]);
  const auto map = std::make_shared<TexelMap>(with_normals(read_mesh(argv[2])), 512, 512);

  // The first control of the history (say, thickness) follows ours. Rank mapping needs no common unit.
  transfer::TransferControl control;
  control.source = history->facts().controls.at(0).name;
  control.destination = "below the rim";
  control.values = below_the_rim(*map);

  // One pixel of the history covers one texel of the mesh.
  const transfer::TransferResult result = transfer::transfer(
      {.history = history, .map = map, .texel_size_mm = map->median_texel_size_mm(), .controls = {control}});
  std::printf("energy %.3f, control error %.3f\n", result.energy.energy, result.energy.control_error_mean);

  // The search was for all times at once: any frame is a gather through the coordinates.
  const ImageF coordinates = transfer::coordinate_image(result, map->width(), map->height(), history->facts().width);
  write_color(argv[3], transfer::gather(history->sample(history->times().back()), coordinates));
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "02_own_control: %s\n", e.what());
  return 1;
}
