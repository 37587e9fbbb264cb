#include "patinate/history/history_sampling.h"

#include <array>

namespace patinate {

namespace {
constexpr std::array<std::string_view, 3> kBetweenNames{"blend", "hold", "nearest"};
}

void describe(OptionVisitor& v, SamplingOptions& o) {
  v.visit_choice({"between", "Between two frames: their blend, the one before, or the nearest"}, o.between,
                 kBetweenNames);
}

TimePosition locate(const History& history, double time, Between between) {
  const TimePosition position = history.locate(time);
  if (between == Between::Blend) return position;
  const bool is_later = between == Between::Nearest && position.fraction >= 0.5;
  return {is_later ? position.index + 1 : position.index, 0.0};
}

ImageF sample(const History& history, double time, Between between) {
  if (between == Between::Blend) return history.sample(time);
  return history.read_frame(locate(history, time, between).index);
}

}  // namespace patinate
