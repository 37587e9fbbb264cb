#include "analysis/fit/field_job.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <utility>

#include "analysis/compare/sections.h"
#include "analysis/figures/correspondence.h"
#include "analysis/fit/field_report.h"
#include "analysis/fit/field_work.h"
#include "analysis/fit/fit_outcome.h"
#include "analysis/report/report_page.h"
#include "libcommon/core/text.h"
#include "libcommon/output/contact_strip.h"
#include "libcommon/output/map_legend.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"

namespace patinate::analysis {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kFieldVersion = 1;  ///< Raised when the same input gives other fields or another report.
constexpr int kMapSide = 360;              ///< Map side of a field on the page, px.
constexpr int kShownSide = 200;            ///< Shown side of a picture on the page, px.

/// Masks alone, for have_same_charts().
ColorStack masked(const ImageU8& mask) {
  ColorStack stack;
  stack.width = mask.width();
  stack.height = mask.height();
  for (std::int64_t i = 0; i < mask.num_pixels(); ++i) {
    if (mask.data()[i] != 0) stack.texels.push_back(static_cast<std::uint32_t>(i));
  }
  return stack;
}

void check_places(const FieldTask& task, const TextureSeries& captured) {
  const std::string sizes = size_text(captured.width(), captured.height()) + " pixels, the scene's atlas " +
                            size_text(task.outline.width, task.outline.height);
  if (std::int64_t{captured.width()} * task.outline.height != std::int64_t{captured.height()} * task.outline.width)
    throw InvalidInput(captured.name() + ": has " + sizes + ": its pixels cannot be places of another shape");
  const StackSize a = stack_size(captured, task.options.places_size),
                  b = stack_size(task.outline.width, task.outline.height, task.options.places_size);
  if (a.width != b.width || a.height != b.height)
    throw InvalidInput("--places-size: found " + std::to_string(task.options.places_size) + "; expected at most " +
                       std::to_string(std::max(std::min(a.width, b.width), std::min(a.height, b.height))) +
                       ", which both sides have (" + captured.name() + ": " + sizes + ")");
  if (task.options.places == FieldPlaces::Equal) return;
  const bool is_same =
      captured.width() == task.outline.width && captured.height() == task.outline.height &&
      have_same_charts(masked(captured.mask(captured.facts().frames.front().time)), masked(task.coverage));
  if (!is_same)
    throw InvalidInput(captured.name() +
                       ": nothing says that its pixels show the places of the scene's atlas, which a field needs; give "
                       "--places equal if they do");
}

/// Colors of a level, at the places and times that are compared: a row a time, and each place's texel.
void save_colors(FieldWork& work, const FieldStep& step, int level, const fs::path& folder, const RunControl& control) {
  const AgedSurface surface = work.task.age(work.maps_of_level(folder, step, level), control.part(0.0, 0.9));
  const ColorStack stack = work.simulated(surface, FitFrames::Seen, control.silent());
  ImageF image(static_cast<int>(stack.num_texels()), static_cast<int>(stack.num_times()), 4);
  for (std::size_t t = 0; t < stack.num_times(); ++t) {
    for (std::size_t i = 0; i < stack.num_texels(); ++i) {
      float* out = image.data() + 4 * (t * stack.num_texels() + i);
      std::copy_n(stack.lab_of(t, i), 3, out);
      out[3] = static_cast<float>(stack.texels[i]);
    }
  }
  fs::create_directories(folder / kJobWorkFolder);
  write_exr(folder / FieldWork::colors_file(step, level), image, {"L", "a", "b", "texel"}, ExrDepth::Float);
}

void solve(FieldWork& work, const FieldStep& step, const fs::path& folder, const RunControl& control) {
  PlaceFieldOptions options;
  options.num_waves = step.kind == FieldStep::Kind::Flat ? 1 : work.task.options.waves;
  save_field(folder / FieldWork::field_file(step),
             fit_place_field(work.colors_of(folder, step, control), options, control));
}

void add_items(const std::shared_ptr<FieldWork>& work, JobPlan& plan) {
  for (const FieldStep& step : work->steps) {
    for (int k = 0; k < work->num_levels(step); ++k) {
      plan.items.push_back(
          {.name = step.level_name(k),
           .outputs = {FieldWork::colors_file(step, k)},
           .run = [work, step, k](const fs::path& folder,
                                  const RunControl& control) { save_colors(*work, step, k, folder, control); },
           .stage = 2 * step.number});
    }
    plan.items.push_back({.name = step.solve_name(),
                          .outputs = {FieldWork::field_file(step)},
                          .run = [work, step](const fs::path& folder,
                                              const RunControl& control) { solve(*work, step, folder, control); },
                          .stage = 2 * step.number + 1});
  }
}

/// How far surfaces are, place by place and by their colors.
class Judge {
 public:
  Judge(FieldWork& work, const RunControl& control) : work_(work), control_(control.silent()) {
    const SeriesFile file = open_series(work.task.history);
    const std::vector<FitTerm> terms{{}};
    seen_.emplace(file.series, work.task.outline, terms, objective_options(work.task.options), FitFrames::Seen,
                  control_);
    if (work.task.options.until)
      held_out_.emplace(file.series, work.task.outline, terms, objective_options(work.task.options), FitFrames::HeldOut,
                        control_);
  }

