#include "analysis/fit/fit_objective.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include "analysis/compare/control_figures.h"
#include "analysis/compare/sections.h"
#include "analysis/figures/aging.h"
#include "analysis/figures/pixel_difference.h"
#include "analysis/figures/sliced_distance.h"
#include "analysis/figures/spatial.h"
#include "analysis/figures/spectrum_distance.h"
#include "analysis/grading/rust_map.h"
#include "libcommon/core/random.h"
#include "libcommon/core/text.h"
#include "libcommon/metrics/color_curves.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

constexpr std::size_t kMaxTimes = 13;         // Most times, as in the comparison's section of colors.
constexpr std::size_t kMaxContrastTimes = 9;  // Most times, as in that of structure.
constexpr std::uint64_t kSampleSeed = 0;      ///< Seed of the places that are compared: the same in every fit.
constexpr std::uint32_t kDeviationPurpose = 0xdef1;
const std::vector<int> kOneBlock{1};

std::vector<SortedColors> sorted_colors(const ColorStack& stack, std::span<const std::uint16_t> block_of,
                                        const ObjectiveOptions& options) {
  std::vector<std::uint32_t> all(stack.num_texels());
  std::iota(all.begin(), all.end(), 0u);
  std::vector<SortedColors> out;
  const std::size_t most = options.samples > 0 ? static_cast<std::size_t>(options.samples) : all.size();
  for (const std::size_t t : spread_indices(stack.num_times(), kMaxTimes))
    out.emplace_back(stack, t, all, block_of, most, kSampleSeed);
  return out;
}

/// Power spectra of lightness at some of the times.
std::vector<Spectrum> spectra_of(const ColorStack& stack) {
  const BlockGrid whole = make_blocks(stack, 1);
  std::vector<Spectrum> out;
  for (const std::size_t t : spread_indices(stack.num_times(), kMaxContrastTimes)) {
    const SpatialStructure structure(stack, t, whole, SpatialFigures::Spectrum);
    out.push_back({structure.frequencies(), structure.spectrum(kOneBlock)});
  }
  return out;
}

std::vector<double> mean_lab(const ColorStack& stack) {
  std::vector<double> means(3 * stack.num_times());
  for (std::size_t t = 0; t < stack.num_times(); ++t) {
    for (std::size_t i = 0; i < stack.num_texels(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) means[3 * t + c] += static_cast<double>(stack.lab_of(t, i)[c]);
    }
    for (std::size_t c = 0; c < 3; ++c) means[3 * t + c] /= static_cast<double>(stack.num_texels());
  }
  return means;
}

/// Share of the texels that have changed visibly by each time.
std::vector<double> covered_share(const TexelAging& aging, std::size_t num_times) {
  std::vector<double> share(num_times);
  for (const std::uint16_t t : aging.covered_at) {
    if (t < num_times) share[t] += 1.0 / static_cast<double>(aging.covered_at.size());
  }
  std::partial_sum(share.begin(), share.end(), share.begin());
  return share;
}

/// Share of the texels that rust covers at each time, by the built-in rule of `patinate grade`.
std::vector<double> rusted_share(const ColorStack& stack, const RunControl& control) {
  const RustMap map({.num_frames = static_cast<int>(stack.num_times()),
                     .color = [&](int t) { return stack.rgb_image(static_cast<std::size_t>(t)); },
                     .mask = stack.mask()},
                    standard_grade_rules().rust, control.silent());
  std::vector<double> share;
  for (std::size_t t = 0; t < stack.num_times(); ++t) {
    const RustFrame frame = map.at(static_cast<int>(t));
    double sum = 0.0;
    for (const std::uint32_t i : stack.texels)
      sum += frame.labels[i] >= 0 ? static_cast<double>(frame.coverage.data()[i]) : 0.0;
    share.push_back(sum / static_cast<double>(stack.num_texels()));
  }
  return share;
}

