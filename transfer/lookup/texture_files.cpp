#include "transfer/lookup/texture_files.h"

#include <algorithm>
#include <memory>

#include "libcommon/core/parallel.h"
#include "libcommon/image/image_rows.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"
#include "transfer/lookup/packed_lookup.h"
#include "transfer/lookup/source_turn.h"

namespace patinate::transfer {

namespace {

std::size_t channels_of(TextureKind kind) { return kind == TextureKind::Value ? 1 : 3; }

RowFormat format_of(const TextureFile& texture, int num_threads) {
  RowFormat format{.key = texture.key, .num_threads = num_threads};
  if (texture.kind == TextureKind::Color) return format;
  format.depth = ExrDepth::Float;
  if (texture.kind == TextureKind::Normal) format.channels = {"X", "Y", "Z"};
  if (texture.kind == TextureKind::Value) {
    format.channels = {"Y"};
    format.unit = texture.unit;
  }
  return format;
}

/// Codes of files that hold codes.
ImageU8 codes_of(TextureKind kind, const ImageF& values) {
  if (kind == TextureKind::Color) return color_codes(values);
  ImageU8 codes(values.width(), values.height(), values.channels());
  if (kind == TextureKind::Normal) {
    normal_codes(values.values(), codes.values());
    return codes;
  }
  for (std::size_t i = 0; i < codes.values().size(); ++i) {
    codes.data()[i] = static_cast<std::uint8_t>(255.0f * std::clamp(values.data()[i], 0.0f, 1.0f) +
                                                0.5f);  // NOLINT(bugprone-incorrect-roundings)
  }
  return codes;
}

/// Texels that are looked up and written while in the cache: rows that EXR compresses together.
std::size_t piece_size(const CoordinateStrips& strips) {
  constexpr std::size_t kPieceTexels = 1 << 16, kRows = kExrChunkRows;
  const auto width = static_cast<std::size_t>(strips.width());
  return (kPieceTexels / width / kRows + 1) * kRows * width;
}

/// One texture's file of one tile.
class TileOfTexture {
 public:
  /// @param num_threads  For what is compressed in it.
  TileOfTexture(const TextureFile& texture, const ImageU8& codes, std::size_t tile, const CoordinateStrips& strips,
                int num_threads)
      : texture_(texture),
        codes_(codes),
        writer_(texture.files[tile], strips.width(), strips.height(), format_of(texture, num_threads)),
        piece_(piece_size(strips)) {
    if (!writer_.takes_codes() && num_threads > 1) piece_ *= 2 * static_cast<std::size_t>(num_threads);
  }

  void write(const PlacesView& places, std::span<const std::uint32_t> turns) {
    // Codes of the source's pixels are those of the texels that show them, and there are fewer of them.
    is_of_codes_ = writer_.takes_codes() && texture_.kind != TextureKind::Normal && places.beside.empty();
    for (std::size_t i = 0; i < places.size(); i += piece_) {
      const std::size_t size = std::min(piece_, places.size() - i);
      write_piece(places.part(i, size), turns.empty() ? turns : turns.subspan(i, size));
    }
  }
  void finish() { writer_.finish(); }