  [[nodiscard]] FieldMisfits operator()(const AgedSurface& surface) const {
    FieldMisfits m;
    m.seen = {work_.misfit_by_place(surface, FitFrames::Seen, control_), (*seen_)(surface, control_).objective};
    if (held_out_)
      m.held_out = FieldMisfit{work_.misfit_by_place(surface, FitFrames::HeldOut, control_),
                               (*held_out_)(surface, control_).objective};
    return m;
  }

  [[nodiscard]] const std::optional<FitObjective>& seen() const { return seen_; }
  [[nodiscard]] const std::optional<FitObjective>& held_out() const { return held_out_; }

 private:
  FieldWork& work_;
  RunControl control_;
  std::optional<FitObjective> seen_, held_out_;
};

/// A field as a picture: octaves over the best single number, or the difference to it of a linear range.
Picture field_picture(const FitParameter& p, const FoundField& f, const ImageF& map, std::size_t number) {
  const bool is_log = p.range.scale == FitScale::Log;
  ImageF shown(map.width(), map.height());
  float most = 0.0F;
  for (std::int64_t i = 0; i < map.num_pixels(); ++i) {
    const auto v = static_cast<double>(map.data()[i]);
    shown.data()[i] = static_cast<float>(is_log ? std::log2(v / f.single) : v - f.single);
    most = std::max(most, std::abs(shown.data()[i]));
  }
  const double end = std::max(1e-6, rounded(static_cast<double>(most), 2));
  const ImageF picture = ramp_picture(shown, {}, -end, end, ColorRamp::Diverging);
  const int factor = std::max(1, kMapSide / picture.width());
  ImageF large(picture.width() * factor, picture.height() * factor, 3);
  for (int y = 0; y < large.height(); ++y) {
    for (int x = 0; x < large.width(); ++x) {
      for (int c = 0; c < 3; ++c) large.at(x, y, c) = picture.at(x / factor, y / factor, c);
    }
  }
  const std::string unit = p.unit.empty() ? "" : " " + p.unit;
  return {.name = "field_" + std::to_string(number),
          .caption = shown_name(p) + ": " +
                     (is_log ? "octaves (doublings) over the best for all places, "
                             : "difference to the best for all places, ") +
                     short_number_text(rounded(f.single, 4)) + unit,
          .image = with_legend(large,
                               {.ramp = ColorRamp::Diverging, .low = -end, .high = end, .unit = is_log ? "" : p.unit})};
}

/// The capture and two simulations at some of the compared times.
std::vector<Picture> frame_pictures(FieldWork& work, const AgedSurface& single, const AgedSurface& after,
                                    const RunControl& control) {
  std::vector<Picture> pictures;
  for (const FitFrames frames : {FitFrames::Seen, FitFrames::HeldOut}) {
    if (frames == FitFrames::HeldOut && !work.task.options.until) continue;
    const bool is_seen = frames == FitFrames::Seen;
    const SeriesFile file = open_series(work.task.history);
    const CommonTimes times = fit_times(file.series.facts(), work.task.outline, objective_options(work.task.options),
                                        frames, file.series.name());
    const std::string unit = time_unit_text(file.series.facts().time_unit);
    std::vector<std::string> labels;
    std::vector<double> of_a, of_b;
    for (const std::size_t t : spread_indices(times.clock.size(), kPicturesInARow)) {
      of_a.push_back(times.times_a[t]), of_b.push_back(times.times_b[t]);
      labels.push_back(short_number_text(rounded(times.times_a[t], 4)) + " " + unit);
    }
    const auto add = [&](const std::string& stem, const std::string& caption, const ColorStack& stack) {
      std::vector<ImageF> images;
      for (std::size_t t = 0; t < stack.num_times(); ++t) images.push_back(stack.rgb_image(t));
      pictures.push_back({.name = stem + (is_seen ? "_seen" : "_held_out"),
                          .caption = caption + (is_seen ? "" : ", frames that no search saw"),
                          .image = contact_strip(images, labels, {.label_px = 13})});
    };
    add("captured", "captured", load_stack(file.series, of_a, kShownSide, control));
    add("single", "the best numbers for all places", stack_of(single, of_b, kShownSide, control));
    add("fields", "fields", stack_of(after, of_b, kShownSide, control));
  }
  return pictures;
}

FieldOutcome field_outcome(FieldWork& work, const fs::path& folder, AgedSurface& after, std::vector<ImageF>& maps,
                           const RunControl& control) {
  const FieldTask& task = work.task;
  const RunControl quiet = control.silent();
  FieldOutcome o;
  const Judge judge(work, control);
  const auto age = [&](const std::vector<PlaceField>& fields) {
    ++o.num_simulations;
    return task.age(work.maps_of(fields), quiet);
  };
  const int num_steps = static_cast<int>(work.steps.size());
  const std::vector<PlaceField> start = work.fields_before(folder, 0), found = work.fields_before(folder, num_steps);
  std::vector<PlaceField> single = start;
  o.fields.resize(task.parameters.size());
  for (const FieldStep& step : work.steps) {
    o.num_simulations += work.num_levels(step);
    FoundField& f = o.fields[step.parameter];
    FittedField fitted = read_field(folder / FieldWork::field_file(step));
    const bool is_single =
        step.kind == FieldStep::Kind::Flat || (task.parameters.size() == 1 && step.kind == FieldStep::Kind::Whole);
    if (is_single) single[step.parameter] = {.num_waves = 1, .coefficients = {fitted.flat_value}};
    f.fitted = std::move(fitted);
  }
  maps = work.maps_of(found);
  after = age(found);
  const AgedSurface one = age(single);
  o.before = judge(age(start));
  o.single = judge(one);
  o.after = judge(after);
  for (std::size_t p = 0; p < o.fields.size(); ++p) {
    control.report(0.3 + 0.5 * static_cast<double>(p) / static_cast<double>(o.fields.size()));
    FoundField& f = o.fields[p];
    f.single = value_at(task.parameters[p], single[p].coefficients.front());
    const auto [low, high] = std::minmax_element(maps[p].values().begin(), maps[p].values().end());
    f.low = static_cast<double>(*low), f.high = static_cast<double>(*high);
    if (found[p].num_waves > 1) o.maps.push_back(field_picture(task.parameters[p], f, maps[p], p + 1));
    if (o.fields.size() == 1) continue;
    std::vector<PlaceField> without = found;
    without[p] = {.num_waves = 1, .coefficients = {f.fitted.flat_value}};
    f.without = judge(age(without));
  }
  o.num_times_seen = judge.seen()->num_times();
  o.time_unit = time_unit_text(open_series(task.history).series.facts().time_unit);
  if (judge.held_out()) {
    o.num_times_held_out = judge.held_out()->num_times();
    o.last_frame = last_frame_held(*judge.held_out(), task.history, *task.options.until, quiet);
  }
  o.pictures = frame_pictures(work, one, after, quiet);
  return o;
}

void join_field(FieldWork& work, const fs::path& folder, const std::string& key, const RunControl& control) {
  AgedSurface after;
  std::vector<ImageF> maps;
  FieldOutcome outcome = field_outcome(work, folder, after, maps, control);
  for (std::vector<Picture>* list : {&outcome.maps, &outcome.pictures})
    embed_pictures(*list, folder / kJobWorkFolder / "picture.png");
  work.task.write_model(folder, maps);
  write_surface(folder / "after", after, key + "-after");
  write_field_report(folder, work.task, outcome, key);
}

}  // namespace

