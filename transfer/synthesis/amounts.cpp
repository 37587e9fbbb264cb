#include "transfer/synthesis/amounts.h"

#include <algorithm>

#include "libcommon/core/parallel.h"

namespace patinate::transfer {

namespace {

constexpr std::int64_t kFewestPixels = 256;  // Fewest pixels of a control value: fewer say nothing about shares.
/// 1 in fixed point; excess and prices are clamped at multiples of it.
constexpr std::int32_t kAmountUnit = 256, kMost = 2 * kAmountUnit, kMostReuse = 3 * kAmountUnit,
                       kMaxPrice = 8 * kAmountUnit;

}  // namespace

void Amounts::Counts::add(const Counts& part) {
  for (std::size_t i = 0; i < has.size(); ++i) has[i] += part.has[i];
  uses.resize(part.uses.size(), 0);
  for (std::size_t i = 0; i < uses.size(); ++i) uses[i] += part.uses[i];
  num_texels += part.num_texels;
}

Amounts::Amounts(const SourceLevel& source)
    : look_(source.is_usable.size(), 0),
      width_(source.width()),
      columns_((source.width() + kCell_px - 1) / kCell_px),
      usable_in_(
          static_cast<std::size_t>(columns_) * static_cast<std::size_t>((source.height() + kCell_px - 1) / kCell_px),
          0),
      reuse_(usable_in_.size(), 0) {
  std::vector<std::int16_t> sorted;
  sorted.reserve(source.usable.size());
  const auto component = [&](std::int32_t p) { return source.appearance.data()[std::int64_t{p} * kAppearanceSize]; };
  for (std::int32_t p : source.usable) sorted.push_back(component(p));
  std::sort(sorted.begin(), sorted.end());
  for (std::int32_t p : source.usable) ++usable_in_[cell_of(p)];
  std::array<std::int16_t, kLooks - 1> limits{};
  for (std::size_t l = 0; l < limits.size(); ++l) limits[l] = sorted[(l + 1) * sorted.size() / kLooks];
  for (std::int32_t p : source.usable) {
    const int look = static_cast<int>(std::upper_bound(limits.begin(), limits.end(), component(p)) - limits.begin());
    look_[p] = static_cast<std::uint8_t>(look);
    ++wanted_[cell(value_of(source.controls.data()[std::int64_t{p} * source.controls.channels()]), look)];
  }
}

void Amounts::measure(const DestinationLevel& destination, const PlaceMap& places, const RunControl& control) {
  set(count(destination, places, control));
}

Amounts::Counts Amounts::count(const DestinationLevel& destination, const PlaceMap& places,
                               const RunControl& control) const {
  const auto num_texels = static_cast<std::int64_t>(destination.texels.size());
  Counts counts = parallel_reduce(
      num_texels, texels_a_count(usable_in_.size()), control, Counts{},
      [&](std::int64_t begin, std::int64_t end) {
        Counts part{.uses = std::vector<std::int64_t>(usable_in_.size(), 0), .num_texels = end - begin};
        auto at = destination.texels.from(static_cast<std::size_t>(begin));
        for (std::int64_t i = begin; i < end; ++i, ++at) {
          const std::int32_t pixel = places.pixels[*at];
          if (pixel < 0) continue;
          ++part.has[cell(value_of(destination.target(*at)[0]), look_[pixel])];
          ++part.uses[cell_of(pixel)];
        }
        return part;
      },
      [](Counts all, const Counts& part) {
        all.add(part);
        return all;
      });
  counts.uses.resize(usable_in_.size(), 0);
  return counts;
}

void Amounts::set(const Counts& counts) {
  set_reuse(counts);
  const Table& has = counts.has;
  for (int v = 0; v < kValues; ++v) {
    std::int64_t all_wanted = 0, all_has = 0;
    for (int l = 0; l < kLooks; ++l) {
      all_wanted += wanted_[cell(v, l)];
      all_has += has[cell(v, l)];
    }
    for (int l = 0; l < kLooks; ++l) {
      const std::size_t c = cell(v, l);
      if (all_wanted < kFewestPixels || all_has == 0) {
        excess_[c] = 0;
        continue;
      }
      // has / all_has over wanted / all_wanted, less one; one more pixel stands for looks that the source has not.
      const std::int64_t share = has[c] * all_wanted, due = (wanted_[c] + 1) * all_has;
      excess_[c] =
          static_cast<std::int32_t>(std::clamp<std::int64_t>((share - due) * kAmountUnit / due, -kAmountUnit, kMost));
    }
  }
  for (std::size_t c = 0; c < price_.size(); ++c) {
    price_[c] = std::clamp(excess_[c] + before_[c], -kMaxPrice, kMaxPrice);
    before_[c] = std::clamp(before_[c] + 2 * excess_[c], -kMaxPrice, kMaxPrice);
  }
}

void Amounts::set_reuse(const Counts& counts) {
  std::int64_t num_usable = 0;
  for (std::int32_t n : usable_in_) num_usable += n;
  for (std::size_t c = 0; c < counts.uses.size(); ++c) {
    const std::int64_t share = counts.num_texels * usable_in_[c] / num_usable,
                       unit = std::max<std::int64_t>({1, share, usable_in_[c]});
    reuse_[c] = static_cast<std::int32_t>(
        std::clamp<std::int64_t>((counts.uses[c] - unit) * kAmountUnit / unit, 0, kMostReuse));
  }
}

}  // namespace patinate::transfer
