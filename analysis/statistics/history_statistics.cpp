#include "analysis/statistics/history_statistics.h"

#include <algorithm>
#include <limits>

#include "analysis/cracks/crack_network.h"
#include "analysis/cracks/line_mask.h"
#include "analysis/figures/aging.h"
#include "analysis/figures/block_bootstrap.h"
#include "analysis/figures/spatial.h"
#include "libcommon/core/parallel.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"

namespace patinate::analysis {

namespace {

/// -1 for what is no hexadecimal digit.
int digit_of(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

std::optional<TimeQuartiles> quartiles(const TexelAging& aging, const std::vector<float>& times) {
  std::vector<float> known;
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (aging.ages[i] != 0) known.push_back(times[i]);
  }
  if (known.empty()) return std::nullopt;
  std::sort(known.begin(), known.end());
  const auto at = [&](double share) {
    return static_cast<double>(
        known[std::min(known.size() - 1, static_cast<std::size_t>(share * static_cast<double>(known.size())))]);
  };
  return TimeQuartiles{at(0.25), at(0.5), at(0.75)};
}

CrackFigures cracks_of(const ColorStack& stack, std::size_t time, const ImageU8& mask) {
  constexpr double kArm_px = 3.0;  // Arms of junctions, which are not looked at.
  const CrackNetwork network = measure_cracks(find_cracks(stack.lab_image(time, 0), mask), mask, kArm_px);
  return {network.share, network.length_px / static_cast<double>(stack.num_texels()) / stack.pixel_mm.value_or(1.0)};
}

}  // namespace

ColorClass parse_color_class(const std::string& text) {
  const std::size_t at = text.find('=');
  const auto fail = [&] { throw InvalidInput("color class: found `" + text + "`; expected NAME=#RRGGBB"); };
  if (at == std::string::npos || at == 0 || text.size() != at + 8 || text[at + 1] != '#') fail();
  ColorClass c{text.substr(0, at)};
  for (std::size_t k = 0; k < 3; ++k) {
    const int high = digit_of(text[at + 2 + 2 * k]), low = digit_of(text[at + 3 + 2 * k]);
    if (high < 0 || low < 0) fail();
    c.code[k] = (16 * high + low) / 255.0;
  }
  return c;
}

std::vector<double> class_shares(const ImageF& rgb, const ImageU8& mask, const std::vector<ColorClass>& classes) {
  if (rgb.channels() != 3 || (!mask.empty() && !mask.same_size(rgb)))
    throw InvalidInput("color classes: three channels and a mask of their size are needed");
  if (classes.empty()) throw InvalidInput("color classes: there is none");
  std::vector<double> counts(classes.size());
  double total = 0.0;
  for (int y = 0; y < rgb.height(); ++y) {
    for (int x = 0; x < rgb.width(); ++x) {
      if (!is_inside(mask, x, y)) continue;
      std::array<double, 3> code{};
      for (std::size_t c = 0; c < 3; ++c) code[c] = static_cast<double>(srgb_from_linear(rgb.pixel(x, y)[c]));
      std::size_t nearest = 0;
      double least = std::numeric_limits<double>::max();
      for (std::size_t k = 0; k < classes.size(); ++k) {
        double d = 0.0;
        for (std::size_t c = 0; c < 3; ++c) d += (code[c] - classes[k].code[c]) * (code[c] - classes[k].code[c]);
        if (d < least) least = d, nearest = k;
      }
      counts[nearest] += 1.0;
      total += 1.0;
    }
  }
  if (total == 0.0) throw InvalidInput("color classes: the mask covers nothing");
  for (double& c : counts) c /= total;
  return counts;
}

HistoryStatistics history_statistics(const TextureSeries& series, const std::vector<ColorClass>& classes, int size,
                                     double visible_delta_e, const RunControl& control) {
  HistoryStatistics s;
  for (const FrameFacts& frame : series.facts().frames) s.times.push_back(frame.time);
  const ColorStack stack = load_stack(series, s.times, size, control.part(0.0, 0.6));
  const BlockGrid grid = make_blocks(stack, 1);
  const ImageU8 mask = stack.mask();
  const std::size_t num_times = stack.num_times();
  s.is_metric = stack.pixel_mm.has_value();
  s.mean_lab.resize(num_times);
  s.correlation_length.resize(num_times);
  s.cracks.resize(num_times);
  s.class_shares.resize(classes.empty() ? 0 : num_times);
  parallel_for(
      static_cast<std::int64_t>(num_times), 1, control.part(0.6, 1.0), [&](std::int64_t begin, std::int64_t end) {
        for (auto t = static_cast<std::size_t>(begin); t < static_cast<std::size_t>(end); ++t) {
          for (std::size_t i = 0; i < stack.num_texels(); ++i) {
            for (std::size_t c = 0; c < 3; ++c)
              s.mean_lab[t][c] += static_cast<double>(stack.lab_of(t, i)[c]) / static_cast<double>(stack.num_texels());
          }
          s.correlation_length[t] = SpatialStructure(stack, t, grid).correlation_length(grid.all());
          if (s.correlation_length[t]) *s.correlation_length[t] *= stack.pixel_mm.value_or(1.0);
          s.cracks[t] = cracks_of(stack, t, mask);
          if (!classes.empty()) s.class_shares[t] = class_shares(stack.rgb_image(t), mask, classes);
        }
      });
  if (num_times < 2) return s;
  const TexelAging aging = texel_aging(stack, visible_delta_e, control);
  const auto n = static_cast<double>(stack.num_texels());
  for (std::size_t t = 0; t < num_times; ++t) {
    s.covered.push_back(static_cast<double>(std::count_if(aging.covered_at.begin(), aging.covered_at.end(),
                                                          [&](std::uint16_t at) { return at <= t; })) /
                        n);
  }
  s.ages_share = static_cast<double>(std::count(aging.ages.begin(), aging.ages.end(), 1)) / n;
  s.onset = quartiles(aging, aging.onset);
  s.saturation = quartiles(aging, aging.saturation);
  return s;
}

}  // namespace patinate::analysis
