#include "libcommon/job/spread_job.h"

#include <algorithm>
#include <charconv>
#include <limits>
#include <map>
#include <set>
#include <system_error>

#include "libcommon/core/files.h"
#include "libcommon/core/input_watch.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/temporary_file.h"
#include "libcommon/core/text.h"
#include "libcommon/job/item_store.h"
#include "libcommon/job/job_record.h"
#include "libcommon/job/output_state.h"
#include "libcommon/job/partial_folder.h"
#include "libcommon/job/stage_run.h"
#include "patinate/core/error.h"

namespace patinate {

namespace fs = std::filesystem;

namespace {

std::string of_items(const std::vector<std::size_t>& items) {
  return (items.size() == 1 ? "item " : "items ") + item_ranges_text(items);
}

/// Indices of items that are not in the store, of those for which `is_asked`.
template <class IsAsked>
std::vector<std::size_t> missing_items(const JobPlan& plan, const ItemStore& store, IsAsked&& is_asked) {
  std::vector<std::size_t> missing;
  for (std::size_t i = 0; i < plan.items.size(); ++i) {
    if (is_asked(i) && !store.has(plan.items[i])) missing.push_back(i);
  }
  return missing;
}

/// The finished items of stages in [begin, end), in the order of stages: of shared work the last one's stays.
void take_stages(const JobPlan& plan, const ItemStore& store, int begin, int end, const fs::path& folder) {
  std::map<int, std::vector<const JobItem*>> stages;
  for (const JobItem& item : plan.items) {
    if (item.stage >= begin && item.stage < end && store.has(item)) stages[item.stage].push_back(&item);
  }
  for (const auto& [stage, items] : stages) {
    for (const JobItem* item : items) store.take(*item, folder);
  }
}

void drop_earlier_work(const JobPlan& plan, const ItemStore& store, int stage) {
  if (plan.shared_work.empty()) return;
  for (const JobItem& item : plan.items) {
    if (item.stage < stage && store.has(item)) store.drop_shared_work(item);
  }
}

JobRecord record_of(const JobPlan& plan, const ItemStore& store) {
  JobRecord record{plan.key, plan.depends_on, {}};
  for (const JobItem& item : plan.items) {
    DoneItem done = store.read(item);
    std::erase_if(done.files, [](const auto& file) { return is_work(file.first); });
    if (!done.files.empty()) record.items[item.name] = std::move(done);
  }
  return record;
}

/// Puts a whole folder where the output belongs. @returns false if another process was faster.
bool publish(TemporaryFolder& folder, OutputState& state, const JobPlan& plan, const JobOptions& options) {
  const std::string stem = state.output.filename().string();
  for (int attempt = 0; attempt < 3; ++attempt) {
    if (folder.move_to(state.output)) return true;
    state = look_at_output(plan);
    if (state.found == FoundOutput::Same) return false;
    require_replaceable(state, options);
    // Aside by one rename, so that a moment passes without OUT, but none with half of it.
    TemporaryFolder old(folder_of(state.output), stem + ".old");
    fs::rename(state.output, old.path() / "output");
  }
  throw CannotComplete(state.output.string() + ": others put other outputs there all the time");
}

/// Takes over what a finished output holds of items that need not be made again.
void take_over(const JobPlan& plan, const OutputState& state, ItemStore& store, const RunControl& control) {
  if (state.found != FoundOutput::Different) return;
  store.refresh();
  for (const JobItem& item : plan.items) {
    const DoneItem* done = store.has(item) ? nullptr : reusable_item(state, item);
    const auto files = done != nullptr ? made_files(item, *done) : std::nullopt;
    if (!files || std::any_of(files->begin(), files->end(), is_work) || !is_unchanged(state.output, *files, *done))
      continue;
    store.open();
    store.add(item, state.output, control);
  }
}

/// @throws CannotComplete if an item waits for one that is neither finished nor asked for.
void require_earlier_items(const JobPlan& plan, const ItemStore& store,
                           const std::map<int, std::vector<std::size_t>>& asked) {
  std::set<std::size_t> coming;
  for (const auto& [stage, items] : asked) {
    const auto missing = missing_items(
        plan, store, [&, s = stage](std::size_t i) { return plan.items[i].stage < s && !coming.contains(i); });
    coming.insert(items.begin(), items.end());
    if (missing.empty()) continue;
    throw CannotComplete(plan.output.string() + ": item " + std::to_string(items.front()) + " (" +
                         plan.items[items.front()].name + ") waits for " + of_items(missing) +
                         "; run what it waits for first");
  }
}

std::size_t run_items_now(const JobPlan& plan, std::span<const std::size_t> items, const JobOptions& options,
                          const RunControl& control) try {
  require_unchanged_inputs();  // That the plan is made of.
  const OutputState state = look_at_output(plan);
  require_replaceable(state, options);
  if (state.found == FoundOutput::Same) return 0;
  ItemStore store(plan);
  take_over(plan, state, store, control);
  store.refresh();
  std::map<int, std::vector<std::size_t>> stages;
  std::size_t num_run = 0;
  for (const std::size_t i : items) {
    if (store.has(plan.items[i])) continue;
    stages[plan.items[i].stage].push_back(i);
    ++num_run;
  }
  if (stages.empty()) {
    control.report(1.0);
    return 0;
  }
  require_earlier_items(plan, store, stages);
  store.open();
  ItemProgress progress(control, plan);
  TemporaryFolder work(store.path(), "work");
  int first_stage = std::numeric_limits<int>::min();  // First stage of what is not in the work folder yet.
  for (const auto& [stage, asked] : stages) {
    store.refresh();
    take_stages(plan, store, first_stage, stage, work.path());
    first_stage = stage;
    run_side_by_side(plan, asked, work.path(), progress, control, [&](const JobItem& item) {
      store.add(item, work.path(), control);
      drop_earlier_work(plan, store, item.stage);
    });
  }
  control.report(1.0);
  return num_run;
} catch (const fs::filesystem_error& e) {
  fail_written(e);
}

JobStatus join_now(const JobPlan& plan, const JobOptions& options, const RunControl& control) try {
  OutputState state = look_at_output(plan);
  require_replaceable(state, options);
  ItemStore store(plan);
  remove_abandoned(folder_of(state.output), state.output.filename().string() + ".old.");
  if (state.found == FoundOutput::Same) {
    store.remove_all();
    control.report(1.0);
    return JobStatus::UpToDate;
  }
  store.refresh();
  const auto missing = missing_items(plan, store, [](std::size_t) { return true; });
  if (!missing.empty()) throw CannotComplete(unfinished_text(plan.output, missing, plan.items.size()));
  TemporaryFolder folder(folder_of(state.output), state.output.filename().string());
  take_stages(plan, store, std::numeric_limits<int>::min(), std::numeric_limits<int>::max(), folder.path());
  ItemProgress progress(control, plan);
  for (std::size_t i = 0; i < plan.items.size(); ++i) progress.set(i, 1.0);
  const InputStep join_step;
  plan.join(folder.path(), progress.item_control(plan.items.size(), thread_count(control)));
  if (manifest_key(folder.path(), plan.manifest) != plan.key)
    throw CannotComplete((folder.path() / plan.manifest).string() + ": was not written by the last step");
  write_job_record(folder.path(), record_of(plan, store), plan.manifest);
  if (options.add_record) options.add_record(folder.path());
  fs::remove_all(folder.path() / fs::path(kJobWorkFolder).parent_path());
  sync_path(folder.path());
  const bool is_ours = publish(folder, state, plan, options);
  sync_path(folder_of(state.output));
  store.remove_all();
  control.report(1.0);
  return is_ours ? JobStatus::Done : JobStatus::UpToDate;
} catch (const fs::filesystem_error& e) {
  fail_written(e);
}

}  // namespace

SpreadState spread_state(const JobPlan& plan) {
  check_plan(plan);
  SpreadState state;
  state.is_up_to_date = look_at_output(plan).found == FoundOutput::Same;
  ItemStore store(plan);
  store.refresh();
  for (const JobItem& item : plan.items) state.is_finished.push_back(state.is_up_to_date || store.has(item));
  return state;
}

std::vector<std::size_t> waits_for(const JobPlan& plan, std::size_t item) {
  std::vector<std::size_t> earlier;
  for (std::size_t i = 0; i < plan.items.size(); ++i) {
    if (plan.items[i].stage < plan.items[item].stage) earlier.push_back(i);
  }
  return earlier;
}

std::size_t run_spread_items(const JobPlan& plan, std::span<const std::size_t> items, const JobOptions& options,
                             const RunControl& control) try {
  check_plan(plan);
  return run_items_now(plan, items, options, control);
} catch (const Canceled&) {
  throw;
} catch (const Error&) {
  if (look_at_output(plan).found != FoundOutput::Same) throw;
  return 0;  // Another process has joined meanwhile, and removed the items.
}

JobStatus join_spread_items(const JobPlan& plan, const JobOptions& options, const RunControl& control) try {
  check_plan(plan);
  return join_now(plan, options, control);
} catch (const Canceled&) {
  throw;
} catch (const Error&) {
  if (look_at_output(plan).found != FoundOutput::Same) throw;
  return JobStatus::UpToDate;  // As above.
}

std::string unfinished_text(const fs::path& output, std::span<const std::size_t> missing, std::size_t num_items) {
  return output.string() + ": " + std::to_string(missing.size()) + " of " + std::to_string(num_items) +
         (num_items == 1 ? " item is" : " items are") + " not finished: " + item_ranges_text(missing) +
         "; run them, and join again";
}

std::string item_ranges_text(std::span<const std::size_t> items) {
  std::string text;
  for (std::size_t begin = 0; begin < items.size();) {
    std::size_t end = begin + 1;
    while (end < items.size() && items[end] == items[end - 1] + 1) ++end;
    text += (text.empty() ? "" : ", ") + std::to_string(items[begin]);
    if (end - begin > 1) text += "-" + std::to_string(items[end - 1]);
    begin = end;
  }
  return text;
}

std::vector<std::size_t> parse_item_ranges(const std::string& text, std::size_t num_items) {
  const auto fail = [&]() -> std::size_t {
    throw ParseError("found `" + text + "`; expected numbers and ranges of the plan's items, as 0-3,7, each [0, " +
                     std::to_string(num_items == 0 ? 0 : num_items - 1) + "]");
  };
  const auto number = [&](const std::string& word) {
    std::size_t value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    return error == std::errc() && end == word.data() + word.size() && !word.empty() && value < num_items ? value
                                                                                                          : fail();
  };
  std::set<std::size_t> items;
  for (const std::string& part : split(text, ',')) {
    const std::size_t dash = part.find('-');
    const std::size_t first = number(part.substr(0, dash));
    const std::size_t last = dash == std::string::npos ? first : number(part.substr(dash + 1));
    if (last < first) fail();
    for (std::size_t i = first; i <= last; ++i) items.insert(i);
  }
  return {items.begin(), items.end()};
}

}  // namespace patinate
