#include "analysis/factorization/factor_quantity.h"

#include <algorithm>
#include <vector>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

bool has_extra(const FrameFacts& frame, const std::string& name) {
  return std::find(frame.extras.begin(), frame.extras.end(), name) != frame.extras.end();
}

/// Names of the quantities that every frame has.
std::string quantities_of(const HistoryFacts& facts) {
  std::string list = "color";
  for (const FactorQuantity q :
       {FactorQuantity::Roughness, FactorQuantity::Specular, FactorQuantity::Metalness, FactorQuantity::Height}) {
    if (std::all_of(facts.frames.begin(), facts.frames.end(),
                    [&](const FrameFacts& f) { return has_extra(f, place_of(q).extra); }))
      list += ", " + name_of(q);
  }
  return list;
}

}  // namespace

std::string name_of(FactorQuantity quantity) {
  return std::string(kFactorQuantityNames[static_cast<std::size_t>(quantity)]);
}

FactorQuantity parse_factor_quantity(const std::string& name) {
  const auto found = std::find(kFactorQuantityNames.begin(), kFactorQuantityNames.end(), name);
  if (found == kFactorQuantityNames.end())
    throw InvalidInput("of: found `" + name + "`; expected color, roughness, specular, metalness or height");
  return static_cast<FactorQuantity>(found - kFactorQuantityNames.begin());
}

QuantityPlace place_of(FactorQuantity quantity) {
  if (quantity == FactorQuantity::Specular) return {"specular", 0};
  if (quantity == FactorQuantity::Roughness) return {"specular", 1};
  return {name_of(quantity), 0};
}

QuantityHistory::QuantityHistory(const HistoryReader& source, FactorQuantity quantity)
    : source_(source), quantity_(quantity), facts_(source.facts()) {
  for (FrameFacts& frame : facts_.frames) {
    if (!has_extra(frame, place_of(quantity).extra))
      throw InvalidInput(source.label() + ": not every frame has a map of " + name_of(quantity) +
                         "; all of them have " + quantities_of(source.facts()));
    frame.extras.clear();
    frame.has_mask = frame.has_mask || quantity == FactorQuantity::Roughness;
  }
}

ImageF QuantityHistory::load_frame(std::size_t frame) const {
  const QuantityPlace place = place_of(quantity_);
  const ImageF map = *source_.read_frame_extra(static_cast<int>(frame), place.extra);
  ImageF out(map.width(), map.height(), 3);
  for (std::int64_t i = 0; i < map.num_pixels(); ++i)
    std::fill_n(out.data() + 3 * i, 3, map.data()[i * map.channels() + place.channel]);
  return out;
}

ImageF QuantityHistory::load_frame_extra(std::size_t frame, std::size_t extra) const {
  return *source_.read_frame_extra(static_cast<int>(frame), facts_.frames[frame].extras[extra]);
}

ImageU8 QuantityHistory::load_frame_mask(std::size_t frame) const {
  ImageU8 mask = source_.read_frame_mask(static_cast<int>(frame));
  if (quantity_ != FactorQuantity::Roughness) return mask;
  const ImageF roughness = load_frame(frame);
  for (std::int64_t i = 0; i < mask.num_pixels(); ++i) {
    if (!(roughness.data()[3 * i] > 0.0f)) mask.data()[i] = 0;
  }
  return mask;
}

}  // namespace patinate::analysis
