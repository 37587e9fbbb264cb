#include "libcommon/job/job.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <system_error>

#include "libcommon/core/file_name.h"
#include "libcommon/core/files.h"
#include "libcommon/core/input_watch.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/temporary_file.h"
#include "libcommon/job/output_state.h"
#include "libcommon/job/partial_folder.h"
#include "libcommon/job/stage_run.h"
#include "libcommon/job/undeclared_output.h"
#include "patinate/core/json.h"

namespace patinate {

namespace fs = std::filesystem;

void check_plan(const JobPlan& plan) {
  std::set<std::string> names;
  for (const JobItem& item : plan.items) {
    if (!is_file_name(item.name) || !names.insert(item.name).second) {
      throw InvalidInput("job: `" + item.name + "` is no unique item name of " + file_name_text());
    }
    if (!(item.weight > 0.0)) throw InvalidInput("job: the weight of `" + item.name + "` is not > 0");
    for (const auto* outputs : {&item.outputs, &item.optional_outputs}) {
      for (const fs::path& output : *outputs) {
        if (output.is_absolute() || output.empty() || *output.lexically_normal().begin() == "..") {
          throw InvalidInput("job: the output `" + output.string() + "` lies outside the folder");
        }
      }
    }
  }
  for (const fs::path& file : plan.shared_work) {
    if (!is_work(file)) throw InvalidInput("job: `" + file.string() + "` lies outside the work folder");
  }
}

namespace {

/// Indices of the items that are still to be run, when everything else has been brought into the folder.
/// @param is_same_plan  The folder was made under the plan's key before.
std::vector<std::size_t> prepare_items(const JobPlan& plan, const OutputState& state, PartialFolder& folder,
                                       bool is_same_plan, const RunControl& control) {
  std::vector<std::size_t> unfinished, pending;
  std::set<std::string> finished_items;
  std::set<fs::path> kept_files;
  for (std::size_t i = 0; i < plan.items.size(); ++i) {
    control.throw_if_stopped();
    const JobItem& item = plan.items[i];
    const std::string key = item_key(plan, item);
    auto files = finished_files(folder.path(), item, key);
    if (!files && folder.finish_written(item, key, control)) files = finished_files(folder.path(), item, key);
    if (!files) {
      unfinished.push_back(i);
      continue;
    }
    finished_items.insert(item.name);
    for (const fs::path& file : *files) kept_files.insert(file.lexically_normal());
  }
  folder.forget_written();
  if (is_same_plan) {
    for (const fs::path& file : plan.shared_work) kept_files.insert(file.lexically_normal());
  }
  folder.keep_only(finished_items, kept_files, control);
  for (std::size_t i : unfinished) {
    control.throw_if_stopped();
    const DoneItem* done = reusable_item(state, plan.items[i]);
    if (!done || !folder.adopt(state.output, plan.items[i], *done)) pending.push_back(i);
  }
  return pending;
}

void run_items(const JobPlan& plan, const OutputState& state, PartialFolder& folder, bool is_same_plan,
               const JobOptions& options, const RunControl& control) {
  ItemProgress progress(control, plan);
  const std::vector<std::size_t> pending = prepare_items(plan, state, folder, is_same_plan, control);
  std::set<std::size_t> is_pending(pending.begin(), pending.end());
  std::map<int, std::vector<std::size_t>> stages;
  std::set<std::string> names;
  std::string last;
  for (std::size_t i = 0; i < plan.items.size(); ++i) {
    if (!is_pending.contains(i)) last = plan.items[i].name;
    names.insert(plan.items[i].name);
    if (is_pending.contains(i))
      stages[plan.items[i].stage].push_back(i);
    else
      progress.set(i, 1.0);
  }
  if (options.on_resume && !last.empty())
    options.on_resume(plan.items.size() - pending.size(), plan.items.size(), last);
  for (const auto& [stage, items] : stages) {
    run_side_by_side(
        plan, items, folder.path(), progress, control,
        [&](const JobItem& item) { folder.mark_done(item, item_key(plan, item), control); },
        [&](const JobItem& item) { folder.mark_written(item, item_key(plan, item)); });
  }

  const InputStep join_step;
  plan.join(folder.path(), progress.item_control(plan.items.size(), thread_count(control)));
  if (manifest_key(folder.path(), plan.manifest) != plan.key) {
    throw CannotComplete((folder.path() / plan.manifest).string() + ": was not written by the last step");
  }
  folder.write_record({plan.key, plan.depends_on, {}}, names, control);
}

/// The share of the progress that publishing has: a marker for each item is removed, and where an output is replaced
/// its files, of an item about three; 4.5 ms each where they were forced to the disk (measured on 1,500 items; of few
/// large ones it is nothing). 0 of plans that do not say what a weight takes.
double publish_share(const JobPlan& plan, bool is_replaced, const RunControl& control) {
  constexpr double kFileSeconds = 0.0045;
  double seconds = plan.weight_seconds * plan.join_weight;
  for (const JobItem& item : plan.items) seconds += plan.weight_seconds * item.weight / thread_count(control);
  const double publish = (is_replaced ? 4.0 : 1.0) * kFileSeconds * static_cast<double>(plan.items.size());
  return seconds > 0.0 ? publish / (seconds + publish) : 0.0;
}

/// Removes what an earlier --force run was killed while removing.
void remove_leftover(const fs::path& output, const std::string& manifest) {
  std::error_code error;
  if (!fs::exists(output.string() + ".partial", error)) return;
  try {
    PartialFolder(output, manifest).discard();
  } catch (const CannotComplete&) {
    // In use or not ours: the finished output does not depend on it.
  }
}

}  // namespace

JobStatus run_job(const JobPlan& plan, const JobOptions& options, const RunControl& control) try {
  check_plan(plan);
  require_unchanged_inputs();  // That the plan is made of.
  OutputState state = look_at_output(plan, options);
  require_replaceable(state, options);
  if (state.found == FoundOutput::Same) {
    remove_leftover(state.output, plan.manifest);
    control.report(1.0);
    return JobStatus::UpToDate;
  }
  PartialFolder folder(state.output, plan.manifest);
  // Looked at again under the lock: another run may have finished in between.
  state = look_at_output(plan, options);
  require_replaceable(state, options);
  if (state.found == FoundOutput::Same) {
    folder.discard();
    control.report(1.0);
    return JobStatus::UpToDate;
  }
  const double made = 1.0 - publish_share(plan, state.found == FoundOutput::Different, control);
  // Work that is made again does not come from the folder that an earlier run was killed while removing.
  if (state.is_made_again || !is_partial_whole(folder.path(), plan.manifest, plan.key)) {
    try {
      const bool is_same_plan = folder.begin(plan.key);
      run_items(plan, state, folder, is_same_plan, options, control.part(0.0, made));
      if (options.add_record) options.add_record(folder.path());
    } catch (const InputChanged&) {
      folder.discard();
      throw;
    } catch (const UndeclaredOutput&) {
      folder.discard();  // Markers of items that wrote more than they said vouch for too little.
      throw;
    } catch (...) {
      if (!folder.has_done_items()) folder.discard();
      throw;
    }
  }
  folder.publish(state.found == FoundOutput::Different, made < 1.0 ? control.part(made, 1.0) : control.silent());
  control.report(1.0);
  return JobStatus::Done;
} catch (const fs::filesystem_error& e) {
  fail_written(e);
}

namespace {

JobStatus check_one_output(const OutputFile& file, const std::string& key, const JobOptions& options) {
  const std::string name = file.path.string();
  std::error_code error;
  if (file.is_folder && fs::is_directory(file.path, error) && fs::is_empty(file.path, error)) return JobStatus::Done;
  if (!fs::exists(file.path, error)) {
    require_file_place(file.path);  // Before minutes of work, and under the name that was given.
    return JobStatus::Done;
  }
  const bool is_folder = fs::is_directory(file.path, error);
  if (is_folder && !file.is_folder)
    throw CannotComplete(name + ": is a folder; the output is a file, give another name");
  if (!is_folder && file.is_folder) throw CannotComplete(name + ": is no folder; give another name");
  if (!is_folder && !fs::is_regular_file(file.path, error))
    throw CannotComplete(name + ": is no regular file; give another name");
  if (!key.empty() && file.existing_key == key)
    return file.lacks_files || (options.force && !options.keeps_same) ? JobStatus::Done : JobStatus::UpToDate;
  if (options.force) return JobStatus::Done;
  throw CannotComplete(name +
                       ": exists and was made from other input or options, or is damaged; give --force to replace it, "
                       "or another output");
}

}  // namespace

JobStatus check_output_files(const std::vector<OutputFile>& files, const std::string& key, const JobOptions& options) {
  JobStatus all = JobStatus::UpToDate;
  for (const OutputFile& file : files) {
    if (check_one_output(file, key, options) == JobStatus::Done) all = JobStatus::Done;
  }
  return all;
}

JobStatus check_output_file(const fs::path& output, const std::string& existing_key, const std::string& key,
                            const JobOptions& options) {
  return check_one_output({.path = output, .existing_key = existing_key}, key, options);
}

void write_run_record(const fs::path& folder, const std::vector<std::string>& command_line, double seconds,
                      const Json& options) {
  std::array<char, 256> host{};
  if (::gethostname(host.data(), host.size() - 1) != 0) host[0] = '\0';
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  ::gmtime_r(&now, &utc);
  std::array<char, 32> date{};
  std::strftime(date.data(), date.size(), "%Y-%m-%dT%H:%M:%SZ", &utc);
  save_json(folder / "run.json", Json{{"date", date.data()},
                                      {"command", command_line},
                                      {"host", host.data()},
                                      {"seconds", seconds},
                                      {"options", options}});
}

}  // namespace patinate
