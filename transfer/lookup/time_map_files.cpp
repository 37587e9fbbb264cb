#include <algorithm>
#include <utility>

#include "libcommon/core/parallel.h"
#include "libcommon/core/text.h"
#include "libcommon/image/image_rows.h"
#include "patinate/atlas/dilate.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"
#include "transfer/lookup/texture_files.h"

namespace patinate::transfer {

namespace {

/// Texels that have coordinates.
ImageU8 covered(const std::filesystem::path& file, int width, int height, const RunControl& control) {
  constexpr int kRows = kExrChunkRows;
  ImageRowReader rows(file, {kCoordinateChannels[0]});
  if (rows.width() != width || rows.height() != height)
    throw IoError(file.string(),
                  "is " + size_text(rows.width(), rows.height()) + "; expected " + size_text(width, height));
  ImageU8 out(width, height);
  for (int y = 0; y < height; y += kRows) {
    control.throw_if_stopped();
    const ImageF columns = rows.read(y, std::min(height, y + kRows));
    for (std::size_t i = 0; i < columns.values().size(); ++i)
      out.row(y).data()[i] = columns.values()[i] >= 0.0f ? 255 : 0;
  }
  return out;
}

}  // namespace

void write_time_map(const TransferFolder& transfer, ImageF times, Between between,
                    std::span<const std::filesystem::path> files, const std::string& key, const TimeMapOptions& frames,
                    const RunControl& control, const CoordinateStripsOptions& options) {
  const TransferManifest& m = transfer.manifest();
  const HistoryManifest& history = transfer.history().manifest();
  const Sheet& sheet = transfer.sheet();
  if (times.width() != sheet.width() || times.height() != sheet.height() || times.channels() != 1 ||
      files.size() != m.tiles.size()) {
    throw InvalidInput("time map: expected a time for every texel and a file for every tile");
  }
  const RunControl quiet = control.silent();
  TimeMapLookup lookup(transfer.history(), between, frames);
  CoordinateStripsOptions strip_options = options;
  strip_options.is_subpixel = m.is_subpixel;
  ImageF tile;
  for (int i = 0; i < sheet.num_tiles(); ++i) {
    const auto part = [&](double from, double to) {
      return control.part((i + from) / sheet.num_tiles(), (i + to) / sheet.num_tiles());
    };
    const std::filesystem::path& coordinates = m.tiles[i].coordinates;
    if (sheet.num_tiles() > 1) tile = cut_tile(times, sheet, i);
    ImageF& own = sheet.num_tiles() > 1 ? tile : times;
    // A texel beside the charts has the color of the nearest one on them: its coordinates, and its time.
    dilate(own, covered(coordinates, m.width, m.height, quiet), -1);
    const CoordinateStrips strips(coordinates, m.width, m.height, history.width, history.height, strip_options,
                                  part(0.0, 0.3));
    ImageRowWriter writer(files[i], m.width, m.height, {.key = key, .num_threads = thread_count(control)});
    ImageF colors;
    strips.visit(
        [&](int first_row, const PlacesView& places, std::span<const std::uint32_t>) {
          const int num_rows = static_cast<int>(places.size() / static_cast<std::size_t>(m.width));
          if (colors.height() != num_rows) colors = ImageF(m.width, num_rows, 3);
          lookup.look_up(places, std::span<const float>(own.row(first_row).data(), places.size()), first_row, colors,
                         quiet);
          if (writer.takes_codes()) return writer.write(srgb8_from_linear(colors).values());
          writer.write(colors.values());
        },
        part(0.3, 1.0));
    writer.finish();
  }
}

}  // namespace patinate::transfer
