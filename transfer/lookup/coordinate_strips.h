/// \file
/// The coordinates of one tile strip by strip, gutters filled: an atlas of any size in a few megabytes.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "patinate/core/run_control.h"
#include "transfer/lookup/packed_lookup.h"

namespace patinate {
class ImageRowReader;
}  // namespace patinate

namespace patinate::transfer {

struct CoordinateStripsOptions {
  std::int64_t kept_texels =
      std::int64_t{1} << 24;  ///< An atlas of at most so many stays in memory (4 to 12 bytes each) and is decoded once.
  std::int64_t strip_texels = std::int64_t{1} << 21;  ///< About as many in a strip; >= 1.
  bool is_subpixel = false;  ///< Places may lie between pixels (TransferManifest::is_subpixel).
  bool with_turns = false;   ///< Read how patches lie, too (source_turn.h), where the file says it.
};

/// Lookups beside the charts are those of the nearest texel of a chart (GutterFill), so that filtering does not bleed.
/// Thread-safe.
class CoordinateStrips {
 public:
  /// Decodes the file once and checks every texel.
  /// @param file           With channels source.x and source.y. @param width,height  That it should have.
  /// @param source_width,source_height  Of the history.
  /// @throws IoError if the file is damaged, of another size, or points outside the source.
  CoordinateStrips(std::filesystem::path file, int width, int height, int source_width, int source_height,
                   const CoordinateStripsOptions& options = {}, const RunControl& control = {});

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  /// @param visitor  Called with strips from top to bottom: whole rows; kNoValue only if no texel is covered.
  /// @param turns  As many as places, pack_turn(); empty unless they were asked for and the file has them.
  using Visitor = std::function<void(int first_row, const PlacesView& places, std::span<const std::uint32_t> turns)>;
  /// @throws IoError if the file has changed or gone meanwhile.
  void visit(const Visitor& visitor, const RunControl& control = {}) const;

 private:
  /// A number a texel.
  struct Layer {
    GutterFill gutters;
    Image<std::uint32_t> kept = {};  ///< Filled; empty when the file is to be read again.
  };
  enum Kind { kPixels, kBeside, kTurns, kNumKinds };
  using Rows = std::array<std::span<std::uint32_t>, kNumKinds>;  ///< Empty where a layer is not there.
  using Room = std::array<std::vector<std::uint32_t>, kNumKinds>;

  /// @returns whether a place lies beside the middle of its pixel.
  bool read(ImageRowReader& file, int strip, const Rows& rows) const;
  [[nodiscard]] Rows rows_in(Room& room, int strip) const;
  [[nodiscard]] std::size_t strip_size(int strip) const;
  [[nodiscard]] std::vector<std::string> channels() const;

  std::filesystem::path file_;
  int width_, height_, source_width_, source_height_;
  std::array<std::optional<Layer>, kNumKinds> layers_;  ///< All find the same texels beside the charts.
};

}  // namespace patinate::transfer
