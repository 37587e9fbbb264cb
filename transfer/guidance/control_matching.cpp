#include "patinate/transfer/control_matching.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "libcommon/core/parallel.h"
#include "patinate/core/error.h"

namespace patinate::transfer {

namespace {

/// In order.
void sort_values(std::vector<float>& values, const RunControl& control) {
  constexpr std::int64_t kPart = 65536;  // Values that a thread sorts at once; results do not depend on it.
  const auto n = static_cast<std::int64_t>(values.size());
  const auto at = [&](std::int64_t i) { return values.begin() + static_cast<std::ptrdiff_t>(std::min(i, n)); };
  parallel_for(n, kPart, control, [&](std::int64_t begin, std::int64_t end) { std::sort(at(begin), at(end)); });
  for (std::int64_t size = kPart; size < n; size *= 2) {
    parallel_for((n + 2 * size - 1) / (2 * size), 1, control, [&](std::int64_t pair, std::int64_t) {
      std::inplace_merge(at(pair * 2 * size), at((pair * 2 + 1) * size), at((pair + 1) * 2 * size));
    });
  }
}

std::vector<float> values_inside(const ImageF& image, const ImageU8& mask, const RunControl& control) {
  std::vector<float> values;
  values.reserve(mask.empty() ? image.values().size()
                              : static_cast<std::size_t>(std::count_if(mask.values().begin(), mask.values().end(),
                                                                       [](std::uint8_t m) { return m != 0; })));
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      if (is_inside(mask, x, y)) values.push_back(image.at(x, y));
    }
  }
  if (values.empty()) throw InvalidInput("a control map is empty: its mask leaves no pixel");
  sort_values(values, control);
  return values;
}

bool is_relative(const std::string& unit) { return unit.empty() || unit == "relative"; }

void check_units(const std::string& destination, const std::string& source) {
  if (is_relative(source)) {
    throw InvalidInput("mapping `physical` needs a unit, and the history's control is relative; use rank or linear");
  }
  if (is_relative(destination) || destination == source) return;
  throw InvalidInput("mapping `physical` needs equal units: the history's control is in `" + source +
                     "`, the destination's in `" + destination + "`; use rank or linear");
}

/// Value at a fraction of sorted values, linear between them.
double quantile(const std::vector<float>& sorted, double fraction) {
  const double position =
      std::clamp(fraction * static_cast<double>(sorted.size()) - 0.5, 0.0, static_cast<double>(sorted.size() - 1));
  const auto index = static_cast<std::size_t>(position);
  const double next = static_cast<double>(sorted[std::min(index + 1, sorted.size() - 1)]);
  const double here = static_cast<double>(sorted[index]);
  return here + (position - static_cast<double>(index)) * (next - here);
}

/// Facts of all values of a destination.
struct ControlValues {
  std::int64_t count = 0;  ///< > 0
  float least = 0.0f, greatest = 0.0f;
};

/// match_control() value by value.
class ControlMatcher {
 public:
  /// @throws InvalidInput as match_control().
  ControlMatcher(const ControlValues& destination, const ControlRange& destination_range, const ImageF& source,
                 const ImageU8& source_mask, const ControlRange& source_range, ControlMapping mapping,
                 const RunControl& control);

  [[nodiscard]] bool needs_ranks() const { return mapping_ == ControlMapping::Rank; }
  /// @param num_below,num_up_to  Of the destination's values, those < and <= this one; looked at where needs_ranks().
  [[nodiscard]] float operator()(float value, std::int64_t num_below, std::int64_t num_up_to) const;

 private:
  ControlValues from_;
  ControlRange from_range_, to_range_;
  ControlMapping mapping_;
  std::vector<float> to_;  ///< Sorted.
};

ControlMatcher::ControlMatcher(const ControlValues& destination, const ControlRange& destination_range,
                               const ImageF& source, const ImageU8& source_mask, const ControlRange& source_range,
                               ControlMapping mapping, const RunControl& control)
    : from_(destination),
      from_range_(destination_range),
      to_range_(source_range),
      mapping_(mapping),
      to_(values_inside(source, source_mask, control)) {
  if (mapping == ControlMapping::Physical) check_units(destination_range.unit, source_range.unit);
}

float ControlMatcher::operator()(float value, std::int64_t num_below, std::int64_t num_up_to) const {
  const double v = static_cast<double>(value);
  double mapped = v;
  switch (mapping_) {
    case ControlMapping::Rank: {
      const double rank = 0.5 * static_cast<double>(num_below + num_up_to);
      mapped = quantile(to_, rank / static_cast<double>(from_.count));
      break;
    }
    case ControlMapping::Linear: {
      const double low = static_cast<double>(from_.least), span = static_cast<double>(from_.greatest) - low;
      const double fraction = span > 0.0 ? (v - low) / span : 0.5;
      mapped = static_cast<double>(to_.front()) + fraction * static_cast<double>(to_.back() - to_.front());
      break;
    }
    case ControlMapping::Physical: {
      const double physical = from_range_.low + v * (from_range_.high - from_range_.low);
      const double span = to_range_.high - to_range_.low;
      mapped = span != 0.0 ? (physical - to_range_.low) / span : 0.0;
      break;
    }
  }
  return static_cast<float>(std::clamp(mapped, 0.0, 1.0));
}