/// Mean difference of two shares over time, per cent.
double share_distance(const std::vector<double>& x, const std::vector<double>& y) {
  double sum = 0.0;
  for (std::size_t t = 0; t < x.size(); ++t) sum += std::abs(x[t] - y[t]);
  return 100.0 * sum / static_cast<double>(x.size());
}

std::vector<BlockValue> times_of(const TexelAging& aging, const std::vector<float>& values) {
  std::vector<BlockValue> out;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (aging.ages[i] != 0) out.push_back({values[i], 0});
  }
  sort_values(out);
  return out;
}

bool uses(const std::vector<FitTerm>& terms, std::initializer_list<FitFigure> figures) {
  return std::any_of(terms.begin(), terms.end(), [&](const FitTerm& t) {
    return std::find(figures.begin(), figures.end(), t.figure) != figures.end();
  });
}

/// Moves all places by the same share of what `captured` states of its deviations.
void move_by_deviation(ColorStack& stack, const ColorStack& captured, std::uint64_t draw) {
  if (captured.deviation.empty()) return;
  RandomStream random(draw, 0, kDeviationPurpose);
  const std::array<double, 3> z{random.normal(), random.normal(), random.normal()};
  const std::size_t n = stack.num_texels(), m = captured.num_texels();
  for (std::size_t t = 0; t < stack.num_times(); ++t) {
    for (std::size_t i = 0; i < n; ++i) {
      const float* deviation = captured.deviation.data() + 3 * (t * m + i * m / n);
      float* rgb = stack.rgb.data() + 3 * (t * n + i);
      for (std::size_t c = 0; c < 3; ++c) rgb[c] += static_cast<float>(z[c] * static_cast<double>(deviation[c]));
      const auto lab =
          lab_from_linear(static_cast<double>(rgb[0]), static_cast<double>(rgb[1]), static_cast<double>(rgb[2]));
      for (std::size_t c = 0; c < 3; ++c) stack.lab[3 * (t * n + i) + c] = static_cast<float>(lab[c]);
    }
  }
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? "none" : text;
}

}  // namespace

struct FitObjective::State {
  std::vector<ControlFacts> control_facts;  ///< Control facts of the captured side.
  std::vector<FitTerm> terms;
  ObjectiveOptions options;
  CommonTimes times;
  ColorStack stack;
  std::vector<std::uint16_t> block_of;  ///< All in one.
  std::vector<SortedColors> colors;
  std::vector<Spectrum> spectra;
  std::vector<double> means;
  std::vector<double> rusted = {};  ///< Share by time.
  std::optional<TexelAging> aging;
  std::vector<std::vector<float>> controls;  ///< At the stack's texels, in the order of their facts.
  int other_size = 0;                        ///< Longer side at which the simulated surfaces are compared.

  /// Prepares what figures need of the captured side beside its colors.
  void prepare(const RunControl& control);
  [[nodiscard]] ColorStack simulated_stack(const AgedSurface& frames, const RunControl& control) const;
  [[nodiscard]] double span() const { return times.clock.back() - times.clock.front(); }
  [[nodiscard]] std::optional<double> figure(FitFigure which, const AgedSurface& frames, const ColorStack& other,
                                             const std::optional<TexelAging>& other_aging, const RunControl& control,
                                             std::string& problem) const;
  [[nodiscard]] std::optional<double> by_control(bool is_rate, const AgedSurface& frames, const ColorStack& other,
                                                 const RunControl& control, std::string& problem) const;
  [[nodiscard]] std::optional<double> contrast(const ColorStack& other, std::string& problem) const;
  [[nodiscard]] std::optional<double> place_by_place(const ColorStack& other, const RunControl& control,
                                                     std::string& problem) const;
};

