#include "libcommon/job/output_state.h"

#include <algorithm>
#include <system_error>

#include "libcommon/core/files.h"
#include "libcommon/job/partial_folder.h"
#include "patinate/core/error.h"

namespace patinate {

namespace fs = std::filesystem;

namespace {

/// "a/b/" and "a/b" are the same folder.
fs::path without_trailing_slash(const fs::path& path) {
  return path.has_filename() || !path.has_parent_path() ? path : path.parent_path();
}

/// Outputs of items, where no record says more.
std::vector<std::string> missing_outputs(const fs::path& output, const JobPlan& plan) {
  std::vector<std::string> missing;
  for (const JobItem& item : plan.items) {
    for (const fs::path& file : item.outputs) {
      std::error_code error;
      if (!is_work(file) && !fs::exists(output / file, error)) missing.push_back(file.generic_string());
    }
  }
  return missing;
}

/// An output of the plan's key by its manifest, or by its record where the manifest is lost or cut off.
void look_at_files(OutputState& state, const JobPlan& plan, bool has_manifest) {
  state.damage = damage_of(state.output, state.record, Looked::AtSizes);
  if (state.record.key.empty()) state.damage.lost = missing_outputs(state.output, plan);
  std::error_code error;
  const bool is_there = fs::exists(state.output / plan.manifest, error);
  if (!has_manifest) (is_there ? state.damage.altered : state.damage.lost).push_back(plan.manifest);
  state.found = state.damage.any() ? FoundOutput::Different : FoundOutput::Same;
}

void look_into(OutputState& state, const JobPlan& plan) {
  const std::string key = manifest_key(state.output, plan.manifest);
  const bool is_same = key.empty() || key == plan.key;
  state.record = read_job_record(state.output, is_same ? plan.key : key);
  if (key.empty() && state.record.key.empty()) {
    throw CannotComplete(state.output.string() + ": exists and holds no " + plan.manifest +
                         " of patinate, so it is left untouched; give another output");
  }
  if (is_same) return look_at_files(state, plan, !key.empty());
  state.found = FoundOutput::Different;
  if (state.record.key.empty()) return;
  state.changes = changes_between(state.record.depends_on, plan.depends_on);
  state.only_grows = plan.may_grow && !state.changes.empty() && !state.record.depends_on.empty() &&
                     std::all_of(state.changes.begin(), state.changes.end(),
                                 [](const JobChange& c) { return c.kind == JobChange::Kind::Added; });
}

/// "photos/day07.jpg changed and 2 more", for one line.
std::string summary(const std::vector<JobChange>& changes) {
  if (changes.empty()) return "";
  const JobChange& c = changes.front();
  std::string text = c.name;
  text += c.kind == JobChange::Kind::Added ? " is new" : c.kind == JobChange::Kind::Removed ? " is gone" : " changed";
  if (changes.size() > 1) text += " and " + std::to_string(changes.size() - 1) + " more";
  return " (" + text + ")";
}

/// "frames/0003.exr and 2 more", for one line.
std::string some_of(const std::vector<std::string>& files) {
  return files.front() + (files.size() > 1 ? " and " + std::to_string(files.size() - 1) + " more" : "");
}

}  // namespace

OutputState look_at_output(const JobPlan& plan, const JobOptions& options) {
  OutputState state = look_at_output(plan);
  if (!options.force || options.keeps_same || (state.found != FoundOutput::Same && !state.damage.any())) return state;
  state.found = FoundOutput::Different;
  state.record = {};
  state.is_made_again = !state.damage.any();
  return state;
}

OutputState look_at_output(const JobPlan& plan) {
  OutputState state;
  state.output = without_trailing_slash(plan.output);
  std::error_code error;
  const fs::file_status status = fs::status(state.output, error);
  if (!fs::exists(status)) {
    const fs::path parent = folder_of(state.output);
    if (!fs::is_directory(parent, error)) {
      throw CannotComplete(state.output.string() + ": cannot be made; the folder " + parent.string() +
                           " does not exist");
    }
    return state;
  }
  if (!fs::is_directory(status)) {
    throw CannotComplete(state.output.string() + ": is a file; the output is a folder, give another name");
  }
  if (!fs::is_empty(state.output, error) || error) look_into(state, plan);
  return state;
}

void require_replaceable(const OutputState& state, const JobOptions& options) {
  if (state.found != FoundOutput::Different || options.force || state.only_grows) return;
  if (!state.damage.altered.empty()) {
    throw CannotComplete(state.output.string() + ": " + some_of(state.damage.altered) +
                         " is no longer what was made; give --force to make it again, or another output");
  }
  if (state.damage.any()) return;  // Nothing is lost that is there.
  throw CannotComplete(state.output.string() + ": exists and was made from other input or options" +
                       summary(state.changes) + "; give --force to replace it, or another output");
}

const std::string& item_key(const JobPlan& plan, const JobItem& item) { return item.key.empty() ? plan.key : item.key; }

const DoneItem* reusable_item(const OutputState& state, const JobItem& item) {
  const auto it = state.record.items.find(item.name);
  return it == state.record.items.end() || item.key.empty() || it->second.key != item.key ? nullptr : &it->second;
}

}  // namespace patinate
