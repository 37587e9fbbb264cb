#include "analysis/fit/misfit.h"

#include <algorithm>
#include <cmath>

#include "analysis/compare/sections.h"
#include "analysis/figures/sliced_distance.h"
#include "libcommon/core/median.h"
#include "libcommon/core/text.h"
#include "libcommon/output/contact_strip.h"
#include "libcommon/output/map_legend.h"

namespace patinate::analysis {

namespace {

constexpr double kShown = 0.95;   ///< Share of the places whose moves the ramp tells apart.
constexpr double kMinHigh = 2.0;  ///< Delta E; below, a map of noise would look like one of misfit.

double scale_of(const MisfitMaps& maps) {
  std::vector<float> values;
  for (const ImageF& map : maps.moves) {
    for (std::int64_t i = 0; i < map.num_pixels(); ++i) {
      if (maps.mask.data()[i] != 0) values.push_back(map.data()[i]);
    }
  }
  if (values.empty()) return kMinHigh;
  const auto rank = static_cast<std::size_t>(kShown * static_cast<double>(values.size() - 1));
  return std::max(kMinHigh, std::ceil(static_cast<double>(value_at_rank(values, rank))));
}

Picture picture(const std::string& name, const std::string& caption, const MisfitMaps& maps, double high) {
  std::vector<ImageF> images;
  std::vector<std::string> labels;
  for (std::size_t k = 0; k < maps.moves.size(); ++k) {
    images.push_back(ramp_picture(maps.moves[k], maps.mask, 0.0, high, ColorRamp::Sequential));
    labels.push_back(short_number_text(rounded(maps.times[k], 4)) + " " + maps.time_unit);
  }
  return {name, caption,
          with_legend(contact_strip(images, labels, {.label_px = 13}),
                      {.ramp = ColorRamp::Sequential, .high = high, .unit = "Delta E", .more = "gray: not seen"})};
}

}  // namespace

MisfitMaps misfit_maps(const ComparedPair& pair, const RunControl& control) {
  MisfitMaps maps{.times = {}, .moves = {}, .mask = pair.a.mask(), .time_unit = pair.time_unit};
  for (const std::size_t t : spread_indices(pair.a.num_times(), kPicturesInARow)) {
    control.throw_if_stopped();
    maps.moves.push_back(pair.a.value_image(sliced_moves(pair.a, t, pair.b, t)));
    maps.times.push_back(pair.a.times[t]);
  }
  return maps;
}

std::vector<Picture> misfit_pictures(const MisfitMaps& before, const MisfitMaps& after) {
  const double high = scale_of(before);
  return {picture("misfit_before", "misfit, before", before, high),
          picture("misfit_after", "misfit, after", after, high)};
}

}  // namespace patinate::analysis