/// Where a value lies among sorted ones: std::equal_range(), begun near by. Texels ask in no order, and a search over
/// all of them waits for memory at each of its steps.
class Ranks {
 public:
  explicit Ranks(const std::vector<float>& sorted) : sorted_(sorted), low_(static_cast<double>(sorted.front())) {
    const double span = static_cast<double>(sorted.back()) - low_;
    scale_ = span > 0.0 ? kCells / span : 0.0;
    begin_.reserve(kCells + 2);
    for (std::size_t i = 0; i < sorted.size(); ++i) {
      while (begin_.size() <= cell_of(sorted[i])) begin_.push_back(i);
    }
    begin_.resize(kCells + 2, sorted.size());
  }
  /// @param value  Within the sorted ones' range. @returns how many are below, and how many are not above it.
  [[nodiscard]] std::pair<std::int64_t, std::int64_t> of(float value) const {
    const std::size_t cell = cell_of(value);
    const auto at = [&](std::size_t c) { return sorted_.begin() + static_cast<std::ptrdiff_t>(begin_[c]); };
    const auto [low, high] = std::equal_range(at(cell), at(cell + 1), value);
    return {low - sorted_.begin(), high - sorted_.begin()};
  }

 private:
  static constexpr int kCells = 1 << 16;  ///< Cells of the table that finds a value's rank; speed alone.
  /// Rises with the value: equal values share one.
  [[nodiscard]] std::size_t cell_of(float value) const {
    return static_cast<std::size_t>(std::clamp((static_cast<double>(value) - low_) * scale_, 0.0, double{kCells}));
  }

  const std::vector<float>& sorted_;
  double low_, scale_ = 0.0;
  std::vector<std::size_t> begin_;  ///< By cell.
};

/// match_control() into the texels of the mask alone.
void match_inside(const ImageF& destination, const ImageU8& destination_mask, const ControlRange& destination_range,
                  const ImageF& source, const ImageU8& source_mask, const ControlRange& source_range,
                  ControlMapping mapping, ImageF& result, const RunControl& control) {
  RunControl silent = control;
  silent.on_progress = nullptr;
  const std::vector<float> from = values_inside(destination, destination_mask, silent);
  const ControlMatcher matched({static_cast<std::int64_t>(from.size()), from.front(), from.back()}, destination_range,
                               source, source_mask, source_range, mapping, silent);
  const Ranks ranks(from);
  const auto all = static_cast<std::int64_t>(from.size());
  constexpr std::int64_t kRows = 8;
  parallel_for(result.height(), kRows, silent, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < result.width(); ++x) {
        if (!is_inside(destination_mask, x, y)) continue;
        const float value = destination.at(x, y);
        const auto [below, up_to] = matched.needs_ranks() ? ranks.of(value) : std::pair(std::int64_t{0}, all);
        result.at(x, y) = matched(value, below, up_to);
      }
    }
  });
}

}  // namespace

SuitedMapping suited_mapping(const ImageF& values, const ImageU8& mask) {
  // Few values, as painted maps have (docs/algorithms/control_matching.md).
  constexpr double kTie = 0.1, kMaxTied = 0.5, kMaxOfOneValue = 0.25;
  constexpr std::int64_t kMaxLookedAt = 1 << 18;  // Pixels that are looked at, evenly picked.
  const std::int64_t stride = std::max<std::int64_t>(1, values.num_pixels() / kMaxLookedAt) | 1;
  std::vector<float> sorted;
  for (std::int64_t i = 0; i < values.num_pixels(); i += stride) {
    if (mask.empty() || mask.data()[i] != 0) sorted.push_back(values.data()[i]);
  }
  std::sort(sorted.begin(), sorted.end());
  const auto total = static_cast<double>(sorted.size());
  double tied = 0.0, largest = 0.0;
  for (auto begin = sorted.begin(); begin != sorted.end();) {
    const auto end = std::upper_bound(begin, sorted.end(), *begin);
    const double share = static_cast<double>(end - begin) / total;
    if (share >= kTie) tied += share;
    largest = std::max(largest, share);
    begin = end;
  }
  // One value everywhere decides nothing: the middle of the source, by either mapping.
  const bool is_linear = largest < 1.0 && (tied >= kMaxTied || largest >= kMaxOfOneValue);
  return {.mapping = is_linear ? ControlMapping::Linear : ControlMapping::Rank, .tied_share = tied};
}

ImageF match_control(const ImageF& destination, const ImageU8& destination_mask, const ControlRange& destination_range,
                     const ImageF& source, const ImageU8& source_mask, const ControlRange& source_range,
                     ControlMapping mapping, const RunControl& control) {
  ImageF result(destination.width(), destination.height());
  match_inside(destination, destination_mask, destination_range, source, source_mask, source_range, mapping, result,
               control);
  return result;
}

ImageF match_control_by_label(const ImageF& destination, const ImageU8& destination_labels,
                              const ControlRange& destination_range, const ImageF& source, const ImageU8& source_labels,
                              const ControlRange& source_range, ControlMapping mapping, const RunControl& control) {
  const auto mask_of = [](const ImageU8& labels, std::uint8_t label) {
    ImageU8 mask(labels.width(), labels.height());
    std::transform(labels.values().begin(), labels.values().end(), mask.values().begin(),
                   [&](std::uint8_t l) { return static_cast<std::uint8_t>(l == label ? 255 : 0); });
    return mask;
  };
  std::array<bool, 256> is_there{};
  for (std::uint8_t label : destination_labels.values()) is_there[label] = true;
  ImageF result(destination.width(), destination.height());
  for (std::size_t label = 1; label < is_there.size(); ++label) {
    if (!is_there[label]) continue;
    match_inside(destination, mask_of(destination_labels, static_cast<std::uint8_t>(label)), destination_range, source,
                 mask_of(source_labels, static_cast<std::uint8_t>(label)), source_range, mapping, result, control);
  }
  return result;
}

}  // namespace patinate::transfer
