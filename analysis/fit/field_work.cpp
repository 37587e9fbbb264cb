#include "analysis/fit/field_work.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <utility>

#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/image/image_io.h"

namespace patinate::analysis {

namespace fs = std::filesystem;

namespace {

constexpr int kNearLevels = 5;  ///< From one level of a range below the field to one above, in halves.

PlaceField everywhere(double unit) { return {.num_waves = 1, .coefficients = {unit}}; }

std::optional<double> read_positive_or_null(const JsonReader& v) {
  return v.is_null() ? std::nullopt : std::optional<double>(v.number(above(0)));
}

}  // namespace

FieldWork::FieldWork(FieldTask given) : task(std::move(given)) {
  const HistoryFacts& facts = open_series(task.history).series.facts();
  const std::string name = open_series(task.history).series.name();
  seen_ = fit_times(facts, task.outline, objective_options(task.options), FitFrames::Seen, name);
  if (task.options.until)
    held_out_ = fit_times(facts, task.outline, objective_options(task.options), FitFrames::HeldOut, name);
  const std::size_t n = task.parameters.size();
  const auto sweep = [&](FieldStep::Kind kind) {
    for (std::size_t p = 0; p < n; ++p)
      steps.push_back({.kind = kind, .parameter = p, .number = static_cast<int>(steps.size())});
  };
  if (n > 1) sweep(FieldStep::Kind::Flat);
  for (int s = 0; s < (n > 1 ? task.options.sweeps : 1); ++s) sweep(FieldStep::Kind::Whole);
  sweep(FieldStep::Kind::Near);
}

int FieldWork::num_levels(const FieldStep& step) const {
  return step.kind == FieldStep::Kind::Near ? kNearLevels : task.options.levels;
}

fs::path FieldWork::colors_file(const FieldStep& step, int level) {
  return fs::path(kJobWorkFolder) / (step.level_name(level) + ".exr");
}
fs::path FieldWork::field_file(const FieldStep& step) {
  return fs::path(kJobWorkFolder) / (step.solve_name() + ".json");
}

const ColorStack& FieldWork::captured(FitFrames frames, const RunControl& control) {
  const std::scoped_lock lock(mutex_);
  const bool is_seen = frames == FitFrames::Seen;
  std::optional<ColorStack>& stack = is_seen ? captured_seen_ : captured_held_out_;
  if (!stack) {
    const SeriesFile file = open_series(task.history);
    stack = load_stack(file.series, (is_seen ? seen_ : held_out_).times_a, task.options.places_size, control);
    stack->times = (is_seen ? seen_ : held_out_).clock;
  }
  return *stack;
}

ColorStack FieldWork::simulated(const AgedSurface& surface, FitFrames frames, const RunControl& control) {
  const CommonTimes& times = frames == FitFrames::Seen ? seen_ : held_out_;
  ColorStack stack = stack_of(surface, times.times_b, task.options.places_size, control);
  stack.times = times.clock;
  const ColorStack& other = captured(frames, control);
  std::vector<std::uint32_t> shared;
  std::set_intersection(other.texels.begin(), other.texels.end(), stack.texels.begin(), stack.texels.end(),
                        std::back_inserter(shared));
  if (shared.empty()) throw InvalidInput(task.model_name + ": its surface and the captured one share no place");
  return restricted(stack, shared);
}

double FieldWork::misfit_by_place(const AgedSurface& surface, FitFrames frames, const RunControl& control) {
  const ColorStack b = simulated(surface, frames, control), a = restricted(captured(frames, control), b.texels);
  double sum = 0.0;
  for (std::size_t i = 0; i < a.lab.size(); ++i)
    sum += std::pow(static_cast<double>(a.lab[i]) - static_cast<double>(b.lab[i]), 2);
  return std::sqrt(3.0 * sum / static_cast<double>(a.lab.size()));
}

std::vector<PlaceField> FieldWork::fields_before(const fs::path& folder, int step) const {
  std::vector<PlaceField> fields;
  for (const FitParameter& p : task.parameters) fields.push_back(everywhere(unit_at(p, p.start)));
  for (const FieldStep& s : steps) {
    if (s.number < step) fields[s.parameter] = read_field(folder / field_file(s)).field;
  }
  return fields;
}

std::vector<ImageF> FieldWork::maps_of(const std::vector<PlaceField>& fields) const {
  std::vector<ImageF> maps;
  for (std::size_t p = 0; p < fields.size(); ++p) {
    const bool is_flat = fields[p].num_waves == 1;
    ImageF& map = maps.emplace_back(is_flat ? 1 : task.outline.width, is_flat ? 1 : task.outline.height);
    for (int y = 0; y < map.height(); ++y) {
      for (int x = 0; x < map.width(); ++x)
        map.at(x, y) = static_cast<float>(
            value_at(task.parameters[p], fields[p].at((x + 0.5) / map.width(), (y + 0.5) / map.height())));
    }
  }
  return maps;
}

PlaceField FieldWork::field_of_level(const std::vector<PlaceField>& before, const FieldStep& step, int level) const {
  const double spacing = 1.0 / (task.options.levels - 1);
  if (step.kind != FieldStep::Kind::Near) return everywhere(level * spacing);
  PlaceField field = before[step.parameter];
  field.coefficients.front() += 2.0 * spacing * (static_cast<double>(level) / (kNearLevels - 1) - 0.5);
  return field;
}

std::vector<ImageF> FieldWork::maps_of_level(const fs::path& folder, const FieldStep& step, int level) const {
  std::vector<PlaceField> fields = fields_before(folder, step.number);
  fields[step.parameter] = field_of_level(fields, step, level);
  return maps_of(fields);
}

FieldColors FieldWork::colors_of(const fs::path& folder, const FieldStep& step, const RunControl& control) {
  FieldColors colors;
  const std::vector<PlaceField> before = fields_before(folder, step.number);
  std::vector<std::uint32_t> texels;
  const ColorStack& whole = captured(FitFrames::Seen, control);
  for (int level = 0; level < num_levels(step); ++level) {
    const ImageF image = read_channels(folder / colors_file(step, level), {"L", "a", "b", "texel"});
    const auto n = static_cast<std::size_t>(image.width());
    if (level == 0) {
      for (std::size_t i = 0; i < n; ++i) texels.push_back(static_cast<std::uint32_t>(image.data()[4 * i + 3]));
    }
    std::vector<float>& lab = colors.levels.emplace_back();
    for (std::int64_t i = 0; i < image.num_pixels(); ++i)
      lab.insert(lab.end(), image.data() + 4 * i, image.data() + 4 * i + 3);
    const PlaceField field = field_of_level(before, step, level);
    std::vector<float>& values = colors.values.emplace_back();
    for (const std::uint32_t t : texels) {
      const double x = (t % static_cast<std::uint32_t>(whole.width) + 0.5) / whole.width,
                   y = (static_cast<double>(t / static_cast<std::uint32_t>(whole.width)) + 0.5) / whole.height;
      if (level == 0) colors.places.push_back({x, y});
      values.push_back(static_cast<float>(std::clamp(field.at(x, y), 0.0, 1.0)));
    }
  }
  const ColorStack a = restricted(whole, texels);
  colors.num_times = a.num_times();
  colors.captured = a.lab;
  return colors;
}

void save_field(const fs::path& file, const FittedField& f) {
  Json trials = Json::array();
  for (const SmoothnessTrial& t : f.trials)
    trials.push_back({{"smoothness", optional_json(t.smoothness)}, {"left_out", t.left_out}});
  save_json(file, Json{{"waves", f.field.num_waves},
                       {"coefficients", f.field.coefficients},
                       {"smoothness", optional_json(f.smoothness)},
                       {"trials", trials},
                       {"misfit", f.misfit},
                       {"flat_misfit", f.flat_misfit},
                       {"flat_value", f.flat_value},
                       {"num_effective", f.num_effective}});
}

FittedField read_field(const fs::path& file) {
  const Json root = load_json(file);
  JsonReader json(file.string(), root);
  FittedField f;
  f.field.num_waves = static_cast<int>(json.member("waves").integer(between(1, 16)));
  f.field.coefficients =
      json.member("coefficients")
          .numbers(static_cast<std::size_t>(f.field.num_waves) * static_cast<std::size_t>(f.field.num_waves));
  f.smoothness = read_positive_or_null(json.member("smoothness"));
  for (JsonReader& t : json.member("trials").elements(100))
    f.trials.push_back({.smoothness = read_positive_or_null(t.member("smoothness")),
                        .left_out = t.member("left_out").number(at_least(0))});
  f.misfit = json.member("misfit").number(at_least(0));
  f.flat_misfit = json.member("flat_misfit").number(at_least(0));
  f.flat_value = json.member("flat_value").number();
  f.num_effective = json.member("num_effective").number();
  json.finish();
  return f;
}

}  // namespace patinate::analysis
