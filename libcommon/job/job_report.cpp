#include "libcommon/job/job_report.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <nlohmann/json.hpp>

#include "libcommon/job/output_state.h"
#include "libcommon/job/partial_folder.h"
#include "patinate/core/error.h"

namespace patinate {

namespace fs = std::filesystem;

namespace {

constexpr std::array<const char*, 4> kNeedNames{"nothing", "make", "grow", "replace"};
constexpr std::array<const char*, 3> kItemNeedNames{"run", "resume", "reuse"};
constexpr std::array<const char*, 3> kChangeNames{"added", "removed", "changed"};

const char* name_of(OutputNeed need) { return kNeedNames[static_cast<std::size_t>(need)]; }
const char* name_of(ItemNeed need) { return kItemNeedNames[static_cast<std::size_t>(need)]; }
const char* name_of(JobChange::Kind kind) { return kChangeNames[static_cast<std::size_t>(kind)]; }

bool is_content_key(const std::string& key) {
  return key.size() == 32 && std::all_of(key.begin(), key.end(), [](unsigned char c) { return std::isxdigit(c) != 0; });
}

std::string line_of(const JobChange& change) {
  if (change.kind == JobChange::Kind::Added) return change.name + " is new";
  if (change.kind == JobChange::Kind::Removed) return change.name + " is gone";
  if (is_content_key(change.before) && is_content_key(change.now)) return change.name + " has other content";
  const auto said = [](const std::string& value) { return value.empty() ? "not given" : "`" + value + "`"; };
  return change.name + " was " + said(change.before) + ", is " + said(change.now);
}

/// "3 frames: a, b, c", at most a handful of names.
std::string item_line(const JobReport& report, ItemNeed need, const std::string& label) {
  constexpr std::size_t kMaxNames = 8;
  std::size_t count = 0;
  std::string names;
  for (const JobReport::Item& item : report.items) {
    if (item.need != need) continue;
    if (++count <= kMaxNames) names += (count == 1 ? "" : ", ") + item.name;
  }
  if (count == 0) return "";
  if (count > kMaxNames) names += ", ... and " + std::to_string(count - kMaxNames) + " more";
  return "\n  " + label + " " + std::to_string(count) + ": " + names;
}

std::string headline(const JobReport& report) {
  switch (report.need) {
    case OutputNeed::UpToDate:
      return "would do nothing";
    case OutputNeed::Missing:
      return "would make it";
    case OutputNeed::Grown:
      return "would make a longer one in its place; nothing in it is lost";
    default:
      return report.needs_force() ? "would leave it untouched; --force would replace it" : "would replace it";
  }
}

ItemNeed need_of(const JobPlan& plan, const JobItem& item, const OutputState& state) {
  if (finished_files(partial_path(state.output), item, item_key(plan, item))) return ItemNeed::Resume;
  const DoneItem* done = reusable_item(state, item);
  const auto files = done ? made_files(item, *done) : std::nullopt;
  return files && is_unchanged(state.output, *files, *done) ? ItemNeed::Reuse : ItemNeed::Run;
}

}  // namespace

std::vector<std::string> JobReport::reasons() const {
  std::vector<std::string> lines;
  if (need == OutputNeed::UpToDate) lines.push_back("up to date");
  if (is_made_again) return {"up to date, and --force makes it again"};
  if (need == OutputNeed::Missing && !damage.any()) lines.push_back("it does not exist");
  if (need == OutputNeed::Stale && changes.empty() && !damage.any())
    lines.push_back("it was made from other input or options");
  for (const std::string& file : damage.lost) lines.push_back(file + " is lost");
  for (const std::string& file : damage.altered) lines.push_back(file + " is no longer what was made");
  for (const JobChange& change : changes) lines.push_back(line_of(change));
  return lines;
}

std::string JobReport::text() const {
  std::string text = output.string() + ": " + headline(*this);
  constexpr std::size_t kMaxReasons = 20;
  const std::vector<std::string> all = reasons();
  for (std::size_t i = 0; i < std::min(all.size(), kMaxReasons); ++i) text += "\n  " + all[i];
  if (all.size() > kMaxReasons) text += "\n  ... and " + std::to_string(all.size() - kMaxReasons) + " more";
  text += item_line(*this, ItemNeed::Resume, "finished by an interrupted run");
  text += item_line(*this, ItemNeed::Reuse, "kept");
  text += item_line(*this, ItemNeed::Run, "to make");
  return text;
}

Json JobReport::json() const {
  Json change_list = Json::array(), item_list = Json::array();
  for (const JobChange& c : changes) {
    change_list.push_back({{"name", c.name}, {"change", name_of(c.kind)}, {"before", c.before}, {"now", c.now}});
  }
  for (const Item& item : items) item_list.push_back({{"name", item.name}, {"need", name_of(item.need)}});
  return {
      {"output", output.string()}, {"dry_run", true},        {"would", name_of(need)}, {"needs_force", needs_force()},
      {"reasons", reasons()},      {"changes", change_list}, {"items", item_list}};
}

JobReport explain_job(const JobPlan& plan, const JobOptions& options) {
  check_plan(plan);
  const OutputState state = look_at_output(plan, options);
  JobReport report;
  report.output = state.output;
  report.is_forced = options.force;
  report.changes = state.changes;
  report.damage = state.damage;
  report.is_made_again = state.is_made_again;
  if (state.found == FoundOutput::Same) report.need = OutputNeed::UpToDate;
  const bool is_only_lost = state.damage.any() && state.damage.altered.empty();
  if (state.found == FoundOutput::Different && !is_only_lost)
    report.need = state.only_grows ? OutputNeed::Grown : OutputNeed::Stale;
  if (state.found == FoundOutput::Same || is_partial_whole(partial_path(state.output), plan.manifest, plan.key))
    return report;
  for (const JobItem& item : plan.items) report.items.push_back({item.name, need_of(plan, item, state)});
  return report;
}

JobReport explain_output_files(const std::vector<OutputFile>& files, const std::string& key,
                               const JobOptions& options) {
  // Everything but a different key is an error of check_output_files() also with `force`.
  const JobStatus status = check_output_files(files, key, {.force = true, .keeps_same = true});
  const bool is_other = std::any_of(files.begin(), files.end(), [&](const OutputFile& file) {
    std::error_code error;
    return fs::exists(file.path, error) && file.existing_key != key;
  });
  JobReport report;
  report.output = files.front().path;
  report.is_forced = options.force;
  report.is_made_again = status == JobStatus::UpToDate && options.force;
  if (status == JobStatus::UpToDate && !options.force) report.need = OutputNeed::UpToDate;
  if (is_other || report.is_made_again) report.need = OutputNeed::Stale;
  return report;
}

}  // namespace patinate