FitObjective::FitObjective(TextureSeries captured, const SurfaceOutline& outline, std::vector<FitTerm> terms,
                           const ObjectiveOptions& options, FitFrames frames, const RunControl& control) {
  check_ranges(options);
  const std::string name = captured.history().label();
  const HistoryFacts& m = captured.facts();
  if (terms.empty()) throw InvalidInput("fit: there is no figure to fit");
  if (m.frames.size() < 2) throw InvalidInput(name + ": has one frame; nothing ages in it");
  if (options.until) {
    if (uses(terms, {FitFigure::Covered, FitFigure::Onset, FitFigure::Saturation, FitFigure::RateByControl}))
      throw InvalidInput(
          "--until: covered, onset, saturation and rate_by_control are about the whole course; use color_distribution, "
          "mean_color, color_by_control, ciede2000 or contrast");
  }
  CommonTimes times = fit_times(m, outline, options, frames, name);
  if (times.clock.size() < 2 && frames == FitFrames::Seen)
    throw InvalidInput(name +
                       ": has only one time in common with the scene; --clock span compares by shares of each span");
  if (uses(terms, {FitFigure::ColorByControl, FitFigure::RateByControl})) {
    std::vector<std::string> names;
    for (const ControlFacts& c : m.controls) names.push_back(c.name);
    const bool has_common = std::any_of(names.begin(), names.end(), [&](const std::string& n) {
      return std::find(outline.control_names.begin(), outline.control_names.end(), n) != outline.control_names.end();
    });
    if (!has_common && !(names.size() == 1 && outline.control_names.size() == 1)) {
      throw InvalidInput(name + ": has no control in common with the scene (history: " + joined(names) +
                         "; scene's run.controls: " + joined(outline.control_names) +
                         "), which color_by_control and rate_by_control need");
    }
  }
  if (uses(terms, {FitFigure::Ciede2000}) &&
      (captured.width() != outline.width || captured.height() != outline.height)) {
    throw InvalidInput(name + ": has " + size_text(captured.width(), captured.height()) +
                       " pixels, the scene's atlas " + size_text(outline.width, outline.height) +
                       ": ciede2000 goes place by place");
  }
  const CommonSizes sizes = common_sizes({captured.width(), captured.height(), captured.pixel_mm()},
                                         {outline.width, outline.height, outline.texel_size_mm}, options.size,
                                         uses(terms, {FitFigure::Ciede2000}));
  ColorStack stack = load_stack(captured, times.times_a, sizes.a, control);
  stack.times = times.clock;
  auto state = std::make_unique<State>(State{.control_facts = m.controls,
                                             .terms = std::move(terms),
                                             .options = options,
                                             .times = std::move(times),
                                             .stack = std::move(stack),
                                             .block_of = {},
                                             .colors = {},
                                             .spectra = {},
                                             .means = {},
                                             .aging = {},
                                             .controls = {},
                                             .other_size = sizes.b});
  State& s = *state;
  s.prepare(control);
  if (s.aging && std::none_of(s.aging->ages.begin(), s.aging->ages.end(), [](std::uint8_t a) { return a != 0; })) {
    throw InvalidInput(name + ": does not age visibly anywhere (--visible-delta-e " +
                       short_number_text(options.visible_delta_e) +
                       "); covered, onset and saturation say nothing about it");
  }
  if (uses(s.terms, {FitFigure::ColorByControl, FitFigure::RateByControl})) {
    for (const ControlFacts& c : s.control_facts) s.controls.push_back(control_at(captured, c.name, s.stack));
  }
  state_ = std::move(state);
}

FitObjective::FitObjective(std::unique_ptr<const State> state) : state_(std::move(state)) {}
FitObjective::~FitObjective() = default;
FitObjective::FitObjective(FitObjective&&) noexcept = default;

const std::vector<FitTerm>& FitObjective::terms() const { return state_->terms; }
std::size_t FitObjective::num_times() const { return state_->times.clock.size(); }

void FitObjective::State::prepare(const RunControl& control) {
  block_of.assign(stack.num_texels(), 0);
  if (uses(terms, {FitFigure::ColorDistribution})) colors = sorted_colors(stack, block_of, options);
  means = mean_lab(stack);
  if (uses(terms, {FitFigure::Contrast})) spectra = spectra_of(stack);
  if (uses(terms, {FitFigure::Rusted})) rusted = rusted_share(stack, control);
  if (uses(terms, {FitFigure::Covered, FitFigure::Onset, FitFigure::Saturation}))
    aging = texel_aging(stack, options.visible_delta_e, control);
}

