#include "libcommon/atlas/gutter_fill.h"

#include <algorithm>

#include "libcommon/core/parallel.h"
#include "patinate/atlas/sheet.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

constexpr std::uint32_t kNoDistance = 1u << 20;  ///< Rows; more than any image has.

/// Along one row: the nearest texel of all columns' nearest ones.
class RowEnvelope {
 public:
  explicit RowEnvelope(std::size_t width) : columns_(width), starts_(width), values_(width) {}

  /// @param values   In place: each column's nearest value. @param distance  Its distance in rows; kNoDistance = none.
  void fill(std::span<std::uint32_t> values, std::span<const std::uint32_t> distance) {
    const auto width = static_cast<std::int64_t>(values.size());
    const auto g = [&](std::int64_t x) { return std::int64_t{distance[x]}; };
    const auto cost = [&](std::int64_t x, std::int64_t column) {
      return (x - column) * (x - column) + g(column) * g(column);
    };
    std::ptrdiff_t top = -1;  // Parabolas that are lowest somewhere, from left to right, and where each begins to be.
    for (std::int64_t u = 0; u < width; ++u) {
      if (g(u) >= kNoDistance) continue;
      while (top >= 0 && cost(starts_[top], columns_[top]) > cost(starts_[top], u)) --top;
      std::int64_t start = 0;
      if (top >= 0) {
        const std::int64_t i = columns_[top];
        // The last x at which the left one is as near; not negative, since it is lower at its own start.
        start = (u * u - i * i + g(u) * g(u) - g(i) * g(i)) / (2 * (u - i)) + 1;
        if (start >= width) continue;
      }
      ++top;
      columns_[top] = u;
      starts_[top] = start;
    }
    if (top < 0) return;
    std::copy(values.begin(), values.end(), values_.begin());
    for (std::int64_t x = width - 1; x >= 0; --x) {
      values[x] = values_[columns_[static_cast<std::size_t>(top)]];
      if (x == starts_[top]) --top;
    }
  }

 private:
  std::vector<std::int64_t> columns_, starts_;
  std::vector<std::uint32_t> values_;
};

}  // namespace

GutterFill::GutterFill(int width, int height, int strip_rows)
    : width_(width),
      height_(height),
      strip_rows_(strip_rows),
      num_strips_(strip_rows > 0 ? (height + strip_rows - 1) / strip_rows : 0) {
  if (width < 1 || height < 1 || width > Sheet::kMaxSide || height > Sheet::kMaxSide || strip_rows < 1) {
    throw InvalidInput("gutters: an atlas of " + std::to_string(width) + " x " + std::to_string(height) +
                       " in strips of " + std::to_string(strip_rows) +
                       " rows; use sides in [1, 65536] and at least a row");
  }
  first_.resize(static_cast<std::size_t>(num_strips_) * static_cast<std::size_t>(width_));
}

int GutterFill::end(int strip) const { return std::min(height_, (strip + 1) * strip_rows_); }

void GutterFill::check(std::span<const std::uint32_t> values, int strip) const {
  const auto expected = static_cast<std::size_t>(end(strip) - begin(strip)) * static_cast<std::size_t>(width_);
  if (values.size() != expected)
    throw InvalidInput("gutters: a strip has " + std::to_string(values.size()) + " texels; expected " +
                       std::to_string(expected));
}

void GutterFill::look(std::span<const std::uint32_t> values) {
  if (num_seen_ == num_strips_) throw InvalidInput("gutters: all strips have been looked at");
  check(values, num_seen_);
  const auto width = static_cast<std::size_t>(width_);
  Covered* const first = first_.data() + static_cast<std::size_t>(num_seen_) * width;
  for (int y = begin(num_seen_); y < end(num_seen_); ++y) {
    const std::uint32_t* const row = values.data() + static_cast<std::size_t>(y - begin(num_seen_)) * width;
    for (std::size_t x = 0; x < width; ++x) {
      if (first[x].row < 0 && row[x] != kNoValue) first[x] = {row[x], y};
    }
  }
  if (++num_seen_ == num_strips_) finish_looking();
}

