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
#include "libcommon/job/job_inputs.h"
#include "patinate/image/image_io.h"

namespace patinate::analysis {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kStageVersion = 8;  ///< Raised when the same input gives other figures.

/// Pair that items share, loaded when the first of them needs it.
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

/// Output of an item: the section, with its pictures as PNGs inside.
JobItem section_item(const std::shared_ptr<Work>& work, const NamedSection& section) {
  return {.name = section.name,
          .outputs = part_files(section_file(section.name)),
          .run = [work, name = section.name, make = section.make](const fs::path& folder, const RunControl& control) {
            Section made = make(work->loaded(control.part(0.0, 0.3)), work->task.options, control.part(0.3, 1.0));
            embed_pictures(made.pictures, folder / kJobWorkFolder / (name + ".png"));
            fs::create_directories(folder / kJobWorkFolder);
            save_part(folder / section_file(name), section_json(made));
          }};
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
  (void)common_times(a.series.facts(), b.series.facts(), task.options);  // Said before work starts.
  const JobInputs inputs = compare_inputs(task, a, b);
  const auto work = std::make_shared<Work>();
  work->task = std::move(task);
  JobPlan plan = inputs.plan(output, kCompareReportFile);
  plan.parallel_items = false;
  std::vector<std::string> names;
  for (const NamedSection& section : compared_sections(work->task.options, a.series.facts(), b.series.facts())) {
    names.push_back(section.name);
    plan.items.push_back(section_item(work, section));
  }
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
