// Parts that sections share, and the section that only shows.
#include <algorithm>
#include <cmath>

#include "analysis/compare/sections.h"
#include "analysis/figures/material_stack.h"
#include "libcommon/core/text.h"
#include "libcommon/image/filters.h"
#include "libcommon/output/contact_strip.h"

namespace patinate::analysis {

namespace {

constexpr int kPictureSide = 256;

ImageF shown(ImageF image) {
  const int longer = std::max(image.width(), image.height());
  if (longer <= kPictureSide) return image;
  const auto side = [&](int s) { return std::max(1, s * kPictureSide / longer); };
  return downscale_area(image, side(image.width()), side(image.height()));
}

}  // namespace

std::vector<std::size_t> spread_indices(std::size_t count, std::size_t most) {
  std::vector<std::size_t> out;
  const std::size_t n = std::min(count, most);
  for (std::size_t i = 0; i < n; ++i) out.push_back(n == 1 ? 0 : i * (count - 1) / (n - 1));
  return out;
}

SplitFigure split_figure(const ComparedPair& pair, const BlockFigure& a_b, const BlockFigure& a_a,
                         const CompareOptions& options, std::uint32_t purpose, const RunControl& control) {
  SplitFigure f;
  f.value = a_b(pair.blocks_a.all(), pair.blocks_b.all());
  f.split = a_a(pair.blocks_a.half(false), pair.blocks_a.half(true));
  if (f.value.empty()) return f;
  const BootstrapOptions bootstrap{.resamples = options.num_resamples,
                                   .seed = options.seed,
                                   .purpose = purpose,
                                   .is_paired = pair.places_problem.empty() && pair.a.texels == pair.b.texels};
  f.intervals = block_intervals(pair.blocks_a, pair.blocks_b, f.value, a_b, bootstrap, control);
  return f;
}

Figure figure_of(const SplitFigure& f, std::size_t k, const std::string& name, const std::string& title,
                 const std::string& unit, const std::string& undefined) {
  Figure figure{.name = name, .title = title, .unit = unit};
  if (f.value.empty()) {
    figure.undefined = undefined;
    return figure;
  }
  figure.value = f.value[k];
  if (f.intervals) {
    figure.low = (*f.intervals)[k].low;
    figure.high = (*f.intervals)[k].high;
  }
  if (!f.split.empty()) figure.split = f.split[k];
  return figure;
}

Picture picture_strip(const std::string& name, const std::string& caption, const ComparedPair& pair,
                      const std::vector<std::size_t>& times, const std::function<ImageF(std::size_t)>& image) {
  std::vector<ImageF> images;
  std::vector<std::string> labels;
  for (const std::size_t t : times) {
    images.push_back(shown(image(t)));
    labels.push_back(short_number_text(rounded(pair.a.times[t], 4)) + " " + pair.time_unit);
  }
  return {name, caption, contact_strip(images, labels, {.label_px = 13})};
}

Section look_section(const ComparedPair& pair) {
  Section section{.name = "look", .title = "How they look"};
  const std::vector<std::size_t> times = spread_indices(pair.a.num_times(), kPicturesInARow);
  section.pictures.push_back(picture_strip("a", "A", pair, times, [&](std::size_t t) { return pair.a.rgb_image(t); }));
  section.pictures.push_back(picture_strip("b", "B", pair, times, [&](std::size_t t) { return pair.b.rgb_image(t); }));
  return section;
}

std::vector<NamedSection> compared_sections(const CompareOptions& options, const HistoryFacts& a,
                                            const HistoryFacts& b) {
  std::vector<NamedSection> sections{
      {"look", [](const ComparedPair& pair, const CompareOptions&, const RunControl&) { return look_section(pair); }},
      {"places", places_section},
      {"colors", colors_section},
      {"controls", controls_section},
      {"structure", structure_section}};
  if (states_material(a) || states_material(b)) sections.push_back({"materials", materials_section});
  if (options.cracks) sections.push_back({"cracks", cracks_section});
  return sections;
}

}  // namespace patinate::analysis
