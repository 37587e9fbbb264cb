#include "analysis/compare/compare_job.h"

#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

#include "analysis/compare/compare_report.h"
#include "analysis/compare/sections.h"
#include "analysis/report/report_page.h"
#include "libcommon/job/cost_model.h"
#include "libcommon/job/job_inputs.h"
#include "patinate/image/image_io.h"

namespace patinate::analysis {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kStageVersion = 8;  ///< Raised when the same input gives other figures.

/// What items share: the pair, loaded when the first of them needs it.
struct Work {
  CompareTask task;
  std::mutex mutex;
  std::optional<ComparedPair> pair;

  const ComparedPair& loaded(const RunControl& control) {
    const std::scoped_lock lock(mutex);
    if (!pair)
      pair.emplace(
          load_pair(open_series(task.a, task.through).series, open_series(task.b).series, task.options, control));
    return *pair;
  }
};

fs::path section_file(const std::string& name) { return fs::path(kJobWorkFolder) / (name + ".json"); }

/// What a section takes before its first pixel, and for a pixel at a time of the compared stacks. Measured in November
/// 2026 on histories of 128 x 96, 256 x 192 and 768 x 576 at three times (docs/scaling.md). Others are not known.
struct SectionCost {
  std::string_view name;
  double seconds, pixel_seconds;
};
constexpr std::array<SectionCost, 6> kSectionCosts{{{"look", 0.02, 2.2e-6},
                                                    {"places", 0.03, 1.8e-6},
                                                    {"colors", 0.16, 2.1e-6},
                                                    {"controls", 0.27, 1.9e-6},
                                                    {"structure", 0.01, 3.4e-6},
                                                    {"materials", 1.5, 2.1e-6}}};
constexpr double kReadPixel_seconds = 1.7e-7;  ///< For a pixel of either history at a time.

/// Pixels of both sides at all times.
struct ComparedPixels {
  double read = 0.0;     ///< Of the histories.
  double stacked = 0.0;  ///< At the size at which they are compared, of one side.

  ComparedPixels(const HistoryFacts& a, const HistoryFacts& b, const CompareOptions& options) {
    const auto num_times = static_cast<double>(common_times(a, b, options).clock.size());
    for (const HistoryFacts* h : {&a, &b}) {
      const double own = static_cast<double>(h->width) * h->height * num_times;
      const double side =
          options.size == 0 ? 1.0 : std::min(1.0, double{1} * options.size / std::max(h->width, h->height));
      read += own / 2.0;
      stacked += side * side * own / 2.0;
    }
  }
  [[nodiscard]] JobCost cost_of(std::string_view section) const {
    for (const SectionCost& c : kSectionCosts) {
      if (c.name == section)
        return {.core_seconds = c.seconds + c.pixel_seconds * stacked + kReadPixel_seconds * read,
                .megabytes = 25.0 + 1.45e-4 * stacked};
    }
    return {};
  }
};

/// What an item leaves: the section, with its pictures as PNGs inside.
JobItem section_item(const std::shared_ptr<Work>& work, const NamedSection& section, const JobCost& cost) {
  return {.name = section.name,
          .outputs = part_files(section_file(section.name)),
          .run =
              [work, name = section.name, make = section.make](const fs::path& folder, const RunControl& control) {
                Section made = make(work->loaded(control.part(0.0, 0.3)), work->task.options, control.part(0.3, 1.0));
                embed_pictures(made.pictures, folder / kJobWorkFolder / (name + ".png"));
                fs::create_directories(folder / kJobWorkFolder);
                save_part(folder / section_file(name), section_json(made));
              },
          .cost = cost};
}

JobInputs compare_inputs(const CompareTask& task, const SeriesFile& a, const SeriesFile& b) {
  JobInputs inputs("compare", kStageVersion);
  inputs.add_content("a", "A", a.key());
  inputs.add_content("b", "B", b.key());
  inputs.add_options(option_values(task.options));
  inputs.add_value("--seed", std::to_string(task.options.seed));
  return inputs;
}

}  // namespace

JobPlan plan_compare(CompareTask task, const fs::path& output) {
  check_ranges(task.options);
  const SeriesFile a = open_series(task.a, task.through), b = open_series(task.b);
  const ComparedPixels pixels(a.series.facts(), b.series.facts(), task.options);  // Said before work starts.
  const JobInputs inputs = compare_inputs(task, a, b);
  const auto work = std::make_shared<Work>();
  work->task = std::move(task);
  JobPlan plan = inputs.plan(output, kCompareReportFile);
  plan.parallel_items = false;
  std::vector<std::string> names;
  for (const NamedSection& section : compared_sections(work->task.options, a.series.facts(), b.series.facts())) {
    names.push_back(section.name);
    plan.items.push_back(section_item(work, section, pixels.cost_of(section.name)));
  }
  plan.join_cost = CostModel{.seconds = 0.05}.of();
  plan.join = [work, names, key = plan.key](const fs::path& folder, const RunControl&) {
    std::vector<Section> made;
    for (const std::string& name : names) made.push_back(section_from_json(load_part(folder / section_file(name))));
    const CompareTask& t = work->task;
    const SeriesFile side_a = open_series(t.a, t.through), side_b = open_series(t.b);
    write_compare_report(folder, {.a = side_a, .b = side_b, .options = t.options, .command = t.command, .key = key},
                         made);
  };
  return plan;
}

}  // namespace patinate::analysis
