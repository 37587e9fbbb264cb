#include "app/output/reduced_transfer.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "patinate/image/color.h"

namespace patinate::app {

Sheet reduced_sheet(const Sheet& sheet, std::int64_t most) {
  Sheet reduced = sheet;
  for (int factor = 1; std::int64_t{reduced.width()} * reduced.height() > most && reduced.tile_width > 1; ++factor) {
    reduced.tile_width = std::max(1, sheet.tile_width / factor);
    reduced.tile_height = std::max(1, sheet.tile_height / factor);
  }
  return reduced;
}

ReducedTransfer::ReducedTransfer(std::shared_ptr<const transfer::TransferFolder> transfer, std::int64_t most,
                                 const RunControl& control)
    : transfer_(std::move(transfer)),
      sheet_(reduced_sheet(transfer_->sheet(), most)),
      textures_(*transfer_, transfer::CoordinateStripsOptions{.kept_texels = 0}, control) {}

ImageF ReducedTransfer::sample(double time, const RunControl& control) const {
  std::array<float, 256> light{};
  for (std::size_t code = 0; code < light.size(); ++code)
    light[code] = linear_from_srgb(static_cast<float>(code) / 255.0f);
  const Sheet& full = transfer_->sheet();
  const ImageF colors = transfer_->history().sample(time);
  const auto width = static_cast<std::size_t>(full.tile_width);
  // Reduced column and row that a texel counts for.
  std::vector<std::size_t> column(width);
  for (std::size_t x = 0; x < width; ++x) column[x] = x * static_cast<std::size_t>(sheet_.tile_width) / width;
  ImageF out(sheet_.width(), sheet_.height(), 3);
  const RunControl silent = control.silent();
  for (int tile = 0; tile < full.num_tiles(); ++tile) {
    ImageF sums(sheet_.tile_width, sheet_.tile_height, 3), counts(sheet_.tile_width, sheet_.tile_height);
    std::int64_t row = 0;
    textures_.gather_rows(
        static_cast<std::size_t>(tile), colors, transfer::color_codes,
        [&](std::span<const std::uint8_t> rows) {
          for (std::size_t at = 0; at < rows.size(); at += 3 * width, ++row) {
            const auto y = static_cast<int>(row * sheet_.tile_height / full.tile_height);
            for (std::size_t x = 0; x < width; ++x) {
              float* sum = sums.pixel(static_cast<int>(column[x]), y).data();
              for (std::size_t c = 0; c < 3; ++c) sum[c] += light[rows[at + 3 * x + c]];
              counts.at(static_cast<int>(column[x]), y) += 1.0f;
            }
          }
        },
        silent);
    for (std::int64_t i = 0; i < sums.num_pixels(); ++i) {
      for (std::int64_t c = 0; c < 3; ++c) sums.data()[3 * i + c] /= std::max(1.0f, counts.data()[i]);
    }
    paste_tile(out, sheet_, tile, sums);
    control.report(static_cast<double>(tile + 1) / full.num_tiles());
  }
  return out;
}

}  // namespace patinate::app