ColorStack FitObjective::State::simulated_stack(const AgedSurface& frames, const RunControl& control) const {
  std::vector<double> at = times.times_b;
  if (options.clock == Clock::Span) {  // Shares of its own span, whatever an iteration stands for.
    for (std::size_t i = 0; i < at.size(); ++i)
      at[i] = times.clock[i] == 1.0
                  ? frames.times.back()
                  : frames.times.front() + times.clock[i] * (frames.times.back() - frames.times.front());
  }
  ColorStack out = stack_of(frames, at, other_size, control);
  out.times = times.clock;
  return out;
}

FitObjective FitObjective::with_captured(const AgedSurface& frames, std::uint64_t draw,
                                         const RunControl& control) const {
  auto state = std::make_unique<State>(State{.control_facts = {},
                                             .terms = state_->terms,
                                             .options = state_->options,
                                             .times = state_->times,
                                             .stack = state_->simulated_stack(frames, control),
                                             .block_of = {},
                                             .colors = {},
                                             .spectra = {},
                                             .means = {},
                                             .aging = {},
                                             .controls = {},
                                             .other_size = state_->other_size});
  State& s = *state;
  move_by_deviation(s.stack, state_->stack, draw);
  s.prepare(control);
  for (const SurfaceControl& c : frames.controls) {
    s.control_facts.push_back(c.parameter);
    s.controls.push_back(values_at(c.values, frames.mask, s.stack));
  }
  return FitObjective(std::move(state));
}

std::optional<double> FitObjective::State::by_control(bool is_rate, const AgedSurface& frames, const ColorStack& other,
                                                      const RunControl& control, std::string& problem) const {
  HistoryFacts simulated;
  for (const SurfaceControl& c : frames.controls) simulated.controls.push_back(c.parameter);
  const std::vector<std::uint16_t> blocks(other.num_texels(), 0);
  double sum = 0.0;
  int count = 0;
  HistoryFacts captured;
  captured.controls = control_facts;
  for (const SharedControl& shared : shared_controls(captured, simulated)) {
    if (!shared.undefined.empty()) {
      problem = shared.name_a + ": " + shared.undefined;
      continue;
    }
    const auto by_name = [](const std::string& name) {
      return [&name](const ControlFacts& c) { return c.name == name; };
    };
    const auto& list_a = control_facts;
    const auto ia = std::find_if(list_a.begin(), list_a.end(), by_name(shared.name_a));
    const auto ib = std::find_if(simulated.controls.begin(), simulated.controls.end(), by_name(shared.name_b));
    const ImageF& values = frames.controls[ib - simulated.controls.begin()].values;
    const ClassedSurface a(stack, block_of, controls[ia - list_a.begin()], *ia, shared, options.num_classes,
                           kSampleSeed, control);
    const ClassedSurface b(other, blocks, values_at(values, frames.mask, other), *ib, shared, options.num_classes,
                           kSampleSeed, control);
    const std::optional<double> d =
        is_rate ? rate_distance(a, kOneBlock, b, kOneBlock) : conditional_distance(a, kOneBlock, b, kOneBlock);
    if (!d) continue;
    sum += is_rate ? *d * span() : *d;
    ++count;
  }
  if (count > 0) return sum / count;
  if (problem.empty()) problem = "the two sides share no class of a control";
  return std::nullopt;
}

std::optional<double> FitObjective::State::contrast(const ColorStack& other, std::string& problem) const {
  const bool is_metric = stack.pixel_mm && other.pixel_mm;
  const std::vector<Spectrum> list = spectra_of(other);
  double sum = 0.0;
  for (std::size_t t = 0; t < list.size(); ++t) {
    const std::optional<double> d =
        contrast_between(spectra[t], is_metric ? *stack.pixel_mm : 1.0, list[t], is_metric ? *other.pixel_mm : 1.0);
    if (!d) {
      problem = "no tile of the surface has a spectrum, or the two sides share no frequency";
      return std::nullopt;
    }
    sum += *d;
  }
  return sum / static_cast<double>(list.size());
}

