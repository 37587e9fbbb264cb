#include "analysis/compare/replicates.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

#include "analysis/compare/sections.h"
#include "analysis/figures/material_stack.h"
#include "libcommon/core/csv.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

constexpr double kLevel = 0.05;  ///< Significance.

bool is_left_out(std::string_view name) {
  const auto has = [&](std::string_view part) { return name.find(part) != std::string_view::npos; };
  return has("_median_") || has("_low_") || has("_high_");
}

/// "Median cell of A" -> "Median cell".
std::string without_side(std::string title) {
  for (const std::string_view end : {" of A", ", A"}) {
    if (title.ends_with(end)) title.resize(title.size() - end.size());
  }
  return title + ": difference";
}

PairDistance distance_of(const Figure& f, const std::string& section) {
  PairDistance d{f.name, f.title, f.unit, section, f.value, f.undefined};
  if (f.name != "ssim_mean") return d;
  d.name = "ssim_distance";
  d.title = "1 - " + f.title;
  if (d.value) d.value = 1.0 - *d.value;
  return d;
}

/// Figures of each side become one.
std::vector<PairDistance> distances_of(const std::vector<Figure>& given, const std::string& section) {
  std::vector<PairDistance> out;
  for (const Figure& unstated : given) {
    const Figure f = as_stated(unstated);
    if (is_left_out(f.name) || f.name.ends_with("_b")) continue;
    if (!f.name.ends_with("_a")) {
      out.push_back(distance_of(f, section));
      continue;
    }
    const std::string name = f.name.substr(0, f.name.size() - 2);
    const auto other = std::find_if(given.begin(), given.end(), [&](const Figure& o) { return o.name == name + "_b"; });
    if (other == given.end()) continue;
    PairDistance d{name + "_difference", without_side(f.title), f.unit, section, {}, ""};
    if (f.value && other->value)
      d.value = std::abs(*f.value - *other->value);
    else
      d.undefined = f.value ? other->undefined : f.undefined;
    out.push_back(std::move(d));
  }
  return out;
}

}  // namespace

std::vector<PairDistance> pair_distances(const ComparedPair& pair, const CompareOptions& given,
                                         const RunControl& control) {
  CompareOptions options = given;
  options.num_resamples = 0;  // Replicates say what is chance.
  std::vector<PairDistance> all = distances_of(difference_figures(pair, control.part(0.0, 0.2)), "places");
  double begin = 0.2;
  const auto add = [&](const Section& section) {
    for (PairDistance& d : distances_of(section.figures, section.name)) all.push_back(std::move(d));
  };
  const auto next = [&] {
    begin += 0.2;
    return control.part(begin - 0.2, begin);
  };
  add(colors_section(pair, options, next()));
  add(controls_section(pair, options, next()));
  add(structure_section(pair, options, next()));
  const RunControl quiet = control.silent();
  if (states_material(pair.series_a.facts()) || states_material(pair.series_b.facts()))
    add(materials_section(pair, options, quiet));
  if (options.cracks) add(cracks_section(pair, options, next()));
  control.report(1.0);
  return all;
}

Json pair_distance_json(const PairDistance& d) {
  return {{"name", d.name},
          {"title", d.title},
          {"unit", d.unit},
          {"section", d.section},
          {"value", d.value ? Json(*d.value) : Json(nullptr)},
          {"undefined", d.undefined}};
}

PairDistance pair_distance_from_json(const Json& json) {
  PairDistance d{json.at("name"), json.at("title"), json.at("unit"), json.at("section"), {}, json.at("undefined")};
  if (json.at("value").is_number()) d.value = json.at("value").get<double>();
  return d;
}

