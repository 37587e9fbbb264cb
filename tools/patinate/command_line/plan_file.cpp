#include "tools/patinate/command_line/plan_file.h"

#include <nlohmann/json.hpp>

#include "libcommon/core/text.h"
#include "libcommon/document/document.h"
#include "libcommon/job/spread_job.h"
#include "patinate/core/error.h"

namespace patinate::cli {

namespace {

constexpr const char* kProgram = "patinate " PATINATE_VERSION;
constexpr std::size_t kMaxWords = 10000;
constexpr std::size_t kMaxShown = 12;

struct PlanDocument {
  std::filesystem::path file;
  std::string program = kProgram;
  std::vector<std::string> command;
  PlannedWork work;
};

constexpr DocumentKind kPlanDocument{
    .format = "patinate.plan",
    .title = "patinate plan",
    .about =
        "What `patinate cluster plan COMMAND ... --json` says and `patinate cluster run` and `join` read: a "
        "command's work as items that can run anywhere."};

/// A reader learns neither what it waits for nor its files.
void describe_item(DocumentVisitor& v, PlannedItem& item, std::size_t number) {
  std::vector<std::string> outputs;
  for (const std::filesystem::path& output : item.outputs) outputs.push_back(output.generic_string());
  std::string waits_for = item_ranges_text(item.waits_for);
  v.member({"number", "For --items.", at_least(0)}, number);
  v.member({"name"}, item.name);
  v.member({"key", "Of all that it depends on: an item with the same name and key is finished once and for all."},
           item.key);
  v.member({"outputs", "Files of the output that it makes; those under .job/work serve later items only."}, outputs);
  v.member({"waits_for", "Numbers and ranges of items that have to be finished before: \"0-3, 7\"."}, waits_for);
  v.member({"weight", "About the time that it takes, against the other items and the join.", above(0)}, item.weight);
  v.member({"inputs", "Names of the plan's inputs that it reads; empty: it may read any."}, item.inputs);
  v.member({"is_finished", "When the plan was made."}, item.is_finished);
}

void describe(DocumentVisitor& v, PlanDocument& d) {
  v.member({"program", "Who made it; another version refuses it."}, d.program);
  if (d.program != kProgram)
    throw IoError(d.file.string(),
                  "was made by " + d.program.substr(0, 40) + ", this is " + kProgram + "; make the plan again");
  v.member({.name = "command",
            .help = "The verb and its arguments, to be given where they were given.",
            .min_size = 1,
            .max_size = kMaxWords},
           d.command);
  std::string output = d.work.output.string();
  v.member({"output", "What is made in the end."}, output);
  v.member({"key", "Content key of all that the work depends on; it is refused when that has changed."}, d.work.key);
  v.list({"inputs", "What the key is made of, as far as it is told."}, d.work.depends_on, [&](JobDependency& input) {
    v.member({"name"}, input.name);
    v.member({"key"}, input.key);
  });
  std::size_t next = 0;
  v.list({"items"}, d.work.items, [&](PlannedItem& item) { describe_item(v, item, next++); });
  v.object({.name = "join", .help = "null: items make files of the output themselves.", .is_nullable = true},
           d.work.has_join, [&] {
             v.member({"weight", "As the items'."}, d.work.join_weight);
           });
  v.member({"is_up_to_date", "When the plan was made."}, d.work.is_up_to_date);
}

}  // namespace

Json plan_json(const std::vector<std::string>& command, const PlannedWork& work) {
  PlanDocument document{.file = {}, .command = command, .work = work};
  return document_json(kPlanDocument, described(document));
}

Json plan_schema() { return document_schema(kPlanDocument, described<PlanDocument>()); }

std::string plan_text(const PlannedWork& work) {
  const std::vector<std::size_t> left = work.unfinished();
  std::string text = work.output.string() + ": ";
  if (work.is_up_to_date) return text + "up to date";
  text += std::to_string(work.items.size()) + (work.items.size() == 1 ? " item" : " items");
  if (left.size() < work.items.size()) text += ", " + std::to_string(work.items.size() - left.size()) + " finished";
  if (!left.empty()) text += "; left: " + item_ranges_text(left);
  if (work.has_join) text += work.items.empty() ? "; join does all of the work" : "; then join";
  for (std::size_t k = 0; k < left.size() && k < kMaxShown; ++k) {
    const PlannedItem& item = work.items[left[k]];
    text += "\n  " + std::to_string(left[k]) + " " + item.name;
    if (!item.waits_for.empty()) text += ", waits for " + item_ranges_text(item.waits_for);
  }
  if (left.size() > kMaxShown) text += "\n  and " + std::to_string(left.size() - kMaxShown) + " more";
  return text;
}

PlanFile read_plan_file(const std::filesystem::path& file) {
  PlanDocument read{.file = file, .command = {}, .work = {}};
  read_document(kPlanDocument, file, described(read));
  return {read.command, {file, read.work.key, read.work.depends_on}};
}

}  // namespace patinate::cli