std::optional<double> FitObjective::State::place_by_place(const ColorStack& other, const RunControl& control,
                                                          std::string& problem) const {
  std::vector<std::uint32_t> shared;
  std::set_intersection(stack.texels.begin(), stack.texels.end(), other.texels.begin(), other.texels.end(),
                        std::back_inserter(shared));
  if (shared.empty()) {
    problem = "the masks have no texel in common";
    return std::nullopt;
  }
  double sum = 0.0;
  for (const PixelDifference& d : pixel_differences(restricted(stack, shared), restricted(other, shared), control))
    sum += d.ciede2000_mean;
  return sum / static_cast<double>(stack.num_times());
}

std::optional<double> FitObjective::State::figure(FitFigure which, const AgedSurface& frames, const ColorStack& other,
                                                  const std::optional<TexelAging>& other_aging,
                                                  const RunControl& control, std::string& problem) const {
  constexpr double kAll = 100.0;  // Largest value: a side does not age visibly.
  const auto distance_of = [&](std::vector<float> TexelAging::*member) -> double {
    const std::optional<double> d = quantile_distance(times_of(*aging, (*aging).*member), kOneBlock,
                                                      times_of(*other_aging, (*other_aging).*member), kOneBlock, 1);
    return d ? 100.0 * *d / span() : kAll;
  };
  switch (which) {
    case FitFigure::ColorDistribution: {
      const std::vector<std::uint16_t> blocks(other.num_texels(), 0);
      const std::vector<SortedColors> list = sorted_colors(other, blocks, options);
      double sum = 0.0;
      for (std::size_t t = 0; t < list.size(); ++t) sum += *sliced_distance(colors[t], kOneBlock, list[t], kOneBlock);
      return sum / static_cast<double>(list.size());
    }
    case FitFigure::MeanColor: {
      const std::vector<double> means_b = mean_lab(other);
      double sum = 0.0;
      for (std::size_t i = 0; i < means.size(); ++i) sum += (means[i] - means_b[i]) * (means[i] - means_b[i]);
      return std::sqrt(sum / static_cast<double>(stack.num_times()));
    }
    case FitFigure::Covered:
      return share_distance(covered_share(*aging, stack.num_times()), covered_share(*other_aging, stack.num_times()));
    case FitFigure::Onset:
      return distance_of(&TexelAging::onset);
    case FitFigure::Saturation:
      return distance_of(&TexelAging::saturation);
    case FitFigure::ColorByControl:
      return by_control(false, frames, other, control, problem);
    case FitFigure::RateByControl:
      return by_control(true, frames, other, control, problem);
    case FitFigure::Ciede2000:
      return place_by_place(other, control, problem);
    case FitFigure::Contrast:
      return contrast(other, problem);
    case FitFigure::Rusted:
      return share_distance(rusted, rusted_share(other, control));
  }
  return std::nullopt;
}

ObjectiveValue FitObjective::operator()(const AgedSurface& frames, const RunControl& control) const {
  const State& s = *state_;
  const ColorStack other = s.simulated_stack(frames, control);
  std::optional<TexelAging> aging;
  if (s.aging) aging = texel_aging(other, s.options.visible_delta_e, control);
  ObjectiveValue out;
  double sum = 0.0, weights = 0.0;
  for (const FitTerm& term : s.terms) {
    out.figures.push_back(s.figure(term.figure, frames, other, aging, control, out.problem));
    if (out.figures.back()) {
      sum += term.weight * *out.figures.back();
      weights += term.weight;
    } else {
      out.problem = std::string(kFitFigureNames[static_cast<std::size_t>(term.figure)]) + ": " + out.problem;
    }
  }
  if (std::all_of(out.figures.begin(), out.figures.end(), [](const auto& f) { return f.has_value(); })) {
    out.objective = sum / weights;
    out.problem.clear();
  }
  return out;
}

}  // namespace patinate::analysis
