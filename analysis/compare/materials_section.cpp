// Two surfaces by what they are made of beside their color.
#include <algorithm>
#include <cmath>
#include <functional>

#include "analysis/compare/sections.h"
#include "analysis/figures/block_values.h"
#include "analysis/figures/height_base.h"
#include "analysis/figures/material_stack.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/text.h"

namespace patinate::analysis {

namespace {

constexpr std::size_t kMaxMaterialTimes = 9;  ///< See docs/algorithms/compare.md.
constexpr std::size_t kMaxPlaces = 4096;      ///< Most places of a side and time whose BRDFs are compared.
constexpr std::uint32_t kBrdfPurpose = 301, kMapPurpose = 310;

/// One number of a material.
struct Quantity {
  std::string name, title, unit;
  std::function<float(const MaterialStack&, std::size_t at)> value;
};

std::vector<Quantity> quantities(bool has_height) {
  std::vector<Quantity> all{
      {"roughness", "Roughness", "", [](const MaterialStack& m, std::size_t at) { return m.roughness[at]; }},
      {"metalness", "Metalness", "", [](const MaterialStack& m, std::size_t at) { return m.metalness[at]; }},
      {"reflectance", "Reflectance at normal incidence", "",
       [](const MaterialStack& m, std::size_t at) { return m.reflectance(at); }}};
  if (has_height) {
    all.push_back({"height", "Height above the base of the first time", "mm",
                   [](const MaterialStack& m, std::size_t at) { return m.height[at]; }});
    all.push_back({"growth", "Growth since the first time", "mm",
                   [](const MaterialStack& m, std::size_t at) { return m.height[at] - m.height[at % m.num_texels]; }});
  }
  return all;
}

/// Text about what was removed from the heights of a side.
std::string base_text(const std::string& name, const TakenBase& base) {
  std::string text = name + ": the mean of its first time, " + short_number_text(base.mean_mm) + " mm";
  if (base.kind == HeightBase::Plane)
    text += ", and the tilt of the plane through it, " + short_number_text(base.tilt_mm) + " mm over the surface";
  return text;
}

/// One of the two compared surfaces, at the times that are compared.
struct Side {
  const ColorStack& stack;
  const BlockGrid& grid;
  MaterialStack material;
};

std::vector<BlockValue> sorted(const Side& side, const Quantity& quantity, std::size_t time) {
  std::vector<BlockValue> values;
  values.reserve(side.material.num_texels);
  for (std::size_t i = 0; i < side.material.num_texels; ++i)
    values.push_back({quantity.value(side.material, time * side.material.num_texels + i), side.grid.block_of[i]});
  sort_values(values);
  return values;
}

std::optional<double> mean_value(const std::vector<BlockValue>& values) {
  double sum = 0.0;
  for (const BlockValue& v : values) sum += static_cast<double>(v.value);
  return values.empty() ? std::nullopt : std::optional(sum / static_cast<double>(values.size()));
}

void add_quantity(const ComparedPair& pair, const Side& a, const Side& b, const Quantity& quantity,
                  const std::vector<double>& times, std::uint32_t purpose, const CompareOptions& options,
                  const RunControl& control, Section& section) {
  std::vector<std::vector<BlockValue>> of_a, of_b;
  for (std::size_t t = 0; t < times.size(); ++t) {
    of_a.push_back(sorted(a, quantity, t));
    of_b.push_back(sorted(b, quantity, t));
  }
  const auto figure = [&](const auto& one, const auto& other) {
    return [&one, &other](const std::vector<int>& wa, const std::vector<int>& wb) {
      double sum = 0.0;
      for (std::size_t t = 0; t < one.size(); ++t) {
        const std::optional<double> d = quantile_distance(one[t], wa, other[t], wb, 1);
        if (!d) return std::vector<double>();
        sum += *d;
      }
      return std::vector<double>{sum / static_cast<double>(one.size())};
    };
  };
  const SplitFigure f = split_figure(pair, figure(of_a, of_b), figure(of_a, of_a), options, purpose, control);
  section.figures.push_back(figure_of(f, 0, quantity.name + "_distance",
                                      quantity.title + ": distance between the distributions, mean over times",
                                      quantity.unit, "a side has no texel"));
  Curve curve{.name = quantity.name,
              .title = quantity.title + ", mean over the surface",
              .x_name = pair.time_name,
              .y_name = quantity.unit.empty() ? quantity.name : quantity.name + " (" + quantity.unit + ")",
              .x = times,
              .columns = {}};
  for (const auto* side : {&of_a, &of_b}) {
    CurveColumn column{side == &of_a ? "A" : "B", {}};
    for (const std::vector<BlockValue>& values : *side) column.values.push_back(mean_value(values));
    curve.columns.push_back(std::move(column));
  }
  section.curves.push_back(std::move(curve));
}

using Mean = std::array<double, kNumReflections>;

/// Sums of what the places of each block reflect, at each time.
struct BlockReflections {
  std::vector<std::vector<Mean>> sums;  ///< [time][block]
  std::vector<int> counts;              ///< Places of each block.
};

BlockReflections block_reflections(const Side& side, std::size_t num_times, const RunControl& control) {
  BlockReflections out;
  out.sums.assign(num_times, std::vector<Mean>(side.grid.num_blocks(), Mean{}));
  out.counts.assign(side.grid.num_blocks(), 0);
  const std::size_t step = (side.material.num_texels + kMaxPlaces - 1) / kMaxPlaces;
  for (std::size_t i = 0; i < side.material.num_texels; i += step) ++out.counts[side.grid.block_of[i]];
  parallel_for(static_cast<std::int64_t>(num_times), 1, control, [&](std::int64_t begin, std::int64_t end) {
    for (auto t = static_cast<std::size_t>(begin); t < static_cast<std::size_t>(end); ++t) {
      for (std::size_t i = 0; i < side.material.num_texels; i += step) {
        const Reflections r = reflections_of(side.material, t * side.material.num_texels + i);
        Mean& sum = out.sums[t][side.grid.block_of[i]];
        for (std::size_t k = 0; k < r.size(); ++k) sum[k] += static_cast<double>(r[k]);
      }
    }
  });
  return out;
}

std::optional<Mean> mean_reflections(const BlockReflections& r, std::size_t time, const std::vector<int>& weights) {
  Mean mean{};
  double count = 0.0;
  for (std::size_t block = 0; block < weights.size(); ++block) {
    if (weights[block] == 0) continue;
    count += weights[block] * r.counts[block];
    for (std::size_t k = 0; k < mean.size(); ++k) mean[k] += weights[block] * r.sums[time][block][k];
  }
  if (!(count > 0.0)) return std::nullopt;
  for (double& m : mean) m /= count;
  return mean;
}

void add_brdf(const ComparedPair& pair, const Side& a, const Side& b, const std::vector<double>& times,
              const CompareOptions& options, const RunControl& control, Section& section) {
  const BlockReflections of_a = block_reflections(a, times.size(), control.part(0.0, 0.3)),
                         of_b = block_reflections(b, times.size(), control.part(0.3, 0.6));
  const auto at = [](const BlockReflections& one, const BlockReflections& other, std::size_t t,
                     const std::vector<int>& wa, const std::vector<int>& wb) -> std::optional<double> {
    const std::optional<Mean> x = mean_reflections(one, t, wa), y = mean_reflections(other, t, wb);
    return x && y ? std::optional(reflection_distance(*x, *y)) : std::nullopt;
  };
  const auto figure = [&](const BlockReflections& one, const BlockReflections& other) {
    return [&](const std::vector<int>& wa, const std::vector<int>& wb) {
      double sum = 0.0;
      for (std::size_t t = 0; t < times.size(); ++t) {
        const std::optional<double> d = at(one, other, t, wa, wb);
        if (!d) return std::vector<double>();
        sum += *d;
      }
      return std::vector<double>{sum / static_cast<double>(times.size())};
    };
  };
  const SplitFigure f =
      split_figure(pair, figure(of_a, of_b), figure(of_a, of_a), options, kBrdfPurpose, control.part(0.6, 1.0));
  section.figures.push_back(figure_of(f, 0, "brdf_distance",
                                      "BRDFs, mean over the surface: log distance with the cosine, mean over times",
                                      "log", "a side has no texel"));
  Curve curve{.name = "brdf_distance",
              .title = "Distance between the BRDFs, mean over the surface",
              .x_name = pair.time_name,
              .y_name = "log(1 + f cos)",
              .x = times,
              .columns = {}};
  CurveColumn column{"A to B", {}};
  for (std::size_t t = 0; t < times.size(); ++t)
    column.values.push_back(at(of_a, of_b, t, pair.blocks_a.all(), pair.blocks_b.all()));
  curve.columns.push_back(std::move(column));
  section.curves.push_back(std::move(curve));
}

/// Where equal texels show equal places: the mean over them.
void add_brdf_by_place(const Side& a, const Side& b, std::size_t num_times, const RunControl& control,
                       Section& section) {
  const std::size_t n = a.material.num_texels, step = (n + kMaxPlaces - 1) / kMaxPlaces;
  std::vector<double> sums(num_times, 0.0);
  parallel_for(static_cast<std::int64_t>(num_times), 1, control, [&](std::int64_t begin, std::int64_t end) {
    for (auto t = static_cast<std::size_t>(begin); t < static_cast<std::size_t>(end); ++t) {
      for (std::size_t i = 0; i < n; i += step) {
        Mean x{}, y{};
        std::ranges::copy(reflections_of(a.material, t * n + i), x.begin());
        std::ranges::copy(reflections_of(b.material, t * n + i), y.begin());
        sums[t] += reflection_distance(x, y);
      }
    }
  });
  double sum = 0.0;
  for (const double s : sums) sum += s;
  section.figures.push_back({.name = "brdf_by_place",
                             .title = "BRDFs, place by place: log distance with the cosine, mean over places and times",
                             .unit = "log",
                             .value = sum / static_cast<double>(num_times * ((n + step - 1) / step))});
}

}  // namespace

Section materials_section(const ComparedPair& pair, const CompareOptions& options, const RunControl& control) {
  Section section{.name = "materials", .title = "Material beside color"};
  const std::vector<std::size_t> indices = spread_indices(pair.a.num_times(), kMaxMaterialTimes);
  std::vector<double> times;
  for (const std::size_t i : indices) times.push_back(pair.a.times[i]);
  Side a{pair.a, pair.blocks_a, load_materials(pair.series_a, pair.a, indices, control.part(0.0, 0.15))};
  Side b{pair.b, pair.blocks_b, load_materials(pair.series_b, pair.b, indices, control.part(0.15, 0.3))};
  section.paragraphs.push_back(
      "BRDFs are told by log(1 + f cos), f the BRDF and cos that of the light; their distance is the root mean square "
      "difference over directions and channels. White against black, without a mirror, is at 0.21. Intervals cover "
      "the places, not how well the material is known.");
  for (const auto& [name, series] : {std::pair("A", &pair.series_a), std::pair("B", &pair.series_b)}) {
    if (!states_material(series->facts()))
      section.paragraphs.push_back(std::string(name) +
                                   " says nothing of its material beside color; it stands for a dull dielectric "
                                   "(roughness 0.8, reflectance 0.04), as in pictures.");
  }
  const bool has_height = !a.material.height.empty() && !b.material.height.empty();
  if (has_height) {
    const TakenBase base_a = take_base(a.material.height, pair.a, height_base_of(pair.series_a)),
                    base_b = take_base(b.material.height, pair.b, height_base_of(pair.series_b));
    section.paragraphs.push_back("Heights of two histories have no common zero. Taken off are, at all times, of " +
                                 base_text("A", base_a) + "; of " + base_text("B", base_b) +
                                 ". Growth is the height less that of the same place at the first time, which needs no "
                                 "common zero.");
  }
  const std::vector<Quantity> all = quantities(has_height);
  for (std::size_t k = 0; k < all.size(); ++k) {
    const double begin = 0.3 + 0.3 * static_cast<double>(k) / static_cast<double>(all.size());
    add_quantity(pair, a, b, all[k], times, kMapPurpose + static_cast<std::uint32_t>(k), options,
                 control.part(begin, begin + 0.3 / static_cast<double>(all.size())), section);
  }
  add_brdf(pair, a, b, times, options, control.part(0.6, 0.9), section);
  if (pair.places_problem.empty() && pair.a.texels == pair.b.texels)
    add_brdf_by_place(a, b, times.size(), control.part(0.9, 1.0), section);
  return section;
}

}  // namespace patinate::analysis