 private:
  void write_piece(const PlacesView& places, std::span<const std::uint32_t> turns) {
    const std::size_t size = channels_of(texture_.kind) * places.size();
    if (is_of_codes_) {
      bytes_.resize(size);
      gather_packed(codes_, places.pixels, std::uint8_t{0}, bytes_);
      return writer_.write(bytes_);
    }
    if (values_.num_pixels() != static_cast<std::int64_t>(places.size()))
      values_ = ImageF(static_cast<int>(places.size()), 1, static_cast<int>(channels_of(texture_.kind)));
    gather_packed(texture_.source, places, 0.0f, values_.values());
    if (texture_.kind == TextureKind::Normal) {
      make_unit_between(places, values_.values());
      turn_normals(turns, values_.values());
    }
    if (!writer_.takes_codes()) return writer_.write(values_.values());
    writer_.write(codes_of(texture_.kind, values_).values());
  }
  const TextureFile& texture_;
  const ImageU8& codes_;
  ImageRowWriter writer_;
  std::size_t piece_;
  bool is_of_codes_ = false;
  std::vector<std::uint8_t> bytes_;
  ImageF values_;
};

}  // namespace

ImageU8 color_codes(const ImageF& linear) { return srgb8_from_linear(linear); }

TextureWriter::TextureWriter(const TransferFolder& transfer, const CoordinateStripsOptions& options,
                             const RunControl& control)
    : source_width_(transfer.history().manifest().width),
      source_height_(transfer.history().manifest().height),
      with_turns_(options.with_turns) {
  const TransferManifest& m = transfer.manifest();
  CoordinateStripsOptions share = options;
  share.kept_texels /= static_cast<std::int64_t>(m.tiles.size());
  share.is_subpixel = m.is_subpixel;
  for (std::size_t i = 0; i < m.tiles.size(); ++i) {
    const auto num_tiles = static_cast<double>(m.tiles.size());
    tiles_.emplace_back(m.tiles[i].coordinates, m.width, m.height, source_width_, source_height_, share,
                        control.part(static_cast<double>(i) / num_tiles, (static_cast<double>(i) + 1.0) / num_tiles));
  }
}

void TextureWriter::write(std::span<const TextureFile> textures, const RunControl& control) const {
  std::vector<ImageU8> codes;
  for (const TextureFile& texture : textures) {
    if (texture.source.width() != source_width_ || texture.source.height() != source_height_ ||
        static_cast<std::size_t>(texture.source.channels()) != channels_of(texture.kind) ||
        texture.files.size() != tiles_.size()) {
      throw InvalidInput("textures: expected a source of the history's size and a file for every tile");
    }
    if (texture.kind == TextureKind::Normal && !with_turns_)
      throw InvalidInput("textures: normals need to know how patches lie");
    const bool is_coded = std::any_of(texture.files.begin(), texture.files.end(), is_coded_image);
    codes.push_back(is_coded && texture.kind != TextureKind::Normal ? codes_of(texture.kind, texture.source)
                                                                    : ImageU8());
  }
  for (std::size_t t = 0; t < tiles_.size(); ++t) {
    std::vector<std::unique_ptr<TileOfTexture>> open;
    const int threads_each =
        std::max(1, thread_count(control) / static_cast<int>(std::max<std::size_t>(1, textures.size())));
    for (std::size_t i = 0; i < textures.size(); ++i)
      open.push_back(std::make_unique<TileOfTexture>(textures[i], codes[i], t, tiles_[t], threads_each));
    const RunControl quiet = control.silent();
    const auto num_tiles = static_cast<double>(tiles_.size());
    tiles_[t].visit(
        [&](int, const PlacesView& places, std::span<const std::uint32_t> turns) {
          parallel_for(static_cast<std::int64_t>(open.size()), 1, quiet,
                       [&](std::int64_t begin, std::int64_t) { open[begin]->write(places, turns); });
        },
        control.part(static_cast<double>(t) / num_tiles, (static_cast<double>(t) + 1.0) / num_tiles));
    for (const auto& file : open) file->finish();
  }
}

void TextureWriter::check_size(int width, int height) const {
  if (width != source_width_ || height != source_height_)
    throw InvalidInput("textures: expected a source of the history's size");
}

void TextureWriter::gather_rows(std::size_t tile, const ImageF& values, const Encode& encode, const TakeRows& take,
                                const RunControl& control) const {
  check_size(values.width(), values.height());
  const std::size_t piece = piece_size(tiles_.at(tile));
  const ImageU8 codes = encode(values);
  const auto channels = static_cast<std::size_t>(codes.channels());
  std::vector<std::uint8_t> bytes;
  tiles_[tile].visit(
      [&](int, const PlacesView& places, std::span<const std::uint32_t>) {
        for (std::size_t i = 0; i < places.size(); i += piece) {
          control.throw_if_stopped();  // Whoever takes the rows packs them, which is slower than finding them.
          const PlacesView part = places.part(i, std::min(piece, places.size() - i));
          if (part.beside.empty()) {
            bytes.resize(channels * part.size());
            gather_packed(codes, part.pixels, std::uint8_t{0}, bytes);
            take(bytes);
          } else {
            ImageF between(static_cast<int>(part.size()), 1, values.channels());
            gather_packed(values, part, 0.0f, between.values());
            take(encode(between).values());
          }
        }
      },
      control);
}

void TextureWriter::normal_rows(std::size_t tile, const ImageF& normals, const TakeRows& take,
                                const RunControl& control) const {
  check_size(normals.width(), normals.height());
  if (!with_turns_ || normals.channels() != 3)
    throw InvalidInput("textures: normals have three channels and need to know how patches lie");
  const std::size_t piece = piece_size(tiles_.at(tile));
  std::vector<float> values;
  std::vector<std::uint8_t> bytes;
  tiles_[tile].visit(
      [&](int, const PlacesView& places, std::span<const std::uint32_t> turns) {
        for (std::size_t i = 0; i < places.size(); i += piece) {
          control.throw_if_stopped();
          const std::size_t size = std::min(piece, places.size() - i);
          values.resize(3 * size);
          bytes.resize(3 * size);
          gather_packed(normals, places.part(i, size), 0.0f, values);
          make_unit_between(places.part(i, size), values);
          turn_normals(turns.empty() ? turns : turns.subspan(i, size), values);
          normal_codes(values, bytes);
          take(bytes);
        }
      },
      control);
}

}  // namespace patinate::transfer
