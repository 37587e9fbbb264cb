/// \file
/// The coordinates of one tile strip by strip, gutters filled: an atlas of any size in a few megabytes.
#pragma once

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
      std::int64_t{1} << 24;  ///< An atlas of at most so many stays in memory (4 bytes each) and is decoded once.
  std::int64_t strip_texels = std::int64_t{1} << 21;  ///< About as many in a strip; >= 1.
  bool with_turns = false;  ///< Read how patches lie, too (source_turn.h), where the file says it.
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
  /// @param turns  As many as indices, pack_turn(); empty unless they were asked for and the file has them.
  using Visitor =
      std::function<void(int first_row, std::span<const std::uint32_t> indices, std::span<const std::uint32_t> turns)>;
  /// @throws IoError if the file has changed or gone meanwhile.
  void visit(const Visitor& visitor, const RunControl& control = {}) const;

 private:
  void read(ImageRowReader& file, int strip, std::span<std::uint32_t> indices, std::span<std::uint32_t> turns) const;
  [[nodiscard]] std::size_t strip_size(int strip) const;
  [[nodiscard]] std::vector<std::string> channels() const;

  std::filesystem::path file_;
  int width_, height_, source_width_, source_height_;
  bool has_turns_ = false;
  GutterFill gutters_;
  std::optional<GutterFill> turn_gutters_;  ///< Finds the same texels, and remembers how patches lie there.
  PackedCoordinates kept_;                  ///< Filled; empty when the file is to be read again.
  Image<std::uint32_t> kept_turns_;
};

}  // namespace patinate::transfer
