#include "patinate/transfer/control_matching.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "libcommon/core/parallel.h"
#include "patinate/core/error.h"

namespace patinate::transfer {

namespace {

/// By parts that are merged, so that a stop is noticed between them.
void sort_values(std::vector<float>& values, const RunControl& control) {
  constexpr std::int64_t kPart = 65536;
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

/// match_control() into the texels of the mask alone.
void match_inside(const ImageF& destination, const ImageU8& destination_mask, const ControlRange& destination_range,
                  const ImageF& source, const ImageU8& source_mask, const ControlRange& source_range,
                  ControlMapping mapping, ImageF& result, const RunControl& control) {
  RunControl silent = control;
  silent.on_progress = nullptr;
  const std::vector<float> from = values_inside(destination, destination_mask, silent);
  const std::vector<float> to = values_inside(source, source_mask, silent);
  if (mapping == ControlMapping::Physical) check_units(destination_range.unit, source_range.unit);
  const auto mapped = [&](float value) -> double {
    const double v = static_cast<double>(value);
    switch (mapping) {
      case ControlMapping::Rank: {
        const auto [low, high] = std::equal_range(from.begin(), from.end(), value);
        const double rank = 0.5 * static_cast<double>((low - from.begin()) + (high - from.begin()));
        return quantile(to, rank / static_cast<double>(from.size()));
      }
      case ControlMapping::Linear: {
        const double low = static_cast<double>(from.front()), span = static_cast<double>(from.back()) - low;
        const double fraction = span > 0.0 ? (v - low) / span : 0.5;
        return static_cast<double>(to.front()) + fraction * static_cast<double>(to.back() - to.front());
      }
      case ControlMapping::Physical: {
        const double physical = destination_range.low + v * (destination_range.high - destination_range.low);
        const double span = source_range.high - source_range.low;
        return span != 0.0 ? (physical - source_range.low) / span : 0.0;
      }
    }
    return v;
  };
  constexpr std::int64_t kRows = 8;
  parallel_for(result.height(), kRows, silent, [&](std::int64_t begin, std::int64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < result.width(); ++x) {
        if (is_inside(destination_mask, x, y))
          result.at(x, y) = static_cast<float>(std::clamp(mapped(destination.at(x, y)), 0.0, 1.0));
      }
    }
  });
}

}  // namespace

SuitedMapping suited_mapping(const ImageF& values, const ImageU8& mask) {
  constexpr double kTie = 0.1, kMostTied = 0.5, kMostOfOneValue = 0.25;
  constexpr std::int64_t kMostLookedAt = 1 << 18;
  const std::int64_t stride = std::max<std::int64_t>(1, values.num_pixels() / kMostLookedAt) | 1;
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
  const bool is_linear = largest < 1.0 && (tied >= kMostTied || largest >= kMostOfOneValue);
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
