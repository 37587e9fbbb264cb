#include "transfer/lookup/texture_files.h"

#include <algorithm>
#include <memory>

#include "libcommon/core/error.h"
#include "libcommon/core/parallel.h"
#include "libcommon/image/color.h"
#include "libcommon/image/image_rows.h"

namespace patinate {

namespace {

/// One texture's file of one tile.
class TileOfTexture {
 public:
  TileOfTexture(const TextureFile& texture, const ImageU8& codes, std::size_t tile, const CoordinateStrips& strips)
      : texture_(texture), codes_(codes), writer_(texture.files[tile], strips.width(), strips.height(), texture.key) {
    constexpr std::size_t kTexels = 1 << 16, kRows = 16;  // Looked up and written while in the cache; rows that EXR compresses together.
    const auto width = static_cast<std::size_t>(strips.width());
    piece_ = (kTexels / width / kRows + 1) * kRows * width;
  }

  void write(std::span<const std::uint32_t> indices) {
    for (std::size_t i = 0; i < indices.size(); i += piece_) write_piece(indices.subspan(i, std::min(piece_, indices.size() - i)));
  }
  void finish() { writer_.finish(); }

 private:
  void write_piece(std::span<const std::uint32_t> indices) {
    if (writer_.takes_codes()) {
      bytes_.resize(3 * indices.size());
      gather_packed(codes_, indices, std::uint8_t{0}, bytes_);
      writer_.write(bytes_);
    } else {
      values_.resize(3 * indices.size());
      gather_packed(texture_.source, indices, 0.0f, values_);
      writer_.write(values_);
    }
  }
  const TextureFile& texture_;
  const ImageU8& codes_;
  ColorRowWriter writer_;
  std::size_t piece_;
  std::vector<std::uint8_t> bytes_;
  std::vector<float> values_;
};

}  // namespace

TextureWriter::TextureWriter(const TransferFolder& transfer, const CoordinateStripsOptions& options, const RunControl& control)
    : source_width_(transfer.history().manifest().width), source_height_(transfer.history().manifest().height) {
  const TransferManifest& m = transfer.manifest();
  CoordinateStripsOptions share = options;
  share.kept_texels /= static_cast<std::int64_t>(m.tiles.size());
  for (std::size_t i = 0; i < m.tiles.size(); ++i) {
    const auto num_tiles = static_cast<double>(m.tiles.size());
    tiles_.emplace_back(m.tiles[i].coordinates, m.width, m.height, source_width_, source_height_, share,
                        control.part(static_cast<double>(i) / num_tiles, (static_cast<double>(i) + 1.0) / num_tiles));
  }
}

void TextureWriter::write(std::span<const TextureFile> textures, const RunControl& control) const {
  std::vector<ImageU8> codes;
  for (const TextureFile& texture : textures) {
    if (texture.source.width() != source_width_ || texture.source.height() != source_height_ || texture.source.channels() != 3 || texture.files.size() != tiles_.size()) {
      throw InvalidInput("textures: expected a source of the history's size and a file for every tile");
    }
    // Codes of the source's pixels are those of the texels that show them, and there are fewer of them.
    const bool is_coded = std::any_of(texture.files.begin(), texture.files.end(), is_coded_image);
    codes.push_back(is_coded ? srgb8_from_linear(texture.source) : ImageU8());
  }
  for (std::size_t t = 0; t < tiles_.size(); ++t) {
    std::vector<std::unique_ptr<TileOfTexture>> open;
    for (std::size_t i = 0; i < textures.size(); ++i) open.push_back(std::make_unique<TileOfTexture>(textures[i], codes[i], t, tiles_[t]));
    RunControl quiet = control;
    quiet.on_progress = {};
    const auto num_tiles = static_cast<double>(tiles_.size());
    tiles_[t].visit(
        [&](int, std::span<const std::uint32_t> indices) {
          parallel_for(static_cast<std::int64_t>(open.size()), 1, quiet, [&](std::int64_t begin, std::int64_t) { open[static_cast<std::size_t>(begin)]->write(indices); });
        },
        control.part(static_cast<double>(t) / num_tiles, (static_cast<double>(t) + 1.0) / num_tiles));
    for (const auto& file : open) file->finish();
  }
}

}  // namespace patinate
