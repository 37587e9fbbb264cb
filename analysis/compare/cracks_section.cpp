// Two surfaces by their cracks.
#include <algorithm>
#include <cmath>
#include <functional>

#include "analysis/compare/sections.h"
#include "analysis/cracks/crack_network.h"
#include "analysis/cracks/line_mask.h"
#include "analysis/figures/block_values.h"
#include "libcommon/core/median.h"
#include "libcommon/core/text.h"

namespace patinate::analysis {

namespace {

constexpr std::uint32_t kSharePurpose = 401, kCellPurpose = 402, kAnglePurpose = 403, kSidePurpose = 404;
/// Area; px; arm over the crack's width (docs/algorithms/crack_statistics.md).
constexpr double kMinShare = 1e-4, kShortestArm = 6.0, kArmPerWidth = 2.5;

/// Cracks of one side at the last common time, by the blocks they lie in.
struct Cracks {
  ImageU8 mask;
  CrackNetwork network;
  double pixel = 1.0;                   ///< mm, or 1.
  std::vector<BlockValue> cells;        ///< log2 of the area, in the unit squared.
  std::vector<BlockValue> angles;       ///< Degrees.
  std::vector<double> cracked, counts;  ///< Texels of every block.

  [[nodiscard]] bool is_none() const { return network.share < kMinShare; }
};

Cracks cracks_of(const ColorStack& stack, const BlockGrid& grid, double pixel) {
  Cracks c;
  const ImageU8 surface = stack.mask();
  c.pixel = pixel;
  c.mask = find_cracks(stack.lab_image(stack.num_times() - 1, 0), surface);
  c.network = measure_cracks(c.mask, surface, kShortestArm);
  const double arm = kArmPerWidth * c.network.width_px().value_or(0.0);
  if (arm > kShortestArm) c.network = measure_cracks(c.mask, surface, std::min(arm, 1000.0));
  c.cracked.resize(grid.num_blocks());
  c.counts.resize(grid.num_blocks());
  std::vector<std::uint16_t> block_at(static_cast<std::size_t>(surface.num_pixels()));
  for (std::size_t i = 0; i < stack.num_texels(); ++i) {
    block_at[stack.texels[i]] = grid.block_of[i];
    c.counts[grid.block_of[i]] += 1.0;
    c.cracked[grid.block_of[i]] += c.mask.data()[stack.texels[i]] != 0 ? 1.0 : 0.0;
  }
  const auto block = [&](double x, double y) {
    return block_at[static_cast<std::size_t>(std::lround(y)) * static_cast<std::size_t>(stack.width) +
                    static_cast<std::size_t>(std::lround(x))];
  };
  for (const CrackCell& cell : c.network.cells)
    c.cells.push_back({static_cast<float>(std::log2(cell.area_px * pixel * pixel)), block(cell.x, cell.y)});
  for (const CrackJunction& j : c.network.junctions)
    c.angles.push_back({static_cast<float>(j.angle_deg()), block(j.x, j.y)});
  sort_values(c.cells);
  sort_values(c.angles);
  return c;
}

/// Figures of one side, its blocks counted so many times each; nothing where there is none.
using SideFigure = std::function<std::optional<double>(const std::vector<int>& weights)>;

std::optional<double> share_of(const Cracks& c, const std::vector<int>& w) {
  double cracked = 0.0, count = 0.0;
  for (std::size_t k = 0; k < w.size(); ++k) cracked += w[k] * c.cracked[k], count += w[k] * c.counts[k];
  return count > 0.0 ? std::optional(cracked / count) : std::nullopt;
}

std::optional<double> mean_angle(const Cracks& c, const std::vector<int>& w) {
  double sum = 0.0, count = 0.0;
  for (const BlockValue& v : c.angles) sum += w[v.block] * static_cast<double>(v.value), count += w[v.block];
  return count > 0.0 ? std::optional(sum / count) : std::nullopt;
}

std::vector<double> share_distance(const Cracks& a, const std::vector<int>& wa, const Cracks& b,
                                   const std::vector<int>& wb) {
  const std::optional<double> x = share_of(a, wa), y = share_of(b, wb);
  return x && y ? std::vector<double>{std::abs(*x - *y)} : std::vector<double>();
}

/// Figures of one side by itself.
void add_side(const Cracks& c, const BlockGrid& grid, const std::string& side, const std::string& unit,
              const CompareOptions& options, const RunControl& control, Section& section) {
  const std::string suffix = side == "A" ? "_a" : "_b";
  const std::string none = "no dark lines are found in " + side;
  const auto add = [&](const std::string& name, const std::string& title, const std::string& of,
                       std::optional<double> value, const std::string& why) {
    section.figures.push_back({.name = name + suffix,
                               .title = title + " of " + side,
                               .unit = of,
                               .value = value,
                               .undefined = value         ? ""
                                            : c.is_none() ? none
                                                          : why});
  };
  const auto with_range = [&](const SideFigure& of) {
    Figure& figure = section.figures.back();
    if (!figure.value) return;
    const BlockFigure drawn = [&](const std::vector<int>& w, const std::vector<int>&) {
      const std::optional<double> v = of(w);
      return v ? std::vector<double>{*v} : std::vector<double>();
    };
    const BootstrapOptions bootstrap{
        .resamples = options.num_resamples, .seed = options.seed, .purpose = kSidePurpose, .is_paired = true};
    if (const auto range = block_ranges(grid, grid, {*figure.value}, drawn, bootstrap, control))
      figure.low = range->front().low, figure.high = range->front().high;
  };
  add("crack_share", "Share of cracks", "", c.network.share, "");
  with_range([&](const std::vector<int>& w) { return share_of(c, w); });
  const std::optional<double> width = c.network.width_px();
  add("crack_width", "Mean width of cracks", unit, width ? std::optional(*width * c.pixel) : std::nullopt, none);
  // Intervals by blocks are too narrow for medians of few cells: counted in docs/studies/how_sure.md.
  std::optional<double> cell_area;
  if (!c.cells.empty()) cell_area = std::exp2(static_cast<double>(c.cells[c.cells.size() / 2].value));
  add("cell_area", "Median cell", unit + "^2", cell_area, "no cell is closed");
  add("junction_angle", "Mean angle between cracks (90: one ends on another; 120: three meet evenly)", "degrees",
      mean_angle(c, grid.all()), "no junction can be followed");
  with_range([&](const std::vector<int>& w) { return mean_angle(c, w); });
}

/// Adds the figures where a control is below and above its median: does the pattern follow it?
void add_halves(const TextureSeries& series, const ColorStack& stack, const Cracks& c, const std::string& side,
                const std::string& unit, Section& section) {
  for (const ControlFacts& control : series.facts().controls) {
    const std::vector<float> values = control_at(series, control.name, stack);
    if (values.empty()) continue;
    ImageF at(stack.width, stack.height);
    for (std::size_t i = 0; i < values.size(); ++i) at.data()[stack.texels[i]] = values[i];
    const float middle = median(values);
    for (const bool is_high : {false, true}) {
      const auto is_here = [&](const auto& part) {
        return (at.at(static_cast<int>(std::lround(part.x)), static_cast<int>(std::lround(part.y))) >= middle) ==
               is_high;
      };
      std::vector<double> cells, angles, waves;
      for (const CrackCell& cell : c.network.cells) {
        if (is_here(cell)) cells.push_back(cell.area_px * c.pixel * c.pixel);
      }
      for (const CrackJunction& j : c.network.junctions) {
        if (is_here(j)) angles.push_back(j.angle_deg());
      }
      for (const CrackSegment& s : c.network.segments) {
        if (is_here(s)) waves.push_back(s.waviness);
      }
      std::sort(cells.begin(), cells.end());
      const auto mean = [](const std::vector<double>& list) -> std::optional<double> {
        if (list.empty()) return std::nullopt;
        double sum = 0.0;
        for (const double v : list) sum += v;
        return sum / static_cast<double>(list.size());
      };
      const std::string suffix = "_" + control.name + (is_high ? "_high_" : "_low_") + (side == "A" ? "a" : "b"),
                        where = " of " + side + " where " + control.name + " is " + (is_high ? "high" : "low");
      const auto add = [&](const std::string& name, const std::string& title, const std::string& of,
                           std::optional<double> value, const std::string& why) {
        section.figures.push_back(
            {.name = name + suffix, .title = title + where, .unit = of, .value = value, .undefined = value ? "" : why});
      };
      add("cell_area", "Median cell", unit + "^2",
          cells.empty() ? std::nullopt : std::optional(cells[cells.size() / 2]), "no closed cell has its middle there");
      add("junction_angle", "Mean angle between cracks", "degrees", mean(angles), "no junction there can be followed");
      add("waviness", "Mean distance of cracks from their chords, as a share of those", "", mean(waves),
          "no crack there is long enough");
    }
  }
}

}  // namespace

Section cracks_section(const ComparedPair& pair, const CompareOptions& options, const RunControl& control) {
  Section section{.name = "cracks", .title = "Cracks"};
  const bool is_metric = pair.a.pixel_mm && pair.b.pixel_mm;
  const std::string unit = is_metric ? "mm" : "pixel";
  const Cracks a = cracks_of(pair.a, pair.blocks_a, is_metric ? *pair.a.pixel_mm : 1.0),
               b = cracks_of(pair.b, pair.blocks_b, is_metric ? *pair.b.pixel_mm : 1.0);
  section.paragraphs.push_back(
      "Dark lines at the last common time, at the compared size; cracks narrower than a pixel of it are not seen "
      "(--size).");
  add_side(a, pair.blocks_a, "A", unit, options, control, section);
  add_side(b, pair.blocks_b, "B", unit, options, control, section);
  add_halves(pair.series_a, pair.a, a, "A", unit, section);
  add_halves(pair.series_b, pair.b, b, "B", unit, section);
  const auto of = [](const Cracks& one, const Cracks& other, const std::vector<BlockValue> Cracks::*list) {
    return [&one, &other, list](const std::vector<int>& wa, const std::vector<int>& wb) {
      const std::optional<double> d = (one.*list).empty() || (other.*list).empty()
                                          ? std::nullopt
                                          : quantile_distance(one.*list, wa, other.*list, wb, 1);
      return d ? std::vector<double>{*d} : std::vector<double>();
    };
  };
  const auto shares = [](const Cracks& one, const Cracks& other) {
    return [&one, &other](const std::vector<int>& wa, const std::vector<int>& wb) {
      return share_distance(one, wa, other, wb);
    };
  };
  section.figures.push_back(figure_of(split_figure(pair, shares(a, b), shares(a, a), options, kSharePurpose, control),
                                      0, "crack_share_distance", "Difference of the shares of cracks", "",
                                      "no block shows the surface"));
  const auto cell_figure =
      split_figure(pair, of(a, b, &Cracks::cells), of(a, a, &Cracks::cells), options, kCellPurpose, control);
  section.figures.push_back(figure_of(cell_figure, 0, "cell_area_distance",
                                      "Distance between the distributions of cell area", "octaves",
                                      "one side has no closed cell"));
  const auto angle_figure =
      split_figure(pair, of(a, b, &Cracks::angles), of(a, a, &Cracks::angles), options, kAnglePurpose, control);
  section.figures.push_back(figure_of(angle_figure, 0, "junction_angle_distance",
                                      "Distance between the distributions of junction angle", "degrees",
                                      "one side has no junction that can be followed"));
  for (const Cracks* c : {&a, &b}) {
    const ColorStack& stack = c == &a ? pair.a : pair.b;
    ImageF picture = stack.rgb_image(stack.num_times() - 1);
    for (std::int64_t i = 0; i < c->mask.num_pixels(); ++i) {
      if (c->mask.data()[i] != 0)
        picture.data()[3 * i] = 0.9f, picture.data()[3 * i + 1] = 0.35f, picture.data()[3 * i + 2] = 0.02f;
    }
    section.pictures.push_back({c == &a ? "cracks_a" : "cracks_b",
                                std::string("What is taken for cracks, ") + (c == &a ? "A" : "B"), std::move(picture)});
  }
  return section;
}

}  // namespace patinate::analysis