void describe(OptionVisitor& v, FieldOptions& o) {
  v.visit({"waves", "Cosines along each side of a field; a field has at most the square of this number of parameters",
           "", between(1, 16)},
          o.waves);
  v.visit({"levels", "Number of simulations with a uniform value, spread over the range of each number", "",
           between(3, 65)},
          o.levels);
  v.visit({"sweeps", "Rounds over several numbers: in each round, every number is searched with the others fixed", "",
           between(1, 10)},
          o.sweeps);
  v.visit({"places_size", "Longer side of the grid on which places are compared; a cell is the mean of its surface",
           "px", between(8, 512)},
          o.places_size);
  v.visit_choice({"places", "Whether the history's pixels show the places of the scene's atlas"}, o.places,
                 kFieldPlacesNames);
  v.visit({"num_times", "Largest number of times at which they are compared", "", between(2, 1024)}, o.num_times);
  v.visit_choice({"clock", "Compare at equal times, or at equal shares of each history's span"}, o.clock, kClockNames);
  v.visit({"until", "Last time that is fitted, in the history's unit; later frames are held out for evaluation", "",
           Range{}},
          o.until);
  v.visit({"size", "Images are reduced to this longer side before color distributions are compared; 0 = not reduced",
           "px", between(0, 65536)},
          o.size);
}