ReplicateComparison compare_replicates(const std::vector<std::vector<PairDistance>>& pairs, std::size_t size_a,
                                       std::size_t size_b, std::uint64_t seed) {
  const Labelings labelings = make_labelings(size_a, size_b, kMaxLabelings, seed);
  ReplicateComparison out{.size_a = size_a,
                          .size_b = size_b,
                          .num_labelings = labelings.is_a.size(),
                          .is_exact = labelings.is_exact,
                          .smallest_p = labelings.smallest_p};
  std::vector<std::vector<double>> distances, gaps;
  for (const std::vector<PairDistance>& of_pair : pairs) {
    for (const PairDistance& d : of_pair) {
      const auto has_name = [&](const ReplicateFigure& f) { return f.what.name == d.name; };
      if (std::none_of(out.figures.begin(), out.figures.end(), has_name))
        out.figures.push_back({.what = {d.name, d.title, d.unit, d.section, {}, ""}});
    }
  }
  std::vector<double> p;
  for (ReplicateFigure& figure : out.figures) {
    for (const std::vector<PairDistance>& of_pair : pairs) {
      const auto d = std::find_if(of_pair.begin(), of_pair.end(),
                                  [&](const PairDistance& one) { return one.name == figure.what.name; });
      if (d != of_pair.end() && d->value) {
        figure.distances.push_back(*d->value);
      } else if (figure.what.undefined.empty()) {
        figure.what.undefined = "some pair has none" + (d == of_pair.end() ? "" : ": " + d->undefined);
      }
    }
    if (!figure.what.undefined.empty()) {
      figure.distances.clear();
      continue;
    }
    distances.push_back(figure.distances);
    gaps.push_back(squared_gaps(figure.distances, labelings));
    figure.difference = group_difference(figure.distances, labelings, gaps.back());
    p.push_back(figure.difference->p);
  }
  out.num_defined = p.size();
  const std::vector<double> corrected = holm_corrected(p);
  std::size_t k = 0;
  for (ReplicateFigure& figure : out.figures) {
    if (figure.difference) figure.p_corrected = corrected[k++];
  }
  out.overall_p = overall_p(distances, gaps);
  const double number = static_cast<double>(std::max<std::size_t>(1, out.num_defined));
  out.smallest_p_corrected = std::min(1.0, number * out.smallest_p);
  out.enough_a_side = 2;
  while (number * smallest_permutation_p(out.enough_a_side, out.enough_a_side) > kLevel) ++out.enough_a_side;
  return out;
}

std::string replicate_figures_csv(const ReplicateComparison& comparison) {
  std::string text =
      "section,figure,unit,A to B (root mean square),within A (root mean square),within B (root mean square),gap,"
      "spread of A,spread of B,effect (spreads),effect (spreads of A),effect (spreads of B),p,p (Holm),undefined\n";
  for (const ReplicateFigure& f : comparison.figures) {
    text += csv_cell(f.what.section) + "," + csv_cell(f.what.name) + "," + csv_cell(f.what.unit);
    if (f.difference) {
      const GroupDifference& d = *f.difference;
      for (const std::optional<double>& v :
           {std::optional(d.between), std::optional(d.within_a), std::optional(d.within_b), std::optional(d.gap),
            std::optional(d.spread_a), std::optional(d.spread_b), d.effect, d.effect_a, d.effect_b, std::optional(d.p),
            std::optional(f.p_corrected)})
        text += "," + csv_cell(v);
      text += ",\n";
    } else {
      text += std::string(12, ',') + csv_cell(f.what.undefined) + "\n";
    }
  }
  return text;
}

std::string replicate_distances_csv(const ReplicateComparison& comparison, const std::vector<std::string>& names) {
  std::string text = "section,figure,unit,one,other,sides,distance\n";
  const std::size_t count = names.size();
  for (const ReplicateFigure& f : comparison.figures) {
    if (!f.difference) continue;
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t j = i + 1; j < count; ++j) {
        const std::string sides = std::string(i < comparison.size_a ? "A" : "B") + (j < comparison.size_a ? "A" : "B");
        text += csv_cell(f.what.section) + "," + csv_cell(f.what.name) + "," + csv_cell(f.what.unit) + "," +
                csv_cell(names[i]) + "," + csv_cell(names[j]) + "," + sides + "," +
                csv_cell(std::optional(f.distances[pair_index(i, j, count)])) + "\n";
      }
    }
  }
  return text;
}

}  // namespace patinate::analysis