void GutterFill::finish_looking() {
  const auto width = static_cast<std::size_t>(width_);
  for (std::size_t i = first_.size() - width; i-- > 0;) {
    if (first_[i].row < 0) first_[i] = first_[i + width];
  }
}

void GutterFill::fill(std::span<std::uint32_t> values, Sweep& sweep, const RunControl& control) const {
  if (num_seen_ < num_strips_ || sweep.strip >= num_strips_)
    throw InvalidInput("gutters: look at every strip first, then fill each once");
  check(values, sweep.strip);
  const RunControl quiet = control.silent();
  const auto width = static_cast<std::size_t>(width_);
  if (sweep.strip == 0) sweep.above.assign(width, {});
  const int first_row = begin(sweep.strip), num_rows = end(sweep.strip) - first_row;
  std::vector<std::uint32_t> distance(values.size());
  const Covered* const below =
      sweep.strip + 1 < num_strips_ ? first_.data() + static_cast<std::size_t>(sweep.strip + 1) * width : nullptr;
  parallel_for(width_, 2048, quiet, [&](std::int64_t from, std::int64_t to) {
    const auto x0 = static_cast<std::size_t>(from), x1 = static_cast<std::size_t>(to);
    for (int y = 0; y < num_rows; ++y) {  // Above, or here.
      const std::size_t row = static_cast<std::size_t>(y) * width;
      for (std::size_t x = x0; x < x1; ++x) {
        Covered& above = sweep.above[x];
        if (values[row + x] != kNoValue) {
          above = {values[row + x], first_row + y};
          distance[row + x] = 0;
        } else {
          values[row + x] = above.value;
          distance[row + x] = above.row < 0 ? kNoDistance : static_cast<std::uint32_t>(first_row + y - above.row);
        }
      }
    }
    std::vector<Covered> next(x1 - x0);
    if (below != nullptr) std::copy(below + x0, below + x1, next.begin());
    for (int y = num_rows - 1; y >= 0; --y) {
      const std::size_t row = static_cast<std::size_t>(y) * width;
      for (std::size_t x = x0; x < x1; ++x) {
        Covered& covered = next[x - x0];
        if (distance[row + x] == 0) {
          covered = {values[row + x], first_row + y};
        } else if (covered.row >= 0 && static_cast<std::uint32_t>(covered.row - first_row - y) < distance[row + x]) {
          values[row + x] = covered.value;
          distance[row + x] = static_cast<std::uint32_t>(covered.row - first_row - y);
        }
      }
    }
  });
  parallel_for(num_rows, 16, quiet, [&](std::int64_t from, std::int64_t to) {
    RowEnvelope envelope(width);
    for (std::int64_t y = from; y < to; ++y) {
      const std::size_t row = static_cast<std::size_t>(y) * width;
      const std::span<const std::uint32_t> d(distance.data() + row, width);
      if (std::any_of(d.begin(), d.end(), [](std::uint32_t v) { return v != 0; }))
        envelope.fill(values.subspan(row, width), d);
    }
  });
  ++sweep.strip;
}

void fill_gutters(Image<std::uint32_t>& values, const RunControl& control) {
  constexpr int kStripRows = 256;
  GutterFill gutters(values.width(), values.height(), kStripRows);
  GutterFill::Sweep sweep;
  const auto strip_of = [&](int strip) {
    return std::span(
        values.row(gutters.begin(strip)).data(),
        static_cast<std::size_t>(gutters.end(strip) - gutters.begin(strip)) * static_cast<std::size_t>(values.width()));
  };
  for (int s = 0; s < gutters.num_strips(); ++s) gutters.look(strip_of(s));
  for (int s = 0; s < gutters.num_strips(); ++s) gutters.fill(strip_of(s), sweep, control);
}

}  // namespace patinate
