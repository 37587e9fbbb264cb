/// \file
/// How coarse a surface's structure is: radial power spectrum and correlation length, block by block.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "analysis/figures/block_bootstrap.h"
#include "analysis/figures/color_stack.h"

namespace patinate::analysis {

/// Covariances take most of the time; without them there is no correlation length.
enum class SpatialFigures { All, Spectrum };

/// Structure of L* at one time.
class SpatialStructure {
 public:
  /// Spectra of square tiles that overlap by half, each with its mean removed and under a Hann window [Welch 1967];
  /// tiles that lie less than nine tenths on the surface are excluded. Covariances along rows, columns and both
  /// diagonals.
  SpatialStructure(const ColorStack& stack, std::size_t time, const BlockGrid& grid,
                   SpatialFigures figures = SpatialFigures::All);

  /// Side of a tile in pixels: the largest power of two up to a quarter of the shorter side, [8, 64].
  [[nodiscard]] int tile_px() const { return tile_px_; }
  /// Tiles that lie on the surface.
  [[nodiscard]] std::size_t num_tiles() const { return tiles_.size(); }
  /// Middle of every half-octave ring, cycles per pixel, ascending.
  [[nodiscard]] const std::vector<double>& frequencies() const { return frequencies_; }
  /// Mean power of every ring, L*^2: over all frequencies of a tile its mean is the variance of L*.
  /// @param weights  How often each block counts. @returns an empty list when no tile lies on the surface.
  [[nodiscard]] std::vector<double> spectrum(std::span<const int> weights) const;
  /// Distance at which the correlation falls to 1/e, pixels. @returns nothing when L* does not vary, or it does not
  /// fall so far within a third of the surface.
  [[nodiscard]] std::optional<double> correlation_length(std::span<const int> weights) const;

 private:
  struct Tile {
    std::uint16_t block;
    std::vector<double> power;
  };
  struct Sums {
    double count = 0.0, product = 0.0, sum = 0.0;  ///< Sums over pairs; `sum` is over both texels.
  };
  void add_tiles(const ColorStack& stack, const ImageF& values, const ImageU8& mask, const BlockGrid& grid);
  void add_pairs(const ColorStack& stack, const ImageF& values, const ImageU8& mask, const BlockGrid& grid);
  [[nodiscard]] std::vector<double> covariances(std::span<const int> weights, std::size_t direction) const;

  int tile_px_ = 0;
  std::size_t num_lags_ = 0;  ///< Lag 0 included.
  std::vector<double> frequencies_;
  std::vector<Tile> tiles_;
  std::vector<Sums> pairs_;  ///< [block][direction][lag]
};

}  // namespace patinate::analysis
