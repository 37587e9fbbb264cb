/// \file
/// For texels beside the charts the nearest covered one, exactly, strip by strip.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/image/image.h"

namespace patinate {

/// A texel that has no value yet.
inline constexpr std::uint32_t kNoValue = 0xFFFFFFFFu;

/// Fills kNoValue with the value of the Euclidean nearest texel that has one, in two rounds over strips of rows, so
/// that an atlas need not be in memory [separable distance transform: Meijster, Roerdink, Hesselink 2000, "A general
/// algorithm for computing distance transforms in linear time"]. The first round notes the first value of every column
/// from each strip's beginning on; the second fills. Equally near: the texel above before the one below in a column,
/// then the column further left. The strips' height changes no value, nor does the number of threads. Memory: 8 bytes a
/// column and strip, and 2 a texel of one strip. Cost: linear in the number of texels.
class GutterFill {
 public:
  /// @param width,height  [1, 65536]. @param strip_rows  >= 1; the last strip may be lower.
  GutterFill(int width, int height, int strip_rows);

  [[nodiscard]] int num_strips() const { return num_strips_; }
  /// Rows of a strip: [begin, end).
  [[nodiscard]] int begin(int strip) const { return strip * strip_rows_; }
  [[nodiscard]] int end(int strip) const;

  /// First round: strips in order. @param values  Of its rows.
  void look(std::span<const std::uint32_t> values);
  struct Covered {
    std::uint32_t value = kNoValue;
    std::int32_t row = -1;
  };
  /// How far a second round has come. Several may continue at once.
  struct Sweep {
    int strip = 0;
    std::vector<Covered> above = {};  ///< Per column: the last one above the strip.
  };
  /// Second round: strips in order, in place; begins once all have been looked at. Where nothing has a value kNoValue
  /// stays.
  void fill(std::span<std::uint32_t> values, Sweep& sweep, const RunControl& control = {}) const;

 private:
  void check(std::span<const std::uint32_t> values, int strip) const;
  void finish_looking();

  int width_, height_, strip_rows_, num_strips_;
  int num_seen_ = 0;            ///< Strips that have been looked at.
  std::vector<Covered> first_;  ///< Per strip and column: the first one from the strip's beginning on.
};

/// GutterFill of values in memory.
void fill_gutters(Image<std::uint32_t>& values, const RunControl& control = {});

}  // namespace patinate