ObjectiveOptions objective_options(const FieldOptions& o) {
  ObjectiveOptions out;
  out.size = o.size;
  out.num_times = o.num_times;
  out.clock = o.clock;
  out.until = o.until;
  return out;
}

JobPlan plan_field(FieldTask task, const fs::path& output) {
  check_ranges(task.options);
  if (task.parameters.empty()) throw InvalidInput("field: no number is named");
  for (const FitParameter& p : task.parameters) {
    if (const std::string problem = start_problem(p); !problem.empty()) throw InvalidInput(problem);
  }
  const SeriesFile file = open_series(task.history);
  check_places(task, file.series);
  JobInputs inputs("field", kFieldVersion);
  inputs.add_content("history", "HISTORY", file.key());
  task.add_inputs(inputs);
  for (const FitParameter& p : task.parameters)
    inputs.add_value("--vary " + p.range.name,
                     number_text(p.range.low) + ":" + number_text(p.range.high) + ":" +
                         std::string(kFitScaleNames[static_cast<std::size_t>(p.range.scale)]));
  inputs.add_options(option_values(task.options));
  const auto work = std::make_shared<FieldWork>(std::move(task));
  JobPlan plan = inputs.plan(output, kFieldReportFile);
  add_items(work, plan);
  plan.join = [work, key = plan.key](const fs::path& folder, const RunControl& control) {
    join_field(*work, folder, key, control);
  };
  return plan;
}

}  // namespace patinate::analysis
